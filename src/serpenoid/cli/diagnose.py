"""Find out what the simulation gets wrong, and why: name the cause, extend the model, measure the gain.

    serpenoid diagnose recordings/2024-09-foam --model problems/snake10.toml --out results/foam
    serpenoid solve problems/snake10.toml --model results/foam/extended-model.toml

Three rungs: command against shape (actuation), shape against markers (observation), shape against motion (medium).
Verdicts: nothing | explained | partly explained | unexplained. What the data cannot separate is reported as a group.
Writes diagnosis.json, extended-model.toml, figures and report.html.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from serpenoid.cli import campaigns, options

if TYPE_CHECKING:
    from serpenoid.diagnose.diagnose import Diagnosis
    from serpenoid.measure.campaign import CampaignFile

STAGES = 10


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `diagnose`."""
    campaigns.add_campaign(parser)
    parser.add_argument("--model", metavar="FILE", help="problem or model file with the baseline medium")
    options.add_output(parser)


def run(args: argparse.Namespace) -> int:
    """Diagnose, write, report."""
    from serpenoid.diagnose.start import lines
    from serpenoid.diagnose.write import write
    from serpenoid.measure.campaign import load_campaign_file

    file, _ = load_campaign_file(args.campaign)
    count = len(file.trial)
    with options.progress_bar(args, "diagnosing", count + STAGES) as advance:
        at = iter(range(count, count + STAGES + 1))
        found = _diagnosed(args, file, advance, lambda text: advance(next(at, count + STAGES), text))
        folder = options.output_folder(args, Path("results") / Path(args.campaign).resolve().name / "diagnosis")
        if not args.no_figures:
            from serpenoid.plot.diagnosis import draw_all

            draw_all(folder, found)
        record = write(folder, file, found, figures=not args.no_figures)
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
    file, recordings = read_recordings(args.campaign, reading)
    return diagnose(recordings, baseline(args.model, file, file.body), say)
