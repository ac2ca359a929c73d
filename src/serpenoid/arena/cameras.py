"""What the cameras make of the markers: noise, occlusions in bursts, fragments without a label - a Motive CSV file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from serpenoid.arena.protocol import Cameras
from serpenoid.arena.robot import Robot
from serpenoid.body import Floats
from serpenoid.files.writing import atomic

ASSET = "Snake"
FIRST_FRAGMENT = 1001


@dataclass(frozen=True)
class Track:
    """One marker column group: name as exported, id, positions (F, 3) in floor axes [m], NaN where not seen."""

    name: str
    positions: Floats


def marker_names(robot: Robot) -> list[str]:
    """Of the vertices, tail to head."""
    names = [f"point_{vertex}" for vertex in range(robot.wheels)]
    for number, vertex in enumerate(robot.links.joints, 1):
        names[vertex] = f"joint_{number}"
    return ["tail", *names[1:-1], "head"]


def film(markers: Floats, names: Sequence[str], cameras: Cameras, random: np.random.Generator) -> list[Track]:
    """Tracks as exported, labelled markers first, from true positions (F, N, 3)."""
    seen = markers + random.normal(0, cameras.noise_m, markers.shape)
    fragments: list[Track] = []
    for vertex in range(len(names)):
        for burst in _bursts(len(seen), cameras, random):
            if random.random() < cameras.unlabelled:
                fragments.append(_fragment(seen[:, vertex], burst, FIRST_FRAGMENT + len(fragments)))
            seen[burst, vertex] = np.nan
    labelled = [Track(f"{ASSET}:{name}", seen[:, vertex]) for vertex, name in enumerate(names)]
    return labelled + fragments


def _bursts(frames: int, cameras: Cameras, random: np.random.Generator) -> Iterator[slice]:
    """Occlusions of one marker: geometric lengths, spaced so that the asked-for share is hidden."""
    if cameras.dropout == 0:
        return
    mean = max(1.0, cameras.dropout_burst_s * cameras.frames_per_second)
    spacing = mean * (1 - cameras.dropout) / cameras.dropout
    begin = int(random.exponential(spacing))
    while begin < frames:
        length = int(random.geometric(1 / mean))
        yield slice(begin, begin + length)
        begin += length + 1 + int(random.exponential(spacing))


def _fragment(positions: Floats, burst: slice, number: int) -> Track:
    part = np.full_like(positions, np.nan)
    part[burst] = positions[burst]
    return Track(f"Unlabeled {number}", part)


def write_motive(path: Path, tracks: list[Track], frames_per_second: float, take: str, started: str) -> None:
    """Motive CSV, layout 1.25, metres, Y up: file x is floor y, file y is height, file z is floor x."""
    with atomic(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as stream:
        stream.writelines(line + "\r\n" for line in _lines(tracks, frames_per_second, take, started))


def _lines(tracks: list[Track], frames_per_second: float, take: str, started: str) -> Iterator[str]:
    frames = len(tracks[0].positions)
    head = {
        "Format Version": "1.25",
        "Take Name": take,
        "Take Notes": "",
        "Capture Frame Rate": f"{frames_per_second:.6f}",
        "Export Frame Rate": f"{frames_per_second:.6f}",
        "Capture Start Time": started,
        "Capture Start Frame": "0",
        "Total Frames in Take": str(frames),
        "Total Exported Frames": str(frames),
        "Rotation Type": "Quaternion",
        "Length Units": "Meters",
        "Coordinate Space": "Global",
    }
    yield ",".join(f"{key},{value}" for key, value in head.items())
    yield ""
    yield _label("Type", ["Marker"] * len(tracks))
    yield _label("Name", [track.name for track in tracks])
    yield _label("ID", [f'"{0x5E47000000000000 + number:016X}"' for number in range(len(tracks))])
    yield _label("Parent", [ASSET if ":" in track.name else "" for track in tracks])
    yield ",," + ",".join(["Position"] * 3 * len(tracks))
    yield "Frame,Time (Seconds)," + ",".join(["X,Y,Z"] * len(tracks))
    cells = np.concatenate([track.positions[:, [1, 2, 0]] for track in tracks], axis=1)
    for frame, row in enumerate(cells):
        values = ("" if value != value else f"{value:.6f}" for value in row.tolist())
        yield f"{frame},{frame / frames_per_second:.6f}," + ",".join(values)


def _label(title: str, values: list[str]) -> str:
    return f",{title}," + ",".join(value for value in values for _ in range(3))
