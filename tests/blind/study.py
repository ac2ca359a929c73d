"""Many hidden-effect trials, one after another or side by side, resumable.

    python -m blind.study --kind random --count 60 --key K --out results/blind --jobs 2

Each trial: make a campaign, run the diagnosis in its own process, only then open the seal and score. Results: one row
a trial in OUT/KIND.csv (table.py), all kinds in OUT/summary.md. A row that is there is not made again. `followup` plays
the experiment proposed in the same world and diagnoses again; some trials yield no group. All kinds: kinds.py.
"""

from __future__ import annotations

import argparse
import hashlib
import hmac
import json
import resource
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from blind import changed_trials, table
from blind.campaign import Campaign
from blind.catalogue import CATALOGUE
from blind.folder import seal, write
from blind.follow_up import follow_up
from blind.kinds import KINDS, RANDOM, Case, case
from blind.known_law import known_law
from blind.pages import write_page
from blind.score import REQUIRED, Answer, Name, answer, errors, judge, odds
from blind.separation import separation
from blind.strength import effective_eps, floor, strength
from serpenoid.parallel import Workers, results

ROOT = Path(__file__).parents[2]
REFUSED = 2  # exit code of a diagnosis that says why it cannot be made


@dataclass(frozen=True)
class Study:
    """What to run. `diagnose` is the command before CAMPAIGN; keys make identities that tell nothing. model: None where
    the robot is not the one of a problem file."""

    kind: str
    out: Path
    model: str | None
    diagnose: str = f"{sys.executable} -m serpenoid diagnose"
    key: str = "blind-6"
    timeout_s: float = 1800.0
    keep: bool = False

    def case(self, index: int) -> Case:
        """Number `index`."""
        return case(self.kind, index, int(self.digest("seed", index)[:15], 16), self.identity(index))

    def identity(self, index: int) -> str:
        """A name that tells nothing."""
        return self.digest("name", index)[:12]

    def digest(self, purpose: str, index: int) -> str:
        text = f"{purpose}:{self.kind}:{index}"
        return hmac.new(self.key.encode(), text.encode(), hashlib.sha256).hexdigest()


@dataclass(frozen=True)
class Said:
    """diagnosis.json (None if there is none), wall and processor time [s], exit code and the end of stderr."""

    diagnosis: dict[str, Any] | None
    seconds: float
    processor_s: float
    code: int
    stderr: str


def run_diagnosis(study: Study, campaign: Path, out: Path, more: Sequence[str] = ()) -> Said:
    """The diagnosis in a process of its own."""
    model = ["--model", study.model] if study.model else []
    command = [*shlex.split(study.diagnose), str(campaign), *model, "--out", str(out), *more]
    began, used = time.perf_counter(), _children()
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=study.timeout_s, check=False)
        code, said = done.returncode, done.stderr[-800:] if done.returncode else ""
    except subprocess.TimeoutExpired:
        code, said = -1, f"no answer within {study.timeout_s:.0f} s"
    took, file = (time.perf_counter() - began, _children() - used), out / "diagnosis.json"
    return Said(json.loads(file.read_text()) if file.exists() else None, *took, code, said)


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _after_m(diagnosis: dict[str, Any]) -> float | None:
    rms = diagnosis.get("gain", {}).get("path_rms_m", {})
    after = rms.get("after") if isinstance(rms, dict) else None
    return float(after["value"] if isinstance(after, dict) else after) if after is not None else None


def score(found: Case, diagnosis: dict[str, Any]) -> dict[str, Any]:
    """Everything the seal allows to say about a diagnosis."""
    if found.acts is not None:
        return changed_trials.score(found.campaign, found.acts, diagnosis)
    c, said = found.campaign, answer(diagnosis)
    f = floor(c)
    row: dict[str, Any] = {
        "verdict": said.verdict,
        "chosen": [str(n) for n in said.chosen],
        "group": [str(n) for n in said.group],
        "stand_ins": [str(n) for n in said.stand_ins],
        "odds": odds(diagnosis),
        "truth": [e.as_dict() for e in c.effects],
        "hidden": [str(Name(e.name, e.place)) for e in c.effects],
        "noise_level_m": f,
        "floor_said_m": diagnosis.get("noise_level_m"),
        "held_out_over_floor": (after / f) if (after := _after_m(diagnosis)) is not None else None,
        "left_open_said_m": diagnosis.get("left_open_m"),
        "eps": c.eps,
        "eps_said": diagnosis.get("anisotropy_ratio", {}).get("after"),
        "eps_interval": diagnosis.get("anisotropy_ratio", {}).get("interval"),
        "eps_alone": diagnosis.get("anisotropy_ratio", {}).get("before"),
    }
    if c.base and found.reference is None:
        return row | healthy(c, said, f)
    if any(e.name not in CATALOGUE for e in c.effects):
        return row | {"outcome": "wrong" if said.verdict == "explained" else "right"}
    strengths = [strength(c, e, f) for e in c.effects]
    verdict = judge(said, c.effects, strengths, lambda i, n: separation(c, c.effects[i], n.name, n.place, f))
    missed, known = errors(diagnosis, c.effects), known_law(c)
    return row | {
        "left_open_m": known.left_open,
        "held_out_known_m": known.held_out,
        "strengths": strengths,
        "outcome": verdict.outcome,
        "separations": verdict.separations,
        "covered": {name: abs(error) <= 1 for name, error in missed.items()},
        "errors_over_half_width": missed,
    }


def healthy(c: Campaign, said: Answer, floor_m: float) -> dict[str, Any]:
    """Another physics, nothing changed: what is named, and not said to stand in for a law, is wrong. Not scored where
    the law that is out of the catalogue is weak itself: nor would an effect of the catalogue be."""
    alone = replace(c, effects=c.base, base=())
    strengths = [strength(alone, law, floor_m) for law in c.base]
    named = sorted(set(said.chosen) - set(said.stand_ins), key=str)
    apart = {f"{law.name} / {n}": separation(alone, law, n.name, n.place, floor_m) for law in c.base for n in named}
    outcome = "right" if not named else "stand-in" if max(strengths) >= REQUIRED else "unscored"
    return {"eps_effective": effective_eps(c), "strengths": strengths, "separations": apart, "outcome": outcome}


def described(c: Campaign) -> dict[str, Any]:
    """The protocol in a few columns."""
    p, tools = c.protocol, c.protocol.instruments
    return {
        "joints": p.robot.joints, "gaits": len({s.gait for s in p.settings}), "plays": p.plays,
        "frames_per_second": tools.frames_per_second, "marker_noise_m": tools.marker_noise,
        "log_hertz": tools.log_hertz, "unseen": list(tools.unseen), "base": [e.as_dict() for e in c.base],
    }  # fmt: skip


def run_one(study: Study, index: int) -> dict[str, Any]:
    """One trial; returns its row."""
    identity = study.identity(index)
    with tempfile.TemporaryDirectory() as temporary:
        work = Path(temporary)
        folder, out, sealed = work / identity, work / "out", work / "sealed" / f"{identity}.json"
        found = study.case(index)
        write(found.campaign, folder)
        seal(found.campaign, sealed)
        more = [f"--without={name}" for name in found.without]
        if found.reference is not None:
            write(found.reference, work / "before")
            more += ["--reference", str(work / "before")]
        del found  # from here on the seal alone knows
        said = run_diagnosis(study, folder, out, more)
        opened = json.loads(sealed.read_text())
        found = study.case(index)
        if [e.as_dict() for e in found.campaign.effects] != opened["effects"]:
            raise RuntimeError(f"{identity}: the seal does not belong to this campaign")
        row = {"identity": identity, "cause": found.cause, "seconds": said.seconds, "processor_s": said.processor_s}
        row |= described(found.campaign)
        if said.diagnosis and not said.code:
            row |= score(found, said.diagnosis)
        else:
            hidden = [str(Name(e.name, e.place)) for e in found.campaign.effects]
            row |= {"outcome": "refused" if said.code == REFUSED else "failed", "hidden": hidden}
        if said.stderr:
            row["stderr"] = said.stderr.replace(f"{ROOT}/", "")
        if study.kind == "followup" and said.diagnosis:
            again = lambda folder, new: run_diagnosis(study, folder, new).diagnosis  # noqa: E731
            row |= follow_up(found.campaign, said.diagnosis, out, work, again)
        if study.keep:
            shutil.copytree(folder, study.out / "campaigns" / identity, dirs_exist_ok=True)
    return row


def run(study: Study, count: int, workers: Workers) -> list[dict[str, Any]]:
    """All trials that the table has not; interrupted studies go on where they stopped."""
    file = study.out / f"{study.kind}.csv"
    before, rows = table.read(file)
    if before.get("key", study.key) != study.key:
        raise SystemExit(f"{file} is of key {before['key']}: another key needs another --out.")
    command = f"python -m blind.study --kind {study.kind} --count {count} --key {study.key}"
    command += f" --model {study.model}" if study.model else ""
    commits = dict.fromkeys([*filter(None, before.get("commit", "").split(" ")), commit()])
    above = {"command": command, "commit": " ".join(commits), "key": study.key}
    known = {row["identity"] for row in rows}
    order = {study.identity(i): i for i in range(count)}
    waiting = [(study, i) for name, i in order.items() if name not in known]
    for n, (_, row) in enumerate(results(run_one, waiting, workers), 1):
        rows = sorted([*rows, row], key=lambda r: order.get(r["identity"], count))
        table.write(file, above, rows)
        sys.stderr.write(f"{n}/{len(waiting)} {row['identity']} {row['outcome']} ({row['seconds']:.0f} s)\n")
    write_page(study.out)
    return rows


def commit() -> str:
    """Of the code that is run."""
    done = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False)
    return done.stdout.strip() or "unknown"


def main() -> None:
    p = argparse.ArgumentParser(description="Hidden-effect trials of `serpenoid diagnose`.")
    p.add_argument("--kind", choices=KINDS, required=True)
    p.add_argument("--count", type=int, required=True)
    p.add_argument("--out", type=Path, default=Path("results/blind"))
    p.add_argument("--model", help="default: none for random protocols, else problems/snake10.toml")
    p.add_argument("--diagnose", default=Study.diagnose, help="command before CAMPAIGN --model MODEL --out DIR")
    p.add_argument("--key", default=Study.key, help="another key, other campaigns")
    p.add_argument("--jobs", type=int, default=1)
    p.add_argument("--cluster", help="a Dask scheduler's address, or local:N")
    p.add_argument("--keep", action="store_true", help="keep the campaign folders")
    a = p.parse_args()
    model = a.model or (None if a.kind in (*RANDOM, "once", "amid") else "problems/snake10.toml")
    run(Study(a.kind, a.out, model, a.diagnose, a.key, keep=a.keep), a.count, Workers(a.jobs, a.cluster))


if __name__ == "__main__":
    main()
