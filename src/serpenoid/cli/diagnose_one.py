"""One campaign diagnosed: read, judged, written, drawn, and said."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from serpenoid.cli import campaigns, options
from serpenoid.cli.claim import content_of, content_of_campaign, sign
from serpenoid.cli.pictures import Pictures, prepare
from serpenoid.cli.work import SERVOS, Work

if TYPE_CHECKING:
    from serpenoid.diagnose.campaign import Listener
    from serpenoid.diagnose.diagnose import Diagnosis
    from serpenoid.diagnose.inference.search.select import Selection
    from serpenoid.diagnose.stages.baseline import Baseline
    from serpenoid.measure.campaign import CampaignFile
    from serpenoid.measure.consistency.claims import Believed, Reader
    from serpenoid.parallel import Beside

    Read = tuple[list[tuple[str, str]], Believed]


def run_one(args: argparse.Namespace, campaign: str) -> int:
    """Diagnose, write, report; the campaign's files are read and checked while what judges them is imported."""
    from serpenoid.measure.campaign import load_campaign_file
    from serpenoid.parallel import Beside

    with Beside(lambda: None) as reader:
        if not load_campaign_file(campaign)[0].tracked_only:
            # what reads and what judges both need is imported once, before there are two processes and their workers
            import scipy.optimize  # noqa: F401

            import serpenoid.measure.consistency.claims  # noqa: F401

            reader.begin()
        return _judged(args, campaign, reader.ask(_files, campaign))


def _judged(args: argparse.Namespace, campaign: str, files: Callable[[], Read]) -> int:
    from serpenoid.diagnose.reference import reference_of, summary
    from serpenoid.diagnose.report.summary import lines
    from serpenoid.diagnose.report.write import write
    from serpenoid.diagnose.start import check_reference
    from serpenoid.measure.campaign import load_campaign_file
    from serpenoid.measure.consistency.claims import read_believed
    from serpenoid.measure.trial_files import unchanged
    from serpenoid.parallel import Beside

    wanted = [*([args.reference] if args.reference is not None else []), campaign]
    known = [load_campaign_file(c)[0] for c in wanted]
    sizes = [len(file.trial) for file in known]
    if args.reference is not None:
        check_reference(args.reference, known[0], campaign, known[-1])
    model = content_of(*([Path(args.model)] if args.model else []))
    reference = content_of_campaign(args.reference) if args.reference is not None else None
    folder = campaigns.folder(args, campaign, "diagnosis", reference, model, sorted(args.without))
    kind = "animal" if known[-1].tracked_only else "robot"
    work = Work(kind, sizes, not args.no_figures)
    with options.progress_bar(args, "diagnosing", 1.0, work.left) as advance, Beside(prepare) as artist:
        work.tell = advance
        pictures = Pictures(folder, None if args.no_figures else artist)
        listener = _listener(args, work, artist)
        earlier, before = None, None
        if args.reference is not None:
            file, then = _diagnosed(args, args.reference, None, listener, read_believed, apart=False)
            work.campaign_done()
            earlier, before = reference_of(then), summary(then) | {"campaign": file.name}

        def read_already(file: CampaignFile, place: Path) -> Believed:
            then, believed = files()
            return unchanged(file, place, then, believed)

        def searched(found: Selection) -> None:
            sign(args)
            pictures.of_motion(found)

        listener = replace(listener, searched=searched, climbed=pictures.of_shapes)
        file, found = _diagnosed(args, campaign, earlier, listener, read_already)
        work.campaign_done()
        pictures.of_rest(found)
        record = write(folder, file, found, before)
        if not args.no_figures:
            work.draw()
        pictures.in_report(found, record)
        pictures.of_changed(found, record)
        work.finish()
    options.report(args, record, [*lines(record), f"written to {folder}"], folder)
    return 0


def _listener(args: argparse.Namespace, work: Work, artist: Beside) -> Listener:
    """What is shown while a campaign is diagnosed."""
    from serpenoid.diagnose.campaign import Listener

    def notice(text: str) -> None:
        if not args.quiet:
            options.complain(text)

    def begin(stage: str) -> None:
        if not args.no_figures and stage != SERVOS:
            artist.begin()  # not before: reading, and judging servos, keep all cores busy
        work.begin(stage)

    return Listener(lambda done, _, name: work.read(done, name), begin, notice)


def _diagnosed(
    args: argparse.Namespace,
    campaign: str,
    earlier: Baseline | None,
    listener: Listener,
    files: Reader,
    apart: bool = True,
) -> tuple[CampaignFile, Diagnosis]:
    from serpenoid.diagnose.campaign import diagnose_campaign
    from serpenoid.effects.catalogue import find

    without = frozenset(find(name).name for name in args.without)
    return diagnose_campaign(campaign, args.model, earlier, without, files, listener, apart)


def _files(campaign: str) -> Read:
    """What the files were when they were read, and what was read and checked."""
    from serpenoid.measure.campaign import load_campaign_file
    from serpenoid.measure.consistency.claims import read_believed
    from serpenoid.measure.trial_files import content

    read = load_campaign_file(campaign)
    return content(*read), read_believed(*read)
