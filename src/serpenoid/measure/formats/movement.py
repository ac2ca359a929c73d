"""Poses that `movement` wrote (netCDF): what it had read of DeepLabCut, SLEAP, LightningPose and others.

`position` over time, space, keypoints and individuals, in whatever order; `confidence` likewise; the frame rate, if it
is known, among the attributes. Positions are an image's.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from serpenoid.errors import InputError
from serpenoid.measure.cells import Floats
from serpenoid.measure.formats.hdf5_files import hdf5, require, texts, whole
from serpenoid.measure.formats.individuals import chosen
from serpenoid.measure.formats.scores import sure
from serpenoid.measure.formats.trackers import LIKELY, Timing, as_image
from serpenoid.measure.tracks import Tracks

AXES = ("individuals", "time", "keypoints", "space")
PROBABLE = ("DeepLabCut", "LightningPose")  # those whose confidence is DeepLabCut's likelihood


def read_movement(path: str | Path, timing: Timing) -> Tracks:
    """The points of one individual."""
    path = Path(path)
    with hdf5(path) as file:
        require(file, path, "movement", "position", *AXES)
        who, names, axes = (texts(file[name], path) for name in ("individuals", "keypoints", "space"))
        if axes != ["x", "y"]:
            raise InputError(
                f"{path}: has points in {', '.join(axes) or 'no direction'}, where x and y in a plane are read. Keep "
                'those on the floor: `dataset.sel(space=["x", "y"])`.'
            )
        own = who.index(chosen(who, timing.individual, path)) if who else 0
        floor = _in_order(file["position"], AXES, path)[own]
        score = _in_order(file["confidence"], AXES[:-1], path)[own] if "confidence" in file else None
        frames = np.asarray(whole(file["time"], path), float)
        unit, program = (_word(file.attrs.get(name)) for name in ("time_unit", "source_software"))
    least = LIKELY if timing.minimum_score is None and program in PROBABLE else timing.minimum_score
    if score is not None and least is not None:
        floor = sure(floor, score, least, path)
    seconds = unit == "seconds"  # else they count frames
    return as_image(path, frames, names, floor, Timing(1.0, timing.length_unit) if seconds else timing)


def _in_order(data: Any, axes: tuple[str, ...], path: Path) -> Floats:
    """A data set with its axes in this order, by the names of their scales."""
    called = [next((scale.name.strip("/") for scale in dim.values()), "") for dim in data.dims]
    if sorted(called) != sorted(axes):
        raise InputError(f"{path}: `{data.name.strip('/')}` must be over {', '.join(axes)}, got {', '.join(called)}.")
    return np.asarray(whole(data, path), float).transpose([called.index(axis) for axis in axes])


def _word(value: Any) -> str:
    """An attribute, in words."""
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)
