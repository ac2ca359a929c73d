"""Whether the body keeps clear between rows and between vertices, proven by interval halving.

Between two rows the joints turn at constant rates and the body frame moves evenly, as a robot plays a table. A point of
the body then moves at most  reach = |d(x, y)| + (|d heading| + sum |d angle|) * length  during a step, and no two
points of an edge are farther apart than its length. A signed distance never changes faster than its point moves, so
the value at the middle of an interval of time and edge, less half of what either can change, bounds it in the whole
interval; intervals that are neither safe nor proven to hold nothing nearer than was found are halved.

Legend: T steps, V vertices, I intervals.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from serpenoid import group
from serpenoid.body import Floats
from serpenoid.model import Model
from serpenoid.objectives.criteria import Gaps
from serpenoid.simulation.steps import shape_rows

RESOLUTION = 1e-4  # body lengths: a tenth of a millimetre on a robot of one metre
MOST = 2_000_000  # intervals that are looked at


@dataclass(frozen=True)
class Clearance:
    """least: the smallest gap found at any point and time; proven: a lower bound on all of them [body lengths]."""

    least: float
    proven: float

    @property
    def words(self) -> str:
        """One line for people."""
        return f"{self.proven:.2e} body lengths proven at every time and place, {self.least:.2e} where it was looked"


@dataclass(frozen=True)
class _Path:
    """Rows of poses (T + 1, 3) and realised angles (T + 1, m) of one motion."""

    model: Model
    poses: Floats
    angles: Floats

    def edges(self, step: np.ndarray, share: Floats, edge: np.ndarray, place: Floats) -> Floats:
        """Points (I, 2) on edges at places in [0, 1], at shares of steps."""
        late = share[:, None]
        pose = (1 - late) * self.poses[step] + late * self.poses[step + 1]
        angles = (1 - late) * self.angles[step] + late * self.angles[step + 1]
        shapes, _ = shape_rows(self.model, angles)
        points = group.place(pose, shapes)
        index = np.arange(len(step))
        tail, head = points[index, edge], points[index, edge + 1]
        return np.asarray((1 - place[:, None]) * tail + place[:, None] * head)

    @property
    def reach(self) -> Floats:
        """How far any point moves in each step at most, shape (T,)."""
        moved = np.linalg.norm(np.diff(self.poses[:, :2], axis=0), axis=1)
        turned = np.abs(np.diff(self.poses[:, 2])) + np.abs(np.diff(self.angles, axis=0)).sum(1)
        return np.asarray(moved + turned)


def clearance(model: Model, poses: Floats, angles: Floats, gaps: list[Gaps], wanted: float = 0.0) -> Clearance:
    """Clearance of a motion: poses (T + 1, 3) [body lengths], realised joint angles (T + 1, m) [rad].

    Intervals proven to be above `wanted` are not looked at again, so `proven` says no more than that where it is.
    """
    path, function = _Path(model, poses, angles), _one_point(gaps)
    steps, edges = len(poses) - 1, len(model.body.edges)
    step, edge = (x.ravel() for x in np.meshgrid(np.arange(steps), np.arange(edges), indexing="ij"))
    time, place = np.full(step.size, 0.5), np.full(step.size, 0.5)
    half_time, half_place = np.full(step.size, 0.5), np.full(step.size, 0.5)
    reach, lengths, least, proven, seen = path.reach, model.body.edges, np.inf, np.inf, 0
    while step.size:
        value = function.map(step.size)(path.edges(step, time, edge, place).T).full().min(0)
        by_time, by_place = half_time * reach[step], half_place * lengths[edge]
        bound, seen = value - by_time - by_place, seen + step.size
        least = min(least, float(value.min()))
        final = (by_time + by_place <= RESOLUTION) | (seen > MOST)
        open_ = ~((bound >= min(wanted, least - RESOLUTION)) | final)
        done = bound[~open_]
        proven = min(proven, float(done.min(initial=np.inf)))
        later = by_time[open_] > by_place[open_]
        step, edge = (np.repeat(x[open_], 2) for x in (step, edge))
        time, half_time = _halved(time[open_], half_time[open_], later)
        place, half_place = _halved(place[open_], half_place[open_], ~later)
    return Clearance(least, min(proven, least))


def _halved(middle: Floats, half: Floats, which: np.ndarray) -> tuple[Floats, Floats]:
    """Intervals twice over; those of `which` as their two halves."""
    quarter = np.where(which, half / 2, 0.0)
    both = np.stack([middle - quarter, middle + quarter], -1).ravel()
    return both, np.repeat(half - quarter, 2)


def _one_point(gaps: list[Gaps]) -> ca.Function:
    point = ca.SX.sym("point", 2)
    return ca.Function("gaps_of_a_point", [point], [ca.densify(ca.vertcat(*(gap(point) for gap in gaps)))])
