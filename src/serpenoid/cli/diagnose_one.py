"""One campaign diagnosed: read, judged, written, drawn, and said."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from serpenoid.cli import campaigns, options
from serpenoid.cli.claim import content_of, content_of_campaign, sign
from serpenoid.cli.work import Work

if TYPE_CHECKING:
    from serpenoid.body import Body, Floats
    from serpenoid.diagnose.diagnose import Diagnosis
    from serpenoid.diagnose.stages.baseline import Baseline
    from serpenoid.measure.campaign import CampaignFile
    from serpenoid.measure.trial_files import Files, Reader
    from serpenoid.parallel import Beside


def run_one(args: argparse.Namespace, campaign: str) -> int:
    """Diagnose, write, report; the campaign's files are read while what judges them is imported."""
    from serpenoid.measure.campaign import load_campaign_file
    from serpenoid.parallel import Beside

    with Beside(lambda: None) as reader:
        if not load_campaign_file(campaign)[0].tracked_only:
            reader.begin()
        return _judged(args, campaign, reader.ask(_files, campaign))


def _judged(args: argparse.Namespace, campaign: str, files: Callable[[], tuple[Body, tuple[Files, ...]]]) -> int:
    from serpenoid.diagnose.reference import reference_of, summary
    from serpenoid.diagnose.report.words import lines
    from serpenoid.diagnose.report.write import write
    from serpenoid.measure.campaign import load_campaign_file
    from serpenoid.measure.trial_files import read_files
    from serpenoid.parallel import Beside

    wanted = [*([args.reference] if args.reference else []), campaign]
    sizes = [len(load_campaign_file(c)[0].trial) for c in wanted]
    default = Path("results") / campaigns.name_of(campaign) / "diagnosis"
    key = [content_of_campaign(c) for c in wanted], content_of(*([Path(args.model)] if args.model else []))
    folder = options.output_folder(args, default, *key, sorted(args.without))
    kind = "animal" if load_campaign_file(campaign)[0].tracked_only else "robot"
    work = Work(kind, sizes, not args.no_figures)
    with options.progress_bar(args, "diagnosing", 1.0, work.left) as advance, Beside(_drawing) as artist:
        work.tell = advance
        earlier, before = None, None
        if args.reference:
            file, then = _diagnosed(args, args.reference, None, work, artist, read_files)
            earlier, before = reference_of(then), summary(then) | {"campaign": file.name}
        file, found = _diagnosed(args, campaign, earlier, work, artist, lambda file, folder: files())
        sign(args)
        record = write(folder, file, found, before)
        if not args.no_figures:
            work.draw()
            _pictures(folder, found, record, artist)
        work.finish()
    options.report(args, record, [*lines(record), f"written to {folder}"], folder)
    return 0


def _diagnosed(
    args: argparse.Namespace, campaign: str, earlier: Baseline | None, work: Work, artist: Beside, files: Reader
) -> tuple[CampaignFile, Diagnosis]:
    from serpenoid.diagnose.campaign import diagnose_campaign
    from serpenoid.effects.catalogue import find

    def notice(text: str) -> None:
        if not args.quiet:
            options.complain(text)

    def begin(stage: str) -> None:
        if not args.no_figures:
            artist.begin()  # not before: reading keeps all cores busy, judging does not
        work.begin(stage)

    without = frozenset(find(name).name for name in args.without)
    found = diagnose_campaign(
        campaign, args.model, earlier, without, lambda done, _, name: work.read(done, name), begin, notice, files
    )
    work.campaign_done()
    return found


def _files(campaign: str) -> tuple[Body, tuple[Files, ...]]:
    from serpenoid.measure.campaign import load_campaign_file
    from serpenoid.measure.trial_files import read_files

    return read_files(*load_campaign_file(campaign))


def _drawing() -> None:
    """What drawing needs takes as long to import as a stage takes to judge."""
    import serpenoid.plot.diagnosis  # noqa: F401


def _draw(folder: Path, found: Diagnosis, table: Floats | None) -> None:
    from serpenoid.plot.diagnosis import draw_all

    draw_all(folder, found, table)


def _pictures(folder: Path, found: Diagnosis, record: dict[str, Any], artist: Beside) -> None:
    from serpenoid.table_file import read_table

    proposed = record["next_experiment"]
    drawn = artist.ask(_draw, folder, found, read_table(folder / proposed["joint_table"]) if proposed else None)
    from serpenoid.diagnose.report.animate import animated
    from serpenoid.diagnose.report.pages import write_pages

    trials = animated(found)
    drawn()
    write_pages(folder, record, trials)
