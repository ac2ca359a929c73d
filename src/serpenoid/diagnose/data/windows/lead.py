"""What comes before a track: with momentum a body runs free from its recording's first poses, up to there and on."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

from serpenoid.body import Body, Floats
from serpenoid.effects.active import ActiveEffect
from serpenoid.measure.remark import Remark
from serpenoid.model import Model
from serpenoid.simulation.path import PathSensitivities, path_sensitivities


class Recorded(Protocol):
    """What is asked of a track's recording; those with equal settings are repeats."""

    @property
    def name(self) -> str:
        """Unique."""

    @property
    def gait(self) -> str:
        """Label."""

    @property
    def body(self) -> Body:
        """Lengths and weights."""

    @property
    def length_unit(self) -> str:
        """`m`, or `bl` (body lengths) where the scale is unknown."""

    @property
    def setting(self) -> tuple[str, float]:
        """Gait and cycle duration."""

    @property
    def promised_s(self) -> float:
        """Seconds that there are to be used."""

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """What was noticed as it was read."""


@dataclass(frozen=True, eq=False)
class Run:
    """A whole recording of a body that moves already when it begins: time (R,) [s], vertices (R, N, 2) [m], measured
    poses (R, 3), of which the first `given` + 1 say how it moves."""

    time: Floats
    vertices: Floats
    poses: Floats
    given: int


@dataclass(frozen=True)
class Lead:
    """Rows of a run before a track's first."""

    run: Run
    rows: int


def led(lead: Lead | None, time: Floats, vertices: Floats, poses: Floats) -> tuple[Floats, Floats, Floats, int]:
    """Time, vertices and poses of a track with its lead before them, and the number of rows that this is."""
    if lead is None:
        return time, vertices, poses, 0
    upto = slice(0, lead.rows + len(time))
    return lead.run.time[upto], lead.run.vertices[upto], lead.run.poses[upto], lead.rows


@lru_cache(maxsize=2)
def free_run(model: Model, run: Run, candidates: tuple[ActiveEffect, ...]) -> PathSensitivities:
    """The whole recording by a model [body lengths, rad]; all parts of it ask for the same one."""
    chains, starts = run.vertices / model.body.total_length_m, run.poses[: run.given + 1] / model.body.pose_units
    return path_sensitivities(model, chains, run.time, starts, list(candidates))
