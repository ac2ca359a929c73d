"""Counts for results/benchmarks/robustness.md: mutated files, and `sweep` and `arena run` killed at random moments.

PYTHONPATH=tests python benchmarks/robustness_files.py mutations 1000
python benchmarks/robustness_files.py kills
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import random
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
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
KILLS, ROUNDS = 5, 4  # in one folder, folders
LEAST_S, MOST_S = 0.5, 7.0  # rather in the middle of the work than after it


def mutations(count: int) -> None:
    """A line per kind of file: how many mutants were refused by name, how many gave the same and another answer."""
    os.environ["SERPENOID_COMPILE"] = "0"
    from fuzz.mutate import KINDS
    from fuzz.specimens import SPECIMENS
    from fuzz.test_fuzz import attack

    for name, specimen in SPECIMENS.items():
        path = Path(tempfile.mkdtemp()) / "deep" / "er" / specimen.file
        path.parent.mkdir(parents=True)
        specimen.write(path)
        rng, found, tried = random.Random(count), Counter(), count // 20 if name == "c3d" else count
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            place = path, path.read_bytes(), specimen.read(path)
            for _ in range(tried):
                kind, where, what = rng.choice(sorted(KINDS)), rng.random(), rng.randrange(1000)
                again = None if rng.random() < 0.5 else (rng.choice(sorted(KINDS)), rng.random())
                try:
                    found[attack(specimen, place, kind, where, what, again)] += 1
                except Exception as error:  # noqa: BLE001 - what must not happen is counted
                    found["traceback, hang or unnamed"] += 1
                    sys.__stdout__.write(f"{name}: {kind} {where!r} {what} {again}: {error!r}\n")
        order = ("refused", "the same answer", "another answer", "traceback, hang or unnamed")
        sys.stdout.write(f"| {name} | {tried} | {' | '.join(str(found[k]) for k in order)} |\n")
        sys.stdout.flush()


def kills() -> None:
    """Killed KILLS times in each of ROUNDS folders, then finished; against an undisturbed run."""
    folder = Path(tempfile.mkdtemp())
    protocol = folder / "short.toml"
    protocol.write_text(PROTOCOL.format(tables=ROOT / "problems" / "protocols"))
    reference = str(ROOT / "problems" / "reference-optimum.toml")
    words = {
        "sweep": ["sweep", reference, "--c", "0:2:9", "--starts", "1", "--no-polish", "--no-figures", "--quiet"],
        "arena run": ["arena", "run", str(protocol), "--jobs", "1", "--quiet"],
    }
    kept = {"sweep": "chain/*.npz", "arena run": "*-first-*/*.csv"}
    answers = {"sweep": ("sweep.csv",), "arena run": ("campaign.toml", "*-first-*/*.csv")}
    for verb, command in words.items():
        whole = folder / f"{verb}-whole"
        _run([*command, "--out", str(whole)])
        counts = Counter()
        for number in range(ROUNDS):
            _one_folder(folder / f"{verb}-{number}", command, kept[verb], random.Random(number), counts)
            same = _answer(folder / f"{verb}-{number}", answers[verb]) == _answer(whole, answers[verb])
            counts["equal answers"] += same
        sys.stdout.write(f"{verb}: {dict(counts)}\n")
        sys.stdout.flush()


def _one_folder(out: Path, command: list[str], kept: str, rng: random.Random, counts: Counter) -> None:
    finished: dict[Path, int] = {}
    for kill in range(KILLS + 1):
        last = kill == KILLS
        process = subprocess.Popen([sys.executable, "-m", "serpenoid", *command, "--out", str(out)])
        if not last:
            time.sleep(rng.uniform(LEAST_S, MOST_S))
            process.kill()
        code = process.wait()
        counts["killed in time"] += code == -9
        counts["reruns that failed"] += code not in (0, -9)
        now = {path: path.stat().st_ino for path in out.glob(kept) if not path.parent.name.startswith(".")}
        counts["files found finished"] += len(finished)
        counts["of them made again"] += sum(now.get(path) != inode for path, inode in finished.items())
        finished = now
        hidden = [p for p in out.rglob(".*") if p.is_file() and p.name != ".arena.json"] if out.exists() else []
        counts["temporary files left at the end"] += len(hidden) * last


def _answer(folder: Path, names: tuple[str, ...]) -> dict[str, str]:
    found = {}
    for path in sorted(path for name in names for path in folder.glob(name)):
        text = path.read_text()
        if path.name == "sweep.csv":  # wall times and iterations of a point are those of the run that solved it
            text = "\n".join(",".join(_number(cell) for cell in line.split(",")[:4]) for line in text.splitlines())
        found[str(path.relative_to(folder))] = hashlib.sha256(text.encode()).hexdigest()
    return found


def _number(cell: str) -> str:
    try:
        return f"{float(cell):.9g}"
    except ValueError:
        return cell


def _run(words: list[str]) -> None:
    subprocess.run([sys.executable, "-m", "serpenoid", *words], check=True)


if __name__ == "__main__":
    mutations(int(sys.argv[2])) if sys.argv[1] == "mutations" else kills()
