"""`serpenoid new problem`: a chain of equal links with half links at its ends, or of given edges.

Wheels in the middles of links stand at vertices of their own, which do not bend; what stands at the joints then weighs
next to nothing. Drag along a smooth body sits in the middles of edges, and a link of one edge would turn freely: links
are cut into `PIECES`. An animal has no links: all its `POINTS` bend.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from typing import get_args

from serpenoid.body import ANIMALS, Body, Kind
from serpenoid.errors import InputError
from serpenoid.files.writing import write_text
from serpenoid.joint_range import LARGEST
from serpenoid.media import DEFAULT, LAWS
from serpenoid.scaffold.json_schema import write_schema
from serpenoid.scaffold.questions import (
    ONE_SIDED,
    Answers,
    Question,
    Template,
    joint_limit,
    number,
    numbers,
    one_of,
    or_empty,
    whole,
)
from serpenoid.wording import counted

KINDS = get_args(Kind)
JOINTS = 6  # where nothing is said
POINTS = 21  # along an animal: drag in the middles of its edges leaves out 1/400
PIECES = 4  # a link: drag in their middles leaves out 1/16 of what resists its own turning
LENGTH, DURATION = "0.6", "5"  # of a robot, where nothing is said
UNKNOWN = dict.fromkeys(ANIMALS, "")
RESIST = ", ".join(f"`{law.name}` ({law.title})" for law in LAWS.values())


QUESTIONS = (
    Question("kind", f"What is it: {', '.join(KINDS)} (empty: not said)?", "", one_of("", *KINDS)),
    Question(
        "joints", "How many joints (empty: one fewer than edges, else 6; of an animal 19)?", "", or_empty(whole(1, 98))
    ),
    Question(
        "edges", "Edge lengths in metres, tail to head (empty: equal links, half as long at both ends)", "", numbers
    ),
    Question(
        "length",
        "Body length in metres (where no edges are given)",
        LENGTH,
        or_empty(number(0, 1000)),
        "edges",
        animals=UNKNOWN,
    ),
    Question(
        "wheels",
        "Where do wheels (feet, scales) meet the floor: at the `joints`, or in the `middles` of links?",
        "joints",
        one_of("joints", "middles"),
        of_robots=True,
    ),
    Question("mass", "Mass in kilograms", "0.9", number(0, 1e4), of_robots=True),
    Question(
        "joint-limit",
        f"How far may a joint bend, in degrees ({ONE_SIDED})?",
        "60",
        joint_limit(LARGEST),
        of_robots=True,
    ),
    Question(
        "speed-limit",
        "How fast may a joint turn, in rpm (57: XL430-W250-T servos without load at 11.1 V)?",
        "57",
        number(0, 1e4),
        of_robots=True,
    ),
    Question("cycle-duration", "Seconds per cycle", DURATION, or_empty(number(0, 600)), animals=UNKNOWN),
    Question(
        "dissipation",
        "Is drag at each `vertex` (wheels, feet), or along each `edge` (a smooth body)?",
        "vertex",
        one_of("vertex", "edge"),
        animals=dict.fromkeys(ANIMALS, "edge"),
    ),
    Question("law", f"What resists: {RESIST}?", DEFAULT, one_of(*LAWS)),
    Question(
        "anisotropy",
        "Drag lengthwise over sideways (wheels: 0.2, slender swimmers: 0.5)",
        "0.2",
        number(0, 1),
        animals={"swimmer": "0.5"},
    ),
)


def written(limit: float | tuple[float, float]) -> str:
    """A joint limit as a problem file gives it."""
    return _listed(limit) if isinstance(limit, tuple) else f"{limit:g}"


def edges_of(answers: Answers) -> list[float]:
    """N - 1 lengths [m]; raises InputError where given ones do not fit the joints."""
    given = answers["edges"]
    joints = answers["joints"] or (len(given) - 1 if given else JOINTS)
    if given and len(given) < 2:
        raise InputError(f"--edges: a joint stands between two edges, got {len(given)}.")
    if given and len(given) != joints + 1:
        raise InputError(f"--edges: needs {joints + 1} numbers for {counted(joints, 'joint')}, got {len(given)}.")
    spacing = (answers["length"] or float(LENGTH)) / joints
    return list(given) or [spacing / 2, *[spacing] * (joints - 1), spacing / 2]


def write(path: Path, answers: Answers) -> str:
    """Write the file; returns a command to begin with."""
    edges = [] if _smooth(answers) else edges_of(answers)
    write_text(path, _text(write_schema(path.parent, "problem"), path.name, answers, edges))
    return f"serpenoid solve {shlex.quote(str(path))} --c 1.0"


def _text(hint: str, file: str, answers: Answers, edges: list[float]) -> str:
    name, typed = Path(file).stem, shlex.quote(file)
    return f"""{hint}
# {name}: {_what(edges)}. `serpenoid schema problem` lists every key.
#   serpenoid simulate {typed}             the gait below
#   serpenoid solve {typed} --c 1.0        the gait that carries it farthest for what it dissipates
{_of_servos(typed, answers)}
[about]
question = "Which gait carries {name} farthest per cycle, for what it dissipates?"

[body]
{_chain(answers, edges)}
# one of {", ".join(KINDS)}: which effects `diagnose` tries; all, where it is left out
{"# " * (not answers["kind"])}kind = "{answers["kind"] or KINDS[0]}"
{_limits(answers)}

[medium]
anisotropy_ratio = {answers["anisotropy"]:g}     # `serpenoid fit` finds it from recordings
dissipation = "{answers["dissipation"]}"       # "vertex": drag at wheels or feet; "edge": along a smooth body
# what resists: {RESIST.replace("`", "")}
law = "{answers["law"]}"

[gait]                       # where the optimiser begins, and what `simulate` plays
sigma = 1.0
a = 4.0
xi = 1.0

[task]
steps = 50                   # rows of the joint table
{_duration(answers)}
c = 0.0                      # weight of the dissipation T E beside the displacement: 0 .. 2.5

[task.bounds]                # where the optimiser may look
sigma = [0.0, 1.0]
x_c = [-6.0, 6.0]
y_c = [-6.0, 6.0]
a = [0.0, 15.0]
xi = [0.5, 2.5]
"""


def _of_servos(file: str, answers: Answers) -> str:
    """The line that leads on to a robot file; none of an animal."""
    if answers["kind"] in ANIMALS:
        return ""
    return f"#   serpenoid new robot --problem {file}  which servo moves which joint\n"


def _limits(answers: Answers) -> str:
    """How far a joint may bend, and of what has servos how fast."""
    if answers["kind"] in ANIMALS:
        mass, limit, speed = answers["mass"], answers["joint-limit"], answers["speed-limit"]
        lines = [] if mass is None else [f"mass_kg = {mass:g}"]
        lines += [] if speed is None else [f"joint_speed_limit_rpm = {speed:g}"]
        known = (
            "# joint_limit_deg = 30         # how far the body bends at one vertex, if that is known; holds in solve"
        )
        return "\n".join(
            [*lines, known if limit is None else f"joint_limit_deg = {written(limit)}         # holds in solve"]
        )
    return f"""mass_kg = {answers["mass"]:g}
joint_limit_deg = {written(answers["joint-limit"])}         # holds in solve, check, export and play
joint_speed_limit_rpm = {answers["speed-limit"]:g}   # of the servos; holds where `cycle_duration_s` is given"""


def _smooth(answers: Answers) -> bool:
    """Whether it is an animal of whose parts nobody says anything."""
    return answers["kind"] in ANIMALS and not (answers["edges"] or answers["joints"] or answers["wheels"])


def _what(edges: list[float]) -> str:
    return f"a chain of {counted(len(edges) - 1, 'joint')}" if edges else "a smooth body"


def _duration(answers: Answers) -> str:
    duration = answers["cycle-duration"]
    return "# cycle_duration_s = 1.0       # if it is known" if duration is None else f"cycle_duration_s = {duration:g}"


def _chain(answers: Answers, edges: list[float]) -> str:
    """Vertices, edges and weights of `edges` [m] from tail to head; none: points along a smooth body."""
    if not edges:
        length = answers["length"]
        said = "# length_m = 0.001             # if it is known" if length is None else f"length_m = {length:g}"
        return f"vertices = {POINTS}                # points along the body, all but the ends bend\n{said}"
    if answers["wheels"] == "middles":
        body = Body(vertices=len(edges) + 1, edge_lengths=tuple(edges)).with_middles()
        return f"""vertices = {body.vertices}             # tail marker, wheel, joint, wheel, ..., wheel, head marker
joints = {list(body.joint_vertices)}   # the others are rigid
edge_lengths = {_listed(body.edges_m)}   # metres, tail to head
weights = {_listed(body.vertex_weights)}   # what each carries, on any scale; a joint next to nothing"""
    if answers["dissipation"] == "edge" and answers["kind"] != "wheeled robot":
        pieces = [edge / PIECES for edge in edges for _ in range(PIECES)]
        joints = list(range(PIECES, len(pieces), PIECES))
        return f"""vertices = {len(pieces) + 1}             # {PIECES} edges a link: drag sits in the middles of edges
joints = {joints}   # the others are rigid
edge_lengths = {_listed(pieces)}   # metres, tail to head
weights = {_listed(_halves(pieces))}   # what each vertex carries, on any scale, or weigh them"""
    return f"""vertices = {len(edges) + 1}             # tail marker, joints, head marker
edge_lengths = {_listed(edges)}   # metres, tail to head
weights = {_listed(_halves(edges))}   # what each vertex carries, on any scale: half of its links, or weigh them"""


def _halves(edges: list[float]) -> list[float]:
    """Half of each edge at either end."""
    return [(before + after) / 2 for before, after in pairwise([0.0, *edges, 0.0])]


def _listed(values: Iterable[float]) -> str:
    return f"[{', '.join(f'{value:.6g}' for value in values)}]"


problem = Template("my-robot.toml", QUESTIONS, write)
