"""Find out what the simulation gets wrong, and why: name the cause, extend the model, measure the gain.

    serpenoid diagnose recordings/2024-09-foam --model problems/snake10.toml --out results/foam
    serpenoid solve problems/snake10.toml --model results/foam/extended-model.toml

Climbs three rungs: command against shape (actuation: servos), shape against markers (observation: cameras, clocks),
shape against motion (medium: wheels and floor). On each, the error stands beside its noise floor, which repeated trials
tell: record every setting twice. Effects (see `serpenoid effects`) are chosen by how well they predict gaits they were
not fitted to, so record six gaits or more, one of them tail first, at several cycle durations and headings.

verdict           nothing left      something left
  effects named   explained         partly explained
  none named      nothing           unexplained

An effect's strength is its trace in floors; below 1.6 it is too faint to name. `or ...` are effects that the data
cannot tell from the one above; `next-experiment.csv` is the gait that would.

Writes report.html (begin there; it needs no other file), diagnosis.json, extended-model.toml, figures as PNG and SVG.
Exit code 0 whatever the verdict, 2 where the campaign or the model cannot be read.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from serpenoid.cli import campaigns, options

if TYPE_CHECKING:
    from serpenoid.diagnose.diagnose import Diagnosis
    from serpenoid.measure.campaign import CampaignFile

STAGES = 10


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `diagnose`."""
    campaigns.add_campaign(parser)
    parser.add_argument(
        "--model",
        metavar="FILE",
        help="problem or model file whose [medium] is the baseline; eps is calibrated (default: the campaign's)",
    )
    options.add_output(parser)


def run(args: argparse.Namespace) -> int:
    """Diagnose, write, report."""
    from serpenoid.diagnose.words import lines
    from serpenoid.diagnose.write import write
    from serpenoid.measure.campaign import load_campaign_file

    file, _ = load_campaign_file(args.campaign)
    folder = options.output_folder(args, Path("results") / Path(args.campaign).resolve().name / "diagnosis")
    count = len(file.trial)
    with options.progress_bar(args, "diagnosing", count + STAGES) as advance:
        at = iter(range(count, count + STAGES + 1))
        found = _diagnosed(args, file, advance, lambda text: advance(next(at, count + STAGES), text))
        record = write(folder, file, found)
        if not args.no_figures:
            advance(count + STAGES, "figures")
            _pictures(folder, found, record)
        advance(count + STAGES)
    options.report(args, record, [*lines(record), f"written to {folder}"])
    return 0


def _diagnosed(
    args: argparse.Namespace, file: CampaignFile, advance: Callable[..., None], say: Callable[[str], None]
) -> Diagnosis:
    """By all three rungs, or by the motion alone where points are all that was recorded."""
    from serpenoid.diagnose.diagnose import diagnose, diagnose_tracked
    from serpenoid.diagnose.recording import read_recordings
    from serpenoid.diagnose.start import baseline
    from serpenoid.diagnose.tracked import is_tracked_only, tracked_recordings
    from serpenoid.measure.load import load_campaign

    def reading(done: int, total: int, name: str) -> None:
        advance(done, name)

    if is_tracked_only(file):
        tracked = tracked_recordings(load_campaign(args.campaign, reading))
        return diagnose_tracked(tracked, baseline(args.model, file, tracked[0].body), say)
    model = baseline(args.model, file, file.body)
    return diagnose(read_recordings(args.campaign, reading)[1], model, say)


def _pictures(folder: Path, found: Diagnosis, record: dict[str, Any]) -> None:
    from serpenoid.diagnose.report import write_pages
    from serpenoid.gaits.table import read_table
    from serpenoid.plot.diagnosis import draw_all

    proposed = record["next_experiment"]
    draw_all(folder, found, read_table(folder / proposed["joint_table"]) if proposed else None)
    write_pages(folder, record)
