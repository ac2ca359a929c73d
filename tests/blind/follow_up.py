"""The experiment that a diagnosis proposes, played in the same world beside a random gait, and diagnosed again."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from blind.campaign import Campaign, with_experiment
from blind.catalogue import Effect
from blind.folder import write
from blind.gaits import random_table
from blind.score import Answer, Name, answer
from blind.snake import Floats

# joint table, cycle duration [s], start pose (None: where the campaign's trials began)
Experiment = tuple[Floats, float, Floats | None]
Record = dict[str, Any]


def follow_up(
    c: Campaign, diagnosis: Record, out: Path, work: Path, diagnose: Callable[[Path, Path], Record | None]
) -> Record:
    """Group sizes before and after, and whether the truth is in them; empty where there was no group.

    `diagnose` takes a campaign's folder and a new one for what it writes. Without a proposal there is no `proposed`.
    """
    before = answer(diagnosis)
    if len(before.group) < 2:
        return {}
    row: Record = {"group_before": len(before.group), "truth_before": _has_truth(before, c.effects)}
    for label, trial in (("proposed", _proposed(diagnosis, out)), ("random", _control(c))):
        if trial is None:
            continue
        folder = work / label
        write(with_experiment(c, *trial), folder)
        again = diagnose(folder, work / f"{label}-out")
        if again is not None:
            said = answer(again)
            row[f"group_{label}"] = len(said.group)
            row[f"members_{label}"] = [str(n) for n in said.group]
            row[f"truth_{label}"] = _has_truth(said, c.effects)
    return row


def _has_truth(said: Answer, effects: tuple[Effect, ...]) -> bool:
    return all(Name(e.name, e.place) in said.group for e in effects)


def _proposed(diagnosis: Record, out: Path) -> Experiment | None:
    proposed = diagnosis.get("next_experiment") or {}
    if not proposed.get("joint_table"):
        return None
    table = np.loadtxt(out / proposed["joint_table"], delimiter=",", skiprows=1)
    start = proposed.get("start_pose")
    pose = np.array([start[k] for k in ("x_m", "y_m", "heading_rad")]) if start else None
    return table, float(proposed["cycle_duration_s"]), pose


def _control(c: Campaign) -> Experiment:
    """A random gait such as campaigns have, at one of their durations."""
    rng = np.random.default_rng([c.seed, 5])
    fastest = c.trials[0].setting.plan.cycle_s
    table = random_table(rng, int(rng.choice([-1, 1])), fastest)
    return table, float(np.round(fastest * rng.choice([1.0, 1.7, 2.8]), 2)), None
