"""WCON, the Worm tracker Commons Object Notation (JSON): midlines of worms, with their own units, origins and heads.

Layout: openworm/tracker-commons, WCON_format.md. Coordinates are told from the origin `ox, oy`, where there is none
from the centroid `cx, cy`, else from 0; each may be one number or one for every time, and a file may hold an individual
in several parts. `head` says which end is the head: `L` the first point, `R` the last, `?` unknown.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from serpenoid.errors import InputError
from serpenoid.files.inputs import RECORDING_BYTES, read_text
from serpenoid.measure.cells import Floats
from serpenoid.measure.formats.individuals import chosen
from serpenoid.measure.formats.trackers import Timing, as_tracks
from serpenoid.measure.tracks import LENGTHS, SECONDS, End, Tracks

FIRST: dict[str, End] = {"L": "head", "R": "tail"}  # which end of the body the first point is, by the head's side


def read_wcon(path: str | Path, timing: Timing) -> Tracks:
    """The midline of one animal: `units`, and `data` with `t`, `x`, `y`; rows are turned so that heads agree."""
    path = Path(path)
    record = _json(path)
    units, data = record.get("units"), record.get("data")
    listed = data if isinstance(data, list) else [data]
    entries = [e for e in listed if isinstance(e, dict) and {"t", "x", "y"} <= set(e)]
    if not isinstance(units, dict) or not entries or len(entries) < len(listed):
        raise InputError(f"{path}: a WCON file has `units`, and `data` with `t`, `x` and `y`.")
    individual = chosen([str(e.get("id")) for e in entries], timing.individual, path)
    entries = [e for e in entries if str(e.get("id")) == individual]
    length, second = LENGTHS.get(str(units.get("x"))), SECONDS.get(str(units.get("t")))
    lengths = {key: units.get(key) for key in ("x", "y", "ox", "oy", "cx", "cy") if any(key in e for e in entries)}
    if length is None or second is None or {LENGTHS.get(str(unit)) for unit in lengths.values()} != {length}:
        raise InputError(
            f"{path}: `units` must be a time ({', '.join(SECONDS)}) for t, and one length (m, cm, mm, um, px) for "
            f"{', '.join(lengths)}, got {', '.join(f'{k}: `{units.get(k)}`' for k in ('t', *lengths))}. "
            "Correct the file."
        )
    rows = sorted((row for entry in entries for row in _rows(entry, path)), key=lambda row: row[0])
    points = rows[0][1].shape if rows else (0, 2)
    if not points[0] or any(row[1].shape != points for row in rows):
        raise InputError(f"{path}: `x` and `y` must hold as many points at every time.")
    first, floor = _turned([end for _, _, end in rows], np.stack([row for _, row, _ in rows]))
    return as_tracks(path, second * np.array([t for t, _, _ in rows]), floor, timing.length_unit or length, first)


def _rows(entry: dict[str, Any], path: Path) -> Iterator[tuple[float, Floats, End | None]]:
    """(time, points (N, 2), which end is first) of every time of one entry."""
    several = isinstance(entry["t"], list)
    times, xs, ys = ((entry[k] if several else [entry[k]]) for k in ("t", "x", "y"))
    origin = next((pair for pair in (("ox", "oy"), ("cx", "cy")) if any(key in entry for key in pair)), ("ox", "oy"))
    heads = entry.get("head")
    try:
        named = heads if isinstance(heads, list) else [heads] * len(times)
        origins = [np.broadcast_to(np.asarray(entry.get(key, 0.0), float), len(times)) for key in origin]
        for t, x, y, ox, oy, head in zip(times, xs, ys, *origins, named, strict=True):
            row = np.stack([np.atleast_1d(np.array(x, float)) + ox, np.atleast_1d(np.array(y, float)) + oy], axis=1)
            yield float(t), row, FIRST.get(str(head)[:1].upper())
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(
            f"{path}: `t`, `x`, `y` and what stands beside them must be numbers, one list of points at every time: "
            f"{error}."
        ) from None


def _turned(ends: list[End | None], floor: Floats) -> tuple[End | None, Floats]:
    """Which end is first in most rows that say it, and points (F, N, 2) with the other rows turned round."""
    told = [end for end in ends if end is not None]
    if not told:
        return None, floor
    first: End = max(("tail", "head"), key=told.count)
    other = np.array([end not in (first, None) for end in ends])
    floor = floor.copy()
    floor[other] = floor[other, ::-1]
    return first, floor


def _json(path: Path) -> dict[str, Any]:
    text = read_text(path, RECORDING_BYTES)
    try:
        record = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not a JSON file: {str(error)[:100]}.") from None
    if not isinstance(record, dict):
        raise InputError(f"{path}: a WCON file is one JSON object.")
    return record
