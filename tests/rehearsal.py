"""What the measurement tests share: a snake, its gaits, and where the recordings of others lie."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.measure.consistency.reach import Reach
from serpenoid.medium import Medium
from serpenoid.model import Model

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"
EPS = 0.1865


def snake(eps: float = EPS, dissipation: str = "vertex") -> Model:
    """The paper's proportions, a head and tail heavier than the rest, lengths in metres."""
    edges = (0.0418, *[0.0836] * 9, 0.0418)
    body = Body(vertices=12, edge_lengths=edges, weights=(1.8, *[1.0] * 10, 2.1), mass_kg=1.38)
    return Model(body, Medium(anisotropy_ratio=eps, dissipation=dissipation))


def of_links(lengths: Floats) -> Reach:
    """Where every pair of markers is a link's two ends (M - 1,)."""
    return Reach(lengths, lengths)


def serpenoid_table(rows: int, a: float = 6.0, xi: float = 1.0, turn: float = 0.0) -> np.ndarray:
    """Joint angles (rows, 10) of a travelling serpenoid wave on equal links; not the package's own formula."""
    phase = 2 * np.pi * np.arange(rows)[:, None] / rows
    s, k = (np.arange(11) + 0.5) / 11, 2 * np.pi * xi
    w1, w2 = a * np.cos(phase) + turn, a * np.sin(phase)
    return np.diff(w1 * (1 - np.cos(k * s)) / k + w2 * np.sin(k * s) / k, axis=1)


def write_c3d(path: Path, hidden: tuple[int, int] | None = None) -> None:
    """Two markers at (1, 1, 1) m in five frames, in millimetres; hidden: (marker, frame) that is not seen."""
    import ezc3d

    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [120.0]
    file["parameters"]["POINT"]["LABELS"]["value"] = ["a", "b"]
    file["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
    points = np.ones((4, 2, 5)) * 1000.0
    points[3] = 1.0
    if hidden is not None:
        points[:3, hidden[0], hidden[1]] = np.nan
    file["data"]["points"] = points
    file.write(str(path))
