"""Find out what the simulation gets wrong, and why: name the cause, extend the model, measure the gain.

    serpenoid diagnose recordings/2024-09-foam --model problems/snake10.toml --out results/foam
    serpenoid solve problems/snake10.toml --model results/foam/extended-model.toml

Three rungs: command against shape (actuation), shape against markers (observation), shape against motion (medium).
Verdicts: nothing | explained | partly explained | unexplained. What the data cannot separate is reported as a group.
Writes diagnosis.json, extended-model.toml, figures and report.html.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from serpenoid.cli import campaigns, options

STAGES = 10


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `diagnose`."""
    campaigns.add_campaign(parser)
    parser.add_argument("--model", metavar="FILE", help="problem or model file with the baseline medium")
    options.add_output(parser)


def run(args: argparse.Namespace) -> int:
    """Diagnose, write, report."""
    from serpenoid.diagnose.diagnose import diagnose
    from serpenoid.diagnose.recording import read_recordings
    from serpenoid.diagnose.start import baseline
    from serpenoid.diagnose.words import lines
    from serpenoid.diagnose.write import write
    from serpenoid.measure.campaign import load_campaign_file

    file, _ = load_campaign_file(args.campaign)
    count = len(file.trial)
    with options.progress_bar(args, "diagnosing", count + STAGES) as advance:
        file, recordings = read_recordings(args.campaign, lambda done, total, name: advance(done, name))
        at = iter(range(count, count + STAGES + 1))
        found = diagnose(recordings, baseline(args.model, file), lambda text: advance(next(at, count + STAGES), text))
        folder = options.output_folder(args, Path("results") / Path(args.campaign).resolve().name / "diagnosis")
        if not args.no_figures:
            from serpenoid.plot.diagnosis import draw_all

            draw_all(folder, found)
        record = write(folder, file, found, figures=not args.no_figures)
        advance(count + STAGES)
    options.report(args, record, [*lines(record), f"written to {folder}"])
    return 0
