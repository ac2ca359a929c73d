"""Find out what the simulation gets wrong, and why: name the cause, extend the model, measure the gain.

    serpenoid diagnose recordings/2024-09-foam --model problems/snake10.toml --out results/foam
    serpenoid solve problems/snake10.toml --model results/foam/extended-model.toml
    serpenoid diagnose recordings/today --reference recordings/2024-09-foam    # what changed since then?

Climbs three rungs: command against shape (actuation: servos), shape against markers (observation: cameras, clocks),
shape against motion (medium: wheels and floor). On each, the error stands beside its noise floor, which repeated trials
tell: record every setting twice. Effects (see `serpenoid effects`) are chosen by how well they predict gaits they were
not fitted to, so record six gaits or more, one of them tail first, at several cycle durations and headings.

verdict           nothing left      something left
  effects named   explained         partly explained
  none named      nothing           unexplained

An effect's strength is its trace in floors; below 1.6 it is too faint to name, and only the extended model has it where
gaits that were not fitted are predicted better with it. `or ...` are effects that the data cannot tell from the one
above; `next-experiment.csv` is the gait that would.

With a reference, that campaign is diagnosed first; what the model gets wrong there is no news.

Writes report.html (begin there; it needs no other file), diagnosis.json, baseline-model.toml and
extended-model.toml, figures as PNG and SVG.
Exit code 0 whatever the verdict, 2 where the campaign or the model cannot be read.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from serpenoid.cli import campaigns, options

if TYPE_CHECKING:
    from serpenoid.diagnose.baseline import Baseline
    from serpenoid.diagnose.diagnose import Diagnosis
    from serpenoid.measure.campaign import CampaignFile

STAGES = 10


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `diagnose`."""
    campaigns.add_campaign(parser)
    parser.add_argument(
        "--model",
        metavar="FILE",
        help="problem or model file: baseline medium (default: the campaign's) and effects that are known; "
        "eps is calibrated",
    )
    parser.add_argument("--reference", metavar="CAMPAIGN", help="an earlier campaign: say what changed since then")
    options.add_output(parser, "results/<campaign>/diagnosis")


def run(args: argparse.Namespace) -> int:
    """Diagnose, write, report."""
    from serpenoid.diagnose.reference import reference_of, summary
    from serpenoid.diagnose.words import lines
    from serpenoid.diagnose.write import write
    from serpenoid.measure.campaign import load_campaign_file

    wanted = [*([args.reference] if args.reference else []), args.campaign]
    sizes = [len(load_campaign_file(c)[0].trial) + STAGES for c in wanted]
    folder = options.output_folder(args, Path("results") / campaigns.name_of(args.campaign) / "diagnosis")
    with options.progress_bar(args, "diagnosing", sum(sizes)) as advance:
        earlier, before = None, None
        if args.reference:
            file, then = _diagnosed(args, args.reference, None, advance)
            earlier, before = reference_of(then), summary(then) | {"campaign": file.name}
        file, found = _diagnosed(args, args.campaign, earlier, lambda n, text: advance(sum(sizes[:-1]) + n, text))
        record = write(folder, file, found, before)
        if not args.no_figures:
            advance(sum(sizes), "figures")
            _pictures(folder, found, record)
        advance(sum(sizes), "")
    options.report(args, record, [*lines(record), f"written to {folder}"], folder)
    return 0


def _diagnosed(
    args: argparse.Namespace, campaign: str, earlier: Baseline | None, advance: Callable[[int, str], None]
) -> tuple[CampaignFile, Diagnosis]:
    """One campaign, beside what was so earlier or beside the model alone; the motion alone where points are all."""
    from serpenoid.diagnose.baseline import Baseline
    from serpenoid.diagnose.diagnose import diagnose, diagnose_tracked
    from serpenoid.diagnose.recording import read_recordings
    from serpenoid.diagnose.start import baseline, check_body
    from serpenoid.diagnose.tracked import is_tracked_only, tracked_recordings
    from serpenoid.errors import InputError
    from serpenoid.measure.campaign import load_campaign_file
    from serpenoid.measure.load import load_campaign

    file, _ = load_campaign_file(campaign)
    count = len(file.trial)
    stages = iter(range(count, count + STAGES))

    def say(text: str) -> None:
        advance(next(stages, count + STAGES), text)

    def reading(done: int, total: int, name: str) -> None:
        advance(done, name)

    if is_tracked_only(file):
        if args.reference:
            raise InputError(f"{campaign}: has tracked points alone, so no other campaign repeats its shapes.")
        tracked = tracked_recordings(load_campaign(campaign, reading))
        return file, diagnose_tracked(tracked, baseline(args.model, file, tracked[0].body), say)
    check_body(args.model, file)
    known = earlier or Baseline(baseline(args.model, file, file.body))
    known.check(file.body)
    return file, diagnose(read_recordings(campaign, reading)[1], known, say)


def _pictures(folder: Path, found: Diagnosis, record: dict[str, Any]) -> None:
    from serpenoid.diagnose.animate import animated
    from serpenoid.diagnose.report import write_pages
    from serpenoid.gaits.table import read_table
    from serpenoid.plot.diagnosis import draw_all

    proposed = record["next_experiment"]
    draw_all(folder, found, read_table(folder / proposed["joint_table"]) if proposed else None)
    write_pages(folder, record, animated(found))
