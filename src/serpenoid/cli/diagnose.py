"""Find out what the simulation gets wrong, and why: name the cause, extend the model, measure the gain.

    serpenoid diagnose recordings/2024-09-foam --model problems/snake10.toml --out results/foam
    serpenoid solve problems/snake10.toml --model results/foam/extended-model.toml
    serpenoid diagnose recordings/today --reference recordings/2024-09-foam    # what changed since then?

Three rungs: command against shape (actuation), shape against markers (observation), shape against motion (medium).
Verdicts: nothing | explained | partly explained | unexplained. What the data cannot separate is reported as a group.
With a reference, that campaign is diagnosed first; what the model gets wrong there is no news.
Writes diagnosis.json, extended-model.toml, figures and report.html.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from serpenoid.cli import campaigns, options

if TYPE_CHECKING:
    from serpenoid.diagnose.baseline import Baseline
    from serpenoid.diagnose.diagnose import Diagnosis
    from serpenoid.measure.campaign import CampaignFile

STAGES = 10


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `diagnose`."""
    campaigns.add_campaign(parser)
    parser.add_argument("--model", metavar="FILE", help="problem or model file with the baseline medium")
    parser.add_argument("--reference", metavar="CAMPAIGN", help="an earlier campaign: say what changed since then")
    options.add_output(parser)


def run(args: argparse.Namespace) -> int:
    """Diagnose, write, report."""
    from serpenoid.diagnose.reference import reference_of, summary
    from serpenoid.diagnose.start import lines
    from serpenoid.diagnose.write import write
    from serpenoid.measure.campaign import load_campaign_file

    wanted = [*([args.reference] if args.reference else []), args.campaign]
    sizes = [len(load_campaign_file(c)[0].trial) + STAGES for c in wanted]
    with options.progress_bar(args, "diagnosing", sum(sizes)) as advance:
        earlier, before = None, None
        if args.reference:
            file, then = _diagnosed(args, args.reference, None, advance)
            earlier, before = reference_of(then), summary(then) | {"campaign": file.name}
        file, found = _diagnosed(args, args.campaign, earlier, lambda n, text: advance(sum(sizes[:-1]) + n, text))
        folder = options.output_folder(args, Path("results") / Path(args.campaign).resolve().name / "diagnosis")
        if not args.no_figures:
            from serpenoid.plot.diagnosis import draw_all

            draw_all(folder, found)
        record = write(folder, file, found, before, figures=not args.no_figures)
        advance(sum(sizes), "")
    options.report(args, record, [*lines(record), f"written to {folder}"])
    return 0


def _diagnosed(
    args: argparse.Namespace, campaign: str, earlier: Baseline | None, advance: Callable[[int, str], None]
) -> tuple[CampaignFile, Diagnosis]:
    """One campaign, beside what was so earlier or beside the model alone."""
    from serpenoid.diagnose.baseline import Baseline
    from serpenoid.diagnose.diagnose import diagnose
    from serpenoid.diagnose.recording import read_recordings
    from serpenoid.diagnose.start import baseline

    file, recordings = read_recordings(campaign, lambda done, total, name: advance(done, name))
    stages = iter(range(len(file.trial), len(file.trial) + STAGES))
    known = earlier or Baseline(baseline(args.model, file))
    known.check(file.body)
    return file, diagnose(recordings, known, lambda text: advance(next(stages, len(file.trial) + STAGES), text))
