"""A C3D file's points as NPZ on standard output: in a process of its own, for ezc3d can crash on a damaged file.

    python -m serpenoid.measure.c3d_child FILE MEGABYTES

What is wrong with the file goes to standard error, and the exit code is 2. Memory is limited to MEGABYTES.
"""

from __future__ import annotations

import io
import sys
from typing import Any

import numpy as np


def main(path: str, megabytes: int) -> int:
    """Points (3, M, F), residuals (M, F), labels, unit, rate."""
    import ezc3d

    _limit_memory(megabytes * 1_000_000)
    try:
        content = ezc3d.c3d(path)
        group: dict[str, Any] = content["parameters"]["POINT"]
        unit = str((group["UNITS"]["value"] or ["mm"])[0]).strip()
        labels, rate = [str(label) for label in group["LABELS"]["value"]], float(group["RATE"]["value"][0])
        points = np.array(content["data"]["points"][:3], dtype=float)
        residuals = np.array(content["data"]["meta_points"]["residuals"])[0]
    except Exception as error:  # noqa: BLE001 - whatever a library of another language throws
        sys.stderr.write(f"{error}\n")
        return 2
    stream = io.BytesIO()
    np.savez(stream, points=points, residuals=residuals, labels=np.array(labels, dtype="U"), unit=unit, rate=rate)
    sys.stdout.buffer.write(stream.getvalue())
    return 0


def _limit_memory(size: int) -> None:
    try:
        import resource
    except ImportError:  # there is no such thing on Windows
        return
    resource.setrlimit(resource.RLIMIT_AS, (size, size))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2])))
