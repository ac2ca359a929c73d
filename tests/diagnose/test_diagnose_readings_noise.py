"""What servos' readings scatter by is known of shapes and of windows as drawing it anew shows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.folder import write
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.shapes.geometry import shapes
from serpenoid.diagnose.data.shapes.shape_in_time import Source, fitted
from serpenoid.diagnose.data.windows.readings_noise import by_readings, of_shapes
from serpenoid.diagnose.data.windows.tracks import half_average, make_tracks
from serpenoid.diagnose.data.windows.windows import predictions
from serpenoid.diagnose.stages.observation.marker_evidence import beside_readings, misfit, sample
from serpenoid.medium import Medium
from serpenoid.model import Model

SD, DRAWS = 4e-4, 24  # rad
MARKER_SD = 2e-4  # m


@pytest.mark.parametrize("choose", [False, True])
def test_the_covariance_of_a_shape_is_that_of_draws(choose: bool) -> None:
    time, at = np.arange(0, 4, 1 / 60), np.array([0.6, 1.0, 1.03, 1.06, 2.5, 3.5])
    true = np.stack([np.sin(2 * np.pi * time / 2), 0.5 * np.cos(2 * np.pi * time / 2)], axis=1)
    rng, drawn, said = np.random.default_rng(0), [], []
    for _ in range(300):
        source = Source.of(time, true + rng.normal(0, SD, true.shape), np.full(2, 3 * SD))  # its size is not known
        shape = fitted([source], np.array([2.0]), 0.078, choose)
        drawn.append(shape.at(at))
        said.append(shape.covariance(at[:, None]))
    np.testing.assert_allclose(shape.variance(at), np.einsum("jrr->rj", said[-1]), rtol=1e-9)
    for joint in range(2):
        found, wanted = np.mean(said, axis=0)[joint], np.cov(np.array(drawn)[:, :, joint].T)
        # 300 draws tell a variance to 8 %; a penalty's bias counts as variance and is none of draws
        np.testing.assert_allclose(np.diag(found), np.diag(wanted), rtol=0.3)
        apart = np.sqrt(np.outer(np.diag(wanted), np.diag(wanted)))
        np.testing.assert_allclose(found / apart, wanted / apart, atol=0.25)


@pytest.mark.parametrize(("more", "left"), [(0.0, 1.0), (1.25, 1.61)])
def test_what_readings_scatter_by_is_no_misfit_of_markers(more: float, left: float, tmp_path: Path) -> None:
    """more: square of what markers scatter by beyond the noise of neighbouring frames. Readings alone make 2.04."""
    write(make(5, [], "short", COMBINATIONS[:1]), tmp_path / "short")
    first = read_recordings(tmp_path / "short")[1][0]
    rng, now = np.random.default_rng(0), Observation.neutral(first.body)
    smooth, exact = first.shape.at(first.read_at), shapes(first.body, first.shape.at(first.time))
    plain, beside = [], []
    for _ in range(DRAWS):
        rough = smooth + rng.normal(0, 8 * SD, smooth.shape)
        markers = exact + rng.normal(0, MARKER_SD, exact.shape)
        data = sample([replace(first, position=rough, markers=markers)])
        off = replace(data, markers=data.markers + rng.normal(0, MARKER_SD * np.sqrt(more), data.markers.shape))
        plain.append(misfit(off, now) / off.count)
        beside.append(beside_readings(off, now))
    assert np.mean(plain) == pytest.approx(2.04 + more, rel=0.03)
    assert np.mean(beside) == pytest.approx(left, rel=0.03)


def test_windows_are_off_by_readings_as_drawn(tmp_path: Path) -> None:
    campaign = make(5, [], "short", COMBINATIONS[:1])
    write(campaign, tmp_path / "short")
    first = read_recordings(tmp_path / "short")[1][0]
    model = Model(first.body, Medium(anisotropy_ratio=campaign.eps))
    smooth, rng = first.shape.at(first.read_at), np.random.default_rng(0)
    again = [replace(first, position=smooth + rng.normal(0, SD, smooth.shape)) for _ in range(DRAWS)]
    tracks = make_tracks(again, Observation.neutral(first.body), model)
    found = predictions(model, tracks)
    left = np.array([t.displacement - p.displacement for t, p in zip(tracks, found, strict=True)])
    playing = tracks[0].playing & tracks[0].usable
    pairs = [(r, t.time[t.boundaries]) for r, t in zip(again, tracks, strict=True)]
    each = [by_readings(r, model, times, of_shapes(r, times, half_average(r))) for r, times in pairs]
    said = np.mean(each, axis=0)
    drawn = np.sqrt((left[:, playing].var(axis=0, ddof=1)).mean(axis=0))
    # 24 draws of some twenty windows tell a standard deviation to 4 %; hidden markers, of which nothing is said, make
    # a heading worse
    np.testing.assert_allclose(np.sqrt((said[playing] ** 2).mean(axis=0)), drawn, rtol=0.35)
    rests = ~tracks[0].playing
    assert (said[rests] < 3 * left[:, rests].std(axis=0)).all()  # at the end of a log, too
    assert (np.array([t.least for t in tracks]) > said.min()).all()
