"""Counts for results/benchmarks/robustness.md: campaigns of random robots: valid ones believed, wrong ones refused.

PYTHONPATH=tests python benchmarks/contradictions.py [FIRST LAST]

Every seed draws a protocol (3 to 20 joints, 25 to 250 frames a second, marker noise 0.1 to 2 mm, a servo log at 10 to
200 Hz or none; `tests/blind/random_protocols.py`) and records it three times: nothing hidden, two effects of the
catalogue, a fault from outside it. None of the three contradicts itself. Then one thing at a time is made wrong in the
first; with odd seeds its servo logs are not named, so that cameras alone must tell. A refusal counts as right if it
names the cure and accuses no trial in which nothing was changed.
"""

from __future__ import annotations

import re
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np

from blind.campaign import Campaign, make
from blind.folder import write
from blind.random_protocols import draw_protocol, effects_that_show
from serpenoid.measure.campaign import load_campaign_file
from serpenoid.measure.consistency.check import Contradiction
from serpenoid.measure.consistency.claims import check_files
from serpenoid.measure.trial_files import read_files
from serpenoid.table_file import read_table, write_table

SEEDS = 0, 12
HIDDEN: dict[str, list | int | str] = {"nothing hidden": [], "two effects": 2, "outside the catalogue": "outside"}
ALL = "every trial"


def contradictions(folder: Path) -> tuple[Contradiction, ...]:
    """What the check says of a folder."""
    file, place = load_campaign_file(folder)
    return check_files(file, place, *read_files(file, place)).contradictions


def number(key: str, factor: float) -> Callable[[Path], str]:
    """A number of the first trial multiplied; returns that trial."""

    def edit(folder: Path) -> str:
        path = folder / "campaign.toml"
        head, first, *rest = path.read_text().split("[[trial]]")
        first = re.sub(rf"{key} = ([0-9.]+)", lambda m: f"{key} = {factor * float(m.group(1)):.6g}", first, count=1)
        path.write_text("[[trial]]".join([head, first, *rest]))
        return file_names(folder)[0]

    return edit


def another_table(folder: Path) -> str:
    """The first trial names the joint table of the last."""
    path = folder / "campaign.toml"
    head, first, *rest = path.read_text().split("[[trial]]")
    named = re.findall(r'joint_table = "(.*)"', rest[-1])[0]
    path.write_text("[[trial]]".join([head, re.sub(r'joint_table = ".*"', f'joint_table = "{named}"', first), *rest]))
    return file_names(folder)[0]


def tables(change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Path], str]:
    """All joint tables changed, as one who mixed up the wiring would."""

    def edit(folder: Path) -> str:
        for path in {folder / trial.joint_table for trial in load_campaign_file(folder)[0].trial if trial.joint_table}:
            write_table(path, change(read_table(path)))
        return ALL

    return edit


def lengths(folder: Path) -> str:
    """Edge lengths in decimetres."""
    path = folder / "campaign.toml"
    text = path.read_text()
    row = re.findall(r"edge_lengths = \[(.*)\]", text)[0]
    path.write_text(text.replace(row, ", ".join(f"{10 * float(cell):.6g}" for cell in row.split(","))))
    return ALL


def file_names(folder: Path) -> list[str]:
    return [trial.name for trial in load_campaign_file(folder)[0].trial]


def exchanged(rows: np.ndarray) -> np.ndarray:
    """The first and the last joint exchanged."""
    order = [rows.shape[1] - 1, *range(1, rows.shape[1] - 1), 0]
    return rows[:, order]


def one_sign(rows: np.ndarray) -> np.ndarray:
    return rows * np.where(np.arange(rows.shape[1]) == 1, -1, 1)


FAULTS: dict[str, tuple[Callable[[Path], str], str]] = {
    "cycle duration halved": (number("cycle_duration_s", 0.5), "cycle_duration_s"),
    "cycle duration doubled": (number("cycle_duration_s", 2.0), "cycle_duration_s"),
    "another gait's table": (another_table, "follow"),
    "tables played backwards": (tables(lambda rows: np.concatenate([rows[:1], rows[:0:-1]])), "backwards"),
    "all signs flipped": (tables(lambda rows: -rows), "all signs flipped|head and tail"),
    "one sign flipped": (tables(one_sign), "turn `joint_2` the other way"),
    "joints in reversed order": (tables(lambda rows: rows[:, ::-1]), "reversed order|head and tail"),
    "two joints exchanged": (tables(exchanged), "exchanged"),
    "lengths in another unit": (lengths, "length_unit"),
}


def without_logs(folder: Path) -> None:
    path = folder / "campaign.toml"
    path.write_text("\n".join(row for row in path.read_text().splitlines() if not row.startswith("servo_log")))


def drawn(seed: int, hide: list | int | str) -> Campaign:
    protocol = draw_protocol(seed)
    return make(seed, hide, f"seed {seed}", protocol=protocol, among=effects_that_show(protocol))


def valid_ones(seed: int, place: Path, counts: Counter[str]) -> None:
    """Three valid campaigns of one protocol; the first stays in `place`."""
    for what, hide in reversed(HIDDEN.items()):
        shutil.rmtree(place, ignore_errors=True)
        write(drawn(seed, hide), place)
        refused = contradictions(place)
        counts[f"valid, {what}"] += 1
        counts[f"valid, {what}: refused"] += bool(refused)
        for one in refused:
            say(f"seed {seed}, {what}: {one}")


def faulty_ones(seed: int, place: Path, counts: Counter[str]) -> None:
    """One thing wrong at a time."""
    if seed % 2:
        without_logs(place)
    for name, (edit, cure) in FAULTS.items():
        folder = place.with_name("faulty")
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(place, folder)
        wrong = edit(folder)
        found = contradictions(folder)
        right = [one for one in found if wrong in (ALL, one.trial)]
        counts[name] += 1
        counts[f"{name}: refused"] += bool(found)
        counts[f"{name}: with the cure"] += any(re.search(cure, str(one)) for one in right) and len(right) == len(found)
        if not found or len(right) < len(found) or not any(re.search(cure, str(one)) for one in right):
            say(f"seed {seed}, {name}: {[str(one) for one in found]}")


def say(text: str) -> None:
    sys.stderr.write(f"{text}\n")


def main() -> None:
    first, last = (int(word) for word in sys.argv[1:]) if len(sys.argv) > 1 else SEEDS
    counts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(first, last):
            valid_ones(seed, Path(folder) / "valid", counts)
            faulty_ones(seed, Path(folder) / "valid", counts)
    for name in (*(f"valid, {what}" for what in HIDDEN), *FAULTS):
        cure = "" if name.startswith("valid") else counts[f"{name}: with the cure"]
        sys.stdout.write(f"| {name} | {counts[name]} | {counts[f'{name}: refused']} | {cure} |\n")


if __name__ == "__main__":
    main()
