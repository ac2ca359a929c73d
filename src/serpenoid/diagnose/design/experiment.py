"""The next experiment: the trial for which rival explanations predict most differently, within the robot's limits.

Free are the six numbers of an elliptical gait (head or tail first), the cycle's duration and the start pose on the
floor that was used. Random trials first, then ever smaller changes of the best: derivative-free on the compiled
simulation. The gait NLP is not used here: its objective would need every rival's path and its derivatives by the gait
at once, on a mesh that resolves pauses, and a handful of rivals is decided long before an optimum is reached.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data.noise.motion import Motion, Noise
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.geometry import shapes
from serpenoid.diagnose.design.contest import Explanation, Plan, Unplayable, expected_chi2
from serpenoid.diagnose.inference.doubt.groups import band
from serpenoid.diagnose.inference.fits.medium import Fit
from serpenoid.gaits import EllipseGait
from serpenoid.joint_range import ranges_deg
from serpenoid.measure.schedule import Schedule
from serpenoid.mechanics.tables import joint_table
from serpenoid.model import Model
from serpenoid.parallel import in_processes
from serpenoid.self_contact import crosses_itself

ROWS = 50
SEARCHES, RANDOM, STEPS, SHRINK = 2, 14, 14, 0.88
WIDTH = np.array([0.15, 0.5, 0.5, 0.5, 0.6, 0.12, 0.25, 0.6, 0.08, 0.08])  # of the first changes, as `_random` orders
LIMIT_DEG, SPEED_LIMIT_RPM, SHARE = 60.0, 57.0, 0.8  # where the body does not say; share of the speed used
SHORTER, LONGER = 0.7, 1.5  # cycle durations beyond those of the campaign
RIVALS = 3


@dataclass(frozen=True)
class Experiment:
    """What to play, and the expected chi squared (n,) by which each of the rivals would be told from the choice.

    band: what excludes one.
    """

    plan: Plan
    chi2: Floats
    band: float

    @property
    def worth(self) -> float:
        """Between 0 and 1: the mean over rivals of how likely each is to be excluded."""
        return float((self.chi2 / (self.chi2 + self.band)).mean())


@dataclass(frozen=True)
class Laboratory:
    """What there is to play with: the choice and its rivals, noise, a schedule whose cycles and pause are kept.

    durations: shortest and longest cycle to try [s]; floor: two corners (2,), (2,) within which to start [m].
    """

    choice: Fit
    rivals: tuple[Fit, ...]
    noise: Noise
    schedule: Schedule
    durations: tuple[float, float]
    floor: tuple[Floats, Floats]

    @classmethod
    def of(cls, choice: Fit, rivals: Sequence[Fit], motion: Motion) -> Laboratory:
        """A campaign's: durations a little beyond its own, the floor that its centroids have visited."""
        schedules = [t.recording.schedule for t in motion.tracks if isinstance(t.recording, Recording)]
        used = [s.cycle_duration_s for s in schedules]
        place = np.concatenate([t.on_floor[:, :2] for t in motion.tracks])
        durations = SHORTER * min(used), LONGER * max(used)
        floor = place.min(axis=0), place.max(axis=0)
        return cls(choice, tuple(rivals[:RIVALS]), motion.noise, schedules[0], durations, floor)


def next_experiment(laboratory: Laboratory) -> Experiment | None:
    """The best trial found to tell the choice from its rivals; None if no trial within the limits was found."""
    found = [e for e in in_processes([(_search, (laboratory, seed)) for seed in range(SEARCHES)]) if e is not None]
    return max(found, key=lambda e: e.worth, default=None)


def _search(laboratory: Laboratory, seed: int) -> Experiment | None:
    rng = np.random.default_rng(seed)
    width = band(laboratory.choice)
    one, others = Explanation.of(laboratory.choice), [Explanation.of(f) for f in laboratory.rivals]
    best: tuple[Experiment, Floats] | None = None

    def consider(x: Floats) -> bool:
        nonlocal best
        plan = planned(laboratory, x)
        if plan is None:
            return False
        try:
            e = Experiment(plan, expected_chi2(one, others, laboratory.noise, plan), width)
        except Unplayable:
            return False
        if best is None or e.worth > best[0].worth:
            best = e, x
        return True

    tried = 0
    for _ in range(20 * RANDOM):
        tried += consider(_random(laboratory, rng))
        if tried == RANDOM:
            break
    for i in range(STEPS):
        if best is not None:
            consider(best[1] + SHRINK**i * WIDTH * rng.normal(size=len(WIDTH)))
    return None if best is None else best[0]


def _random(laboratory: Laboratory, rng: np.random.Generator) -> Floats:
    """sigma, x_c, y_c, theta, a, xi; ln of the duration; heading, x, y of the start."""
    sigma = rng.choice([-1, 1]) * rng.uniform(0.35, 1.0)
    gait = [sigma, *rng.uniform(-2.5, 2.5, 2), rng.uniform(-np.pi, np.pi), rng.uniform(3.5, 8), rng.uniform(0.75, 1.5)]
    return np.array(
        [*gait, rng.uniform(*np.log(laboratory.durations)), rng.uniform(-np.pi, np.pi), *rng.uniform(*laboratory.floor)]
    )


def planned(laboratory: Laboratory, x: Floats) -> Plan | None:
    """The trial of ten numbers (see `_random`), None where the robot or the floor forbids it."""
    table = table_of(laboratory.choice.model, x[:6])
    duration, (low, high) = round(float(np.exp(x[6])), 2), laboratory.floor
    within = (x[8:] >= low).all() and (x[8:] <= high).all()
    shortest, longest = laboratory.durations
    if not (within and shortest <= duration <= longest) or not playable(laboratory.choice.model.body, table, duration):
        return None
    schedule = replace(laboratory.schedule, table=table, cycle_duration_s=duration, start_s=0.0)
    return Plan(schedule, np.array([x[8], x[9], x[7]]))


def table_of(model: Model, gait: Floats) -> Floats:
    """Joint table (T, m) of ellipse parameters (6,); about the middles of the joints' ranges."""
    middles = np.mean(_ranges(model.body), axis=0)
    return np.round(joint_table(model, EllipseGait.from_parameters(gait).parameters, ROWS) + middles, 6)


def _ranges(body: Body) -> tuple[Floats, Floats]:
    """Smallest and largest angle of every joint [rad]."""
    limit = LIMIT_DEG if body.joint_limit_deg is None else body.joint_limit_deg
    low, high = np.deg2rad(ranges_deg(limit, body.joint_count)).T
    return low, high


def playable(body: Body, table: Floats, duration: float) -> bool:
    """Whether a table (T, m) keeps joint and speed limits, and the body does not cross itself."""
    low, high = _ranges(body)
    speed_limit = SHARE * (body.joint_speed_limit_rpm or SPEED_LIMIT_RPM) * 2 * np.pi / 60
    fastest = np.abs(np.diff(table, axis=0, append=table[:1])).max() * len(table) / duration
    if (table < low).any() or (table > high).any() or fastest > speed_limit:
        return False
    return not crosses_itself(shapes(body, table)).any()
