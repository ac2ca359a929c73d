"""What somebody with a recording of an animal is told: of clocks, rest, single frames and a file to begin with."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import serpenoid as sp
from serpenoid.cli.main import main
from serpenoid.errors import InputError
from serpenoid.measure.campaign import load_campaign_file
from serpenoid.measure.formats.trackers import Timing, read_deeplabcut
from serpenoid.measure.load import load_campaign
from specimens import animal_campaign

ROOT = Path(__file__).resolve().parents[1]
RATE, POINTS = 25.0, 7


def crawl(frames: int, speed: float = 0.3) -> tuple[np.ndarray, np.ndarray]:
    """Times (F,) [s] and points (F, POINTS, 2) [body lengths], with noise, of a body that bends and is carried."""
    time = np.arange(frames) / RATE
    angle = 0.5 * np.sin(2 * np.pi * (time[:, None] + np.arange(POINTS - 1) / POINTS))
    steps = np.stack([np.cos(angle), np.sin(angle)], axis=2) / (POINTS - 1)
    points = np.concatenate([np.zeros((frames, 1, 2)), np.cumsum(steps, axis=1)], axis=1)
    points = points - points.mean(axis=1, keepdims=True) + (speed * time)[:, None, None] * np.array([1.0, 0.0])
    return time, points + np.random.default_rng(0).normal(0, 1e-3, points.shape)


def notes(folder: Path, time: np.ndarray, points: np.ndarray) -> str:
    return " / ".join(load_campaign(animal_campaign(folder, "crawler", time, 0.4 * points, "m")).trials[0].notes)


def test_of_many_gaps_the_first_are_told_and_how_many_more_there_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    time, points = crawl(300)
    for frame in range(10, 290, 20):
        points[frame : frame + 5] = np.nan
    folder = animal_campaign(tmp_path, "crawler", time, 0.4 * points, "m")
    assert main(["measure", str(folder), "--out", str(tmp_path / "out"), "--no-figures"]) == 0
    said = capsys.readouterr().out
    assert said.count("  long gap  ") == 11
    assert "  long gap          and 4 more, 0.24 s at most (campaign.json)" in said


def test_of_three_points_it_is_said_that_they_tell_no_ratio(tmp_path: Path) -> None:
    time, points = crawl(100)
    assert "shows no wave" not in notes(tmp_path, time, points)
    assert "3 points have one joint, which shows no wave" in notes(tmp_path, time, points[:, ::3])


def test_times_in_milliseconds_are_asked_about(tmp_path: Path) -> None:
    time, points = crawl(100)
    assert "milliseconds" not in notes(tmp_path, time, points)
    assert "its frames are 40 s apart: are times in milliseconds" in notes(tmp_path, 1000 * time, points)


def test_of_a_body_that_stays_nobody_says_which_end_leads(tmp_path: Path) -> None:
    assert "moves head first" in notes(tmp_path, *crawl(100))
    time, points = crawl(100, speed=0.0)
    still = np.repeat(points[:1], 100, axis=0) + np.random.default_rng(1).normal(0, 1e-3, points.shape)
    weights = np.array([0.5, *np.ones(POINTS - 2), 0.5]) / (POINTS - 1)  # of a uniform body
    bends = points - (weights @ points)[:, None] + np.random.default_rng(1).normal(0, 1e-3, points.shape)
    for shown, words in ((bends, "stays where it is"), (still, "nothing moved")):
        said = notes(tmp_path, time, shown)
        assert words in said
        assert "first" not in said


@pytest.mark.filterwarnings("error")
def test_one_frame_is_no_motion(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"crawler.csv: 1 frame; a motion takes 8 or more"):
        notes(tmp_path, *(values[:1] for values in crawl(20)))


def test_a_frame_that_is_there_twice_has_a_row(tmp_path: Path) -> None:
    head = "scorer,a,a,a\nbodyparts,tail,tail,tail\ncoords,x,y,likelihood\n"
    (tmp_path / "a.csv").write_text(head + "0,1,1,1\n1,1,1,1\n1,1,1,1\n")
    with pytest.raises(InputError, match="row 6.*times must increase, got 1 after 1"):
        read_deeplabcut(tmp_path / "a.csv", Timing(RATE))


def test_a_new_campaign_of_an_animal_has_neither_servos_nor_tables(tmp_path: Path) -> None:
    text = (ROOT / "problems" / "snake10.toml").read_text()
    (tmp_path / "worm.toml").write_text(text.replace("[body]", '[body]\nkind = "crawler"'))
    words = ["--problem", str(tmp_path / "worm.toml"), "--format", "deeplabcut", "--yes"]
    assert main(["new", "campaign", str(tmp_path / "made"), *words]) == 0
    file, folder = load_campaign_file(tmp_path / "made")
    assert file.body.is_animal
    said = (folder / "campaign.toml").read_text()
    assert not [word for word in ("Robot:", "joint_table", "cycles", "play") if word in said]


def test_a_new_campaign_of_a_tracker_of_animals_is_an_animal_s(tmp_path: Path) -> None:
    assert main(["new", "campaign", str(tmp_path / "made"), "--format", "deeplabcut", "--yes"]) == 0
    file, folder = load_campaign_file(tmp_path / "made")
    assert file.body.is_animal
    assert not file.lengths_given  # nobody said how long
    said = (folder / "campaign.toml").read_text()
    assert "# or wheeled robot, crawling robot, swimming robot, swimmer\n" in said
    assert not [word for word in ("Robot:", "joint_table", "cycles", "play", "mass_kg", "weights") if word in said]


def test_two_points_are_told_why_three_are_the_least(tmp_path: Path) -> None:
    (tmp_path / "campaign.toml").write_text('format = 1\nname = "a"\n[body]\nvertices = 2\n[[trial]]\nname = "b"\n')
    with pytest.raises(InputError, match="3 are the least, as a joint between two edges bends.*got 2"):
        load_campaign_file(tmp_path)


@pytest.mark.slow
def test_what_a_film_of_a_body_at_rest_does_not_determine_has_no_value(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Neither on the screen nor for a program that reads fit.json or the exit code."""
    time, points = crawl(100)
    still = np.repeat(points[:1], 100, axis=0) + np.random.default_rng(1).normal(0, 1e-3, points.shape)
    folder = animal_campaign(tmp_path, "crawler", time, 0.4 * still, "m")
    assert main(["fit", str(folder), "--out", str(tmp_path / "out"), "--no-figures"]) == 1
    said = capsys.readouterr().out
    assert re.search(r"K = 1 / eps +not determined +95 %", said)
    assert "best-RMS" not in said
    record = json.loads((tmp_path / "out" / "fit.json").read_text())
    assert record["together"]["values"] == {"anisotropy_ratio": None}
    assert record["together"]["interval_95"]["anisotropy_ratio"][1] == 1.0
    assert record["best_rms_mean"] is None
    assert "anisotropy_ratio not determined" in str(sp.fit(folder))


def test_a_unit_that_is_none_of_these_is_refused_with_what_to_do(tmp_path: Path) -> None:
    folder = animal_campaign(tmp_path, "crawler", *crawl(20), "m")
    path = folder / "campaign.toml"
    path.write_text(path.read_text().replace('length_unit = "m"', 'length_unit = "inch"'))
    with pytest.raises(InputError, match=r"must be m, cm, .* got 'inch'. Multiply positions .*an inch is 25.4 mm"):
        load_campaign(folder)


@pytest.mark.slow
@pytest.mark.usefixtures("virtual_machine")
def test_a_fit_that_prints_its_numbers_says_what_is_wrong_with_them() -> None:
    found = sp.fit(ROOT / "problems" / "campaigns" / "lamprey.toml")
    said = str(found)
    assert "the model is wrong somewhere" in said
    assert "ran into its bound" in said
    low, high = 1 / found.drag_ratio[2], 1 / found.drag_ratio[1]
    assert f"{low:.4g} .. {high:.4g}" in said  # the wider interval, as for K
