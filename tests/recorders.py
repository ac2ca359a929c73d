"""Files as other programs write them, made from their documentation alone: times [s] and points (F, N, 2), tail first.

What each wrote last is known: a reader has to give it back, with y upwards.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

DOWN = np.array([1.0, -1.0])


def names_of(points: np.ndarray) -> list[str]:
    """tail, p1, p2, ..., head."""
    return ["tail", *(f"p{k}" for k in range(1, points.shape[1] - 1)), "head"]


def ethovision(
    path: Path, time: np.ndarray, points: np.ndarray, names: Sequence[str], order: Sequence[int], unit: str = "mm"
) -> None:
    """Raw data of one track as Excel: facts, names of columns, units, a row for each sample; `-` is not found."""
    import openpyxl

    book = openpyxl.Workbook()
    sheet = book.active
    sheet.title = "Track-Arena 1-Subject 1"
    for row in (["Number of header lines:", 7], ["Experiment", "worms"], ["Start time", "01.05.2024 12:00:00"],
                ["Subject", "Subject 1"], []):  # fmt: skip
        sheet.append(row)
    sheet.append(["Trial time", "Recording time", *(f"{axis} {names[k]}" for k in order for axis in "XY"), "Area"])
    sheet.append(["s", "s", *[unit] * (2 * len(order)), f"{unit}\N{SUPERSCRIPT TWO}"])
    for t, row in zip(time.tolist(), points, strict=True):
        cells = [float(value) if np.isfinite(value) else "-" for k in order for value in row[k]]
        sheet.append([t, t, *cells, 1.5])
    book.save(path)


def trackmate(
    path: Path, time: np.ndarray, points: np.ndarray, unit: str = "mm", clock: str = "sec", whole: bool = False
) -> None:
    """`Export tracks to XML file`, or (whole) what TrackMate itself saves: spots by frames, edges by tracks."""
    step = float(time[1] - time[0])
    image = [[(f"{x:.6f}", f"{y:.6f}") for x, y in row] for row in points * DOWN]
    seen_of = [np.flatnonzero(np.isfinite(points[:, k, 0])).tolist() for k in range(points.shape[1])]
    frames, count = len(time), points.shape[1]
    if not whole:
        lines = [f'<Tracks nTracks="{count}" spaceUnits={quoteattr(unit)} frameInterval="{step}" '
                 f'timeUnits="{clock}" generationDateTime="Tue, 16 Apr 2024" from="TrackMate v7.12.2">']  # fmt: skip
        for k, seen in enumerate(seen_of):
            lines.append(f'  <particle nSpots="{len(seen)}">')
            lines += [f'    <detection t="{f}" x="{image[f][k][0]}" y="{image[f][k][1]}" z="0.0" />' for f in seen]
            lines.append("  </particle>")
        path.write_text('<?xml version="1.0" encoding="UTF-8"?>\n' + "\n".join([*lines, "</Tracks>"]), "utf-8")
        return
    lines = ['<TrackMate version="7.12.2">', f'  <Model spatialunits={quoteattr(unit)} timeunits="{clock}">',
             f'    <AllSpots nspots="{frames * count}">']  # fmt: skip
    for f in range(frames):
        lines.append(f'      <SpotsInFrame frame="{f}">')
        lines += [
            f'        <Spot ID="{f * count + k}" name="ID{f * count + k}" POSITION_X="{image[f][k][0]}" '
            f'POSITION_Y="{image[f][k][1]}" POSITION_Z="0.0" POSITION_T="{f * step}" FRAME="{f}" VISIBILITY="1" />'
            for k in range(count)
            if f in seen_of[k]
        ]
        if f == 0:
            lines.append('        <Spot ID="999999" name="lost" POSITION_X="5.0" POSITION_Y="5.0" POSITION_T="0.0" '
                         'FRAME="0" VISIBILITY="0" />')  # fmt: skip
        lines.append("      </SpotsInFrame>")
    lines += ["    </AllSpots>", "    <AllTracks>"]
    for k, seen in enumerate(seen_of):
        lines.append(f'      <Track name="Track_{k}" TRACK_ID="{k}" NUMBER_SPOTS="{len(seen)}">')
        pairs = zip(seen, seen[1:], strict=False)
        lines += [f'        <Edge SPOT_SOURCE_ID="{a * count + k}" SPOT_TARGET_ID="{b * count + k}" LINK_COST="0.1" />'
                  for a, b in pairs]  # fmt: skip
        lines.append("      </Track>")
    lines += ["    </AllTracks>", "    <FilteredTracks>", *(f'      <TrackID TRACK_ID="{k}" />' for k in range(count)),
              "    </FilteredTracks>", "  </Model>", "  <Settings>",
              f'    <ImageData filename="a.tif" width="512" height="512" nframes="{frames}" pixelwidth="1.0" '
              f'timeinterval="{step}" />', "  </Settings>", "</TrackMate>"]  # fmt: skip
    path.write_text('<?xml version="1.0" encoding="UTF-8"?>\n' + "\n".join(lines), "utf-8")


def imagej_results(path: Path, points: np.ndarray) -> None:
    """Multi-point selections measured slice by slice: a row for each point, none of whose columns says which it is."""
    rows = [" ,Area,Mean,X,Y,Slice"]
    for f, row in enumerate(points * DOWN):
        rows += [f"{len(rows) + k},0,128,{x:.4f},{y:.4f},{f + 1}" for k, (x, y) in enumerate(row)]
    path.write_text("\n".join(rows) + "\n")


def tracker(path: Path, time: np.ndarray, points: np.ndarray, names: Sequence[str], mark: str = "\t") -> None:
    """Tables of several point masses beside one another, each with its own t, x, y below its name."""
    rows = [mark.join(f"{name}{mark}{mark}" for name in names), mark.join(["t", "x", "y"] * len(names))]
    for t, row in zip(time, points, strict=True):
        rows.append(mark.join(mark.join((f"{t:.4E}", f"{x:.5E}", f"{y:.5E}")) for x, y in row))
    path.write_text("\n".join(rows) + "\n")


def wcon(path: Path, time: np.ndarray, points: np.ndarray) -> None:
    """One object of JSON, packed where the name ends in .zip."""
    data = {"id": "1", "t": time.tolist(), "x": points[..., 0].tolist(), "y": points[..., 1].tolist()}
    text = json.dumps({"units": {"t": "s", "x": "mm", "y": "mm"}, "data": [data]})
    if path.suffix == ".zip":
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr(path.stem, text)
    else:
        path.write_text(text)


def qtm_mat(path: Path, time: np.ndarray, points: np.ndarray, names: Sequence[str]) -> None:
    """QTM's export to MATLAB: a structure of the file's name, `Trajectories.Labeled.Data` (markers, 4, frames) [mm]."""
    from scipy.io import savemat

    frames, count = points.shape[:2]
    data = np.concatenate([points, 0 * points[..., :1] + 5.0, 0 * points[..., :1] + 0.1], axis=2)
    labels = np.empty((1, count), dtype=object)
    labels[0, :] = list(names)
    labelled = {"Count": float(count), "Labels": labels, "Data": data.transpose(1, 2, 0)}
    take = {"File": "C:\\take.qtm", "StartFrame": 1.0, "Frames": float(frames), "FrameRate": 1 / (time[1] - time[0]),
            "Trajectories": {"Labeled": labelled, "Unidentified": {"Count": 0.0}}}  # fmt: skip
    savemat(path, {"qtm_take": take})


def sleap_project(
    path: Path, points: np.ndarray, names: Sequence[str], tracks: Sequence[str] = (), by_hand: int | None = None
) -> None:
    """A project of SLEAP (.slp): predictions of every frame, of each track; one frame corrected by hand.

    points: (F, N, 2) [px, y up], of the first track; others stand 1000 px beside.
    """
    import h5py

    frames, count = points.shape[:2]
    animals = max(1, len(tracks))
    predicted = np.zeros(frames * animals * count, [("x", "<f8"), ("y", "<f8"), ("visible", "?"), ("complete", "?"),
                                                    ("score", "<f8")])  # fmt: skip
    instances = np.zeros(frames * animals + (by_hand is not None), [
        ("instance_id", "<i8"), ("instance_type", "u1"), ("frame_id", "<u8"), ("skeleton", "<u4"), ("track", "<i4"),
        ("from_predicted", "<i8"), ("score", "<f4"), ("point_id_start", "<u8"), ("point_id_end", "<u8"),
        ("tracking_score", "<f4")])  # fmt: skip
    table = np.zeros(frames, [("frame_id", "<u8"), ("video", "<u4"), ("frame_idx", "<u8"),
                              ("instance_id_start", "<u8"), ("instance_id_end", "<u8")])  # fmt: skip
    hand = np.zeros(count if by_hand is not None else 0, [("x", "<f8"), ("y", "<f8"), ("visible", "?"),
                                                          ("complete", "?")])  # fmt: skip
    shown = np.stack([points * DOWN + 1000 * k for k in range(animals)], axis=1)
    at = 0
    for f in range(frames):
        begin = at
        for k in range(animals):
            first = (f * animals + k) * count
            piece = predicted[first : first + count]
            piece["x"], piece["y"] = shown[f, k].T + (7.0 if f == by_hand else 0.0)
            piece["score"], piece["visible"] = 0.9, np.isfinite(shown[f, k, :, 0])
            instances[at] = (at, 1, f, 0, k if tracks else -1, -1, 0.9, first, first + count, 0.0)
            at += 1
        if f == by_hand:
            hand["x"], hand["y"] = shown[f, 0].T
            hand["visible"] = True
            instances[at] = (at, 0, f, 0, 0 if tracks else -1, begin, 0.0, 0, count, 0.0)
            at += 1
        table[f] = (f, 0, f, begin, at)
    order = list(range(count))[::-1]  # of the project's nodes, of which the skeleton's refer to
    nodes = [{"name": names[k], "weight": 1.0} for k in order]
    meta = {"version": "2.0.0", "skeletons": [{"nodes": [{"id": order.index(k)} for k in range(count)], "links": []}],
            "nodes": nodes}  # fmt: skip
    with h5py.File(path, "w") as file:
        group = file.create_group("metadata")
        group.attrs["format_id"], group.attrs["json"] = 1.2, np.bytes_(json.dumps(meta))
        file["videos_json"] = np.array([json.dumps({"backend": {"filename": "a.mp4"}})], dtype="S")
        file.create_dataset("tracks_json", data=np.array([json.dumps([0, name]) for name in tracks], dtype="S80"))
        file["frames"], file["instances"] = table, instances
        file["points"], file["pred_points"] = hand, predicted


def toxtrac(path: Path, time: np.ndarray, points: np.ndarray) -> None:
    """A row for each animal and frame, without names of columns: frame, arena, track, x, y, label."""
    rows = [f"{f}\t1\t{k + 1}\t{x:.4f}\t{y:.4f}\t1" for f, row in enumerate(points) for k, (x, y) in enumerate(row)]
    path.write_text("\n".join(rows) + "\n")
