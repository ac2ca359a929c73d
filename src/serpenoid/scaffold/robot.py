"""`serpenoid new robot`: which servo moves which joint, how far, how fast, over which bus."""

from __future__ import annotations

import shlex
from math import ceil, radians
from pathlib import Path
from typing import TYPE_CHECKING

from serpenoid.body import LONGEST_CYCLE_S
from serpenoid.errors import InputError
from serpenoid.files.writing import write_text
from serpenoid.joint_range import as_pair, limit_words, range_words
from serpenoid.robot.models import DEFAULT, ServoModel, models
from serpenoid.scaffold.json_schema import write_schema
from serpenoid.scaffold.questions import (
    ONE_SIDED,
    Answers,
    Question,
    Template,
    existing,
    joint_limit,
    number,
    one_of,
    whole,
)
from serpenoid.wording import counted

if TYPE_CHECKING:
    from serpenoid.problem import Problem

CELL_V = 3.3, 4.2, 3.7  # of a lithium cell: empty, full, nominal
CLOSE = 0.1  # a battery this near to what is recommended serves
NUMBERS = ("no", "one", "two", "three", "four", "five", "six", "seven")
USUAL_CYCLE_S = 5.0
USUAL, USUAL_SPEED = "usual", 0.7  # of the no-load speed at the recommended voltage


def _ids(text: str) -> tuple[int, ...]:
    ids = tuple(whole(0, 252)(part.strip()) for part in text.split(",")) if text else ()
    if len(set(ids)) < len(ids):
        raise ValueError("needs a different ID for every servo")
    return ids


def _baud_rate(text: str) -> int:
    known = sorted({rate for servo in models().values() for rate in servo.baud_rates.values()})
    if not text.isdecimal() or int(text) not in known:
        raise ValueError(f"needs one of {', '.join(map(str, known))}")
    return int(text)


def _speed(text: str) -> float | None:
    """None: what is usual."""
    return None if text == USUAL else number(0, max(servo.fastest[1] for servo in models().values()))(text)


QUESTIONS = (
    Question("problem", "Problem file of its body (empty: answer the next)", "", existing),
    Question("joints", "How many joints (where no problem file is given)?", "6", whole(1, 60), "problem"),
    Question("model", f"Servo model ({', '.join(models())})", DEFAULT, one_of(*models())),
    Question("ids", "Servo IDs, tail to head, with commas (empty: 1, 2, 3 ...)", "", _ids),
    Question(
        "joint-limit", f"How far may the mechanics bend a joint, in degrees ({ONE_SIDED})?", "80", joint_limit(175)
    ),
    Question("speed-limit", f"How fast may a joint turn, in rpm ({USUAL}: 0.7 of its no-load speed)?", USUAL, _speed),
    Question("baud-rate", "Baud rate of the servos", "1000000", _baud_rate),
)


def write(path: Path, answers: Answers) -> str:
    """Write the file; returns a command to begin with."""
    problem = _problem(answers)
    joints = int(answers["joints"]) if problem is None else problem.body.joint_count
    ids = answers["ids"] or tuple(range(1, joints + 1))
    if len(ids) != joints:
        raise InputError(f"--ids: needs {counted(joints, 'number')}, one a joint, got {len(ids)}.")
    low, high = as_pair(answers["joint-limit"])
    if not low <= 0 <= high:
        raise InputError(
            f"--joint-limit: must hold 0, where a joint is straight: `zero_ticks` lies between its limits, got "
            f"{low:g},{high:g}."
        )
    servo = models()[answers["model"]]
    answers = {**answers, "speed-limit": _speed_limit(servo, answers)}
    _refuse_rate(servo, answers["baud-rate"])
    head = _head(write_schema(path.parent, "robot"), path.name, servo, answers, _cycle(problem))
    joint_sections = [_servo(number, servo_id, servo, answers) for number, servo_id in enumerate(ids, 1)]
    write_text(path, "\n".join([head, _limits(answers, problem), *joint_sections]))
    return f"serpenoid robot emulate --robot {shlex.quote(str(path))}"


def _speed_limit(servo: ServoModel, answers: Answers) -> float:
    """What was asked for, if the motor can; else what is usual [rpm]."""
    asked: float | None = answers["speed-limit"]
    volts, fastest = servo.fastest
    if asked is not None and asked > fastest:
        raise InputError(
            f"--speed-limit: {servo.name} servos do {fastest:g} rpm at {volts:g} V without load, got {asked:g}."
        )
    return float(ceil(USUAL_SPEED * servo.no_load_speed_rpm(servo.recommended_V))) if asked is None else asked


def _refuse_rate(servo: ServoModel, baud_rate: int) -> None:
    rates = servo.baud_rates.values()
    if baud_rate not in rates:
        raise InputError(f"--baud-rate: {servo.name} servos know {', '.join(map(str, rates))}, got {baud_rate}.")


def _voltage_section(servo: ServoModel) -> str:
    """A battery of lithium cells where one is near what is recommended, else a supply."""
    (low, high), wanted = servo.voltage_range, servo.recommended_V
    empty, full, nominal = CELL_V
    cells = round(wanted / nominal)
    if abs(cells * nominal - wanted) <= CLOSE * wanted:
        window, source = (cells * empty, cells * full, cells * nominal), f"{NUMBERS[cells]} lithium cells"
    else:
        window, source = (wanted * (1 - CLOSE), wanted * (1 + CLOSE), wanted), f"a supply of {wanted:g} V"
    lowest, highest, usual = max(low, window[0]), min(high, window[1]), window[2]
    return f"""[voltage]                    # at the servos' input; {source}
minimum_V = {lowest:.1f}
maximum_V = {highest:.1f}
nominal_V = {usual:.1f}"""


def _problem(answers: Answers) -> Problem | None:
    if answers["problem"] is None:
        return None
    from serpenoid.problem import load

    return load(answers["problem"])


def _limits(answers: Answers, problem: Problem | None) -> str:
    """Where the limits of all joints come from: whoever copies them to a robot must know that nobody measured them."""
    limit = answers["joint-limit"]
    sides = range_words(*limit) if isinstance(limit, tuple) else f"+-{limit:g}"
    said = f"# Limits: {sides} degrees at {answers['speed-limit']:g} rpm, the same for every joint"
    body = None if problem is None else problem.body.joint_limit_deg
    own = (
        ""
        if body is None
        else f"\n# The body in {answers['problem'].name} bends by {limit_words(body)} degrees: `play` holds that, too."
    )
    return f"""{said}, as this file was asked for or by default.
# They are of the mechanics: try by hand where the first parts touch, and put your own numbers below. A joint that
# bends farther to one side has `zero_ticks` nearer to one of its limits; with sign = -1 these change places.{own}
"""


def _cycle(problem: Problem | None) -> float:
    """The problem's own duration of a cycle, if a robot may play so long a one [s]."""
    own = None if problem is None else problem.task.cycle_duration_s
    return USUAL_CYCLE_S if own is None or own > LONGEST_CYCLE_S else own


def _head(hint: str, file: str, servo: ServoModel, answers: Answers, cycle_duration_s: float) -> str:
    name, typed = Path(file).stem, shlex.quote(file)
    return f"""{hint}
# {name}: which servo moves which joint. joint_1 is next to the tail. `serpenoid schema robot` lists every key.
#   serpenoid robot emulate --robot {typed}                        rehearse without a robot
#   serpenoid robot scan                                               what is on the bus
#   serpenoid play RESULTS --robot {typed} --log trials/first      play and record
# Calibrate: straighten the robot by hand, copy the ticks that `robot scan` shows into `zero_ticks` and shift the limits
# with them. Turn a joint counter-clockwise seen from above: if its ticks fall, its sign is -1.
# Behind a gear or a belt a joint has `gear_ratio`, turns of its servo for one of the joint.
format = 1
name = "{name}"
model = "{servo.name}"  # a [[joint]] with another servo says `model` itself

[bus]
baud_rate = {answers["baud-rate"]}          # servos leave the factory at 57600, all with ID 1

[motion]
{f"cycle_duration_s = {cycle_duration_s}":28} # where the results do not say it
approach_speed_rpm = 5.0     # slow way to the first row
approach_limit_deg = 90.0    # no joint may be farther than this from the first row
watchdog_s = 0.5             # a servo that hears nothing for so long stops by itself

{_voltage_section(servo)}

[tracking]                   # how far a joint may stand from its command, lag apart
limit_deg = {servo.tracking_limit_deg:.1f}             # without this line: of each servo's own model
lag_s = 0.3
action = "stop"              # or "slow", "warn"
"""


def _servo(number: int, servo_id: int, servo: ServoModel, answers: Answers) -> str:
    (low, high), centre = as_pair(answers["joint-limit"]), servo.ticks_per_turn // 2
    # to the nearest tick, as angles are played: a gait that ends at the limit is within it
    down, up = (max(1, round(radians(side) / servo.radians_per_tick)) for side in (-low, high))
    return f"""[[joint]]                    # joint_{number}
id = {servo_id}
sign = 1
zero_ticks = {centre}
minimum_ticks = {centre - down}         # {low:+z.4g} degrees
maximum_ticks = {centre + up}         # {high:+z.4g} degrees
speed_limit_rpm = {answers["speed-limit"]:g}
"""


robot = Template("my-robot-servos.toml", QUESTIONS, write)
