"""A film that hangs until its end contradicts what the log says meanwhile; one of a robot at rest does not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rehearsal import serpenoid_table, snake
from serpenoid.compare.rehearse import Laboratory, write_campaign
from serpenoid.errors import InputError
from serpenoid.measure.consistency.hanging import jitters, stands_from
from serpenoid.measure.load import load_campaign

HERTZ, CYCLE_S, HEADER = 40, 3.0, 7
FRAMES = 200


def campaign(folder: Path, hangs_s: float | None, noise_m: float, hidden: float = 0.05, still_s: float = 1.0) -> Path:
    """Two cycles of a snake; hangs_s: of the film's clock, from where on every frame is the one before it."""
    lab = Laboratory(frames_per_second=HERTZ, marker_sd_m=noise_m, hidden_share=hidden, still_s=still_s)
    write_campaign(folder, snake(), {"g": serpenoid_table(40)}, lab, 1, 0, CYCLE_S, 2, 0.5)
    if hangs_s is not None:
        (film,) = folder.glob("*/motion.csv")
        lines = film.read_text().splitlines()
        last = HEADER + round(hangs_s * HERTZ)
        stands = lines[last].split(",")[2:]
        lines[last:] = [",".join(line.split(",")[:2] + stands) for line in lines[last:]]
        film.write_text("\n".join(lines) + "\n")
    return folder


def without_log(folder: Path) -> Path:
    file = folder / "campaign.toml"
    file.write_text("\n".join(line for line in file.read_text().splitlines() if not line.startswith("servo_log")))
    return folder


def without_labels(folder: Path) -> Path:
    file = folder / "campaign.toml"
    text = file.read_text()
    file.write_text(text + '\n[servo_log]\ncolumns = { phase = "none", cycle = "none", step = "none" }\n')
    return folder


@pytest.mark.parametrize("hangs_s", [2.0, 4.3, 5.5])  # within a cycle, in the pause, in the next cycle
@pytest.mark.parametrize(("noise_m", "hidden"), [(1e-3, 0.05), (2e-4, 0.0), (0.0, 0.0)])
def test_beside_a_log_that_goes_on_it_is_refused_with_the_moment(tmp_path, hangs_s, noise_m, hidden):
    where = without_labels(campaign(tmp_path, hangs_s, noise_m, hidden))
    since = 4.0 if (hangs_s, noise_m) == (4.3, 0.0) else hangs_s  # without noise a pause stands from its beginning
    with pytest.raises(InputError, match=rf"from {since:g} s to its end .*while the servo log.*`to_s = {since:g}`"):
        load_campaign(where)


def test_beside_a_table_that_goes_on_it_is_refused_where_points_have_noise(tmp_path):
    with pytest.raises(InputError, match=r"from 4\.3 s to its end .*by the joint table.*`to_s = 4\.3`"):
        load_campaign(without_log(campaign(tmp_path, 4.3, 1e-3)))


def test_without_noise_a_robot_that_rests_is_not_told_so(tmp_path):
    (trial,) = load_campaign(campaign(tmp_path / "log", None, 0.0, hidden=0.0, still_s=8.0)).trials
    assert not any("no point" in note for note in trial.notes)
    (trial,) = load_campaign(without_log(campaign(tmp_path / "stops", 4.3, 0.0))).trials
    assert not any("no point" in note for note in trial.notes)


def test_where_nothing_moves_meanwhile_or_it_is_believed_it_is_said(tmp_path):
    (trial,) = load_campaign(campaign(tmp_path / "rests", 10.5, 1e-3, still_s=3.0)).trials
    assert any("from 10.5 s to its end" in note and "`to_s = 10.5`" in note for note in trial.notes)
    file = campaign(tmp_path / "moves", 4.3, 1e-3) / "campaign.toml"
    file.write_text(file.read_text().replace("[[trial]]", "[[trial]]\nbelieve = true"))
    (trial,) = load_campaign(file.parent).trials
    assert len([note for note in trial.notes if "no point" in note]) == 1


def test_with_that_remedy_the_clock_is_that_of_the_first_cycle(tmp_path):
    where = without_labels(campaign(tmp_path, 4.6, 2e-4))
    file = where / "campaign.toml"
    file.write_text(file.read_text().replace("[[trial]]", "[[trial]]\nto_s = 4.6"))
    (trial,) = load_campaign(where).trials
    assert trial.servo.offset.offset_s == pytest.approx(Laboratory().servo_clock_s, abs=0.02)
    assert len(trial.passages) == 1


@pytest.mark.parametrize("hidden", [None, slice(0, FRAMES), slice(150, FRAMES)])
def test_from_when_on_points_stand_is_known_whichever_is_hidden(hidden):
    points = np.random.default_rng(0).normal(0, 1e-3, (FRAMES, 5, 2))
    assert stands_from(points) is None
    points[120:] = points[120]
    points[:, 2] = points[:, 2] if hidden is None else np.nan
    assert stands_from(points) == 120
    points[-10:] = np.nan
    assert stands_from(points) == 120
    assert stands_from(points * np.nan) is None
    assert stands_from(np.repeat(points[:1], FRAMES, axis=0)) is None


def test_only_white_noise_beyond_the_files_rounding_jitters():
    rng = np.random.default_rng(0)
    time = np.arange(FRAMES)[:, None, None] / HERTZ
    smooth = np.concatenate([np.sin(time + np.arange(5)[:, None]), np.cos(1.3 * time + np.arange(5)[:, None])], axis=2)
    noise = rng.normal(0, 1e-3, smooth.shape)
    assert jitters(np.round(smooth + noise, 5))
    assert not jitters(np.round(smooth + noise, 2))  # a point at rest stands in all digits
    assert not jitters(np.round(smooth, 5))
    assert not jitters(smooth)
    assert not jitters(np.cumsum(noise, axis=0))
    assert not jitters(np.repeat(smooth[::4], 4, axis=0))  # steps
    assert not jitters(smooth * np.nan)
