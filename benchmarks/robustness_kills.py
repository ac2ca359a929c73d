"""Counts for results/benchmarks/robustness.md: `sweep`, `arena run`, `diagnose` and `compare` killed at random moments.

PYTHONPATH=tests python benchmarks/robustness_kills.py [sweep|arena|diagnose|compare ...]

Each is run once undisturbed. Then it is begun and killed (SIGKILL) at a random moment of what is left of that run's
duration, again and again in one folder, up to MOST times, and at last left to finish; then in a new folder, until KILLS
signals have hit it at work. Counted: reruns that failed, answers that differ from the undisturbed one, and pieces of
finished work that a later run made again (a file that is written anew has another inode) or that the undisturbed run
did not need.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from rehearsal import serpenoid_table, snake
from serpenoid.compare.rehearse import Laboratory, write_campaign

ROOT = Path(__file__).resolve().parents[1]
KILLS, MOST = 20, 5  # in all; in one folder
LEAST = 0.3  # of an undisturbed run's duration: starting and what is not kept
PROTOCOL = """\
format = 1
name = "short"
seed = 3
trials = 6
cycles = 1
cycle_duration_s = 2.0
pause_s = 0.5

[[gait]]
name = "head-first"
joint_table = "{tables}/head-first.csv"

[[gait]]
name = "tail-first"
joint_table = "{tables}/tail-first.csv"
"""
TIMES = {"wall_time_s", "iterations", "seconds", "provenance"}  # of the run, not of the answer


@dataclass(frozen=True)
class Verb:
    """A command without its --out; where its finished pieces lie, and its answer, in (results, cache)."""

    words: list[str]
    pieces: Callable[[Path, Path], dict[str, int]]
    answer: Callable[[Path], object]


def verbs(folder: Path) -> dict[str, Verb]:
    """The four commands on small inputs, which are made in `folder`."""
    protocol, gaits, weak = folder / "short.toml", folder / "gaits", folder / "weak"
    protocol.write_text(PROTOCOL.format(tables=ROOT / "problems" / "protocols"))
    tables = {"wide": serpenoid_table(30), "low": serpenoid_table(30, a=4.0)}
    write_campaign(gaits, snake(), tables, Laboratory(frames_per_second=30.0), 2, 0, 2.0, 1, 1.0)
    write(make(7, (Effect("gain_loss", 3, {"loss": 0.15}),), "weak", COMBINATIONS[:2]), weak)
    reference = str(ROOT / "problems" / "reference-optimum.toml")
    sweep = ["sweep", reference, "--c", "0:2:9", "--starts", "1", "--no-polish", "--no-figures"]
    return {
        "sweep": Verb(sweep, lambda out, _: inodes(out, "chain/*.npz"), swept),
        "arena": Verb(
            ["arena", "run", str(protocol), "--jobs", "1"],
            lambda out, _: inodes(out, "[!.]*-first-*/*.csv"),
            lambda out: {str(p.relative_to(out)): p.read_bytes() for p in sorted(out.glob("[!.]*-first-*/*.csv"))},
        ),
        "diagnose": Verb(
            ["diagnose", str(weak), "--no-figures", "--jobs", "1"],
            lambda _, cache: inodes(cache, "work/[!.]*.work"),
            lambda out: plain(json.loads((out / "diagnosis.json").read_text())),
        ),
        "compare": Verb(
            ["compare", str(gaits), "--no-figures"],
            lambda _, cache: inodes(cache, "work/[!.]*.work"),
            lambda out: plain(json.loads((out / "compare.json").read_text())),
        ),
    }


def inodes(folder: Path, pattern: str) -> dict[str, int]:
    """Name -> inode of finished files."""
    return {str(path.relative_to(folder)): path.stat().st_ino for path in folder.glob(pattern)}


def swept(out: Path) -> object:
    """c, displacement and cost of every point to nine digits; wall times are those of the run that solved it."""
    rows = [line.split(",")[:4] for line in (out / "sweep.csv").read_text().splitlines()[1:]]
    return [[f"{float(cell):.9g}" if cell.replace(".", "").isdigit() else cell for cell in row] for row in rows]


def plain(record: object) -> object:
    """A record without what belongs to its run."""
    if isinstance(record, dict):
        return {key: plain(value) for key, value in record.items() if key not in TIMES}
    return [plain(value) for value in record] if isinstance(record, list) else record


def run(verb: Verb, out: Path, cache: Path, kill_s: float | None = None) -> tuple[int, float]:
    """Exit code and seconds of the command, killed after `kill_s`."""
    words = [sys.executable, "-m", "serpenoid", *verb.words, "--quiet", "--out", str(out)]
    begun = time.monotonic()
    process = subprocess.Popen(words, env={**os.environ, "SERPENOID_CACHE": str(cache)})
    try:
        process.wait(kill_s)
    except subprocess.TimeoutExpired:
        process.kill()
    return process.wait(), time.monotonic() - begun


def study(name: str, verb: Verb, folder: Path) -> Counter[str]:
    """All kills of one command."""
    compiled = folder / "compiled"
    run(verb, folder / f"{name}-first", compiled)  # compiles what is needed
    shutil.rmtree(compiled / "work", ignore_errors=True)
    shutil.copytree(compiled, folder / f"{name}-cache")
    code, seconds = run(verb, folder / f"{name}-whole", folder / f"{name}-cache")
    assert code == 0, f"{name}: exit code {code}"
    whole = verb.answer(folder / f"{name}-whole")
    needed = set(verb.pieces(folder / f"{name}-whole", folder / f"{name}-cache"))
    counts: Counter[str] = Counter(pieces=len(needed))
    rng, number = random.Random(name), 0
    while counts["killed at work"] < KILLS:
        out, cache = folder / f"{name}-{number}", folder / f"{name}-{number}-cache"
        shutil.copytree(compiled, cache)
        finished: dict[str, int] = {}
        for last in (*[False] * MOST, True):
            left = seconds * max(1 - len(finished) / len(needed), LEAST)
            code, _ = run(verb, out, cache, None if last else rng.uniform(0.02, 1.0) * left)
            counts["killed at work"] += code == -9
            counts["reruns that failed"] += code not in (0, -9)
            now = verb.pieces(out, cache)
            counts["finished pieces found by a later run"] += len(finished)
            counts["of them made again"] += sum(now.get(piece) != inode for piece, inode in finished.items())
            finished = now
        counts["folders finished"] += 1
        counts["answers that differ"] += verb.answer(out) != whole
        counts["pieces that the undisturbed run did not need"] += len(set(finished) - needed)
        counts["temporary files left"] += sum(
            path.name.startswith((".writing-", ".unfinished-")) for path in out.rglob(".*")
        )
        number += 1
        shutil.rmtree(cache)
    return counts


def main() -> None:
    with tempfile.TemporaryDirectory() as place:
        for name, verb in verbs(Path(place)).items():
            if len(sys.argv) < 2 or name in sys.argv[1:]:
                counts = study(name, verb, Path(place))
                sys.stdout.write(f"{name}: {dict(counts)}\n")
                sys.stdout.flush()


if __name__ == "__main__":
    main()
