"""The power log: lines `t_s,voltage_V,current_A,power_W` as the sketch streams them from its INA260 sensor.

The stream may begin in the middle of a line and may carry other text; only whole, finite lines are kept.
"""

from __future__ import annotations

import contextlib
import math
import threading
import time
from pathlib import Path
from typing import Self, TextIO

import serial

from serpenoid.errors import InputError
from serpenoid.robot.log import check_new, open_new
from serpenoid.robot.port import not_opened

HEADER = "t_s,voltage_V,current_A,power_W"
BAUD_RATE = 115200  # of the sketch's USB serial; USB itself ignores it
LONGEST_LINE = 200


def parse_line(line: str) -> tuple[float, float, float, float] | None:
    """The four numbers of a line, or None if it is not a line of a power log."""
    cells = line.strip().split(",")
    if len(cells) != 4:
        return None
    try:
        values = [float(cell) for cell in cells]
    except ValueError:
        return None
    return (values[0], values[1], values[2], values[3]) if all(map(math.isfinite, values)) else None


class PowerRecorder:
    """Records a stream to `power.csv` in `folder` from `begin()` to the end of the `with` block, in its own thread."""

    def __init__(self, port: str, folder: Path | None) -> None:
        if folder is None:
            raise InputError("--power-port needs --log DIR: that is where power.csv goes.")
        self._port = port
        self._path = check_new(folder / "power.csv")
        self._stream: TextIO | None = None
        self._finished = threading.Event()
        self._thread = threading.Thread(target=self._record, name="power log", daemon=True)
        self.lines = 0
        self.lost = False

    def __enter__(self) -> Self:
        try:
            self._serial = serial.Serial(self._port, BAUD_RATE, timeout=0.05, exclusive=True)
        except serial.SerialException as error:
            raise not_opened(f"--power-port {self._port}", error) from None
        return self

    def begin(self) -> None:
        """Create the file; what the sensor sent before is dropped."""
        self._serial.reset_input_buffer()
        self._stream = open_new(self._path)
        self._stream.write(HEADER + "\n")
        self._stream.flush()
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._finished.set()
        if self._stream is not None:
            self._thread.join(timeout=2.0)
            with contextlib.suppress(OSError):  # a full disk: `lost` says so
                self._stream.close()
        self._serial.close()

    def _record(self) -> None:
        pending = b""
        while not self._finished.is_set():
            try:
                pending += self._serial.read(256)
            except (serial.SerialException, OSError, TypeError):
                self.lost = True
                return
            *lines, pending = pending.split(b"\n")
            pending = pending[-LONGEST_LINE:]
            try:
                for line in lines:
                    self._keep(line.decode("ascii", errors="replace"))
            except OSError:
                self.lost = True
                return

    def _keep(self, line: str) -> None:
        values = parse_line(line)
        if values is not None and self._stream is not None:
            self._stream.write("{:.6f},{:.4f},{:.5f},{:.4f}\n".format(*values))
            self._stream.flush()
            self.lines += 1


def record_power(port: str, folder: Path, seconds: float) -> int:
    """Record for `seconds` (or until Ctrl-C, which keeps what there is); return the number of lines."""
    with PowerRecorder(port, folder) as recorder:
        recorder.begin()
        give_up = time.monotonic() + seconds
        while time.monotonic() < give_up and not recorder.lost:
            time.sleep(0.05)
        return recorder.lines
