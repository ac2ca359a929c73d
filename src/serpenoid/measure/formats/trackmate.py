"""TrackMate's XML: what it saves itself, and its export of tracks; each track is a point.

Layout of the export: `Tracks` (spaceUnits, frameInterval, timeUnits), in it `particle`, in it `detection` (t, a frame;
x, y). Of what it saves: `Model` (spatialunits, timeunits) with `Spot` (ID, FRAME, POSITION_X, POSITION_Y), `Track`
(name, TRACK_ID) of `Edge` (SPOT_SOURCE_ID, SPOT_TARGET_ID), `TrackID` of those that filters left; `ImageData`
(timeinterval). y counts downwards, in whatever unit.
"""

from __future__ import annotations

from pathlib import Path
from typing import cast
from xml.etree.ElementTree import ParseError, XMLParser

import numpy as np

from serpenoid.errors import InputError
from serpenoid.files.inputs import RECORDING_BYTES, number, read_unpacked
from serpenoid.measure.formats.trackers import Timing, as_named
from serpenoid.measure.tracks import DOWN, LENGTHS, SECONDS, Tracks, no_time
from serpenoid.wording import counted

MOST_CELLS = 100_000_000
NO_TRACKS = "holds no tracks: track the points of the body in TrackMate, one track each, and save it again."


class _Spots:
    """What a parser found: by track its spots (frame, x, y), and what is said of units."""

    def __init__(self) -> None:
        self.root = ""
        self.units: dict[str, str] = {}
        self.spots: dict[str, dict[str, str]] = {}
        self.members: dict[str, dict[str, None]] = {}  # of each track the IDs of its spots
        self.kept: set[str] = set()
        self.ids: dict[str, str] = {}
        self.track = ""

    def start(self, tag: str, said: dict[str, str]) -> None:
        """An element begins."""
        self.root = self.root or tag
        if tag in ("Tracks", "Model", "ImageData"):
            self.units |= said
        elif tag in ("particle", "Track"):
            name = said.get("name") or f"Track_{said.get('TRACK_ID', len(self.members))}"
            self.track = f"{name} ({len(self.members)})" if name in self.members else name
            self.members[self.track] = {}
            self.ids[self.track] = said.get("TRACK_ID", self.track)
        elif tag == "detection":
            spot = str(len(self.spots))
            self.spots[spot] = {"FRAME": said.get("t", ""), "POSITION_X": said.get("x", ""),
                                "POSITION_Y": said.get("y", "")}  # fmt: skip
            self.members.setdefault(self.track, {})[spot] = None
        elif tag == "Spot":
            self.spots[said.get("ID", "")] = said
        elif tag == "Edge":
            ends = (said.get("SPOT_SOURCE_ID", ""), said.get("SPOT_TARGET_ID", ""))
            self.members.setdefault(self.track, {}).update(dict.fromkeys(ends))
        elif tag == "TrackID":
            self.kept.add(said.get("TRACK_ID", ""))

    def close(self) -> _Spots:
        """All of the file."""
        return self


def read_trackmate(path: str | Path, timing: Timing) -> Tracks:
    """All tracks that filters left as points, in the order of the file, which need not be that of the body."""
    path = Path(path)
    found = _parsed(path)
    tracks = {name: list(ids) for name, ids in found.members.items() if ids}
    tracks = {name: ids for name, ids in tracks.items() if not found.kept or found.ids[name] in found.kept}
    if not tracks:
        raise InputError(f"{path}: {NO_TRACKS}")
    rows = np.array([(k, *_row(found, spot, path)) for k, ids in enumerate(tracks.values()) for spot in ids])
    frames, at = np.unique(rows[:, 1], return_inverse=True)
    cells = at * len(tracks) + rows[:, 0].astype(int)
    if len(np.unique(cells)) < len(cells):
        first = rows[np.setdiff1d(np.arange(len(rows)), np.unique(cells, return_index=True)[1])[0]]
        raise InputError(
            f"{path}: track `{list(tracks)[int(first[0])]}` has two spots in frame {first[1]:g}: where tracks split or "
            "merge, nothing says which is the point of the body. Take that apart in TrackMate."
        )
    if len(frames) * len(tracks) > MOST_CELLS:
        raise InputError(f"{path}: {counted(len(frames), 'frame')} of {counted(len(tracks), 'track')}. Is it one film?")
    floor = np.full((len(frames) * len(tracks), 2), np.nan)
    floor[cells] = rows[:, 2:]
    floor = floor.reshape(len(frames), len(tracks), 2) * DOWN
    return as_named(path, frames * _interval(found, timing, path), list(tracks), floor, _length(found, timing, path))


def _parsed(path: Path) -> _Spots:
    data = read_unpacked(path, RECORDING_BYTES)
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        raise InputError(f"{path}: not a file of TrackMate: it declares entities.")
    parser = XMLParser(target=_Spots())
    try:
        parser.feed(data)
        found = cast(_Spots, parser.close())
    except (ParseError, ValueError, LookupError) as error:
        raise InputError(f"{path}: not a readable XML file ({error}). Was the copy cut off?") from None
    if found.root not in ("Tracks", "TrackMate"):
        raise InputError(
            f"{path}: begins with `{found.root[:40]}`, where a file of TrackMate has `TrackMate` or `Tracks`. Export a "
            "table of points as CSV."
        )
    return found


def _row(found: _Spots, spot: str, path: Path) -> tuple[float, float, float]:
    """Frame, x and y of a spot."""
    said = found.spots.get(spot)
    if said is None:
        raise InputError(f"{path}: a track has a spot `{spot[:20]}`, which is not in the file. Was it cut off?")
    values = [number(said.get(key, "")) for key in ("FRAME", "POSITION_X", "POSITION_Y")]
    if any(value is None for value in values):
        raise InputError(f"{path}: spot `{said.get('name', spot)[:20]}` has no numbers for its frame and position.")
    frame, x, y = (float(value or 0.0) for value in values)
    return frame, x, y


def _length(found: _Spots, timing: Timing, path: Path) -> str:
    said = found.units.get("spaceUnits") or found.units.get("spatialunits") or ""
    unit = timing.length_unit or LENGTHS.get(said.casefold())
    if unit is None:
        raise InputError(f"{path}: its unit of length is {said[:20]!r}: give `length_unit` in [motion].")
    return unit


def _interval(found: _Spots, timing: Timing, path: Path) -> float:
    """Seconds from frame to frame."""
    if timing.frames_per_second:
        return 1 / timing.frames_per_second
    unit = SECONDS.get((found.units.get("timeUnits") or found.units.get("timeunits") or "").casefold())
    step = number(found.units.get("frameInterval") or found.units.get("timeinterval") or "")
    if unit is None or not step or step < 0:
        raise no_time(path, "counts frames")
    return unit * step
