"""WCON files as the format's specification describes them: origins, centroids, heads, parts, units."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from serpenoid.errors import InputError
from serpenoid.measure.campaign import load_campaign_file
from serpenoid.measure.formats.trackers import Timing
from serpenoid.measure.formats.wcon import read_wcon
from serpenoid.measure.trial_files import read_trial

TIME = np.arange(9) / 10
WAY = np.column_stack([0.3 * TIME, -0.1 * TIME])  # of the body's middle, mm
MIDLINE = np.column_stack([np.linspace(-0.5, 0.5, 4), [0.0, 0.1, 0.1, 0.0]])  # about the middle, mm
POINTS = (WAY[:, None] + MIDLINE).tolist()


def written(path: Path, *entries: dict, **units: str) -> Path:
    said = {"t": "s", "x": "mm", "y": "mm"} | units
    path.write_text(json.dumps({"units": said, "data": list(entries)}))
    return path


def entry(points, rows: slice = slice(None), **beside) -> dict:
    own = np.asarray(points)[rows]
    return {"id": 1, "t": TIME[rows].tolist(), "x": own[..., 0].tolist(), "y": own[..., 1].tolist()} | beside


@pytest.mark.parametrize("pair", ["o", "c"])
def test_coordinates_are_told_from_the_origin_and_without_one_from_the_centroid(tmp_path, pair):
    """Without this a worm whose points are told from its centroid would stay where it is."""
    about = entry(
        np.broadcast_to(MIDLINE, (9, 4, 2)), **{f"{pair}x": WAY[:, 0].tolist(), f"{pair}y": WAY[:, 1].tolist()}
    )
    path = written(tmp_path / "w.wcon", about, **{f"{pair}x": "mm", f"{pair}y": "mm"})
    np.testing.assert_allclose(read_wcon(path, Timing()).floor, np.asarray(POINTS) * 1e-3, atol=1e-15)


def test_beside_an_origin_the_centroid_is_only_told(tmp_path):
    path = written(
        tmp_path / "w.wcon",
        entry(POINTS, ox=0.0, oy=1.0, cx=[9.0] * 9, cy=[9.0] * 9),
        ox="mm",
        oy="mm",
        cx="mm",
        cy="mm",
    )
    np.testing.assert_allclose(read_wcon(path, Timing()).floor, (np.asarray(POINTS) + [0, 1]) * 1e-3, atol=1e-15)


def test_an_origin_in_another_unit_is_refused(tmp_path):
    path = written(tmp_path / "w.wcon", entry(POINTS, ox=1.0, oy=1.0), ox="um", oy="um")
    with pytest.raises(InputError, match=r"one length .* for x, y, ox, oy, got .*ox: `um`"):
        read_wcon(path, Timing())


@pytest.mark.parametrize(
    ("said", "first"), [("L", "head"), ("R", "tail"), ("right", "tail"), ("?", None), (None, None)]
)
def test_which_end_is_the_head_is_taken_from_the_file(tmp_path, said, first):
    found = read_wcon(written(tmp_path / "w.wcon", entry(POINTS, head=said)), Timing())
    assert found.first_point == first
    np.testing.assert_allclose(found.floor, np.asarray(POINTS) * 1e-3)


def test_rows_whose_head_is_at_the_other_end_are_turned_round(tmp_path):
    flipped = np.array(POINTS)
    flipped[3] = flipped[3, ::-1]
    path = written(tmp_path / "w.wcon", entry(flipped, head=["L", "L", "?", "R", *5 * "L"]))
    np.testing.assert_allclose(read_wcon(path, Timing()).floor, np.asarray(POINTS) * 1e-3)


def test_an_individual_may_stand_in_several_parts_in_any_order(tmp_path):
    path = written(tmp_path / "w.wcon", entry(POINTS, slice(3, 9)), entry(POINTS, slice(0, 3)), t="milliseconds")
    found = read_wcon(path, Timing())
    np.testing.assert_allclose(found.time_s, TIME * 1e-3)
    np.testing.assert_allclose(found.floor, np.asarray(POINTS) * 1e-3)


CAMPAIGN = """
format = 1
name = "worms"
[body]
kind = "crawler"
vertices = 4
[motion]
format = "wcon"
{key}
[[trial]]
name = "a"
motion = "w.wcon"
"""


def labelled(folder: Path, key: str, head: str):
    written(folder / "w.wcon", entry(POINTS, head=head))
    (folder / "campaign.toml").write_text(CAMPAIGN.format(key=key))
    file, _ = load_campaign_file(folder / "campaign.toml")
    return read_trial(file, file.trial[0], folder).labelled.vertices


def test_the_head_that_a_file_tells_needs_no_key_and_bears_no_other(tmp_path):
    np.testing.assert_allclose(labelled(tmp_path, "", "L")[:, ::-1], np.asarray(POINTS) * 1e-3)
    np.testing.assert_allclose(labelled(tmp_path, "", "R"), np.asarray(POINTS) * 1e-3)
    np.testing.assert_allclose(labelled(tmp_path, 'first_point = "head"', "?")[:, ::-1], np.asarray(POINTS) * 1e-3)
    with pytest.raises(InputError, match='says that its first point is the tail: leave `first_point = "head"`'):
        labelled(tmp_path, 'first_point = "head"', "R")
