"""Points that were smoothed in time before they were exported are told; points as they were seen are not."""

import numpy as np
import pytest
from scipy.signal import savgol_filter

from serpenoid.measure.animals.smoothed import smoothed_over
from serpenoid.measure.load import load_campaign
from serpenoid.measure.trial import Motion
from specimens import animal_campaign
from swimmers_by_curves import Curve


def film(points: int = 11, frames: int = 181, noise: float = 0.002) -> tuple[np.ndarray, np.ndarray]:
    """Times (F,) [beats] and points (F, N, 2) of a body one unit long, each seen with noise of its own."""
    beats, body, _ = Curve(ratio=5.0, waves=1.2, amplitude=0.8).film(points, frames, 6)
    return beats, body + np.random.default_rng(3).normal(0, noise, body.shape)


def moving_mean(points: np.ndarray, over: int) -> np.ndarray:
    wide = np.pad(points, [(over // 2, over // 2), (0, 0), (0, 0)], "edge")
    return np.lib.stride_tricks.sliding_window_view(wide, over, axis=0).mean(axis=-1)


def measured(folder, time, points) -> tuple[Motion, str]:
    trial = load_campaign(animal_campaign(folder, "a", time, points, "m")).trials[0]
    assert trial.motion is not None
    return trial.motion, " ".join(trial.notes)


@pytest.mark.parametrize("over", [3, 5])
def test_a_moving_mean_is_told_with_its_frames_and_what_it_takes(tmp_path, over):
    time, points = film()
    motion, said = measured(tmp_path, time, moving_mean(points, over))
    # frames whose directions are taken are next to the others, and share noise with them: it seems to last less
    assert 0.7 * over < smoothed_over(motion) < 1.15 * over
    assert "as they were before that" in said
    assert f"mean over {np.ceil(smoothed_over(motion)):.0f} frames takes" in said


def test_a_filter_that_keeps_cubics_is_told(tmp_path):
    time, points = film()
    assert "as they were before that" in measured(tmp_path, time, savgol_filter(points, 9, 2, axis=0))[1]


def test_smoothed_points_of_which_some_are_hidden_are_told(tmp_path):
    time, points = film(frames=361)
    points = moving_mean(points, 3)
    points[np.random.default_rng(1).random(points.shape[:2]) < 0.05] = np.nan
    header = "t_s," + ",".join(f"x_{k},y_{k}" for k in range(points.shape[1]))
    animal_campaign(tmp_path, "a", time, points, "m")
    rows = np.column_stack([time, points.reshape(len(time), -1)])
    lines = [",".join("" if np.isnan(v) else f"{v:.5f}" for v in row) for row in rows]
    (tmp_path / "a.csv").write_text("\n".join([header, *lines]) + "\n")
    assert "as they were before that" in " ".join(load_campaign(tmp_path).trials[0].notes)


@pytest.mark.parametrize(
    ("points", "frames", "noise"),
    [(11, 181, 2e-3), (5, 121, 1e-3), (8, 121, 0.01), (11, 61, 2e-3), (21, 601, 4e-3), (7, 1501, 3e-4), (11, 181, 0.0)],
)
def test_points_as_they_were_seen_are_not_accused(tmp_path, points, frames, noise):
    motion, said = measured(tmp_path, *film(points, frames, noise))
    assert smoothed_over(motion) == 1
    assert "as they were before that" not in said


def test_whole_pixels_that_stay_the_same_for_frames_are_not_accused(tmp_path):
    """A slow body's points are rounded alike from frame to frame: that lasts, and is no filter."""
    time, points = film(frames=1201, noise=0.0)
    assert smoothed_over(measured(tmp_path, time, np.round(points * 200) / 200)[0]) == 1


def test_a_tracker_whose_errors_last_beside_others_that_do_not_is_not_accused(tmp_path):
    time, points = film(frames=601)
    rng = np.random.default_rng(8)
    slow = np.zeros(points.shape)
    for frame in range(1, len(slow)):
        slow[frame] = 0.95 * slow[frame - 1] + rng.normal(0, 0.0007, points.shape[1:])
    assert smoothed_over(measured(tmp_path, time, points + slow)[0]) == 1
