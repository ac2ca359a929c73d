"""What a diagnosis takes for granted: a model, perhaps with effects, and what is known of cameras and servos."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.noise.motion import Motion, Repeated
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.windows.windows import Track
from serpenoid.diagnose.stages.actuation.choose_set_points import plays
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import ActuationEffect
from serpenoid.errors import InputError
from serpenoid.model import Model

ALIKE = 0.01


@dataclass(frozen=True)
class Baseline:
    """model: where the calibration of eps begins; its effects are held.

    others: what servos and cameras are known to do. without: effects that the catalogue shall not have. law_open:
    whether nobody says which law the medium follows. remarks: how it came to be the baseline, where that is no matter
    of course.
    """

    model: Model
    others: tuple[ActiveEffect, ...] = field(default=(), kw_only=True)
    without: frozenset[str] = field(default=frozenset(), kw_only=True)
    law_open: bool = field(default=False, kw_only=True)
    remarks: tuple[str, ...] = field(default=(), kw_only=True)

    @property
    def known(self) -> tuple[ActiveEffect, ...]:
        """Effects that are no news."""
        return (*self.model.effects, *self.others)

    @property
    def rate(self) -> tuple[float, float]:
        """Of the film's clock beside the servos' [s/s], as it is known, and its deviation."""
        return sum(x for e in self.known if e.effect.marks == "rate" for x in e.coordinates[:-1]), 0.0

    @property
    def unlike(self) -> Floats | float:
        """The largest difference between two repeats' windows that is no news (3,) [m, m, rad]."""
        return 0.0

    @property
    def earlier(self) -> Repeated:
        """What repeats of an earlier campaign tell of chance."""
        return Repeated()

    @property
    def ratio(self) -> float | None:
        """eps, where it was measured before; the calibration still begins at the model's."""
        return None

    def ratio_before(self, tracks: Sequence[Track]) -> tuple[float, float] | None:
        """Between which eps of an earlier campaign counts as the same on these tracks; None without one."""
        return None

    def ratio_known(self, tracks: Sequence[Track]) -> bool:
        """Whether an earlier campaign tells eps as it was on these tracks."""
        known = self.ratio_before(tracks)
        return known is not None and known[0] == known[1]

    @property
    def ratio_doubt(self) -> tuple[float, float]:
        """How many times as small and as large eps of an earlier campaign may be as its model has it; 1 without one."""
        return 1.0, 1.0

    def rows_held(self, recordings: Sequence[Recording]) -> bool | None:
        """Whether rows of tables are held, as they were in an earlier campaign; None without one, or where commands of
        these recordings say it."""
        return None

    @property
    def rows_said(self) -> bool:
        """Whether commands of an earlier campaign said how rows are taken."""
        return False

    @property
    def squares(self) -> tuple[float, ...]:
        """What the stage of markers is known to leave, which is no news: see `Stage`."""
        return ()

    def doubt_of(self, effect: ActiveEffect) -> Floats:
        """By how much less and more (P, 2) the coordinates of the same effect may have been than they are taken to be
        in an earlier campaign; 0 without one."""
        return np.zeros((len(effect.effect.parameters), 2))

    def guessed(self, effect: ActiveEffect) -> bool:
        """Whether an earlier campaign is explained with the same effect, which is no finding there."""
        return False

    @property
    def inadequate(self) -> bool:
        """Whether its law is known to be another than the floor's: what it missed repeated."""
        return False

    def otherwise(self, motion: Motion) -> tuple[tuple[Motion, Model, float], ...]:
        """The same motion beside other explanations of what an earlier campaign's model missed, their models, and their
        weights beside this one's."""
        return ()

    def beside(self, model: Model) -> Baseline:
        """With another of these explanations as the baseline."""
        raise NotImplementedError

    def instead(self, trial: str) -> Baseline | None:
        """With the next of these explanations, as this one's has no path along a trial; None: there is no other."""
        return None

    def check(self, body: Body) -> None:
        """Raise InputError if this is not known of such a body."""
        check_same(self.model.body, body)

    def observation(self) -> Observation:
        """What is known to lie between chain and markers."""
        return Observation.of(self.model.body, self.others)

    def begun(self, recordings: Sequence[Recording]) -> tuple[Recording, ...]:
        """Recordings from where they are known to begin."""
        return tuple(recordings)

    def plays(self, recordings: Sequence[Recording]) -> Plays:
        """The servos' readings, beside what is expected of them."""
        return replace(plays(recordings), without=self.without, known=read_by_servos(self.others))

    def corrected(self, tracks: Sequence[Track]) -> tuple[Track, ...]:
        """Tracks without what the model is known to get wrong."""
        return tuple(tracks)


def check_same(mine: Body, body: Body) -> None:
    """Raise InputError if a reference's body is not that of the campaign."""
    if len(mine.edges_m) != len(body.edges_m) or np.abs(mine.edges_m / body.edges_m - 1).max() > ALIKE:
        raise InputError(
            "the reference is of another body: its `edge_lengths` differ. Take a campaign of the same robot."
        )


def read_by_servos(effects: Sequence[ActiveEffect]) -> tuple[ActiveEffect, ...]:
    """Those that servos' own readings show."""
    return tuple(e for e in effects if isinstance(e.effect, ActuationEffect) and e.effect.shown)
