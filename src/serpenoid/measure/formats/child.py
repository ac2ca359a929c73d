"""Files whose readers, of other languages, can crash on damaged ones: read in a process of its own, given as NPZ.

    python -m serpenoid.measure.formats.child KIND FILE MEGABYTES

What is wrong with the file goes to standard error, and the exit code is 2. Memory is limited to MEGABYTES.
"""

from __future__ import annotations

import io
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from serpenoid.errors import InputError

TIMEOUT_S = 120
OTHERS = "others"  # in words
MAT_ARRAYS = ("t_s", "frame", "points", "x", "y")
NUMBERS = "biuf"  # kinds of types of NumPy
OWN = "_"  # before names that a file gives: `file` is a word of savez
Arrays = dict[str, Any]


def read_in_child(kind: str, path: Path, size: int) -> Arrays:
    """What a file of so many bytes holds; InputError where its reader finds nothing, or breaks down."""
    called = f"{path}: not a readable {kind} file"
    command = [
        sys.executable,
        "-m",
        "serpenoid.measure.formats.child",
        kind,
        str(path),
        str(2000 + 40 * size // 1_000_000),
    ]
    try:
        ended = subprocess.run(command, capture_output=True, check=False, timeout=TIMEOUT_S)
    except subprocess.TimeoutExpired:
        raise InputError(f"{called}: nothing was found in {TIMEOUT_S} s.") from None
    if ended.returncode:
        said = ended.stderr.decode(errors="replace").strip().splitlines()
        why = said[-1] if ended.returncode == 2 and said else "its reader broke down over it"
        raise InputError(f"{called}: {why}.")
    with np.load(io.BytesIO(ended.stdout)) as data:
        return {name.removeprefix(OWN): data[name] for name in data.files}


def main(kind: str, path: str, megabytes: int) -> int:
    """Write one file's arrays."""
    read = {"C3D": _c3d, "MATLAB": _matlab, "NumPy": _numpy, "QTM": _qtm}[kind]()
    _limit_memory(megabytes * 1_000_000)
    try:
        arrays = read(path)
    except MemoryError:
        sys.stderr.write("says that it holds more than fits into memory\n")
        return 2
    except Exception as error:  # noqa: BLE001 - whatever a library of another language throws
        sys.stderr.write(f"{str(error).rstrip('.')}\n")
        return 2
    stream = io.BytesIO()
    np.savez(stream, **{OWN + name: array for name, array in arrays.items()})
    sys.stdout.buffer.write(stream.getvalue())
    return 0


def _c3d() -> Callable[[str], Arrays]:
    """Points (3, M, F), residuals (M, F), labels, unit, rate."""
    import ezc3d

    def read(path: str) -> Arrays:
        content = ezc3d.c3d(path)
        group: dict[str, Any] = content["parameters"]["POINT"]
        return {
            "points": np.array(content["data"]["points"][:3], dtype=float),
            "residuals": np.array(content["data"]["meta_points"]["residuals"])[0],
            "labels": np.array([str(label) for label in group["LABELS"]["value"]], dtype="U"),
            "unit": str((group["UNITS"]["value"] or ["mm"])[0]).strip().lower(),
            "rate": float(group["RATE"]["value"][0]),
        }

    return read


def _matlab() -> Callable[[str], Arrays]:
    """The arrays of a .mat that are asked for, and in words what else is there."""
    from scipy.io import loadmat, whosmat

    def told(path: str, name: str, shape: tuple[int, ...], kind: str) -> str:
        size = ", ".join(map(str, shape))
        if kind == "cell":
            return f"`{name}` (cell of {np.prod(shape)})"
        found = np.asarray(loadmat(path, appendmat=False, variable_names=[name]).get(name))
        if kind == "struct":
            return f"`{name}` (struct: {', '.join(found.dtype.names or ())})"
        words = {"c": "complex, "} | dict.fromkeys(NUMBERS, "")
        return f"`{name}` ({words.get(found.dtype.kind, f'{kind}, ')}{size})"

    def read(path: str) -> Arrays:
        found = loadmat(path, appendmat=False, variable_names=MAT_ARRAYS)
        given = {name: np.asarray(found[name]) for name in MAT_ARRAYS if name in found}
        arrays = {name: array.astype(float) for name, array in given.items() if array.dtype.kind in NUMBERS}
        others = [told(path, *of) for of in whosmat(path, appendmat=False) if of[0] not in arrays]
        return arrays | {OTHERS: np.array(others, dtype="U")}

    return read


def _qtm() -> Callable[[str], Arrays]:
    """Labels (M,), positions (M, 4, F), frames and their rate of what QTM exports for MATLAB."""
    from scipy.io import loadmat

    def read(path: str) -> Arrays:
        held = (value for value in loadmat(path, appendmat=False).values() if isinstance(value, np.ndarray))
        takes = [take for value in held for take in value.ravel() if "Trajectories" in (value.dtype.names or ())]
        if len(takes) != 1:
            raise ValueError(f"holds {len(takes)} structures with `Trajectories`, where one is read")
        trajectories = takes[0]["Trajectories"].ravel()[0]
        if "Labeled" not in (getattr(trajectories.dtype, "names", None) or ()) or not trajectories["Labeled"].size:
            raise ValueError("has no labelled trajectories: label the markers in QTM, and export it again")
        labelled = trajectories["Labeled"].ravel()[0]
        data = np.asarray(labelled["Data"], dtype=float)
        return {
            "labels": np.array([str(np.squeeze(label)) for label in labelled["Labels"].ravel()], dtype="U"),
            "data": data[..., None] if data.ndim == 2 else data,  # MATLAB drops the axis of one frame
            "rate": float(takes[0]["FrameRate"].ravel()[0]),
            "frames": float(takes[0]["Frames"].ravel()[0]),
        }

    return read


def _numpy() -> Callable[[str], Arrays]:
    """All arrays of an .npz, which must be numbers; the one of an .npy is `points`."""

    def read(path: str) -> Arrays:
        found = np.load(path, allow_pickle=False)
        arrays = {"points": found} if isinstance(found, np.ndarray) else {name: found[name] for name in found.files}
        words = next((name for name, array in arrays.items() if array.dtype.kind not in NUMBERS), None)
        if words is not None:
            raise ValueError(f"`{words}` holds no numbers ({arrays[words].dtype})")
        return {name: np.asarray(array, dtype=float) for name, array in arrays.items()}

    return read


def _limit_memory(size: int) -> None:
    try:
        import resource
    except ImportError:  # there is no such thing on Windows
        return
    resource.setrlimit(resource.RLIMIT_AS, (size, size))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2], int(sys.argv[3])))
