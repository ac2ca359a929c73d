"""What becomes of the motors: every fault of the emulator at random moments, and answers of servos that share an ID.

Each run is `serpenoid play` as a process of its own on the real SDK, against ten emulated servos. The "Robot" part of
results/benchmarks/robustness.md is written anew; the rest of that file stays.

    PYTHONPATH=tests/robot python benchmarks/robot_robustness.py [--repeats N]
"""

from __future__ import annotations

import argparse
import json
import random
import re
import tempfile
import time
from collections import Counter
from pathlib import Path

from emulated import emulator, play_words, read_log, serpenoid, write_gait

from serpenoid.files.writing import write_text
from serpenoid.robot.bus.collisions import read_ping_answers
from serpenoid.robot.emulator import packets
from serpenoid.robot.emulator.collision import overlapped

FILE = Path(__file__).parents[1] / "results" / "benchmarks" / "robustness.md"
BEGIN, END = "<!-- robot -->", "<!-- end of robot -->"
FAULTS = {
    "silent:4@{}": "servo 4 no longer answers",
    "deaf:4@{}": "servo 4 neither hears nor answers",
    "reset:4@{}": "servo 4 loses power for a moment",
    "stuck:4@{}": "servo 4 is blocked",
    "crc:4@{}": "checksums of servo 4 are wrong",
    "delay:4@{}=0.3": "servo 4 answers 0.3 s late",
    "overheat:4@{}": "servo 4 overheats",
    "voltage@{}=9.0": "the battery falls to 9.0 V",
    "unplug@{}=0.3": "the cable is out for 0.3 s",
    "unplug@{}": "the cable stays out",
}
COLLISIONS = 2000


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=6)
    repeats = parser.parse_args().repeats
    rng = random.Random(0)
    rows = [row(fault, words, repeats, rng) for fault, words in FAULTS.items()]
    table = [
        "| fault | runs | exit codes | motors off, confirmed | stopped by watchdog | log readable |",
        "| --- " * 6 + "|",
    ]
    text = "\n".join([BEGIN, INTRODUCTION.format(repeats=repeats), *table, *rows, "", collisions(rng), TRACKING, END])
    write_text(FILE, replaced(FILE.read_text(encoding="utf-8") if FILE.exists() else "# Robustness\n", text))


def row(fault: str, words: str, repeats: int, rng: random.Random) -> str:
    codes: Counter[int] = Counter()
    off = watched = readable = 0
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            with emulator(folder, fault.format(f"{rng.uniform(0.0, 2.5):.2f}")) as rig:
                done = serpenoid(*play_words(write_gait(folder, amplitude=0.3), rig.port, folder / "log", cycles=6))
                time.sleep(0.7)  # longer than a watchdog
                off += not any(rig.torques)
                watched += any(rig.torques) and all(
                    servo.table["bus_watchdog"] == -1 for servo in rig.chain.servos if servo.torque
                )
            codes[done.returncode] += 1
            read_log(folder / "log" / "servo.csv")
            readable += json.loads((folder / "log" / "play.json").read_text())["status"] == "failed"
    shown = ", ".join(f"{code} ({count}x)" for code, count in sorted(codes.items()))
    return f"| {words} | {repeats} | {shown} | {off} | {watched} | {readable} |"


def collisions(rng: random.Random) -> str:
    """Answers to a broadcast ping of two servos with one ID, begun at different moments."""
    silent = understood = 0
    for seed in range(COLLISIONS):
        servo_id = rng.randrange(253)
        answer = packets.build_status(servo_id, 0, bytes([36, 4, 45]))
        found = read_ping_answers(overlapped([answer, answer], random.Random(seed)), packets.crc16)
        understood += bool(found.servos)
        silent += not found.collision
    return (
        f"Of {COLLISIONS} pairs of servos with one ID that answer a broadcast ping together, {COLLISIONS - silent} are "
        f"noticed as such; {understood} give an answer that looks whole."
    )


def replaced(old: str, part: str) -> str:
    if BEGIN in old:
        return re.sub(f"{re.escape(BEGIN)}.*{re.escape(END)}", lambda _: part, old, flags=re.DOTALL)
    return f"{old.rstrip()}\n\n{part}\n"


INTRODUCTION = """## Robot

`PYTHONPATH=tests/robot python benchmarks/robot_robustness.py`: each fault {repeats} times, at a random moment of the
approach or of the gait (0 to 2.5 s after torque on). "Stopped by watchdog": motors that `play` could no longer reach.
"""
TRACKING = """
Tracking errors of a healthy robot, lag apart (distance from the commands of the last 0.3 s), in the arena's six gaits
(`problems/protocols/six-gaits.toml`): at most 1.7, 1.9, 6.1, 3.3, 2.5 and 2.5 degrees; of the README's gait on the
emulated bus 6.2. The default `limit_deg` of 12 is twice the largest, and three quarters of what a servo's whole torque
holds off."""

if __name__ == "__main__":
    main()
