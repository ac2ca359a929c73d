"""`serpenoid new protocol`: what the virtual laboratory plays, on the body of a problem file."""

from __future__ import annotations

import json
import os
import shlex
from pathlib import Path

from serpenoid.errors import InputError
from serpenoid.files.writing import examples, write_text
from serpenoid.scaffold.json_schema import write_schema
from serpenoid.scaffold.questions import Answers, Question, Template, existing, number, whole
from serpenoid.table_file import write_table

QUESTIONS = (
    Question("problem", "Problem file of the robot (empty: the paper's snake)", "", existing),
    Question("trials", "How often is each gait played?", "3", whole(1, 1000)),
    Question("cycles", "Cycles in each trial", "2", whole(1, 1000)),
    Question("cycle-duration", "Seconds per cycle", "5", number(0, 600)),
    Question("seed", "Seed of everything random", "1", whole(0, 10**9)),
)


def write(path: Path, answers: Answers) -> str:
    """Write the file and the joint table of the problem's own gait; returns a command to begin with."""
    from serpenoid.lifting import flat_only
    from serpenoid.problem import load
    from serpenoid.simulation.problem import gait_table

    source = answers["problem"] or examples() / "snake10.toml"
    problem = load(source)
    if problem.body.mass_kg is None:
        raise InputError(f"{source}: [body] mass_kg: the arena needs the robot's mass.")
    flat_only(problem.lift, str(source))
    named = "" if answers["problem"] is None else f"problem = {json.dumps(_relative(source, path.parent))}"
    write_table(path.parent / "gaits" / f"{path.stem}.csv", gait_table(problem))
    write_text(path, _text(write_schema(path.parent, "protocol"), path.name, named, answers))
    return f"serpenoid arena run {shlex.quote(str(path))}"


def _relative(source: Path, folder: Path) -> str:
    return Path(os.path.relpath(source, folder)).as_posix()


def _text(hint: str, file: str, named: str, answers: Answers) -> str:
    name, typed = Path(file).stem, shlex.quote(file)
    out = shlex.quote(f"results/{name}")
    robot = named or '# problem = "mine.toml"     # another body than the paper\'s ten-servo snake'
    return f"""{hint}
# {name}: trials in the virtual laboratory (docs/arena.md). `serpenoid schema protocol` lists every key.
#   serpenoid arena run {typed} --out {out}
#   serpenoid measure {out} ; serpenoid compare {out}
format = 1
name = "{name}"
{robot}
seed = {answers["seed"]}                     # the same seed gives the same bytes
trials = {answers["trials"]}                   # repeats of each gait and duration
cycles = {answers["cycles"]}
cycle_duration_s = {answers["cycle-duration"]:g}
pause_s = 2.0                # after every cycle

[[gait]]                     # one section for each joint table
name = "first"
joint_table = "gaits/{name}.csv"
# cycle_durations_s = [5.0, 8.0]

[start]
headings_deg = [0, 120, 240] # trial n takes heading n

# [robot]                    # any number of the robot: grip, wheel_diameter_m, voltage_V ...
# [robot.changes.payload]    # what is hidden in it, for `serpenoid diagnose` to find
# link = 2
# mass_kg = 0.2
"""


protocol = Template("protocol.toml", QUESTIONS, write)
