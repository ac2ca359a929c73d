"""How well `play` keeps its schedule at 57,600 and 1,000,000 baud, beside what the packets alone allow.

Ten emulated servos in a process of their own pace every byte to the baud rate; the player is the real one on the real
SDK. Lateness is the moment at which a row begins to leave minus its deadline.

    python benchmarks/robot_schedule.py [--cycles N]      writes results/benchmarks/robot_schedule.md

Beside the trial a process that only sleeps measures how late this computer wakes anybody up: no row can do better.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from serpenoid.files.writing import write_text
from serpenoid.robot.plan import read_time_s, write_time_s
from serpenoid.robot.table import write_table

ROOT = Path(__file__).parents[1]
ROBOT_FILE = ROOT / "problems" / "robots" / "snake10-robot.toml"
STEPS, JOINTS = 50, 10
# baud rate -> cycle durations [s]: the usual five seconds, and near the fastest that the bus allows
CASES = {57600: (5.0, 4.6), 1000000: (5.0, 1.0)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cycles", type=int, default=10)
    cycles = parser.parse_args().cycles
    rows = [measure(baud, duration, cycles) for baud, durations in CASES.items() for duration in durations]
    write_text(ROOT / "results" / "benchmarks" / "robot_schedule.md", report(rows, cycles))


def measure(baud: int, duration: float, cycles: int) -> list[str]:
    """One trial: the numbers of a table row."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        robot = folder / "robot.toml"
        robot.write_text(ROBOT_FILE.read_text().replace("baud_rate = 1000000", f"baud_rate = {baud}"))
        phase = np.arange(STEPS)[:, None] / STEPS + np.arange(JOINTS) / JOINTS
        write_table(folder / "gait.csv", 0.3 * np.sin(2 * np.pi * phase))
        timing = play(folder, robot, duration, cycles)
    write, read = write_time_s(JOINTS, baud) * 1000, read_time_s(JOINTS, baud) * 1000
    bus = [f"{write:.2f}", f"{read:.2f}"]
    failed = sum(timing["failed_exchanges"].values())
    sleeper = " / ".join(f"{value:.1f}" for value in timing["woken_late_ms"])
    late = [f"{timing[f'late_{which}_ms']:.3f}" for which in ("median", "p99", "worst")]
    return [
        f"{baud:,}",
        f"{duration / STEPS * 1000:.0f}",
        *bus,
        str(timing["rows"]),
        *late,
        str(timing["missed"]),
        str(failed),
        sleeper,
    ]


def play(folder: Path, robot: Path, duration: float, cycles: int) -> dict[str, Any]:
    environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
    serpenoid = [sys.executable, "-m", "serpenoid"]
    emulate = [*serpenoid, "robot", "emulate", "--robot", str(robot)]
    emulator = subprocess.Popen(emulate, env=environment, stdout=subprocess.PIPE, text=True)
    try:
        port = emulator.stdout.readline().strip() if emulator.stdout else ""
        words = ["--robot", str(robot), "--port", port, "--cycles", str(cycles), "--log", str(folder / "log")]
        played = ["play", str(folder / "gait.csv"), *words, "--cycle-duration", str(duration)]
        player = subprocess.Popen([*serpenoid, *played], env=environment, stdin=subprocess.DEVNULL)
        woken_late = sleep_beside(player)
    finally:
        emulator.send_signal(signal.SIGINT)
        emulator.wait()
    timing: dict[str, Any] = json.loads((folder / "log" / "play.json").read_text())["timing"]
    return timing | {"woken_late_ms": woken_late}


def sleep_beside(player: subprocess.Popen[bytes]) -> list[float]:
    """99th percentile and worst lateness [ms] of a process that sleeps 5 ms at a time while the trial runs."""
    late = []
    while player.poll() is None:
        before = time.monotonic()
        time.sleep(0.005)
        late.append((time.monotonic() - before - 0.005) * 1000)
    return [float(np.percentile(late, 99)), max(late)]


def report(rows: list[list[str]], cycles: int) -> str:
    header = ["baud", "row [ms]", "bus: write [ms]", "bus: read [ms]", "rows"]
    header += [
        "late, median [ms]",
        "late, 99 % [ms]",
        "late, worst [ms]",
        "missed",
        "failed reads",
        "idle sleeper late, 99 % / worst [ms]",
    ]
    lines = ["| " + " | ".join(cells) + " |" for cells in [header, ["--:"] * len(header), *rows]]
    machine = f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}"
    load = f"load average {os.getloadavg()[0]:.1f}"
    return f"""# Row schedule of `serpenoid play`

`python benchmarks/robot_schedule.py --cycles {cycles}` on {machine}, {load}.

Ten emulated XL430 servos, bytes paced to the baud rate, 50 rows a cycle. *Late* is when a row begins to leave, after
its deadline; the servos have it one `bus: write` later, whatever the computer does. *Missed* rows left more than a
tenth of a row late. *bus: read* is the sync read of all states and one servo's health, sent after each row; a row
shorter than write and read together is refused before playing. *Failed reads* are answers that did not come within the
SDK's own timeout and were asked again: here the emulator, a program like any other, was kept waiting for a core. The
*idle sleeper* is a process beside them that does nothing but sleep 5 ms at a time.

{chr(10).join(lines)}
"""


if __name__ == "__main__":
    main()
