"""Laws of the whole body that do little alone: all are fitted at once, and those that are there remain."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from blind.campaign import COMBINATIONS, Effect, make
from blind.folder import write
from blind.windows import windows
from serpenoid.diagnose.inference.doubt.together import laws_together
from serpenoid.diagnose.inference.fits.medium import TO_THE_END, fit_eps, fit_guided
from serpenoid.diagnose.inference.search.discrepancy import information_criterion
from serpenoid.diagnose.inference.search.select import Selection, calibrated
from serpenoid.diagnose.inference.search.tries import unclear

WHEELS = [
    Effect("contact_offset", None, {"offset": 0.018}),
    Effect("wheel_mount", None, {"share": 0.9}),
    Effect("track_width", None, {"half_track": 0.025}),
    Effect("grip_saturation", None, {"saturation_speed": 0.02}),
]


def nothing_found(folder: Path, hidden: list[Effect], gaits: int) -> Selection:
    """A search that ended with eps alone."""
    campaign = make(3, hidden, "laws", COMBINATIONS[:gaits])
    write(campaign, folder)
    motion, model = windows(folder, campaign.eps)
    motion, null = calibrated(motion, fit_guided(motion, fit_eps(motion, model), TO_THE_END))
    return Selection(null, (), null, (), (), motion, null, 1e-3, ())


@pytest.mark.slow
def test_laws_of_wheels_that_act_together_remain_and_no_other(tmp_path: Path) -> None:
    found = nothing_found(tmp_path, WHEELS, 4)
    fitted = laws_together(found)
    assert fitted is not None
    assert fitted.chi2 < 0.05 * found.null.chi2
    assert information_criterion(found.motion, fitted) < information_criterion(found.motion, found.null)
    told = {e.name: next(iter(e.parameters.values())) for e in fitted.effects}
    assert set(told) == {e.name for e in WHEELS}
    for effect in WHEELS:
        (value,) = effect.parameters.values()
        assert told[effect.name] == pytest.approx(value, rel=0.1)


def test_one_gait_tells_no_law_from_another_and_little_that_is_left_asks_for_none(tmp_path: Path) -> None:
    assert laws_together(nothing_found(tmp_path / "one", WHEELS, 1)) is None
    assert laws_together(nothing_found(tmp_path / "healthy", [], 2)) is None


def test_beside_a_reference_none_is_looked_for(tmp_path: Path) -> None:
    """What its robot moves by already is known; two gaits of these laws leave enough to ask for them."""
    found = nothing_found(tmp_path, WHEELS, 2)
    assert unclear(found.best)
    assert laws_together(replace(found, motion=replace(found.motion, ratio=0.2))) is None
