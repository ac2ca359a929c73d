"""`serpenoid new robot`: which servo moves which joint, how far, how fast, over which bus."""

from __future__ import annotations

import shlex
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING

from serpenoid.errors import InputError
from serpenoid.files.writing import write_text
from serpenoid.robot.control_table import BAUD_RATES, TICKS_PER_TURN
from serpenoid.robot.ticks import RADIANS_PER_TICK
from serpenoid.scaffold.json_schema import write_schema
from serpenoid.scaffold.questions import Answers, Question, Template, existing, number, whole

if TYPE_CHECKING:
    from serpenoid.problem import Problem

CENTRE = TICKS_PER_TURN // 2


def _ids(text: str) -> tuple[int, ...]:
    ids = tuple(whole(0, 252)(part.strip()) for part in text.split(",")) if text else ()
    if len(set(ids)) < len(ids):
        raise ValueError("needs a different ID for every servo")
    return ids


def _baud_rate(text: str) -> int:
    if not text.isdecimal() or int(text) not in BAUD_RATES.values():
        raise ValueError(f"needs one of {', '.join(map(str, BAUD_RATES.values()))}")
    return int(text)


QUESTIONS = (
    Question("problem", "Problem file of its body (empty: answer the next)", "", existing),
    Question("joints", "How many joints (where no problem file is given)?", "6", whole(1, 60), "problem"),
    Question("ids", "Servo IDs, tail to head, with commas (empty: 1, 2, 3 ...)", "", _ids),
    Question("joint-limit", "How far may the mechanics bend a joint, in degrees?", "80", number(0, 175)),
    Question("speed-limit", "How fast may a joint turn, in rpm?", "40", number(0, 61)),
    Question("baud-rate", "Baud rate of the servos", "1000000", _baud_rate),
)


def write(path: Path, answers: Answers) -> str:
    """Write the file; returns a command to begin with."""
    problem = _problem(answers)
    joints = int(answers["joints"]) if problem is None else problem.body.joint_count
    ids = answers["ids"] or tuple(range(1, joints + 1))
    if len(ids) != joints:
        raise InputError(f"--ids: {joints} joints need {joints} IDs, got {len(ids)}.")
    head = _head(write_schema(path.parent, "robot"), path.name, answers)
    reach = int(radians(answers["joint-limit"]) / RADIANS_PER_TICK)
    servos = [_servo(number, servo_id, reach, answers) for number, servo_id in enumerate(ids, 1)]
    write_text(path, "\n".join([head, _limits(answers, problem), *servos]))
    return f"serpenoid robot emulate --robot {shlex.quote(str(path))}"


def _problem(answers: Answers) -> Problem | None:
    if answers["problem"] is None:
        return None
    from serpenoid.problem import load

    return load(answers["problem"])


def _limits(answers: Answers, problem: Problem | None) -> str:
    """Where the limits of all joints come from: whoever copies them to a robot must know that nobody measured them."""
    said = f"# Limits: +-{answers['joint-limit']:g} degrees at {answers['speed-limit']:g} rpm, the same for every joint"
    body = None if problem is None else problem.body.joint_limit_deg
    own = (
        ""
        if body is None
        else f"\n# The body in {answers['problem'].name} bends by {body:g} degrees: `play` holds that, too."
    )
    return f"""{said}, as this file was asked for or by default.
# They are of the mechanics: try by hand where the first parts touch, and put your own numbers below.{own}
"""


def _head(hint: str, file: str, answers: Answers) -> str:
    name, typed = Path(file).stem, shlex.quote(file)
    return f"""{hint}
# {name}: which servo moves which joint. joint_1 is next to the tail. `serpenoid schema robot` lists every key.
#   serpenoid robot emulate --robot {typed}                        rehearse without a robot
#   serpenoid robot scan                                               what is on the bus
#   serpenoid play RESULTS --robot {typed} --log trials/first      play and record
# Calibrate: straighten the robot by hand, copy the ticks that `robot scan` shows into `zero_ticks` and shift the limits
# with them. Turn a joint counter-clockwise seen from above: if its ticks fall, its sign is -1.
format = 1
name = "{name}"
model = "XL430-W250-T"

[bus]
baud_rate = {answers["baud-rate"]}          # servos leave the factory at 57600, all with ID 1

[motion]
cycle_duration_s = 5.0       # where the results do not say it
approach_speed_rpm = 5.0     # slow way to the first row
approach_limit_deg = 90.0    # no joint may be farther than this from the first row
watchdog_s = 0.5             # a servo that hears nothing for so long stops by itself

[voltage]                    # at the servos' input; three lithium cells
minimum_V = 9.9
maximum_V = 12.6
nominal_V = 11.1

[tracking]                   # how far a joint may stand from its command, lag apart
limit_deg = 12.0
lag_s = 0.3
action = "stop"              # or "slow", "warn"
"""


def _servo(number: int, servo_id: int, reach: int, answers: Answers) -> str:
    limit = answers["joint-limit"]
    return f"""[[joint]]                    # joint_{number}
id = {servo_id}
sign = 1
zero_ticks = {CENTRE}
minimum_ticks = {CENTRE - reach}         # -{limit:g} degrees
maximum_ticks = {CENTRE + reach}         # +{limit:g} degrees
speed_limit_rpm = {answers["speed-limit"]:g}
"""


robot = Template("my-robot-servos.toml", QUESTIONS, write)
