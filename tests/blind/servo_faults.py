"""What the diagnosis says of servos that no law of the catalogue describes, beside truths of the catalogue; resumable.

    python -m blind.servo_faults --key K --count 1 --out results/blind/servo-faults

Each row of OUT/faults.csv: one campaign (faults.py) through the stages that read the servo log, actuation and
observation. `laws` holds what each law of the servos leaves of what it does, the number that
`law_error.LAW_ERROR` is compared with; `share_left` the smallest of those at the place of the fault. A row that
is there is not made again.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from blind import table
from blind.catalogue import Effect
from blind.faults import AKIN, AT_ALL, FAULTS, HARMLESS, Faulty, faulty
from blind.folder import write
from blind.score import REQUIRED, Name
from blind.strength import strength
from blind.study import Study, commit
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.inference.fits.finding import Named, Stage
from serpenoid.diagnose.stages.actuation.actuation_search import Played
from serpenoid.diagnose.stages.actuation.choose_actuation import _law_error
from serpenoid.diagnose.stages.actuation.expected import carried
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.observation.choose_observation import choose_observation
from serpenoid.diagnose.stages.observation.witness import of_servos
from serpenoid.errors import InputError
from serpenoid.medium import Medium
from serpenoid.model import Model

Laws = dict[str, float | str]
REFUSED = re.compile(
    r"^(\w+?)(?: at (?:joint|vertex) (\d+))? would leave (?:(\d+)%|(more)) (?:of what|than) it does: not its law$"
)
MORE = "> 1"  # of what it does


@dataclass(frozen=True)
class Said:
    """Of the two stages: names, those that are said to be stand-ins, what each law leaves of what it does, words."""

    named: tuple[Name, ...] = ()
    stand_ins: tuple[Name, ...] = ()
    laws: tuple[tuple[Name, float | str], ...] = ()
    told: tuple[str, ...] = ()
    crash: str = ""


def said_of(folder: Path) -> Said:
    """What a campaign folder's servo log and markers show."""
    try:
        return _said(folder)
    except InputError as error:
        return Said(told=(str(error).replace(f"{folder}/", ""),))
    except Exception:  # noqa: BLE001 a crash is a result
        return Said(crash=traceback.format_exc(limit=-2))


def _said(folder: Path) -> Said:
    _, recordings = read_recordings(folder)
    model = Model(recordings[0].body, Medium(anisotropy_ratio=0.2))  # of the floor nothing is asked
    recordings, servos, actuation = of_servos(recordings, Baseline(model))
    observation = Stage("observation")
    carrying = carried(recordings, servos, [n.effect for n in (*actuation.named, *actuation.undetected)])
    if all(r.by_servos for r in carrying):
        observation, _ = choose_observation(carrying, Observation.neutral(carrying[0].body))
    every = (*actuation.named, *observation.named)
    remarks = dict.fromkeys(remark.words for r in carrying for remark in r.remarks)
    return Said(
        tuple(_name(n) for n in every),
        tuple(_name(n) for n in every if n.stand_in),
        (*_kept(servos, (*actuation.named, *actuation.undetected)), *_refused((*actuation.words, *observation.words))),
        (*actuation.words, *observation.words, *remarks),
    )


def _name(n: Named) -> Name:
    return Name(n.effect.name, n.effect.place)


def _kept(servos: Plays, named: Sequence[Named]) -> Iterator[tuple[Name, float | str]]:
    """Laws that are not refused."""
    best = Played(servos, tuple(n.effect for n in named))
    for n in named:
        share = _law_error(best, n.effect)
        yield _name(n), share if share <= 1 else MORE


def _refused(words: Sequence[str]) -> Iterator[tuple[Name, float | str]]:
    """Laws that are, from the words that say so."""
    for found in filter(None, map(REFUSED.match, words)):
        name, place, percent, _ = found.groups()
        yield Name(name, int(place) if place else None), int(percent) / 100 if percent else MORE


def outcome(fault: str, truth: Sequence[Effect], said: Said, place: int = 0, strength: float = np.inf) -> str:
    """Right: what is hidden is named alone, or nothing where joints follow; of a fault, words without a name are all
    that can be had, or the nearest law of the same part (akin). strength: of the truth, in noise levels."""
    hidden, names = {Name(e.name, e.place) for e in truth}, set(said.named)
    if said.crash:
        return "crash"
    if fault in AKIN and names == {Name(AKIN[fault], place)}:
        return "akin"
    if hidden and names == hidden:
        return "right"
    if names - hidden - set(said.stand_ins):
        return "wrong name"
    if names - hidden:
        return "stand-in"
    if fault in HARMLESS and not said.told:
        return "right"
    if hidden and strength < REQUIRED:
        return "below detection"
    return "refused in words" if said.told else "no name"


def _share_left(laws: Sequence[tuple[Name, float | str]], place: int | None) -> float | str | None:
    """Of the best law at a place."""
    there = [share for name, share in laws if name.place == place]
    numbers = [share for share in there if isinstance(share, float)]
    return min(numbers) if numbers else next(iter(there), None)


def _row(found: Faulty, said: Said, seconds: float) -> table.Row:
    c, at_all = found.campaign, found.fault in AT_ALL
    p, visible = c.protocol, [strength(c, e, np.inf) for e in c.effects]
    row = {
        "fault": found.fault, "identity": c.identity,
        "outcome": outcome(found.fault, c.effects, said, found.place, min(visible, default=np.inf)),
        "share_left": _share_left(said.laws, None if at_all else found.place),
        "joints": p.robot.joints, "place": "all" if at_all else found.place, "log_hertz": p.instruments.log_hertz,
        "gaits": len(p.settings), "plays": p.plays, "truth": [e.as_dict() for e in c.effects],
        "strength": min(visible, default=None),
        "named": [str(n) for n in said.named], "stand_ins": [str(n) for n in said.stand_ins],
        "laws": {str(name): share for name, share in said.laws}, "told": list(said.told), "processor_s": seconds,
    }  # fmt: skip
    row |= {"crash": said.crash} if said.crash else {}
    return {name: value for name, value in row.items() if value is not None}


def run_one(study: Study, index: int) -> table.Row:
    """One campaign; study.kind is the fault."""
    found = faulty(study.kind, int(study.digest("seed", index)[:15], 16), study.identity(index))
    with tempfile.TemporaryDirectory() as folder:
        write(found.campaign, Path(folder) / found.campaign.identity)
        began = time.process_time()
        said = said_of(Path(folder) / found.campaign.identity)
    return _row(found, said, time.process_time() - began)


def run(key: str, count: int, out: Path, faults: Sequence[str] = FAULTS) -> list[table.Row]:
    """All campaigns that the table has not, a campaign of each fault before the second of any."""
    file = out / "faults.csv"
    before, rows = table.read(file)
    if before.get("key", key) != key:
        raise SystemExit(f"{file} is of key {before['key']}: another key needs another --out.")
    commits = dict.fromkeys([*filter(None, before.get("commit", "").split(" ")), commit()])
    command = f"python -m blind.servo_faults --key {key} --count {count}"
    above = {"command": command, "commit": " ".join(commits), "key": key}
    known = {row["identity"] for row in rows}
    studies = [(Study(fault, out, None, key=key), i) for i in range(count) for fault in faults]
    for study, index in studies:
        if study.identity(index) in known:
            continue
        row = run_one(study, index)
        rows = sorted([*rows, row], key=lambda r: FAULTS.index(r["fault"]))
        table.write(file, above, rows)
        sys.stderr.write(f"{row['fault']} {row['identity']} {row['outcome']} ({row['processor_s']:.0f} s)\n")
    return rows


def main() -> None:
    p = argparse.ArgumentParser(description="Servo faults outside the catalogue, and truths, on the stages of the log.")
    p.add_argument("--key", required=True, help="another key, other campaigns")
    p.add_argument("--count", type=int, default=1, help="campaigns a fault")
    p.add_argument("--out", type=Path, default=Path("results/blind/servo-faults"))
    p.add_argument("--faults", nargs="*", choices=FAULTS, default=FAULTS, metavar="FAULT", help=", ".join(FAULTS))
    a = p.parse_args()
    run(a.key, a.count, a.out, a.faults)


if __name__ == "__main__":
    main()
