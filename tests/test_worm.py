"""The worm of the animal's quick start: its file is what it is said to be, and its K is found."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import make_worm
from serpenoid.compare.likelihood import fit
from serpenoid.compare.segments import trial_segments
from serpenoid.compare.start import neutral_model
from serpenoid.measure.load import load_campaign

CAMPAIGN = Path(__file__).parents[1] / "problems" / "campaigns" / "worm.toml"
pytestmark = pytest.mark.usefixtures("virtual_machine")


def test_the_recording_is_the_one_that_is_generated() -> None:
    kept = np.loadtxt(make_worm.FILE, delimiter=",", skiprows=1)
    np.testing.assert_allclose(kept, make_worm.rows(), atol=6e-5)  # four decimals


def test_its_drag_ratio_is_found() -> None:
    campaign = load_campaign(CAMPAIGN)
    segments = trial_segments(campaign.trials[0])[:4]  # the page fits all, with an interval from them
    found = fit(neutral_model(campaign), segments, ("anisotropy_ratio",), np.array([0.5]))
    assert 1 / found.values[0] == pytest.approx(make_worm.RATIO, rel=0.02)
    assert found.noise_scale < 1.3
