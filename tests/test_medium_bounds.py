"""Bounds of the anisotropy ratio: refused where they make no sense, kept by every fit, free where none are stated."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import serpenoid as sp
from serpenoid.compare.calibrate import calibrate
from serpenoid.compare.parameters import bounds
from serpenoid.diagnose.data.untestable import beyond_bounds
from serpenoid.diagnose.inference.fits.bounds import held_at_bounds
from serpenoid.diagnose.inference.fits.evidence import Evidence
from serpenoid.diagnose.start import at_middles, baseline
from serpenoid.effects.active import ActiveEffect
from serpenoid.errors import InputError
from serpenoid.measure.campaign import load_campaign_file
from serpenoid.measure.load import load_campaign
from serpenoid.medium import LEAST, SLIPPERY, Medium, OpenMedium
from serpenoid.model import Model
from serpenoid.model_file import read_model_file, write_model_file

ROOT = Path(__file__).parents[1]
WATER = Medium(anisotropy_ratio=0.5, anisotropy_ratio_bounds=(0.5, 1.0))


@pytest.mark.parametrize("pair", ["[0.5, 0.4]", "[0.0, 1.0]", "[0.5, 120]"])
def test_bounds_out_of_order_or_range_are_refused(pair: str) -> None:
    path = ROOT / "problems" / "reference.toml"
    with pytest.raises(InputError, match=r"anisotropy_ratio_bounds` needs 0 < lower < upper <= 100"):
        sp.load(path, set=[f"medium.anisotropy_ratio_bounds={pair}"])


def test_a_ratio_outside_its_own_bounds_is_refused() -> None:
    with pytest.raises(InputError, match=r"must be within `anisotropy_ratio_bounds`"):
        sp.load(ROOT / "problems" / "lamprey-water.toml", set=["medium.anisotropy_ratio=0.2"])


def test_a_ratio_above_one_is_taken_for_the_other_way_round_but_within_bounds_that_hold_it() -> None:
    path = ROOT / "problems" / "reference.toml"
    with pytest.raises(InputError, match=r"in \(0, 1\], got 5.* of 5 is 0\.2 here.*_bounds = \[1, 10\]"):
        sp.load(path, set=["medium.anisotropy_ratio=5"])
    asked = ["medium.anisotropy_ratio=5", "medium.anisotropy_ratio_bounds=[1, 10]"]
    assert sp.load(path, set=asked).medium.anisotropy_ratio == 5.0


@pytest.mark.parametrize("ratio", ["0", "1e-300", "-0.2", "101"])
def test_a_ratio_of_no_medium_is_refused(ratio: str) -> None:
    with pytest.raises(InputError, match=r"`anisotropy_ratio` must be from 1e-09 to 100, got"):
        sp.load(ROOT / "problems" / "reference.toml", set=[f"medium.anisotropy_ratio={ratio}"])


def test_with_the_least_ratio_a_body_moves_as_without_drag_lengthwise() -> None:
    """The way from there on is linear in eps, so that ten times as much tells what is left."""
    path = ROOT / "problems" / "reference.toml"
    problems = [sp.load(path, set=[f"medium.anisotropy_ratio={ratio}"]) for ratio in (LEAST, 10 * LEAST)]
    least, more = (sp.simulate(problem).trajectory.displacement for problem in problems)
    assert abs(more - least) / 9 < 1e-8


def test_a_ratio_with_which_searches_hardly_end_is_asked_about_but_not_where_bounds_hold_it() -> None:
    path = ROOT / "problems" / "reference.toml"
    (said,) = sp.load(path, set=["medium.anisotropy_ratio=1e-5"]).odd_units
    assert said.startswith("with `anisotropy_ratio` = 1e-05 drag sideways is 1e+05 times that lengthwise")
    meant = ["medium.anisotropy_ratio=1e-5", "medium.anisotropy_ratio_bounds=[1e-6, 1.0]"]
    assert not sp.load(path, set=meant).odd_units
    assert not sp.load(path, set=[f"medium.anisotropy_ratio={SLIPPERY}"]).odd_units


def test_cases_of_a_robust_gait_stay_within_the_bounds_of_the_medium() -> None:
    path = ROOT / "problems" / "robust.toml"
    with pytest.raises(InputError, match=r"task\.robust\.anisotropy_ratio \[0\.5, 2\.0\] is not within 0 \.\. 1"):
        sp.load(path, set=["task.robust.anisotropy_ratio=[0.5, 2.0]"])


@pytest.mark.parametrize(("pair", "ratio"), [((0.5, 1.0), 0.5), ((0.05, 20.0), 0.2), ((1.0, 10.0), 5.0)])
def test_a_first_guess_is_on_the_side_of_the_bounds(pair: tuple[float, float], ratio: float) -> None:
    assert OpenMedium(anisotropy_ratio_bounds=pair).guessed().anisotropy_ratio == ratio


def test_bounds_of_water_rule_out_what_bounds_of_a_surface_do_not() -> None:
    body = sp.load(ROOT / "problems" / "reference.toml").body
    assert "forward_backward_asymmetry" in beyond_bounds(Model(body, WATER))
    assert not beyond_bounds(Model(body, Medium(anisotropy_ratio=3.0, anisotropy_ratio_bounds=(1.0, 10.0))))


def test_bounds_that_are_not_stated_leave_the_hash_of_a_problem_alone() -> None:
    path = ROOT / "problems" / "reference.toml"
    plain, bounded = sp.load(path), sp.load(path, set=["medium.anisotropy_ratio_bounds=[0.001, 1.0]"])
    assert plain.hash != bounded.hash
    assert "anisotropy_ratio_bounds" in plain.medium.model_dump()


def test_a_model_file_keeps_the_bounds(tmp_path: Path) -> None:
    write_model_file(tmp_path / "model.toml", WATER, [])
    assert Medium.model_validate(read_model_file(tmp_path / "model.toml")["medium"]) == WATER


@pytest.mark.slow
@pytest.mark.usefixtures("virtual_machine")
def test_a_fit_to_the_lamprey_stops_at_the_bound_and_says_so() -> None:
    campaign = load_campaign(ROOT / "problems" / "campaigns" / "lamprey.toml")
    found = calibrate(campaign, Model(campaign.body, WATER), ("anisotropy_ratio",))
    assert found.together.values[0] == 0.5
    assert found.mean_best_rms == pytest.approx(0.5, rel=1e-3)  # tolerance of its search
    assert any("ran into its bound 0.5" in text for text in found.together.warnings)


def test_without_stated_bounds_a_fit_may_go_anywhere() -> None:
    body = sp.load(ROOT / "problems" / "reference.toml").body
    low, high = bounds(("anisotropy_ratio",), Model(body, Medium(anisotropy_ratio=0.2)))
    assert (low[0], high[0]) == (1e-4, 1.0)


@pytest.mark.parametrize(("push", "held"), [(-1.0, True), (1.0, False)])
def test_only_what_is_pushed_outwards_is_held_at_a_bound(push: float, held: bool) -> None:
    body = sp.load(ROOT / "problems" / "reference.toml").body
    inertia = ActiveEffect.neutral("inertia")
    columns = np.random.default_rng(0).normal(size=(40, 2))
    rows = push * columns.sum(axis=1)
    sums = held_at_bounds(Model(body, WATER), [inertia], Evidence.of(rows, columns, np.arange(40) // 10))
    values, _ = sums.solve([0, 1])
    assert values == pytest.approx([0.0, 0.0] if held else [1.0, 1.0], abs=1e-6)  # the ridge is 1e-9


def test_of_a_recorded_body_the_ratio_may_be_left_to_fits(tmp_path: Path) -> None:
    """A law or where drag sits can be said alone, in a campaign and in what a diagnosis takes as its baseline."""
    whole = '[[trial]]\nname = "a"\nmotion = "a.csv"\n'
    begin = 'format = 1\nname = "c"\n[body]\nvertices = 3\nedge_lengths = [0.1, 0.1]\n[medium]\n'
    path = tmp_path / "campaign.toml"
    path.write_text(begin + 'law = "coulomb"\nanisotropy_ratio_bounds = [0.5, 1.0]\n' + whole)
    file, _ = load_campaign_file(path)
    assert file.medium is not None
    assert file.medium.anisotropy_ratio is None
    assert baseline(None, file, file.body).medium == Medium(
        law="coulomb", anisotropy_ratio=0.5, anisotropy_ratio_bounds=(0.5, 1.0)
    )
    (tmp_path / "m.toml").write_text('[medium]\ndissipation = "edge"\n')
    assert at_middles(tmp_path / "m.toml", file)
    assert baseline(tmp_path / "m.toml", file, file.body).medium.law == "viscous"
    path.write_text(begin + "anisotropy_ratio = 1.7\n" + whole)
    with pytest.raises(InputError, match=r"must be in \(0, 1\], got 1\.7"):
        load_campaign_file(path)
