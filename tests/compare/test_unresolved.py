"""Points that show no motion of a body are refused, and end no fit in minutes; noise about a body at rest is none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from serpenoid.compare.calibrate import anisotropy
from serpenoid.compare.start import neutral_model
from serpenoid.errors import InputError
from serpenoid.files.writing import write_csv
from serpenoid.measure.load import Campaign, load_campaign
from swimmers_by_curves import Curve

POINTS = 9


def filmed(folder: Path, points: np.ndarray) -> Campaign:
    """A film (F, N, 2) [mm] of an animal at 30 frames a second."""
    rows = np.column_stack([np.arange(len(points)) / 30, points.reshape(len(points), -1)])
    names = [f"{axis}_{k}" for k in range(POINTS) for axis in "xy"]
    write_csv(folder / "film.csv", ["t_s", *names], rows.tolist())
    text = f'format = 1\nname = "w"\n[body]\nkind = "crawler"\nvertices = {POINTS}\n[motion]\nformat = "tidy"\n'
    text += 'length_unit = "mm"\ncolumns = { time = "t_s", x = "x_*", y = "y_*" }\n'
    (folder / "campaign.toml").write_text(f'{text}[[trial]]\nname = "film"\nmotion = "film.csv"\n')
    return load_campaign(folder)


@pytest.mark.parametrize(("way", "seed"), [("anywhere", 0), ("walks", 5)])
def test_points_at_random_are_refused_before_anything_is_fitted(way: str, seed: int, tmp_path: Path) -> None:
    campaign = filmed(tmp_path, at_random(way, seed))
    with pytest.raises(InputError, match=r"trial `film`: these points show no motion of a body: .* % of the frames"):
        anisotropy(campaign, neutral_model(campaign))


def test_points_that_walk_at_random_and_turn_little_are_told_to_be_in_no_order(tmp_path: Path) -> None:
    (trial,) = filmed(tmp_path, at_random("walks", 0)).trials
    assert any("nothing that is found from them can be believed" in note for note in trial.notes)


def at_random(way: str, seed: int) -> np.ndarray:
    """Points (F, N, 2) [mm], anew in each frame or by steps from one to the next."""
    points = np.random.default_rng(seed).uniform(0, 100, (60, POINTS, 2))
    return np.cumsum(points - 50, axis=0) if way == "walks" else points


@pytest.mark.slow
def test_noise_of_half_an_edge_about_a_moving_body_is_no_reason_to_refuse(tmp_path: Path) -> None:
    _, seen, _ = Curve(6.0, 1.2, 0.8).film(POINTS, 60, 2.0)
    noise = np.random.default_rng(0).normal(0, 0.5 / (POINTS - 1), seen.shape)
    campaign = filmed(tmp_path, 100 * (seen + noise))
    assert np.isfinite(anisotropy(campaign, neutral_model(campaign)).interval).all()
