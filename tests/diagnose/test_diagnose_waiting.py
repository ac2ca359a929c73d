"""Before a trial begins a body on a slope slides, or is held: what it does then is no part of the trial."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.windows.tracks import _slides, make_tracks
from serpenoid.effects.active import ActiveEffect
from serpenoid.medium import Medium
from serpenoid.model import Model
from specimens import reference

PULL = {"pull_x": 0.01, "pull_y": -0.006}
SLOPE = ActiveEffect.of("slope", None, **PULL)
PATCH = ActiveEffect.of("friction_patch", None, strength=-0.7, x=0.1, y=0.05, radius=0.14)
SLID = np.array([0.02, -0.012])  # [m/s], lengthwise drag being less than that sideways


def slid(r: Recording) -> Recording:
    """The same trial of a body that nobody held until it began."""
    waited = np.minimum(r.time, 0.0)[:, None, None]
    return replace(r, markers=r.markers + waited * SLID)


def test_where_a_trial_begins_is_not_told_by_what_a_body_on_a_slope_did_before(tmp_path: Path) -> None:
    campaign = make(5, [Effect("slope", None, PULL)], "short", COMBINATIONS[:1])
    write(campaign, tmp_path)
    held = read_recordings(tmp_path)[1]
    body = held[0].body
    flat = Model(body, Medium(anisotropy_ratio=campaign.eps))
    steep = replace(flat, effects=(SLOPE,))
    seen = Observation.neutral(body)

    def apart(model: Model) -> list[float]:
        """How far the first poses of both are from each other [m]."""
        pairs = zip(make_tracks(held, seen, model), make_tracks([slid(r) for r in held], seen, model), strict=True)
        return [float(np.hypot(*(a.measured[0] - b.measured[0])[:2])) for a, b in pairs]

    assert max(apart(steep)) < 2e-5
    assert min(apart(flat)) > 1e-4  # a body that nothing pulls waits where it was laid: all frames are read


@pytest.mark.parametrize(("effects", "slides"), [((), False), ((PATCH,), False), ((SLOPE,), True)])
def test_only_what_is_pulled_slides(effects: tuple[ActiveEffect, ...], slides: bool) -> None:
    model = replace(reference(), effects=effects)
    vertices = np.stack([np.linspace(0, 1, model.body.vertices), np.zeros(model.body.vertices)], axis=1)
    assert _slides(model, vertices * model.body.total_length_m, np.zeros(3)) is slides
