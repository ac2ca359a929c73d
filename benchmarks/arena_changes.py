"""How much of a change of an arena robot its own law of the floor tells, if it is told the truth and nothing is fitted.

    PYTHONPATH=src:tests:benchmarks python benchmarks/arena_changes.py FOLDER > results/benchmarks/arena_changes.md

Robots drawn at random (`arena.any_robot`), healthy and changed, are played into FOLDER. Windows of both are predicted
by force balance at every step of the measured shapes, with the arena's contact law, the robot's own numbers and the
true change. What the change is (mean of its trials minus mean of the healthy ones of the same setting) is compared with
what is left of it beside that prediction, and beside that of the healthy law on the changed shapes. Nothing is fitted.
What is left is what a balance of forces does not hold (wheels that leave the floor, inertia, joints that give way).
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import arena_discrepancy as arena
import numpy as np
from arena_discrepancy import CREEP, Floats, Law

from arena.any_robot import Drawn, draw, hidden_of, play
from arena.hidden import Hidden
from serpenoid.body import Body
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.repeats import by_setting
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import held_out_labels
from serpenoid.diagnose.data.windows.tracks import tracker
from serpenoid.diagnose.data.windows.windows import Prediction, Track
from serpenoid.diagnose.diagnose import choose_observation
from serpenoid.diagnose.inference.search.select import calibrated
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.motion.choose_motion import eps_alone
from serpenoid.diagnose.start import baseline

CASES = (
    ("any-2", 1, "seized"), ("any-1", 4, "seized"), ("any-1", 8, "seized"), ("any-1", 4, "ratchet"),
    ("any-1", 6, "ratchet"), ("any-1", 1, "ratchet"), ("any-2", 5, "ratchet"), ("any-1", 7, "smooth"),
    ("any-2", 3, "payload"), ("any-1", 3, "payload"),
)  # fmt: skip
WHEEL_M = 0.028  # radius of the paper's wheels, which scale with the edges
Forces = Callable[[Law, Floats, Floats, Floats], tuple[Floats, Floats, Floats]]
Predicted = Sequence[Prediction] | None


@dataclass(frozen=True)
class Robot:
    """Of a draw, in the terms of `arena_discrepancy`."""

    drawn: Drawn
    body: Body

    @property
    def law(self) -> Law:
        parts, size = self.drawn.robot, self.drawn.size
        grip, rolling, damping = (float(parts[k]) for k in ("grip", "rolling_resistance", "rolling_damping"))
        return Law(grip=grip, rolling=rolling, damping=damping, half_track=0.025 * size, offset=0.01823 * size)

    def changed(self, hidden: Hidden) -> tuple[Law, Forces]:
        """The law of the changed robot: loads, and forces of each load."""
        ((kind, how),) = hidden.changes.items()
        law = self.law
        if kind == "payload":
            loads = self.body.vertex_weights * self.drawn.protocol.robot.mass_kg
            loads[[how["link"], how["link"] + 1]] += how["mass_kg"] / 2
            law = replace(law, loads=loads / loads.sum())

        def forces(law: Law, turning: Floats, along: Floats, across: Floats) -> tuple[Floats, Floats, Floats]:
            roll, side, moment = (np.array(x) for x in HEALTHY(law, turning, along, across))
            if kind == "ratchet":
                more = how["torque"] / (WHEEL_M * self.drawn.size) / self.drawn.wheel_load_N
                roll += np.where(along < 0, more * np.tanh(along / CREEP), 0.0)
            if kind == "smooth_tyre":
                side[:, how["vertex"]] *= how["factor"]
                moment[:, how["vertex"]] *= how["factor"]
            if kind == "seized_wheel":
                v, scrub = how["vertex"], law.half_track * turning
                slip = np.sqrt(across**2 + scrub**2 + along**2 + CREEP**2)
                roll[:, v], side[:, v] = (law.grip * along / slip)[:, v], (law.grip * across / slip)[:, v]
                moment[:, v] = (law.grip * law.half_track * scrub / slip)[:, v]
            return roll, side, moment

        return law, forces


HEALTHY = arena.forces


def predicted(law: Law, tracks: Sequence[Track], forces: Forces = HEALTHY) -> list[Prediction]:
    arena.forces = forces
    try:
        return [arena.predicted(law, t) for t in tracks]
    finally:
        arena.forces = HEALTHY


def motion_of(campaign: Path, model: Path) -> Motion:
    """Windows of a campaign and their noise, beside drag alone."""
    file, recordings = read_recordings(campaign)
    _, seen = choose_observation(recordings, Observation.neutral(file.body))
    known = Baseline(baseline(model, file, file.body))
    motion, null = eps_alone(tracker(recordings, seen), held_out_labels(recordings), known, None)
    return calibrated(motion, null)[0]


def means(motion: Motion, said: Predicted) -> dict[tuple[str, float], Floats]:
    """Of each setting, mean displacement of its trials' windows (W, 3), less what is predicted."""
    found = {}
    for setting, trials in by_setting(motion.tracks).items():
        count = min(len(motion.tracks[i].displacement) for i in trials)
        own = [motion.tracks[i].displacement[:count] - (said[i].displacement[:count] if said else 0) for i in trials]
        found[setting] = np.nanmean(own, axis=0)
    return found


def size(now: Motion, then: Motion, said: tuple[Predicted, Predicted]) -> float:
    """RMS of the difference of two campaigns' means, in units of a window's noise."""
    here, there = means(now, said[0]), means(then, said[1])
    noise = np.nanmean(then.noise.of(then.tracks[0]), axis=0)
    parts = []
    for setting in here.keys() & there.keys():
        count = min(len(here[setting]), len(there[setting]))
        parts.append(((here[setting][:count] - there[setting][:count]) / noise).ravel())
    return float(np.sqrt(np.nanmean(np.concatenate(parts) ** 2)))


def main() -> None:
    work = Path(sys.argv[1])
    sys.stdout.write(
        "`python benchmarks/arena_changes.py FOLDER`: RMS over windows of what changed, in units of a window's noise, "
        "and what the arena's own law leaves of it\n\n"
        "| robot | change | all of it | healthy law, changed shapes | true law |\n"
        "| --- | --- | --- | --- | --- |\n"
    )
    for key, number, name in CASES:
        drawn = draw(key, number)
        hidden = hidden_of(drawn)[name]
        folders = [play(work / key, drawn, n, key, h) for n, h in (("healthy", Hidden()), (name, hidden))]
        then, now = (motion_of(f / "campaign", f.parent / "robot.toml") for f in folders)
        robot = Robot(drawn, then.tracks[0].recording.body)
        before = predicted(robot.law, then.tracks)
        law, forces = robot.changed(hidden)
        every = [(None, None), (predicted(robot.law, now.tracks), before), (predicted(law, now.tracks, forces), before)]
        sizes = " | ".join(f"{size(now, then, said):.1f}" for said in every)
        sys.stdout.write(f"| {key}, {number} | {name} | {sizes} |\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
