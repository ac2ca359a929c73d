"""All laws of a body at once: found where they act together, none where one gait is all there is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from blind.windows import windows
from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.inference.medium import Fit, fit_eps
from serpenoid.diagnose.inference.select import Selection, calibrated
from serpenoid.diagnose.inference.together import laws_together

WHEELS = {
    "wheel_mount": ("share", 0.9),
    "contact_offset": ("offset", 0.02),
    "track_width": ("half_track", 0.05),
    "grip_saturation": ("saturation_speed", 0.05),
}


@pytest.fixture(scope="module")
def wheeled(tmp_path_factory: pytest.TempPathFactory) -> tuple[Motion, Fit]:
    """Pairs of wheels on axles behind the joints, whose tyres slip, and drag alone fitted to them."""
    folder: Path = tmp_path_factory.mktemp("wheels")
    laws = [Effect(name, None, {parameter: value}) for name, (parameter, value) in WHEELS.items()]
    campaign = make(71, laws, "wheels", COMBINATIONS[:3])
    write(campaign, folder)
    motion, model = windows(folder, campaign.eps)
    return calibrated(motion, fit_eps(motion, model))


def _found(motion: Motion, null: Fit) -> Selection:
    """A search that found nothing."""
    return cast(Selection, SimpleNamespace(motion=motion, null=null, best=null, settled=null))


def test_laws_that_act_together_are_found_from_where_they_change_nothing(wheeled: tuple[Motion, Fit]) -> None:
    motion, null = wheeled
    found = laws_together(_found(motion, null))
    assert found is not None
    values = {e.name: e.parameters for e in found.effects}
    assert values.keys() == WHEELS.keys()
    assert {name: values[name][p] for name, (p, _) in WHEELS.items()} == {
        name: pytest.approx(value, rel=0.15) for name, (_, value) in WHEELS.items()
    }
    assert found.chi2 < 0.002 * null.chi2


def test_one_gait_says_nothing_of_so_many_numbers(wheeled: tuple[Motion, Fit]) -> None:
    motion, null = wheeled
    assert laws_together(_found(replace(motion, labels=(0,) * len(motion.labels)), null)) is None


def test_where_little_is_left_there_is_nothing_to_find(wheeled: tuple[Motion, Fit]) -> None:
    motion, null = wheeled
    clear = replace(null, chi2=float(np.sum(null.evidence.count)))
    assert laws_together(_found(motion, clear)) is None
