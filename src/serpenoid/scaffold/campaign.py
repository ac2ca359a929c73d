"""`serpenoid new campaign`: a campaign folder for a body, with one made-up trial so that it runs."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import get_args

import numpy as np

from serpenoid.body import Body, Floats, Kind
from serpenoid.errors import InputError
from serpenoid.files.writing import examples, write_csv, write_text
from serpenoid.measure.formats.readers import NAMES, READERS
from serpenoid.measure.schedule import Schedule
from serpenoid.medium import Medium
from serpenoid.scaffold.film import FILM, OF_A_FILM, campaign_of
from serpenoid.scaffold.film_format import format_of
from serpenoid.scaffold.json_schema import write_schema
from serpenoid.scaffold.questions import Answers, Question, Template, existing, number, one_of
from serpenoid.table_file import write_table

EXAMPLE = "example"
BEGIN = "# --- made up: `serpenoid campaign add` takes this trial out again ---"
END = "# --- end of what is made up ---"
USUAL_KIND = "wheeled robot"
CYCLES, PAUSE_S, LEAD_S = 2, 1.0, 1.0
NOISE_M = 2e-4  # of good cameras
STEP_S = 5e-3  # four in a frame of the film
PLAYED = (
    "play RESULTS --robot ROBOT.toml --cycles 3 --pause 2 --log trials/first",
    "campaign add {0} trials/first MOTION-FILE",
    "measure {0} ; serpenoid compare {0}",
    "diagnose {0} --model PROBLEM.toml",
)
FILMED = ("campaign add {0} TRACK-FILE", "measure {0} ; serpenoid fit {0}", "diagnose {0}")
UNITS = {
    "m": ['length_unit = "m"            # for formats that do not say: m, cm, mm, um, px, bl'],
    "px": ['length_unit = "px"', "# metres_per_pixel = 0.0005   # of your camera: what follows is then in metres"],
}


QUESTIONS = (
    FILM,
    Question(
        "problem",
        "Problem file of the robot or animal (empty: the paper's robot; of a tracker of animals, one as long)",
        "",
        existing,
        unless="film",
        refused="is of an animal, whose body the film tells. Of a robot leave that out: `campaign add` takes films.",
    ),
    Question(
        "format",
        f"Format of the motion files: {', '.join(NAMES)} (of a film what it begins like)",
        "motive",
        one_of(*NAMES),
        guess=lambda answers: format_of(answers["film"]) if answers.get("film") else None,
    ),
    Question(
        "frames-per-second",
        "Frames per second of the cameras, where their files do not say",
        "120",
        number(0, 1e5),
        key="frames_per_second",
    ),
    *OF_A_FILM,
)


def write(path: Path, answers: Answers) -> str:
    """Write campaign.toml (or the named file) with the film or the example's files; returns what to begin with."""
    folder = path.parent
    begin = f"serpenoid measure {shlex.quote(str(folder))}"
    if answers["film"]:
        name, sections = folder.absolute().name, campaign_of(answers, folder)
        write_text(path, "\n".join([*_head(write_schema(folder, "campaign"), name, FILMED), *sections]))
        return begin
    from serpenoid.lifting import flat_only
    from serpenoid.model import Model
    from serpenoid.problem import load
    from serpenoid.simulation.problem import gait_table
    from serpenoid.simulation.rollout import simulate_joint_angles

    problem = load(answers["problem"] or examples() / "snake10.toml")
    flat_only(problem.lift, problem.name)
    assumed = not answers["problem"] and READERS[answers["format"]].animals
    body = _animal(problem.body) if assumed else problem.body
    table, duration = gait_table(problem), problem.task.cycle_duration_s or 5.0
    closed = not problem.task.transient
    motion = simulate_joint_angles(
        Model(body, problem.medium) if assumed else problem.model, _run_through(table, duration, closed), closed=closed
    )
    if not motion.status.ok:
        raise InputError(f"{problem.name}: its gait cannot be simulated: {motion.status.value}.")
    if not body.is_animal:
        write_table(folder / EXAMPLE / "joint_table.csv", table)
    steps = motion.steps_per_cycle
    cycle = motion.vertices[: steps + 1] * body.total_length_m
    poses = motion.poses[[0, steps]]
    shown = cycle[:, _marked(body)]
    _write_motion(folder / EXAMPLE / "motion.csv", shown, poses, duration, body.total_length_m)
    hint = write_schema(folder, "campaign")
    write_text(path, _text(hint, folder.absolute().name, body, problem.medium, duration, answers))
    return begin


def _animal(robot: Body) -> Body:
    """A crawler as long as a robot, of which nobody said anything."""
    return Body(kind="crawler", vertices=robot.vertices, edge_lengths=robot.edge_lengths)


def _run_through(table: Floats, duration: float, closed: bool) -> Floats:
    """A table (T, m) as a robot plays it, on straight lines from row to row, in steps so short that they are none;
    closed: from the last row to the first, too."""
    parts = int(np.ceil(duration / len(table) / STEP_S))
    steps = len(table) * parts
    played = steps if closed else steps - parts + 1
    return Schedule(table, duration, cycles=1, pause_s=0.0).commanded(np.arange(played) / steps * duration)


def _write_motion(path: Path, cycle: Floats, poses: Floats, duration: float, length: float) -> None:
    """Vertices of a simulated cycle (K + 1, N, 2) [m], played with pauses, as a tidy CSV."""
    turn = poses[1, 2] - poses[0, 2]
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    begin, end = poses[:, :2] * length
    times, places, moved = [0.0], [cycle[0]], cycle
    for n in range(CYCLES):
        start = LEAD_S + n * (duration + PAUSE_S)
        times += list(start + np.arange(len(cycle)) * duration / (len(cycle) - 1))
        places += list(moved)
        moved = (moved - begin) @ rotation.T + end if n == 0 else moved
    times.append(times[-1] + PAUSE_S)
    places.append(places[-1])
    grid = np.arange(0.0, times[-1], 0.02)
    flat = np.reshape(places, (len(places), -1))
    shown = np.stack([np.interp(grid, times, column) for column in flat.T], axis=1)
    shown += np.random.default_rng(0).normal(0, NOISE_M, shown.shape)
    header = ["t_s", *(f"{axis}_{vertex}" for vertex in range(cycle.shape[1]) for axis in "xy")]
    write_csv(path, header, np.column_stack([grid, shown]).tolist())


def _text(hint: str, name: str, body: Body, medium: Medium, duration: float, answers: Answers) -> str:
    """The commented file."""
    mass = [] if body.mass_kg is None else [f"mass_kg = {body.mass_kg:g}"]
    measure = "along the body; without them they are estimated" if body.is_animal else "measure them"
    joints = [] if body.joints is None else [f"joints = {list(body.joints)}"]
    lengths = ", ".join(f"{edge:.6g}" for edge in body.edges_m)
    weights = ", ".join(f"{weight:.6g}" for weight in body.vertex_weights)
    others = ", ".join(kind for kind in get_args(Kind) if kind != (body.kind or USUAL_KIND))
    unknown = "# " if body.is_animal and not answers["problem"] else ""
    prefix = "" if body.is_animal else "Robot:"
    marked, labels = _marked(body), _labels(body)
    names = ", ".join(f'"{prefix}{labels[vertex]}"' for vertex in marked)
    markers = f"markers = [{names}]   # as the cameras call them, vertex 0 (tail) first"
    kind = READERS[answers["format"]]
    some = len(marked) < body.vertices
    seen = [f"vertices = {marked}   # those with a marker: tail, joints and head; add others, and their names"] * some
    return "\n".join(
        [
            *_head(hint, name, FILMED if body.is_animal else PLAYED),
            "[body]",
            f"vertices = {body.vertices}" + "   # points along the body that you track" * bool(unknown),
            f'{"" if body.kind else "# "}kind = "{body.kind or USUAL_KIND}"   # or {others}',
            f"{unknown}edge_lengths = [{lengths}]   # metres, tail to head: {measure}",
            *(() if body.is_animal and body.weights is None else (f"weights = [{weights}]",)),
            *joints,
            *mass,
            "",
            *_medium(medium),
            "[motion]                     # how the motion files are to be read; a trial may override any key",
            f'format = "{answers["format"]}"',
            *UNITS[kind.unit],
            f"frames_per_second = {answers['frames-per-second']:g}",
            *kind.lines,
            markers if kind.named else f"# {markers}",
            *seen,
            "",
            BEGIN,
            "[[trial]]",
            f'name = "{EXAMPLE}"',
            f'gait = "{EXAMPLE}"',
            *(() if body.is_animal else _commanded(duration)),
            f'motion = "{EXAMPLE}/motion.csv"',
            'format = "tidy"',
            'length_unit = "m"',
            END,
            "",
        ]
    )


def _marked(body: Body) -> list[int]:
    """Vertices that have a marker: the ends of rigid links. What lies within them, a wheel or a cut into edges, moves
    with them and is seldom marked."""
    return body.corners


def _medium(medium: Medium) -> tuple[str, ...]:
    """Where drag sits is part of what is fitted; at vertices it need not be said."""
    if medium.dissipation == "vertex":
        return ()
    return (
        "[medium]",
        f"anisotropy_ratio = {medium.anisotropy_ratio:g}   # of the problem file: `fit` says what the recordings tell",
        f'dissipation = "{medium.dissipation}"',
        "",
    )


def _head(hint: str, name: str, steps: tuple[str, ...]) -> list[str]:
    typed = shlex.quote(name)
    return [
        hint,
        f"# {name}: recordings of one robot or animal (docs/campaign-format.md).",
        "# Every key: serpenoid schema campaign",
        *(f"#   serpenoid {step.format(typed)}" for step in steps),
        "format = 1",
        f'name = "{name}"',
        "",
    ]


def _commanded(duration: float) -> tuple[str, ...]:
    return (
        f'joint_table = "{EXAMPLE}/joint_table.csv"',
        f"cycle_duration_s = {duration:g}",
        f"cycles = {CYCLES}",
        f"pause_s = {PAUSE_S:g}",
    )


def _labels(body: Body) -> list[str]:
    joints = {vertex: f"joint_{number}" for number, vertex in enumerate(body.joint_vertices, 1)}
    inside = [joints.get(vertex, f"point_{vertex}") for vertex in range(1, body.vertices - 1)]
    return ["tail", *inside, "head"]


campaign = Template("campaign/campaign.toml", QUESTIONS, write)
