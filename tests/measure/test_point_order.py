"""Named points of a long table are in order along the body, whichever of them are missing where the file begins."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from serpenoid.errors import InputError
from serpenoid.measure.film.relabel import label_vertices
from serpenoid.measure.formats.points import read_long
from serpenoid.measure.tracks import Tracks

LONG = {"time": "t", "point": "p", "x": "x", "y": "y"}


def written(path: Path, frames: list[list[str]], body: list[str]) -> Tracks:
    """A table with so many points in each frame, each at its place along the body."""
    rows = [f"{t},{name},{body.index(name)},{t}" for t, names in enumerate(frames) for name in names]
    path.write_text("\n".join(["t,p,x,y", *rows]) + "\n")
    return read_long(path, LONG, "m")


NUMBERED = [f"n{k}" for k in range(12)]
NAMED = ["tail", "hip", "belly", "neck", "head"]


@pytest.mark.parametrize(("body", "frames"), [
    (NUMBERED, [NUMBERED[1:4] + NUMBERED[6:], NUMBERED[:9], NUMBERED[::2]]),
    (NUMBERED[::-1], [NUMBERED[:3:-1], NUMBERED[::-1], NUMBERED[5::-1]]),  # numbered from the other end, as listed
    (NUMBERED, [sorted(NUMBERED[1:]), sorted(NUMBERED)]),  # n0, n1, n10, n11, n2, ..
    (NAMED, [["hip", "neck"], NAMED, ["tail", "head"]]),
    (NAMED, [["hip", "belly", "head"], ["tail", "hip", "belly"], ["belly", "neck", "head"]]),  # none has all
])  # fmt: skip
def test_order_along_the_body_is_not_that_in_which_points_are_first_seen(tmp_path, body, frames):
    tracks = written(tmp_path / "m.csv", frames, body)
    assert list(tracks.names) == body
    found = label_vertices(tracks, None, None, len(body), False).vertices
    for t, names in enumerate(frames):
        seen = np.flatnonzero(np.isfinite(found[t, :, 0]))
        assert seen.tolist() == sorted(body.index(name) for name in names)
        assert found[t, seen, 0].tolist() == seen.tolist()


@pytest.mark.parametrize("frames", [
    [["hip", "neck", "head"], ["tail", "hip", "belly"]],  # belly before neck, or after?
    [["hip", "tail", "neck", "head"], ["tail", "hip", "belly"]],  # the tail before the hip, and after
])  # fmt: skip
def test_where_nothing_says_the_order_markers_are_asked_for(tmp_path, frames):
    tracks = written(tmp_path / "m.csv", frames, NAMED)
    with pytest.raises(InputError, match="no frame has all points, .* give them as `markers` in .motion., tail first"):
        label_vertices(tracks, None, None, len(NAMED), False)
    found = label_vertices(tracks, tuple(NAMED), None, len(NAMED), False).vertices
    assert found[1, :3, 0].tolist() == [0, 1, 2]
