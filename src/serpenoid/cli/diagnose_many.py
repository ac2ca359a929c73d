"""Several campaigns diagnosed, in processes of this machine or on a cluster, and all answers in one table.

Each has a folder of its own beside the table. A campaign whose diagnosis is there, made from the same files by the same
version, is not diagnosed again: the same command goes on where it was stopped.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from serpenoid.cli import campaigns, options
from serpenoid.cli.claim import content_of, content_of_campaign, sign
from serpenoid.errors import InputError
from serpenoid.files.writing import short_hash, write_csv, write_json
from serpenoid.version import __version__

RECEIPT = "inputs.json"  # what a diagnosis was made from
HEADER = (
    "campaign", "verdict", "effects", "alternatives", "changed_trials", "path_rms_before_m", "path_rms_after_m",
    "noise_level_m", "anisotropy_ratio", "drag_ratio", "drag_ratio_low", "drag_ratio_high", "seconds", "folder",
    "fault",
)  # fmt: skip


def run_many(args: argparse.Namespace) -> int:
    """Diagnose all, write diagnoses.csv, report; exit code 1 where a campaign could not be diagnosed."""
    from serpenoid.parallel import results

    names = [campaigns.name_of(c) for c in args.campaign]
    model = content_of(Path(args.model)) if args.model else None
    earlier = content_of_campaign(args.reference) if args.reference is not None else None
    key = short_hash(names, model, earlier, sorted(args.without))
    folder = options.output_folder(args, Path("results") / f"diagnoses-{key}", key)
    if len(set(names)) < len(names):
        raise InputError("two of the campaigns have the same name and would write to the same folder: name each once.")
    asked = {key: value for key, value in vars(args).items() if key not in ("run", "held", "requests")}
    tasks = [
        (asked | {"campaign": [str(Path(c).resolve())], "out": str((folder / name).resolve())},)
        for c, name in zip(args.campaign, names, strict=True)
    ]
    sign(args)
    rows: dict[int, dict[str, Any]] = {}
    with options.progress_bar(args, "campaigns", len(tasks)) as advance:
        for index, row in results(diagnose_one, tasks, options.workers(args)):
            rows[index] = row
            advance(len(rows), f"{row['campaign']}: {row['verdict'] or row['fault']}")
            write_table(folder / "diagnoses.csv", [rows[i] for i in sorted(rows)])
    found = [rows[i] for i in sorted(rows)]
    lines = [_line(row) for row in found]
    options.report(args, found, [*lines, f"table             {folder / 'diagnoses.csv'}"], folder)
    return 1 if any(r["fault"] for r in found) else 0


def _line(row: dict[str, Any]) -> str:
    """Campaign, verdict, what was named or went wrong; of an animal K, too."""
    ratio = [f"K {row['drag_ratio']:.3g} with nothing named"] if row["drag_ratio"] else []
    said = "; ".join([row["effects"] or row["fault"] or "", *ratio]).removeprefix("; ")
    return f"{row['campaign']:24} {row['verdict'] or 'failed':18} {said}".rstrip()


def write_table(path: Path, rows: list[dict[str, Any]]) -> None:
    """One line a campaign; pandas.read_csv opens it."""
    write_csv(path, HEADER, [["" if row[key] is None else row[key] for key in HEADER] for row in rows])


def diagnose_one(settings: dict[str, Any]) -> dict[str, Any]:
    """One campaign in a process of its own: its row, from its folder if it was diagnosed before."""
    from serpenoid.cli.diagnose_one import run_one

    args = argparse.Namespace(**settings | {"quiet": True, "json": False, "open": False, "jobs": 1, "cluster": None})
    campaign, out, begun = args.campaign[0], Path(args.out), time.perf_counter()
    receipt = {"inputs": fingerprint(args)}
    row: dict[str, Any] = dict.fromkeys(HEADER) | {"campaign": campaigns.name_of(campaign), "folder": str(out)}
    try:
        if not _same(out / RECEIPT, receipt):
            with ExitStack() as args.held:
                run_one(args, campaign)
            write_json(out / RECEIPT, receipt | {"seconds": time.perf_counter() - begun})
    except (InputError, OSError) as error:
        return row | {"fault": str(error)}
    return row | _answers(out)


def fingerprint(args: argparse.Namespace) -> str:
    """Hash of all files of the campaign, model and reference, and of the options that change the answer."""
    found = hashlib.sha256(f"{__version__} {args.no_figures} {sorted(args.without)}".encode())
    for name in (args.campaign[0], args.model, args.reference):
        if name is not None:
            place = Path(name) if Path(name).is_dir() else Path(name).parent
            for path in sorted(place.rglob("*")) if Path(name).is_dir() else [Path(name)]:
                if path.is_file():
                    found.update(str(path.relative_to(place)).encode() + path.read_bytes())
    return found.hexdigest()


def _same(path: Path, receipt: dict[str, Any]) -> bool:
    try:
        return json.loads(path.read_text(encoding="utf-8"))["inputs"] == receipt["inputs"]
    except (OSError, ValueError, KeyError, TypeError):
        return False


def _answers(out: Path) -> dict[str, Any]:
    from serpenoid.diagnose.report.sentences import changed_trials
    from serpenoid.diagnose.report.words import title

    record = json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))
    rms, drag = record["gain"]["path_rms_m"], record["drag_ratio"] or {"value": None, "interval": [None, None]}
    return {
        "verdict": record["verdict"],
        "effects": "; ".join(title(e) for e in record["effects"]),
        "alternatives": "; ".join(title(e) for e in record["alternatives"]),
        "changed_trials": "; ".join(changed_trials(record)[:2]),
        "path_rms_before_m": rms["before"],
        "path_rms_after_m": rms["after"],
        "noise_level_m": record["noise_level_m"],
        "anisotropy_ratio": record["anisotropy_ratio"]["after"],
        "drag_ratio": drag["value"],
        "drag_ratio_low": drag["interval"][0],
        "drag_ratio_high": drag["interval"][1],
        "seconds": json.loads((out / RECEIPT).read_text(encoding="utf-8"))["seconds"],
    }
