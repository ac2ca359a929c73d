"""Where repeats were laid at other headings they differ by the room, too: that is no chance, and is found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blind import campaign as blind_campaign
from blind.campaign import make
from blind.catalogue import Effect
from blind.folder import write
from blind.protocol import COMBINATIONS, Protocol, usual
from blind.windows import windows
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import residuals, window_noise
from serpenoid.diagnose.inference.fits.medium import Fit, fit_eps
from serpenoid.diagnose.inference.search.ranking import score
from serpenoid.diagnose.inference.search.room import chance
from serpenoid.diagnose.inference.search.select import calibrated

SEED, SETTINGS = 5, 2
DRIFT = Effect("frame_drift", None, {"velocity_x": 3e-3, "velocity_y": -4e-3})
SLOPE = Effect("slope", None, {"pull_x": 5e-3, "pull_y": -4e-3})


def protocol(turn: float) -> Protocol:
    """Every setting twice, the second time turned [rad]."""
    usually = usual(SEED, COMBINATIONS[:SETTINGS])
    both = [(s, replace(s, heading=s.heading + turn, label=f"{s.label}t")) for s in usually.settings]
    return replace(usually, settings=tuple(s for pair in both for s in pair), plays=1)


def about_eps(folder: Path, turn: float, *hidden: Effect) -> tuple[Motion, Fit]:
    """Motion and the fit of eps alone, before noise is known."""
    write(make(SEED, list(hidden), "turned", protocol=protocol(turn)), folder)
    motion, model = windows(folder, 0.2)
    return motion, fit_eps(motion, model)


@pytest.mark.parametrize(
    "hidden", [pytest.param(DRIFT, id=DRIFT.name), pytest.param(SLOPE, id=SLOPE.name, marks=pytest.mark.slow)]
)
def test_what_the_room_does_to_repeats_at_other_headings_is_no_chance(hidden: Effect, tmp_path: Path) -> None:
    """Taken for chance it hides itself: its noise is several times as large, and lasts."""
    motion, base = about_eps(tmp_path / "hidden", 2.0, hidden)
    still, nothing = about_eps(tmp_path / "nothing", 2.0)
    alone = window_noise(still.tracks, residuals(still.tracks, nothing.predictions))[0]
    as_chance = window_noise(motion.tracks, residuals(motion.tracks, base.predictions))[0]
    motion, fitted = calibrated(motion, base)
    assert (as_chance.playing[:2] > 2 * alone.playing[:2]).all()
    np.testing.assert_allclose(motion.noise.playing, alone.playing, rtol=0.15)  # of 144 numbers: 6 % is one SD
    assert score(motion, fitted)[0][0].name == hidden.name


@pytest.mark.parametrize(
    ("turn", "block_s"), [*(pytest.param(turn, 0.1, marks=pytest.mark.slow) for turn in (0.0, 2.0)), (2.0, 1.0)]
)
def test_where_nothing_is_of_the_room_noise_is_that_of_the_differences(
    turn: float, block_s: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Laid alike or turned, with pushes that are forgotten at once or last for a second."""
    monkeypatch.setattr(blind_campaign, "SLIP_BLOCK_S", block_s)
    motion, base = about_eps(tmp_path, turn)
    plain, _ = window_noise(motion.tracks, residuals(motion.tracks, base.predictions))
    found = chance(motion, base)
    assert np.array_equal(found.playing, plain.playing)
    assert found.memory == plain.memory
