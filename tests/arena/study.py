"""Hidden changes of the arena's robot, diagnosed with a healthy campaign as reference; resumable.

    python -m arena.study --out results/blind/arena [NAME ...]

For each: six gaits twice (`problems/protocols/six-gaits.toml`, with a seed of its own), the diagnosis, and only then a
look at what was hidden. One row of arena.csv a change, a summary in README.md; a row that is there is not made again.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from arena.hidden import HIDDEN, Hidden, Name
from arena.table import TABLE, write_table
from blind import table
from blind.study import commit
from serpenoid.arena.campaign import run_campaign
from serpenoid.arena.protocol import load_protocol
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.diagnose import Diagnosis, diagnose
from serpenoid.diagnose.reference import Reference, reference_of, summary
from serpenoid.diagnose.report.write import write
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.start import baseline

KEPT = ("verdict", "effects", "alternatives", "below_detection", "left", "residual_pattern", "noise_level_m", "gain")
ROOT = Path(__file__).parents[2]
PROTOCOL = ROOT / "problems" / "protocols" / "six-gaits.toml"
MODEL = ROOT / "problems" / "snake10.toml"


@dataclass(frozen=True)
class Study:
    """work: where campaigns and diagnoses are kept (their names tell nothing); key: another one, other seeds."""

    work: Path
    key: str = "arena-1"

    def digest(self, name: str) -> str:
        return hashlib.sha256(f"{self.key}:{name}".encode()).hexdigest()

    def folder(self, name: str) -> Path:
        return self.work / self.digest(name)[:12]

    def play(self, name: str, hidden: Hidden) -> Path:
        """The campaign and, elsewhere, its noise-free motion."""
        folder = self.folder(name)
        text = PROTOCOL.read_text(encoding="utf-8").replace('"six-gaits/', f'"{PROTOCOL.parent}/six-gaits/')
        seed = int(self.digest(name)[12:18], 16)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "protocol.toml").write_text(text.replace("seed = 11", f"seed = {seed}") + hidden.toml)
        protocol, tables = load_protocol(folder / "protocol.toml")
        run_campaign(protocol, tables, folder / "campaign", truth=folder / "truth")
        return folder / "campaign"


def diagnosed(
    campaign: Path, known: Reference | None, out: Path, model: Path = MODEL
) -> tuple[Diagnosis, dict[str, Any]]:
    """The diagnosis as the command makes it, and what it writes."""
    file, recordings = read_recordings(campaign)
    found = diagnose(recordings, known or Baseline(baseline(model, file, file.body)), lambda text: None)
    return found, write(out, file, found)


def judged(said: dict[str, Any], hidden: Hidden) -> dict[str, Any]:
    """Right: named, and nothing else. For what is outside the catalogue: no name at all. For nothing: nothing."""
    named, rivals = _names(said["effects"]), _names(said["alternatives"])
    stand_ins = _names([e for e in said["effects"] if e["stand_in"]])
    claimed = [n for n in named if n not in stand_ins]
    others = [n for n in claimed if n not in hidden.answers]
    spare = len(others) > int(len(others) == len(claimed))  # one stands for the truth if that is among its rivals
    if not hidden.changes:
        outcome = "right" if said["verdict"] == "nothing" else "wrong"
    elif hidden.outside:
        outcome = "wrong" if named or said["verdict"] == "explained" else "right"
    elif {*named, *rivals} & set(hidden.answers):
        outcome = "named beside others" if spare else "right"
    else:
        outcome = "wrong" if named else "missed"
    return {"outcome": outcome, "answers": [list(a) for a in hidden.answers]}


def _names(items: list[dict[str, Any]]) -> list[Name]:
    return [(e["name"], e["place"]) for e in items]


def moved_by(changed: Path, healthy: Path, again: Path | None = None) -> tuple[float, float]:
    """Path RMS [m] between changed and healthy trials, and between healthy repeats, starts laid together.

    again: the healthy robot once more; where nothing was played twice its trials are the repeats.
    """
    then, now = (_paths(f) for f in (healthy, changed))
    twice = [(then[n], then[f"{n[:-1]}2"]) for n in then if n.endswith("-1") and f"{n[:-1]}2" in then]
    if not twice and again is not None:
        once_more = _paths(again)
        twice = [(then[n], once_more[n]) for n in then]
    each = [_apart(now[n], then[n]) for n in then], [_apart(a, b) for a, b in twice]
    return tuple(float(np.sqrt(np.mean(np.square(x)))) for x in each)  # type: ignore[return-value]


def _paths(folder: Path) -> dict[str, np.ndarray]:
    return {p.stem: _path(p) for p in sorted((folder / "truth").glob("*.npz"))}


def _path(file: Path) -> np.ndarray:
    """Middle of the markers (F, 2), from the first frame's middle and tail-to-head direction."""
    markers = np.load(file)["markers"][..., :2]
    chord = markers[0, -1] - markers[0, 0]
    c, s = chord / np.hypot(*chord)
    middle = markers.mean(axis=1)
    return (middle - middle[0]) @ np.array([[c, -s], [s, c]])


def _apart(a: np.ndarray, b: np.ndarray) -> float:
    n = min(len(a), len(b))
    return float(np.sqrt(((a[:n] - b[:n]) ** 2).sum(axis=1).mean()))


def run_one(study: Study, name: str, known: Reference, out: Path) -> dict[str, Any]:
    """One change; returns its row, from the table if it was run before."""
    before = next((row for row in table.read(out / TABLE)[1] if row["name"] == name), None)
    if before is not None:
        return before
    campaign = study.play(name, HIDDEN[name])
    began = time.process_time()
    _, said = diagnosed(campaign, known, study.folder(name) / "diagnosis")
    change, repeats = moved_by(study.folder(name), study.folder("healthy"))
    row = {"name": name, "hidden": HIDDEN[name].changes, **judged(said, HIDDEN[name]), **{k: said[k] for k in KEPT}}
    row |= {"path_change_m": change, "path_repeats_m": repeats, "seconds": time.process_time() - began}
    return row


def kept(study: Study, out: Path, row: dict[str, Any]) -> None:
    """One more row of the table, or the same one anew."""
    rows = [r for r in table.read(out / TABLE)[1] if r["name"] != row["name"]]
    above = {"command": f"python -m arena.study --key {study.key}", "commit": commit(), "key": study.key}
    table.write(out / TABLE, above, [*rows, row])


def main() -> None:
    p = argparse.ArgumentParser(
        description="Hidden changes of the arena's robot, diagnosed against a healthy campaign."
    )
    p.add_argument("names", nargs="*", metavar="NAME", help=f"default: all of {', '.join(HIDDEN)}")
    p.add_argument("--out", type=Path, default=Path("results/blind/arena"))
    p.add_argument("--work", type=Path, default=Path("results/arena-study"))
    p.add_argument("--key", default=Study.key)
    a = p.parse_args()
    study = Study(a.work, a.key)
    healthy, said = diagnosed(study.play("healthy", Hidden()), None, study.folder("healthy") / "diagnosis")
    kept(study, a.out, {"name": "healthy", **summary(healthy), "scores": said["scores"]})
    known = reference_of(healthy)
    for name in a.names or HIDDEN:
        row = run_one(study, name, known, a.out)
        kept(study, a.out, row)
        sys.stderr.write(f"{name}: {row['outcome']} ({row['verdict']})\n")
        write_table(a.out)


if __name__ == "__main__":
    main()
