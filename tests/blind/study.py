"""Many hidden-effect trials, one after another or side by side, resumable.

    python -m blind.study --kind one --count 200 --out results/blind/ --model problems/snake10.toml

Each trial: make a campaign, run the diagnosis in its own process, only then open the seal and score. Results: one JSON
per trial in OUT/KIND/, a summary in OUT/KIND.json. A trial whose JSON exists is not run again.
"""

from __future__ import annotations

import argparse
import hashlib
import hmac
import json
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from blind.campaign import Campaign, make, with_experiment
from blind.catalogue import CATALOGUE, Effect
from blind.folder import seal, write
from blind.gaits import random_table
from blind.handful import HANDFUL
from blind.score import Answer, Name, answer, errors, judge
from blind.separation import separation
from blind.strength import floor, strength
from blind.summary import summarise

KINDS: dict[str, int | str] = {"null": 0, "one": 1, "two": 2, "outside": "outside", "followup": 1, "handful": 0}


@dataclass(frozen=True)
class Study:
    """What to run. `diagnose` is the command before CAMPAIGN; keys make identities that tell nothing."""

    kind: str
    out: Path
    model: str
    diagnose: str = f"{sys.executable} -m serpenoid diagnose"
    key: str = "blind-1"
    timeout_s: float = 600.0
    keep: bool = False

    def hidden(self, index: int) -> int | str | Sequence[Effect]:
        """What to hide: a number of effects to draw, the name of a kind, or the given effects of the handful."""
        return HANDFUL[index] if self.kind == "handful" else KINDS[self.kind]

    def digest(self, purpose: str, index: int) -> str:
        text = f"{purpose}:{self.kind}:{index}"
        return hmac.new(self.key.encode(), text.encode(), hashlib.sha256).hexdigest()


def _atomic(path: Path, value: object) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(f".{os.getpid()}.part")
    temporary.write_text(json.dumps(value, indent=1))
    temporary.replace(path)


def run_diagnosis(study: Study, campaign: Path, out: Path) -> tuple[dict[str, Any] | None, float, str]:
    """diagnosis.json (None if it failed), wall time [s], the end of what the process wrote to stderr."""
    command = [*shlex.split(study.diagnose), str(campaign), "--model", study.model, "--out", str(out)]
    began = time.perf_counter()
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=study.timeout_s, check=False)
        said = done.stderr[-800:] if done.returncode else ""
    except subprocess.TimeoutExpired:
        said = f"no answer within {study.timeout_s:.0f} s"
    took = time.perf_counter() - began
    file = out / "diagnosis.json"
    if not file.exists():
        return None, took, said or "no diagnosis.json"
    return json.loads(file.read_text()), took, said


def _after_m(diagnosis: dict[str, Any]) -> float | None:
    rms = diagnosis.get("gain", {}).get("path_rms_m", {})
    after = rms.get("after") if isinstance(rms, dict) else None
    return float(after["value"] if isinstance(after, dict) else after) if after is not None else None


def score(c: Campaign, diagnosis: dict[str, Any]) -> dict[str, Any]:
    """Everything the seal allows to say about a diagnosis."""
    f = floor(c)
    said = answer(diagnosis)
    row: dict[str, Any] = {
        "verdict": said.verdict,
        "chosen": [str(n) for n in said.chosen],
        "group": [str(n) for n in said.group],
        "truth": [e.as_dict() for e in c.effects],
        "hidden": [str(Name(e.name, e.place)) for e in c.effects],
        "floor_m": f,
        "floor_said_m": diagnosis.get("noise_floor_m"),
        "held_out_over_floor": (after / f) if (after := _after_m(diagnosis)) is not None else None,
    }
    if any(e.name not in CATALOGUE for e in c.effects):
        return row | {"outcome": "wrong" if said.verdict == "explained" else "right"}
    strengths = [strength(c, e, f) for e in c.effects]
    verdict = judge(said, c.effects, strengths, lambda i, n: separation(c, c.effects[i], n.name, n.place, f))
    missed = errors(diagnosis, c.effects)
    return row | {
        "strengths": strengths,
        "outcome": verdict.outcome,
        "separations": verdict.separations,
        "covered": {name: abs(error) <= 1 for name, error in missed.items()},
        "errors_over_half_width": missed,
    }


def _truth_in_group(said: Answer, effects: tuple[Effect, ...]) -> bool:
    return all(Name(e.name, e.place) in said.group for e in effects)


def _experiment(diagnosis: dict[str, Any], out: Path) -> tuple[np.ndarray, float] | None:
    """The proposed joint table and cycle duration, if there is one."""
    proposed = diagnosis.get("next_experiment") or {}
    if not proposed.get("joint_table"):
        return None
    table = np.loadtxt(out / proposed["joint_table"], delimiter=",", skiprows=1)
    return table, float(proposed["cycle_duration_s"])


def follow_up(study: Study, c: Campaign, diagnosis: dict[str, Any], out: Path, work: Path) -> dict[str, Any]:
    """Play the proposed experiment, and beside it a random gait, in the same world; diagnose both again."""
    before = answer(diagnosis)
    experiment = _experiment(diagnosis, out)
    if len(before.group) < 2 or experiment is None:
        return {}
    table, cycle_s = experiment
    random = random_table(np.random.default_rng(c.seed), 1, cycle_s)
    result: dict[str, Any] = {"group_before": len(before.group), "truth_before": _truth_in_group(before, c.effects)}
    for label, gait in (("proposed", table), ("random", random)):
        folder = work / label
        write(with_experiment(c, gait, cycle_s), folder)
        again, _, _ = run_diagnosis(study, folder, work / f"{label}-out")
        if again is not None:
            said = answer(again)
            result[f"group_{label}"] = len(said.group)
            result[f"truth_{label}"] = _truth_in_group(said, c.effects)
    return result


def run_one(study: Study, index: int) -> dict[str, Any]:
    """One trial; returns its row, from the file if it was run before."""
    identity = study.digest("name", index)[:12]
    file = study.out / study.kind / f"{identity}.json"
    if file.exists():
        return json.loads(file.read_text())
    seed = int(study.digest("seed", index)[:15], 16)
    with tempfile.TemporaryDirectory() as temporary:
        work = Path(temporary)
        folder, out, sealed = work / identity, work / "out", work / "sealed" / f"{identity}.json"
        c = make(seed, study.hidden(index), identity)
        write(c, folder)
        seal(c, sealed)
        del c  # from here on the seal alone knows
        diagnosis, took, said = run_diagnosis(study, folder, out)
        opened = json.loads(sealed.read_text())
        c = make(opened["seed"], study.hidden(index), identity)
        row = {"identity": identity, "seconds": took}
        row |= score(c, diagnosis) if diagnosis else {"outcome": "failed", "hidden": [e.name for e in c.effects]}
        if said:
            row["stderr"] = said
        if study.kind == "followup" and diagnosis:
            row |= follow_up(study, c, diagnosis, out, work)
        if study.keep:
            shutil.copytree(folder, study.out / "campaigns" / identity, dirs_exist_ok=True)
    _atomic(file, row)
    return row


def run(study: Study, count: int, jobs: int) -> dict[str, Any]:
    """All trials, then the summary; interrupted studies go on where they stopped."""
    rows = []
    with ProcessPoolExecutor(jobs) as pool:
        waiting = [pool.submit(run_one, study, i) for i in range(count)]
        for n, done in enumerate(as_completed(waiting), 1):
            row = done.result()
            rows.append(row)
            sys.stderr.write(f"{n}/{count} {row['identity']} {row['outcome']} ({row['seconds']:.0f} s)\n")
    command = f"python -m blind.study --kind {study.kind} --count {count} --model {study.model} --key {study.key}"
    summary = {"command": command} | summarise(study.kind, sorted(rows, key=lambda r: r["identity"]))
    _atomic(study.out / f"{study.kind}.json", summary)
    return summary


def main() -> None:
    p = argparse.ArgumentParser(description="Hidden-effect trials of `serpenoid diagnose`.")
    p.add_argument("--kind", choices=sorted(KINDS), required=True)
    p.add_argument("--count", type=int, required=True)
    p.add_argument("--out", type=Path, default=Path("results/blind"))
    p.add_argument("--model", default="problems/snake10.toml")
    p.add_argument("--diagnose", default=Study.diagnose, help="command before CAMPAIGN --model MODEL --out DIR")
    p.add_argument("--key", default=Study.key, help="another key, other campaigns")
    p.add_argument("--jobs", type=int, default=1)
    p.add_argument("--keep", action="store_true", help="keep the campaign folders")
    a = p.parse_args()
    study = Study(a.kind, a.out, a.model, a.diagnose, a.key, keep=a.keep)
    sys.stdout.write(json.dumps(run(study, a.count, a.jobs), indent=1) + "\n")


if __name__ == "__main__":
    main()
