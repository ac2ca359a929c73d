"""Recordings written as a laboratory would: Motive CSV, servo log, power log. For rehearsals and round trips."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from serpenoid.files.writing import write_csv, write_text
from serpenoid.measure.cells import Floats


def write_motive(
    path: str | Path,
    time_s: Floats,
    floor_m: Floats,
    names: Sequence[str],
    version: str = "1.23",
    unit: str = "Meters",
    height_m: float = 0.05,
) -> None:
    """Positions (F, M, 2) [m] on the floor as a Motive export (file Z = floor x, file X = floor y); NaN: hidden."""
    scale = {"Meters": 1.0, "Centimeters": 100.0, "Millimeters": 1000.0}[unit]
    frames, markers = floor_m.shape[:2]
    rate = (frames - 1) / (time_s[-1] - time_s[0])
    facts = ["Format Version", version, "Take Name", "rehearsal", "Capture Frame Rate", f"{rate:.6f}"]
    facts += ["Export Frame Rate", f"{rate:.6f}", "Total Frames in Take", str(frames)]
    facts += ["Total Exported Frames", str(frames), "Rotation Type", "Quaternion", "Length Units", unit]
    label = [("", "") if version in ("1.21", "1.22") else ("", word) for word in ("Type", "Name", "ID")]
    triple = [name for name in names for _ in range(3)]
    lines = [",".join(facts), "", ",".join((*label[0], *["Marker"] * 3 * markers)), ",".join((*label[1], *triple))]
    lines.append(",".join((*label[2], *[f"ID{k}" for k in range(markers) for _ in range(3)])))
    if version == "1.25":
        lines.append(",".join(("", "Parent", *[""] * 3 * markers)))
    lines.append(",".join(("", "", *["Position"] * 3 * markers)))
    lines.append(",".join(("Frame", "Time (Seconds)", *["X", "Y", "Z"] * markers)))
    cells = np.full((frames, markers, 3), height_m)
    cells[..., 2], cells[..., 0] = floor_m[..., 0], floor_m[..., 1]
    cells[~np.isfinite(floor_m).all(axis=2)] = np.nan
    for frame, (time, row) in enumerate(zip(time_s, (cells * scale).reshape(frames, -1), strict=True)):
        lines.append(f"{frame},{time:.6f}," + ",".join("" if np.isnan(v) else f"{v:.6f}" for v in row))
    write_text(path, "\n".join(lines) + "\n")


def write_servo_log(
    path: str | Path,
    time_s: Floats,
    position: Floats,
    command: Floats | None = None,
    schedule: Sequence[tuple[str, int, int]] | None = None,
) -> None:
    """Joint angles (R, m) [rad] and, if given, the commands and (phase, cycle, step) of every row."""
    joints = range(1, position.shape[1] + 1)
    header, columns = ["t_s"], [time_s[:, None]]
    if command is not None:
        header += [f"command_{j}" for j in joints]
        columns.append(command)
    header += [f"position_{j}" for j in joints]
    columns.append(position)
    numbers = np.hstack(columns)
    if schedule is None:
        write_csv(path, header, numbers.tolist())
        return
    rows = [[row[0], *where, *row[1:]] for row, where in zip(numbers.tolist(), schedule, strict=True)]
    write_csv(path, [header[0], "phase", "cycle", "step", *header[1:]], rows)


def write_power_log(path: str | Path, time_s: Floats, power_W: Floats, voltage_V: float = 11.1) -> None:
    """Power [W] with the current that a constant voltage makes of it."""
    rows = [[t, voltage_V, p / voltage_V, p] for t, p in zip(time_s.tolist(), power_W.tolist(), strict=True)]
    write_csv(path, ["t_s", "voltage_V", "current_A", "power_W"], rows)
