"""The paper's whole protocol in the arena: 24 gaits, three trials each, compared, beside the printed numbers.

    serpenoid reproduce                        # about ten minutes on two cores; needs the extra `arena`
    serpenoid reproduce --gaits 2 --trials 1   # a small one, to see that it works

Finds the gaits (twelve random, the same improved within +-30 %), plays them in the virtual arena, lays Exp, Sim and
Resim over each other, and writes tables, heat maps and a report. After an interruption the same command goes on.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

from serpenoid.cli import options
from serpenoid.cli.claim import sign


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `reproduce`."""
    parser.add_argument("--problem", type=Path, metavar="PROBLEM", help="robot and medium (default: the paper's snake)")
    options.add_set(parser)
    parser.add_argument("--gaits", type=int, default=12, metavar="N", help="random gaits, each also improved (12)")
    parser.add_argument("--trials", type=int, default=3, metavar="N", help="trials of each gait (3)")
    parser.add_argument("--seed", type=int, default=0, help="of gaits and trials (0)")
    options.add_workers(parser, "trials", os.cpu_count() or 1)
    options.add_output(parser, "results/reproduce")


def run(args: argparse.Namespace) -> int:
    """Find, play, compare, write."""
    from serpenoid.arena import mujoco_module
    from serpenoid.arena.campaign import run_campaign
    from serpenoid.compare.plain import refuse_effects
    from serpenoid.compare.study import compare_campaign
    from serpenoid.errors import InputError
    from serpenoid.files.writing import examples
    from serpenoid.measure.load import load_campaign
    from serpenoid.problem import load
    from serpenoid.studies.reproduce import gait_tables, paper_protocol

    if min(args.gaits, args.trials) < 1:
        raise InputError("--gaits and --trials need a positive number.")
    problem = load(args.problem or examples() / "snake10.toml", args.set)
    refuse_effects(problem.model)
    mujoco_module()  # or the gaits would be found first
    folder = options.output_folder(args, Path("results/reproduce"), problem.hash, args.gaits, args.trials, args.seed)
    sign(args)
    with options.progress_bar(args, "gaits", args.gaits) as advance:
        tables = gait_tables(folder / "gaits", problem, args.gaits, args.seed, advance)
        advance(args.gaits)
    protocol = paper_protocol(problem, list(tables), args.trials, args.seed)
    total = 2 * args.gaits * args.trials
    with options.progress_bar(args, "trials", total) as advance:
        run_campaign(protocol, tables, folder / "campaign", workers=options.workers(args), report=advance)
    with options.progress_bar(args, "reading", total) as advance:
        campaign = load_campaign(folder / "campaign", lambda done, _, name: advance(done, name), options.workers(args))
        advance(total)
    with options.progress_bar(args, "comparing", total) as advance:
        study = compare_campaign(campaign, problem.model, lambda done, _total, name: advance(done, name))
        advance(total)
    return _write(args, folder, study, campaign)


def _write(args: argparse.Namespace, folder: Path, study: Any, campaign: Any) -> int:
    from serpenoid.cli.compare import lines
    from serpenoid.compare.write import study_record, write_study
    from serpenoid.studies.reproduce import beside_the_paper, write_beside

    record = study_record(study, campaign, "as stated")
    with options.progress_bar(args, "drawing", 1) as advance:
        write_study(folder, study, campaign, record, not args.no_figures, lambda _done, name: advance(0, name))
        advance(1)
    rows = beside_the_paper(study.ratios)
    write_beside(folder, rows)
    table = [
        f"{r['pair']:<10} mean {r['mean']:.4f} ({r['paper_mean']:.4f})  SD {r['std']:.4f} ({r['paper_std']:.4f})  "
        f"s {r['s']:.4f} ({r['paper_s']:.4f})"
        for r in rows
    ]
    summary = [*lines(study, "the paper's"), "", "beside the paper (its numbers in brackets):", *table]
    options.report(args, {"beside_the_paper": rows, **record}, [*summary, f"written to        {folder}"], folder)
    return 0
