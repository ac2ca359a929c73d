"""What a diagnosis is worth in use: optimal gaits of its baseline and of its extended model, played on the same robot.

The robot is the arena's, with whatever is hidden in it still there. Both gaits are played alike, from where the
optimiser begins: at the origin, heading along x, which matters on a slope. Displacement is that of the body's centroid
over one cycle, as the cameras see it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import stdtrit

from serpenoid.arena.protocol import PlayedGait, Protocol
from serpenoid.body import Floats
from serpenoid.cases import told_table
from serpenoid.errors import InputError
from serpenoid.gaits import Gait
from serpenoid.parallel import Workers
from serpenoid.problem import Problem, load
from serpenoid.table_file import write_table
from serpenoid.wording import counted

if TYPE_CHECKING:
    from serpenoid.diagnose.data.recordings.recording import Recording

MODELS = {"baseline": "baseline-model.toml", "extended": "extended-model.toml"}
AVERAGED_S = 0.1
Progress = Callable[[int, str], None]


@dataclass(frozen=True)
class OptimalGait:
    """Joint table (T, m) [rad], what its own model promises [body lengths a cycle], whether that is certified."""

    table: Floats
    promised: float
    certified: bool


def tasks_of(problem: Path, diagnosis: Path) -> dict[str, Problem]:
    """The problem under both models of a diagnosis folder. Raises InputError where they move a body alike."""
    for file in MODELS.values():
        if not (diagnosis / file).is_file():
            raise InputError(f"{diagnosis}: holds no {file}. Name the folder that `serpenoid diagnose` wrote.")
    tasks = {name: load(problem, model=diagnosis / file) for name, file in MODELS.items()}
    if tasks["baseline"].model == tasks["extended"].model:
        raise InputError(
            f"{diagnosis}: its two models are the same, as nothing that moves the body was found, and so are their "
            "optimal gaits: there is no gain to measure. Name a diagnosis whose extended model holds an effect."
        )
    return tasks


def optimal_gaits(tasks: dict[str, Problem], progress: Progress) -> dict[str, OptimalGait]:
    """The optimum under each model; the second search knows the first's gait."""
    found: dict[str, OptimalGait] = {}
    begins: list[Gait] = []
    for number, (name, task) in enumerate(tasks.items()):
        progress(number, name)
        begins += [] if begins else [task.gait]
        found[name], gait = _optimum(task, begins)
        begins.append(gait)
    return found


def _optimum(task: Problem, begins: list[Gait]) -> tuple[OptimalGait, Gait]:
    """Searched without derivatives, then solved from there; where that does not converge, what the search found."""
    from serpenoid.mechanics.tables import family_tables
    from serpenoid.optimise.search import search
    from serpenoid.optimise.solve import solve_from
    from serpenoid.simulation import simulate_joint_angles

    gait, cost = search(task, begins)
    solved = solve_from(task, gait)
    if solved.status.ok and solved.cost <= cost:
        return OptimalGait(told_table(task, solved.table), solved.trajectory.displacement, True), solved.gait
    family = task.family_of(gait)
    table = family_tables(task.model, family, family.start()[None])[0]
    return OptimalGait(told_table(task, table), simulate_joint_angles(task.model, table).displacement, False), gait


def protocol_of(robot: Protocol, problem: Problem, trials: int, cycles: int) -> Protocol:
    """The two gaits on that robot and floor, one after the other."""
    if problem.body.joint_count != robot.robot.servos:
        remedy = f"Name the robot's problem file with --problem, or its body with `problem` in {robot.name}'s protocol."
        body = counted(problem.body.joint_count, "joint")
        raise InputError(f"the problem's body has {body}, the protocol's robot {robot.robot.servos}. {remedy}")
    duration = problem.task.cycle_duration_s or robot.cycle_duration_s
    gaits = tuple(PlayedGait(name=name, joint_table=f"{name}.csv") for name in MODELS)
    start = robot.start.model_copy(update={"headings_deg": (0.0,)})
    changes = {"gait": gaits, "trials": trials, "cycles": cycles, "cycle_duration_s": duration, "start": start}
    return robot.model_copy(update=changes)


def play(
    folder: Path, protocol: Protocol, gaits: dict[str, OptimalGait], workers: Workers, progress: Progress
) -> dict[str, Floats]:
    """Displacements per trial [body lengths a cycle], by gait."""
    from serpenoid.arena.campaign import run_campaign
    from serpenoid.diagnose.data.recordings.reading import read_recordings

    tables = {name: gait.table for name, gait in gaits.items()}
    for name, table in tables.items():
        write_table(folder / f"{name}.csv", table)
    run_campaign(protocol, tables, folder / "campaign", workers=workers, report=progress)
    _, recordings = read_recordings(folder / "campaign")
    return {name: np.array([displacement(r) for r in recordings if r.gait == name]) for name in gaits}


def displacement(r: Recording) -> float:
    """Mean over the cycles of one trial [body lengths]."""
    from serpenoid.diagnose.data.shapes.geometry import register, shapes

    poses, _ = register(shapes(r.body, r.angles), r.markers)

    def place(time: float) -> Floats:
        near = np.abs(r.time - time) < AVERAGED_S / 2
        return np.asarray(np.nanmean(poses[near, :2], axis=0))

    begins = [n * r.schedule.period_s for n in range(r.schedule.cycles)]
    moved = [place(t + r.schedule.cycle_duration_s) - place(t) for t in begins]
    return float(np.mean([np.hypot(*x) for x in moved]) / r.body.total_length_m)


def record_of(gaits: dict[str, OptimalGait], found: dict[str, Floats]) -> dict[str, Any]:
    """in-use.json: displacements with their spread, and what the extension gains, with Welch's 95 % interval."""
    record: dict[str, Any] = {"unit": "body lengths a cycle"}
    for name, values in found.items():
        record[name] = {
            "promised": gaits[name].promised, "certified": gaits[name].certified,
            "mean": float(values.mean()), "sd": float(values.std(ddof=1)), "trials": values.tolist(),
        }  # fmt: skip
    before, after = found["baseline"], found["extended"]
    gain = float(after.mean() - before.mean())
    parts = [x.var(ddof=1) / len(x) for x in (before, after)]
    freedom = sum(parts) ** 2 / sum(p**2 / (len(x) - 1) for p, x in zip(parts, (before, after), strict=True))
    half = float(stdtrit(freedom, 0.975) * np.sqrt(sum(parts)))
    return record | {"gain": gain, "gain_interval": [gain - half, gain + half]}


def lines(record: dict[str, Any]) -> list[str]:
    """The summary."""
    rows = [
        f"{name:9} played {g['mean']:.4f} +- {g['sd']:.4f} in {counted(len(g['trials']), 'trial')}, promised "
        f"{g['promised']:.4f}"
        for name, g in ((name, record[name]) for name in MODELS)
    ]
    low, high = record["gain_interval"]
    return [*rows, f"gain      {record['gain']:+.4f}   95 % {low:+.4f} .. {high:+.4f} {record['unit']}"]
