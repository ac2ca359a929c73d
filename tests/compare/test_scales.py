"""What not knowing a film's scale does to K: in its interval, as much as a fit of a larger film says."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from serpenoid.compare.calibrate import anisotropy
from serpenoid.compare.lengths import others_of
from serpenoid.compare.scales import scales_sd
from serpenoid.compare.segments import trial_segments
from serpenoid.compare.start import neutral_model
from serpenoid.measure.load import Campaign, align_trial, load_campaign
from serpenoid.measure.trial_files import read_files
from swimmers_by_curves import Curve

PIXELS, POINTS = 400.0, 9
RATIO = "anisotropy_ratio"


def films(folder: Path, sizes: tuple[float, ...], keys: str = "", noise: float = 0.02) -> Campaign:
    """Of a worm with K = 6, one film each so many pixels a body length; noise: over the distance of points."""
    text = f'format = 1\nname = "w"\n[body]\nkind = "crawler"\nvertices = {POINTS}\nlength_m = 0.2\n[motion]\n'
    text += f'format = "array"\nlength_unit = "px"\n{keys}\n'
    folder.mkdir()
    for k, pixels in enumerate(sizes):
        time, seen, _ = Curve(6.0, 1.2, 0.8 + 0.05 * k).film(POINTS, 100, 4.0)
        rng = np.random.default_rng(k)
        np.savez(folder / f"{k}.npz", t_s=time, points=pixels * (seen + rng.normal(0, noise / 12, seen.shape)))
        text += f'[[trial]]\nname = "t{k}"\nmotion = "{k}.npz"\n'
    (folder / "campaign.toml").write_text(text)
    return load_campaign(folder)


def by_scales(campaign: Campaign, trial: str | None) -> tuple[float, float]:
    """Standard error of eps by scales, and all of it."""
    model = neutral_model(campaign)
    chosen = replace(campaign, trials=tuple(t for t in campaign.trials if trial in (None, t.name)))
    segments = tuple(s for t in chosen.trials for s in trial_segments(t))
    found = anisotropy(chosen, model)
    larger = others_of(campaign, model)(trial).films
    return float(scales_sd(model, segments, larger, found.solution)[0]), float(found.sd[0])


@pytest.mark.slow
def test_films_of_two_zooms_have_scales_of_their_own_and_k_is_that_of_known_ones(tmp_path: Path) -> None:
    unknown = films(tmp_path / "u", (PIXELS, 1.5 * PIXELS))
    known = films(tmp_path / "k", (PIXELS, PIXELS), f"metres_per_pixel = {0.2 / PIXELS}")
    a, b = (anisotropy(each, neutral_model(each)) for each in (unknown, known))
    scales = by_scales(unknown, None)[0]
    assert scales > 0.1 * b.sd[0]
    assert by_scales(known, None)[0] == 0
    assert a.values[0] == pytest.approx(b.values[0], abs=3 * scales)
    assert a.sd[0] == pytest.approx(np.hypot(b.sd[0], scales), rel=0.1)
    one, other = (by_scales(unknown, name)[0] for name in ("t0", "t1"))
    assert scales < max(one, other)  # errors of two scales make less of the mean


@pytest.mark.slow
def test_to_first_order_is_what_a_fit_of_a_larger_film_says(tmp_path: Path) -> None:
    campaign = films(tmp_path / "c", (PIXELS,))
    trial, times = campaign.trials[0], 4.0
    _, read = read_files(campaign.file, campaign.folder)
    made = align_trial(campaign.file, read[0], campaign.body, trial.motion, 1 + times * trial.scale_sd)
    larger = replace(campaign, trials=(replace(made, passages=trial.passages),))
    model = neutral_model(campaign)
    moved = anisotropy(larger, model).values[0] - anisotropy(campaign, model).values[0]
    assert abs(moved) == pytest.approx(times * by_scales(campaign, None)[0], rel=0.2)
