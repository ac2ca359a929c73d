"""Intervals of the profile: the parabola's where there is one, one-sided where a law saturates."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from serpenoid.diagnose.data.chance import NORMAL
from serpenoid.diagnose.inference.doubt.profile import in_its_range, profile_ends


def test_where_chi_squared_is_a_parabola_the_ends_are_its_own(
    diagnosed: tuple[Any, dict[str, Any], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    found = diagnosed[0].motion.selection
    settled = found.settled
    (effect,) = settled.effects
    (x,) = effect.coordinates[:-1]
    sd = np.sqrt(np.diag(settled.evidence.solve(range(len(settled.coordinates)))[1]))[1]
    ends = profile_ends(found.motion, settled, effect, NORMAL**2, NORMAL * sd)
    np.testing.assert_allclose(ends, [x - NORMAL * sd, x + NORMAL * sd], atol=0.1 * sd)
    monkeypatch.setattr(type(effect.effect), "coordinate_bounds", lambda *_: [(0.0, x + sd)])
    assert (
        profile_ends(found.motion, settled, effect, NORMAL**2, NORMAL * sd)[1] == x + sd
    )  # nothing up to the bound is excluded


def test_a_name_has_no_interval_that_holds_what_changes_nothing(diagnosed: tuple[Any, dict[str, Any], Any]) -> None:
    found = diagnosed[0].motion
    (named,) = found.stage.named
    settled, motion = found.selection.settled, found.selection.motion
    assert in_its_range(motion, settled, named, ()) is named
    (parameter,) = named.effect.effect.parameters
    wide = replace(named, intervals={parameter.name: (-0.9, 3.0)})
    low, high = in_its_range(motion, settled, wide, ()).intervals[parameter.name]
    assert low is not None
    assert high is not None
    assert 0 < low < named.effect.parameters[parameter.name] < high < 1
    np.testing.assert_allclose([low, high], named.intervals[parameter.name], atol=0.02)  # gaits agree here
