"""Many hidden-effect trials, one after another or side by side, resumable.

    python -m blind.study --kind one --count 200 --out results/blind/ --model problems/snake10.toml

Each trial: make a campaign, run the diagnosis in its own process, only then open the seal and score. Results: one JSON
per trial in OUT/KIND/, a summary in OUT/KIND.json, all kinds in OUT/summary.md. A trial whose JSON exists is not run
again. `followup` plays the experiment proposed in the same world and diagnoses again; some trials yield no group.
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
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from blind.campaign import COMBINATIONS, Campaign, make
from blind.catalogue import CATALOGUE
from blind.folder import seal, write
from blind.follow_up import follow_up
from blind.handful import HANDFUL, HANDFUL_COMBINATIONS
from blind.near import draw_near, short
from blind.pages import TITLES, write_page
from blind.score import Name, answer, errors, judge
from blind.separation import separation
from blind.strength import floor, strength
from blind.summary import summarise

HIDDEN: dict[str, int | str] = {"null": 0, "one": 1, "two": 2, "outside": "outside"}
KINDS = (*HIDDEN, "followup", "handful")


@dataclass(frozen=True)
class Study:
    """What to run. `diagnose` is the command before CAMPAIGN; keys make identities that tell nothing."""

    kind: str
    out: Path
    model: str
    diagnose: str = f"{sys.executable} -m serpenoid diagnose"
    key: str = "blind-6"
    timeout_s: float = 600.0
    keep: bool = False

    def campaign(self, index: int, identity: str) -> Campaign:
        """Number `index`: effects drawn, the given ones of the handful, or near ones in a short campaign."""
        seed = int(self.digest("seed", index)[:15], 16)
        if self.kind == "followup":
            return short(seed, draw_near(seed), identity)
        if self.kind == "handful":
            return make(seed, HANDFUL[index], identity, COMBINATIONS[:HANDFUL_COMBINATIONS])
        return make(seed, HIDDEN[self.kind], identity)

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


def run_one(study: Study, index: int) -> dict[str, Any]:
    """One trial; returns its row, from the file if it was run before."""
    identity = study.digest("name", index)[:12]
    file = study.out / study.kind / f"{identity}.json"
    if file.exists():
        return json.loads(file.read_text())
    with tempfile.TemporaryDirectory() as temporary:
        work = Path(temporary)
        folder, out, sealed = work / identity, work / "out", work / "sealed" / f"{identity}.json"
        c = study.campaign(index, identity)
        write(c, folder)
        seal(c, sealed)
        del c  # from here on the seal alone knows
        diagnosis, took, said = run_diagnosis(study, folder, out)
        opened = json.loads(sealed.read_text())
        c = study.campaign(index, identity)
        if [e.as_dict() for e in c.effects] != opened["effects"]:
            raise RuntimeError(f"{identity}: the seal does not belong to this campaign")
        row = {"identity": identity, "seconds": took}
        row |= score(c, diagnosis) if diagnosis else {"outcome": "failed", "hidden": [e.name for e in c.effects]}
        if said:
            row["stderr"] = said
        if study.kind == "followup" and diagnosis:
            row |= follow_up(c, diagnosis, out, work, lambda folder, new: run_diagnosis(study, folder, new)[0])
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
    if study.kind in TITLES:
        write_page(study.out)
    return summary


def main() -> None:
    p = argparse.ArgumentParser(description="Hidden-effect trials of `serpenoid diagnose`.")
    p.add_argument("--kind", choices=KINDS, required=True)
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
