"""Markers in space in every system's own layout: the same numbers, in metres; what is broken is named."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from serpenoid.errors import InputError
from serpenoid.measure.campaign import MotionKeys
from serpenoid.measure.film.relabel import label_vertices
from serpenoid.measure.formats.qualisys import read_qualisys
from serpenoid.measure.formats.readers import READERS
from serpenoid.measure.formats.tidy import read_tidy
from serpenoid.measure.formats.trc import read_trc
from serpenoid.measure.formats.vicon import read_vicon
from serpenoid.measure.tracks import Tracks

NAMES, FRAMES, RATE = ["Snake:tail", "Snake:joint", "Snake:head"], 12, 50.0
SPACE = np.round(np.random.default_rng(0).normal(size=(FRAMES, 3, 3)), 6)  # [m]
SPACE[4, 1] = SPACE[:, 2] = np.nan


def cells(row: np.ndarray, scale: float, empty: str = "") -> list[str]:
    return [empty if np.isnan(value) else f"{scale * value:.3f}" for value in row.ravel()]


def vicon(unit: str = "mm", scale: float = 1e3, more: bool = False) -> str:
    """more: devices before, velocities beside and joints after the trajectories."""
    names, axes, beside = ["", ""], ["Frame", "Sub Frame"], 3 if more else 0
    for name in NAMES:
        names += [name, "", "", *[""] * beside]
        axes += ["X", "Y", "Z", *["X'", "Y'", "Z'"][:beside]]
    rows = [["Trajectories"], [f"{RATE:g}"], names, axes, ["", "", *[unit] * (len(axes) - 2)]]
    for frame, row in enumerate(SPACE, 1):
        points = [cell for point in row for cell in cells(point, scale) + ["7"] * beside]
        rows.append([str(frame), "0", *points])
    text = "\n".join(",".join(row) for row in rows) + "\n"
    if not more:
        return text
    devices = "\n\nDevices\n1000\n,,Force plate," + ",".join("abcdefghijklmnopqrstuv") + "\nFrame,Sub Frame,Fx\n,,N\n"
    return devices + "1,0,1\n1,1,1\n\n" + text + "\nJoints\n50\n,,Knee\nFrame,Sub Frame,RX\n,,deg\n1,0,3\n\n"


def qualisys(columns: bool = True, clock: bool = True, empty: str = "") -> str:
    facts = [["NO_OF_FRAMES", f"{FRAMES}"], ["NO_OF_CAMERAS", "8"], ["NO_OF_MARKERS", "3"], ["FREQUENCY", f"{RATE:g}"]]
    facts += [["DESCRIPTION", "--"], ["TIME_STAMP", "2024-05-01, 12:00:00.000", "82.1"], ["DATA_INCLUDED", "3D"]]
    rows = [*facts, ["MARKER_NAMES", *NAMES], ["TRAJECTORY_TYPES", *["Measured"] * 3]]
    if columns:
        rows.append([*["Frame", "Time"] * clock, *(f"{name} {axis}" for name in NAMES for axis in "XYZ")])
    for frame, row in enumerate(SPACE):
        rows.append([*[str(frame + 1), f"{frame / RATE:.5f}"] * clock, *cells(row, 1e3, empty)])
    return "\r\n".join("\t".join(row) for row in rows) + "\r\n"


def trc(unit: str = "mm", scale: float = 1e3, gap: str = "\n", empty: str = "") -> str:
    keys = ["DataRate", "CameraRate", "NumFrames", "NumMarkers", "Units", "OrigDataRate", "OrigDataStartFrame"]
    rows = [["PathFileType", "4", "(X/Y/Z)", "a.trc"], keys, [f"{RATE}", f"{RATE}", f"{FRAMES}", "3", unit, "50", "1"]]
    rows.append(["Frame#", "Time", *(cell for name in NAMES for cell in (name, "", ""))])
    rows.append(["", "", *(f"{axis}{k}" for k in (1, 2, 3) for axis in "XYZ")])
    head = "\n".join("\t".join(row) for row in rows)
    data = [[str(k + 1), f"{k / RATE:.5f}", *cells(row, scale, empty)] for k, row in enumerate(SPACE)]
    return head + "\n" + gap + "\n".join("\t".join([*row, ""]) for row in data) + "\n"


FILES: dict[str, tuple[Callable[[Path], Tracks], str]] = {
    "vicon": (read_vicon, vicon()),
    "vicon, metres": (read_vicon, vicon("m", 1.0)),
    "vicon, with all else": (read_vicon, vicon(more=True)),
    "vicon, resaved": (read_vicon, vicon().replace(",", ";").replace(".", ",")),
    "qualisys": (read_qualisys, qualisys()),
    "qualisys, bare": (read_qualisys, qualisys(False, False, "0.000")),
    "qualisys, version 2": (
        read_qualisys,
        "FILE_VERSION\t2.0.0\r\n" + qualisys().replace("\r\nDESC", "\r\nEVENT\ta\t3\t0.06\r\nDESC"),
    ),
    "qualisys, times": (read_qualisys, qualisys(False, True, "NaN")),
    "trc": (read_trc, trc()),
    "trc, metres": (read_trc, trc("m", 1.0, "", "NaN")),
    "trc, zeros": (read_trc, trc(empty="0")),
}


@pytest.mark.parametrize("name", FILES)
def test_the_same_markers_in_every_layout_are_the_same(tmp_path, name):
    read, text = FILES[name]
    (tmp_path / "a.csv").write_bytes(text.encode())
    tracks = read(tmp_path / "a.csv")
    digits = 6e-4 if "metres" in name else 6e-7  # three decimals are written
    np.testing.assert_allclose(tracks.space, SPACE, atol=digits)
    np.testing.assert_allclose(tracks.time_s - tracks.time_s[0], np.arange(FRAMES) / RATE, atol=1e-5)
    assert list(tracks.names) == NAMES
    assert not any(tracks.unlabelled)
    kind = name.split(",")[0]
    assert READERS[kind].read(tmp_path / "a.csv", MotionKeys(up_axis="x")).floor[0, 0, 0] == tracks.space[0, 0, 1]
    with pytest.raises(InputError, match=f'another kind of file begins: `format = "{kind}"`'):
        read_tidy(tmp_path / "a.csv")


@pytest.mark.parametrize(("kind", "edit", "match"), [
    ("vicon", lambda text: text.replace(",,mm,mm", ",,mm,deg", 1), "one unit of all positions expected, got deg, mm"),
    ("vicon", lambda text: text.replace("mm", "in"), "unit of its positions must be m, cm or mm, got 'in'"),
    ("vicon", lambda text: text.replace("joint", "tail"), "two markers have this name"),
    ("vicon", lambda text: text.replace("\n50\n", "\nfast\n", 1), "`frames a second`, a number above zero, got 'fast'"),
    ("vicon", lambda text: text.replace("Trajectories", "Joints"), "no section `Trajectories`"),
    ("vicon", lambda text: text.replace("X,Y,Z", "X,Y,Y", 1), "two markers have this name"),
    ("vicon", lambda text: text.replace("\n4,0,", "\n3,0,"), r"column A \(`Frame`\): times must increase"),
    ("vicon", lambda text: text[:-30] + "\n", "cells where the header has"),
    ("qualisys", lambda text: text[: text.rindex("\r\n12\t")], "holds 11 frames, and its header promises 12"),
    ("qualisys", lambda text: text.replace("\t3D", "\t6D"), "no trajectories of markers in 3D"),
    ("qualisys", lambda text: text.replace("\tSnake:head\r", "\r"), "row 11: has 11 cells, where 2 markers make 6"),
    ("qualisys", lambda text: text.replace("Snake:joint", "Snake:tail"), "two markers are called `Snake:tail`"),
    ("qualisys", lambda text: text.replace("NO_OF_FRAMES", "FRAMES"), "begins with `NO_OF_FRAMES`.* got 'FRAMES'"),
    ("trc", lambda text: text[: text.rindex("\n12\t")], "holds 11 frames, and its header promises 12"),
    ("trc", lambda text: text.replace("\tmm\t", "\tfurlongs\t"), "must be m, cm or mm, got 'furlongs'"),
    ("trc", lambda text: text.replace("(X/Y/Z)", "(X/Y)"), "a TRC file begins with"),
    ("trc", lambda text: text.replace("Snake:joint\t", "\t"), "cells where the header has 8"),
])  # fmt: skip
def test_broken_files_are_refused_with_what_is_wrong(tmp_path, kind, edit, match):
    read, text = FILES[kind]
    (tmp_path / "a.csv").write_bytes(edit(text).encode())
    assert edit(text) != text
    with pytest.raises(InputError, match=match):
        read(tmp_path / "a.csv")


@pytest.mark.parametrize("kind", ["vicon", "qualisys", "trc"])
def test_a_file_that_ends_anywhere_is_refused_or_read_as_far_as_it_goes(tmp_path, kind):
    read, text = FILES[kind]
    for end in range(0, len(text), 7):
        (tmp_path / "a.csv").write_bytes(text[:end].encode())
        with contextlib.suppress(InputError):
            frames = len(read(tmp_path / "a.csv").time_s)
            assert frames == FRAMES or kind == "vicon"  # which promises no number


@pytest.mark.parametrize("kind", ["vicon", "qualisys", "trc"])
def test_a_file_without_one_of_its_lines_or_with_an_empty_one_is_no_traceback(tmp_path, kind):
    read, text = FILES[kind]
    lines = text.splitlines()
    for k in range(len(lines)):
        for left in ([], [""], [","], ["\t\t"]):
            (tmp_path / "a.csv").write_text("\n".join([*lines[:k], *left, *lines[k + 1 :]]) + "\n")
            with contextlib.suppress(InputError):
                read(tmp_path / "a.csv")


def test_fragments_without_a_name_are_known_as_such(tmp_path):
    (tmp_path / "a.csv").write_text(vicon().replace("Snake:joint", "*108").replace("Snake:tail", "Snake:*2"))
    assert read_vicon(tmp_path / "a.csv").unlabelled == (True, True, False)
    (tmp_path / "a.tsv").write_text(qualisys().replace("Snake:joint", "New 0012"))
    assert read_qualisys(tmp_path / "a.tsv").unlabelled == (False, True, False)


@pytest.mark.parametrize(
    ("markers", "said"),
    [
        (("Worm:tail", "Worm:joint", "Worm:head"), "begin with `Snake:`, those of `markers` with `Worm:`"),
        (("tail", "joint", "head"), "begin with `Snake:`, those of `markers` with no subject"),
        (("Snake:a", "Snake:b", "Snake:c"), ""),
    ],
)
def test_markers_of_another_subject_are_told_with_both(tmp_path, markers, said):
    (tmp_path / "a.csv").write_text(vicon())
    with pytest.raises(InputError, match="none of the campaign's `markers` is in it") as refused:
        label_vertices(read_vicon(tmp_path / "a.csv"), markers, None, 3, from_head=False)
    assert said in str(refused.value)
    assert ("begin with" in str(refused.value)) == bool(said)


def test_where_the_campaign_names_no_markers_those_of_the_file_are_told(tmp_path):
    (tmp_path / "a.csv").write_text(vicon().replace("Snake:joint", "*108"))
    with pytest.raises(
        InputError, match=r"names no `markers`.*Say them .*tail first; the file has Snake:tail, Snake:h"
    ):
        label_vertices(read_vicon(tmp_path / "a.csv"), None, np.array([0.1]), 2, from_head=False)
