"""Projects of SLEAP (`.slp`, HDF5): what it predicted, and what a person set or corrected, which goes before.

Layout: sleap-io, formats/slp.md. `frames` are rows of `instances`, these of `points` (set by hand) or `pred_points`;
`tracks_json` names animals; nodes stand in `metadata`, each skeleton's in its own order.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from serpenoid.errors import InputError
from serpenoid.measure.cells import Floats
from serpenoid.measure.formats.hdf5_files import hdf5, require, texts, whole
from serpenoid.measure.formats.individuals import chosen
from serpenoid.measure.formats.scores import sure
from serpenoid.measure.formats.trackers import Timing, as_image
from serpenoid.measure.tracks import Tracks
from serpenoid.wording import counted

BY_HAND = 0  # type of an instance
NO_TRACK = ""


def is_project(path: Path) -> bool:
    """Whether an HDF5 file is one."""
    with hdf5(path) as file:
        return "instances" in file


def read_sleap_project(path: str | Path, timing: Timing) -> Tracks:
    """The points of one animal in one film, in the order of its skeleton."""
    path = Path(path)
    with hdf5(path) as file:
        require(file, path, "SLEAP project", "metadata", "frames", "instances", "points", "pred_points")
        meta = _json(file["metadata"].attrs["json"], path)
        frames, instances = whole(file["frames"], path), whole(file["instances"], path)
        stored = {True: whole(file["points"], path), False: whole(file["pred_points"], path)}
        called = [_json(word, path) for word in texts(file["tracks_json"], path)] if "tracks_json" in file else []
        videos = np.unique(frames["video"][frames["instance_id_end"] > frames["instance_id_start"]])
        if len(videos) > 1:
            raise InputError(
                f"{path}: has points of {len(videos)} films, where one is read: export each as analysis HDF5 in SLEAP."
            )
        kinds = np.unique(instances["skeleton"])
        if len(kinds) != 1:
            raise InputError(f"{path}: has points of {counted(len(kinds), 'skeleton')}, where one is read.")
        names = _nodes(meta, int(kinds[0]), path)
        animals = [str(called[k][1]) if 0 <= k < len(called) else NO_TRACK for k in instances["track"].tolist()]
        tracked = [name for name in animals if name != NO_TRACK]
        own = chosen(tracked, timing.individual, path)
        numbers, floor, score = _of_animal(
            frames, instances, stored, [name == own for name in animals], len(names), path
        )
    if timing.minimum_score is not None:
        floor = sure(floor, score, timing.minimum_score, path)
    return as_image(path, numbers, names, floor, timing)


def _of_animal(
    frames: Any, instances: Any, stored: dict[bool, Any], mine: list[bool], count: int, path: Path
) -> tuple[Floats, Floats, Floats]:
    """Numbers of frames (F,), points (F, N, 2) and scores (F, N) of one animal's instances."""
    shown: dict[int, tuple[bool, Floats, Floats]] = {}
    for frame in frames:
        index = int(frame["frame_idx"])
        for k in range(int(frame["instance_id_start"]), int(frame["instance_id_end"])):
            if not mine[k]:
                continue
            by_hand = int(instances["instance_type"][k]) == BY_HAND
            if index in shown and shown[index][0] == by_hand:
                raise InputError(
                    f"{path}: frame {index} shows two animals of one track, or of none. Track them in SLEAP, or "
                    "take one out."
                )
            if index in shown and shown[index][0]:
                continue
            first, end = int(instances["point_id_start"][k]), int(instances["point_id_end"][k])
            points = stored[by_hand][first:end]
            if len(points) != count:
                raise InputError(
                    f"{path}: frame {index} has {counted(len(points), 'point')} of {counted(count, 'node')}."
                )
            seen = np.asarray(points["visible"], bool)[:, None]
            place = np.where(seen, np.stack([points["x"], points["y"]], axis=1), np.nan)
            shown[index] = (by_hand, place, np.full(count, np.inf) if by_hand else np.asarray(points["score"], float))
    if not shown:
        raise InputError(f"{path}: holds no points: predict, or label frames, and save the project again.")
    order = sorted(shown)
    return np.array(order, float), np.stack([shown[k][1] for k in order]), np.stack([shown[k][2] for k in order])


def _nodes(meta: Any, skeleton: int, path: Path) -> list[str]:
    """Names of a skeleton's nodes."""
    try:
        return [str(meta["nodes"][int(node["id"])]["name"]) for node in meta["skeletons"][skeleton]["nodes"]]
    except (LookupError, TypeError, ValueError):
        raise InputError(f"{path}: its skeleton cannot be read. Export analysis HDF5 in SLEAP.") from None


def _json(word: Any, path: Path) -> Any:
    try:
        return json.loads(word)
    except (ValueError, TypeError, RecursionError):
        raise InputError(f"{path}: its description cannot be read. Export analysis HDF5 in SLEAP.") from None
