"""Recordings of swimmers, points alone: generated ones first, so that what the lamprey shows is a finding, no rule."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from blind.ground import Ground
from blind.swimmers import NOISE, OUTSIDE, Swimmer, write
from serpenoid.cli.main import main
from serpenoid.diagnose.data import tracked
from serpenoid.diagnose.data.shapes.geometry import placed, shapes
from serpenoid.diagnose.data.shapes.shapes_from_points import from_points
from serpenoid.diagnose.data.tracked import tracked_recordings
from serpenoid.diagnose.data.windows.windows import Track, predictions
from serpenoid.diagnose.report.summary import lines
from serpenoid.effects.active import ActiveEffect
from serpenoid.measure.load import load_campaign
from serpenoid.medium import Medium
from serpenoid.model import Model

ROOT = Path(__file__).parents[2]
SHORT_S = 5.0  # five strokes of the body


def diagnosed(campaign: Path, folder: Path, *more: str) -> dict[str, Any]:
    """The record of a diagnosis, in the water that a slender body allows."""
    water = folder.parent / "water.toml"
    water.write_text("[medium]\nanisotropy_ratio = 0.5\nanisotropy_ratio_bounds = [0.5, 1.0]\n")
    return concluded(campaign, water, folder, *more)


def concluded(campaign: Path, water: Path, folder: Path, *more: str) -> dict[str, Any]:
    """The same with a problem or model file."""
    command = ["diagnose", campaign, "--model", water, "--out", folder, "--quiet"]
    assert main([*map(str, command), *more]) == 0
    return json.loads((folder / "diagnosis.json").read_text())


def names(record: dict[str, Any]) -> set[str]:
    return {e["name"] for e in [*record["effects"], *record["alternatives"]]}


@pytest.mark.parametrize("seed", [31, pytest.param(32, marks=pytest.mark.slow)])
def test_in_a_swimmer_by_drag_alone_nothing_is_found(seed: int, tmp_path: Path) -> None:
    eps = float(np.random.default_rng(seed).uniform(0.55, 0.9))
    found = diagnosed(write(Swimmer(Ground(eps), seed, SHORT_S), tmp_path / "swim"), tmp_path / "out", "--no-figures")
    assert found["verdict"] == "nothing"
    assert found["effects"] == []
    assert found["anisotropy_ratio"]["after"] == pytest.approx(eps, rel=0.01)  # 0.3 % from smoothed shapes


@pytest.mark.slow
def test_a_swimmer_whose_drag_no_water_has_is_told_so_where_no_file_bounds_it(tmp_path: Path) -> None:
    (water := tmp_path / "water.toml").write_text("[medium]\nanisotropy_ratio = 0.5\n")
    campaign = write(Swimmer(Ground(0.2), 33, SHORT_S), tmp_path / "swim") / "campaign.toml"
    campaign.write_text(campaign.read_text().replace("[body]", '[body]\nkind = "swimmer"'))
    found = concluded(campaign, water, tmp_path / "out", "--no-figures")
    assert found["drag_ratio"]["value"] == pytest.approx(5, rel=0.05)
    assert ["K is above 2" in text for text in found["beyond_water"]] == [True]
    told = "\n".join(lines(found))
    assert "caution           K is above 2, the most that slender-body theory allows" in told
    assert "dry friction" not in told  # which water has not


@pytest.mark.slow
@pytest.mark.parametrize("seed", [41, 42])
def test_hidden_added_mass_is_found_and_its_interval_covers_it(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    eps, tau = float(rng.uniform(0.5, 0.85)), float(np.exp(rng.uniform(np.log(0.15), np.log(0.8))))
    swim = write(Swimmer(Ground(eps, added_mass=tau), seed, SHORT_S), tmp_path / "swim")
    found = diagnosed(swim, tmp_path / "out", "--no-figures")
    assert found["verdict"] == "explained"
    assert [e["name"] for e in found["effects"]] == ["added_mass"]
    low, high = found["effects"][0]["parameters"]["relaxation_time"]["interval"]
    assert low < tau < high
    assert found["gain"]["path_rms_m"]["after"] < 0.2 * found["gain"]["path_rms_m"]["before"]


@pytest.mark.parametrize("kind", [pytest.param("", marks=pytest.mark.slow), "swimmer"])
def test_windows_of_a_body_that_coasts_do_not_depend_on_the_mesh(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    eps, tau = 0.6, 0.25
    folder = write(Swimmer(Ground(eps, added_mass=tau), 44, SHORT_S / 2), tmp_path / "swim")
    file = folder / "campaign.toml"
    if kind:
        file.write_text(file.read_text().replace("[body]", f'[body]\nkind = "{kind}"'))
    recordings = tracked_recordings(load_campaign(folder))
    water = Medium(anisotropy_ratio=eps)
    model = Model(recordings[0].body, water, (ActiveEffect.of("added_mass", relaxation_time=tau),))

    def moved(finer: int, about: Model) -> np.ndarray:
        monkeypatch.setattr(tracked, "STEPS_PER_WINDOW", 12 * finer)
        monkeypatch.setattr(tracked, "LEAD", 2 * finer)
        return np.concatenate([p.displacement for p in predictions(model, tracked.tracker(recordings)(about))])

    limit = moved(4, model)
    error, massless = (np.abs(moved(1, m) - limit).mean(axis=0) for m in (model, Model(model.body, water)))
    assert (error < massless / 10).all()  # of the fourth order, where what a massless mesh puts back leaves the second


@pytest.mark.slow
@pytest.mark.parametrize("stated", [True, False])
@pytest.mark.parametrize(("kind", "film_s"), [("pulses", SHORT_S), *((k, 8.0) for k in sorted(OUTSIDE))])
def test_what_is_outside_the_catalogue_is_not_called_added_mass(
    kind: str, film_s: float, stated: bool, tmp_path: Path
) -> None:
    rng = np.random.default_rng(51)
    swimmer = Swimmer(Ground(0.6, external=(OUTSIDE[kind](rng),)), 51, film_s)
    file = write(swimmer, tmp_path / "swim") / "campaign.toml"
    if stated:
        file.write_text(file.read_text().replace("[body]", '[body]\nkind = "swimmer"'))
    found = diagnosed(file.parent, tmp_path / "out", "--no-figures")
    assert found["verdict"] in ("unexplained", "partly explained")
    assert all(e["stand_in"] for e in found["effects"])
    assert found["residual_pattern"]
    assert "added_mass" not in names(found)
    # a body that is not said to swim may have wheels, and beside a tyre that is not there `inertia` helps to predict
    assert not stated or "inertia" not in names(found)


@pytest.mark.slow
def test_the_lamprey_keeps_within_slender_body_theory_and_what_is_missing_is_named(tmp_path: Path) -> None:
    found = concluded(
        ROOT / "problems" / "campaigns" / "lamprey.toml", ROOT / "problems" / "lamprey-water.toml", tmp_path
    )
    assert [found["anisotropy_ratio"][key] for key in ("before", "after", "at_bound")] == [0.5, 0.5, True]
    assert found["verdict"] == "partly explained"
    (added_mass,) = (e for e in found["effects"] if e["name"] == "added_mass")
    low, high = added_mass["parameters"]["relaxation_time"]["interval"]
    assert 0 < low < high == 100  # it saturates: drag hardly matters against it
    assert not names(found) & set(found["untestable"])
    gain = found["gain"]
    assert gain["path_rms_m"]["after"] < 0.5 * gain["path_rms_m"]["before"]  # on parts it was not fitted to
    assert gain["log_likelihood"]["after"] > gain["log_likelihood"]["before"]
    assert (tmp_path / "report.html").is_file()


@pytest.mark.slow
def test_what_the_prickleback_shows_is_not_forced_into_the_catalogue(tmp_path: Path) -> None:
    found = diagnosed(ROOT / "problems" / "campaigns" / "prickleback.toml", tmp_path / "out", "--no-figures")
    assert found["anisotropy_ratio"]["after"] == 0.5
    assert found["verdict"] == "unexplained"
    assert set(found["skipped"]) == {"actuation", "observation"}
    said = (tmp_path / "out" / "summary.txt").read_text()  # nobody knows how long a pixel is
    assert "body lengths" in said
    assert " mm" not in said


def test_what_smoothing_takes_out_is_the_noise_of_the_points(tmp_path: Path) -> None:
    swimmer = Swimmer(Ground(0.6), 61)
    time, points = swimmer.film()
    recording = tracked_recordings(load_campaign(write(swimmer, tmp_path)))[0]
    found = from_points(recording.body, time, points, points)
    edge = recording.body.edges_m[4]  # all but the ends' are equal: an angle is a second difference
    assert found.angle_noise[:, 1:-1].std() == pytest.approx(NOISE * np.sqrt(6) / edge, rel=0.1)


def test_draws_of_the_states_scatter_as_the_smoothed_states_do(tmp_path: Path) -> None:
    swimmer = Swimmer(Ground(0.6), 62, SHORT_S)
    time, points = swimmer.film()
    body = tracked_recordings(load_campaign(write(swimmer, tmp_path)))[0].body
    first = from_points(body, time, points, points).states
    near = placed(shapes(body, first.angles), first.poses)
    quiet = from_points(body, time, points, near)
    rng, noise = np.random.default_rng(7), np.random.default_rng(8)
    draws = [quiet.draw(rng) for _ in range(20)]
    again = [near + noise.normal(0, NOISE, points.shape) for _ in range(20)]
    filmed = [from_points(body, time, seen, near).states for seen in again]
    for values in (lambda s: s.angles, lambda s: s.poses[:, :2], lambda s: s.poses[:, 2]):
        drawn = np.std([values(s) - values(quiet.states) for s in draws])
        true = np.std([values(s) - values(quiet.states) for s in filmed])
        assert drawn == pytest.approx(true, rel=0.15)


def test_windows_in_which_a_model_has_no_root_have_the_noise_of_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A search tries models whose steps have no root: NaN there stood in all sums, and ended it."""
    swimmer = Swimmer(Ground(0.6), 61, SHORT_S)
    recordings = tracked_recordings(load_campaign(write(swimmer, tmp_path)))
    model = Model(recordings[0].body, Medium(anisotropy_ratio=0.6, dissipation="vertex"))
    whole = tracked.tracker(recordings)(model)
    missed = tracked._missed

    def rootless(model: Model, track: Track) -> np.ndarray:
        left = missed(model, track)
        left[2:] = np.nan
        return left

    monkeypatch.setattr(tracked, "_missed", rootless)
    holed = tracked.tracker(recordings)(model)
    for a, b in zip(whole, holed, strict=True):
        np.testing.assert_array_equal(a.noise[:2], b.noise[:2])
    typical = np.sqrt(np.mean(np.concatenate([t.noise[:2] for t in whole]) ** 2, axis=0))
    np.testing.assert_allclose(holed[0].noise[2:], np.broadcast_to(typical, holed[0].noise[2:].shape))
