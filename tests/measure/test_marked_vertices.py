"""Markers at some vertices only: wheels in the middles of links have a vertex of their own, and no marker."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from serpenoid.cli.main import main
from serpenoid.errors import InputError
from serpenoid.measure.load import load_campaign

ENDS = [0, 2, 4, 6, 8]  # tail, three joints, head
SHOWN = 0.2e-3 * 2**0.5 / 0.05  # rad: noise of two markers on a link of 50 mm


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of a robot with wheels in the middles of its links, which shows every vertex."""
    folder = tmp_path_factory.mktemp("middles")
    robot = ["--joints", "3", "--edges", "0.05,0.1,0.08,0.06", "--wheels", "middles"]
    assert main(["new", "problem", str(folder / "mine.toml"), "--yes", *robot]) == 0
    words = ["--problem", str(folder / "mine.toml"), "--format", "tidy", "--yes"]
    assert main(["new", "campaign", str(folder / "campaign.toml"), *words]) == 0
    return folder


def marked(whole: Path, to: Path, key: str) -> Path:
    """The same where joints and ends alone have markers."""
    rows = [line.split(",") for line in (whole / "example" / "motion.csv").read_text().split()]
    kept = [[row[0], *(cell for k in ENDS for cell in row[1 + 2 * k : 3 + 2 * k])] for row in rows]
    kept[0] = ["t_s", *(f"{axis}_{k}" for k in range(len(ENDS)) for axis in "xy")]
    to.mkdir(parents=True)
    (to / "motion.csv").write_text("\n".join(",".join(row) for row in kept))
    text = (whole / "campaign.toml").read_text().replace("[motion] ", f"[motion]\n{key}\n#", 1)
    text = text.replace('"example/motion.csv"', f'"{to / "motion.csv"}"')
    path = whole / f"{to.name}.toml"
    path.write_text(text)
    return path


def test_shapes_are_those_that_all_vertices_show(whole: Path, tmp_path: Path) -> None:
    full = load_campaign(whole).trials[0].motion
    some = load_campaign(marked(whole, tmp_path / "some", f"vertices = {ENDS}")).trials[0].motion
    assert full is not None
    assert some is not None
    assert not len(some.jumps)
    assert not len(some.gaps)
    apart = some.joint_angles - full.joint_angles
    assert np.sqrt(np.nanmean(apart**2)) < SHOWN
    assert some.marker_sd == pytest.approx(full.marker_sd, rel=0.2)


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("vertices = [0, 2, 4, 8, 6]", "increasing"),
        ("vertices = [0, 2, 4, 6, 9]", "from 0 to 8"),
        ("vertices = [0, 2]", "5 markers for 2 vertices"),
        (f'vertices = {ENDS}\nmarkers = ["a", "b"]', "needs 5 names, got 2"),
        ("", "5 markers for 9 vertices"),
    ],
)
def test_what_does_not_fit_is_refused_in_words(whole: Path, tmp_path: Path, key: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        load_campaign(marked(whole, tmp_path / "wrong", key))
