"""One interface for all motion files: the name in `[motion] format` -> a reader (path, keys) -> Tracks.

A reader gives points in the order of the file, in metres where the file or `length_unit` says so, y up; what it does
not understand it refuses by file, row and column. Another format is a function, its name in `MotionFormat`, and a
`Format` in `READERS`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal, get_args

from serpenoid.errors import InputError
from serpenoid.measure.formats.arrays import read_array
from serpenoid.measure.formats.hdf5_files import is_hdf5
from serpenoid.measure.formats.motive import read_motive
from serpenoid.measure.formats.movement import read_movement
from serpenoid.measure.formats.points import read_c3d, read_long, read_sleap
from serpenoid.measure.formats.qualisys import read_qualisys
from serpenoid.measure.formats.sleap_project import is_project, read_sleap_project
from serpenoid.measure.formats.tidy import read_tidy
from serpenoid.measure.formats.trackers import Timing, read_deeplabcut, read_sleap_analysis, read_tierpsy
from serpenoid.measure.formats.trackmate import read_trackmate
from serpenoid.measure.formats.trc import read_trc
from serpenoid.measure.formats.trex import read_trex
from serpenoid.measure.formats.vicon import read_vicon
from serpenoid.measure.formats.wcon import read_wcon
from serpenoid.measure.tracks import Tracks

if TYPE_CHECKING:
    from serpenoid.measure.campaign import MotionKeys

    Reader = Callable[[Path, MotionKeys], Tracks]

MotionFormat = Literal[
    "motive",
    "vicon",
    "qualisys",
    "trc",
    "c3d",
    "deeplabcut",
    "sleap",
    "movement",
    "tierpsy",
    "trackmate",
    "trex",
    "wcon",
    "array",
    "tidy",
    "long",
]
NAMES: tuple[str, ...] = get_args(MotionFormat)
FORMATS = " | ".join(NAMES)
LONG = (
    'It has one row per frame and point: `columns = { time = "t", point = "id", x = "x", y = "y" }`; '
    'with two columns per point, `format = "tidy"`.'
)


def _timed(read: Callable[[Path, Timing], Tracks]) -> Reader:
    """A reader that needs what [motion] says of time, length and score."""

    def reader(path: Path, keys: MotionKeys) -> Tracks:
        return read(path, Timing(keys.frames_per_second, keys.length_unit, keys.minimum_score, keys.individual))

    return reader


def _sleap(path: Path, keys: MotionKeys) -> Tracks:
    if is_hdf5(path):
        return _timed(read_sleap_project if is_project(path) else read_sleap_analysis)(path, keys)
    return read_sleap(
        path, keys.frames_per_second, keys.length_unit or "px", keys.minimum_score or 0.0, keys.individual
    )


def _long(path: Path, keys: MotionKeys) -> Tracks:
    if keys.columns is None or keys.length_unit is None:
        raise InputError(f'{path}: `format = "long"` needs `columns` and `length_unit` in [motion]. {LONG}')
    columns = {role: name for role, name in keys.columns if isinstance(name, str)}
    if not {"x", "y"} <= set(columns) or not {"time", "frame"} & set(columns):
        raise InputError(
            f"{path}: `columns` needs x, y and time or frame for a long file, a name for each, and `point` where a "
            "column says which point a row is of."
        )
    return read_long(path, columns, keys.length_unit, keys.frames_per_second, keys.time_unit or "s", keys.individual)


def _tidy(path: Path, keys: MotionKeys) -> Tracks:
    return read_tidy(path, keys.length_unit or "m", keys.frames_per_second, keys.columns, keys.time_unit or "s")


@dataclass(frozen=True)
class Format:
    """A kind of motion file. read: makes tracks of one. up_axis: of points in space, where [motion] names none.

    vertices: its points are the body's vertices already, in order. For a new campaign: animals, whether its films show
    those; named, whether its points have names; unit, its `length_unit`; lines, more lines of [motion].
    """

    read: Reader
    up_axis: str | None = None
    vertices: bool = False
    animals: bool = False
    named: bool = False
    unit: str = "m"
    lines: tuple[str, ...] = ()


def _in_space(read: Callable[[Path, str], Tracks], up: str) -> Format:
    """Of markers with names in space, which says its units and times."""

    def reader(path: Path, keys: MotionKeys) -> Tracks:
        return read(path, keys.up_axis or up)

    return Format(reader, up, named=True, lines=(f'up_axis = "{up}"                # what points up, usually',))


READERS: dict[str, Format] = {
    "motive": _in_space(read_motive, "y"),
    "vicon": _in_space(read_vicon, "z"),
    "qualisys": _in_space(read_qualisys, "z"),
    "trc": _in_space(read_trc, "y"),
    "c3d": _in_space(read_c3d, "z"),
    "deeplabcut": Format(_timed(read_deeplabcut), animals=True, named=True, unit="px"),
    "sleap": Format(_sleap, animals=True, named=True, unit="px"),
    "movement": Format(_timed(read_movement), animals=True, named=True, unit="px"),
    "tierpsy": Format(_timed(read_tierpsy), animals=True),
    "trackmate": Format(_timed(read_trackmate), animals=True, named=True),
    "trex": Format(_timed(read_trex), animals=True),
    "wcon": Format(_timed(read_wcon), animals=True),
    "array": Format(_timed(read_array)),
    "tidy": Format(
        _tidy,
        vertices=True,
        lines=('# columns = { time = "t_s", x = "x_*", y = "y_*" }   # names of your own, two columns per point',),
    ),
    "long": Format(
        _long,
        lines=(
            'columns = { time = "t", point = "point", x = "x", y = "y" }   # your names: one row per frame and point',
        ),
    ),
}


def up_axis(name: str | None) -> str:
    """The vertical axis that a format usually has."""
    return (READERS[name].up_axis if name in READERS else None) or "z"
