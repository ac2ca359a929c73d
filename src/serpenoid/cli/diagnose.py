"""Find out what the simulation gets wrong, and why: name the cause, extend the model, measure the gain.

    serpenoid diagnose recordings/2024-09-foam --model problems/snake10.toml --out results/foam
    serpenoid solve problems/snake10.toml --model results/foam/extended-model.toml
    serpenoid diagnose recordings/today --reference recordings/2024-09-foam    # what changed since then?

In three stages: command against shape (actuation: servos), shape against markers (observation: cameras, clocks),
shape against motion (medium: wheels and floor). In each, the error stands beside its noise level, which repeated trials
tell: record every setting twice. Effects (see `serpenoid effects`) are chosen by how well they predict gaits they were
not fitted to, so record six gaits or more, two of them tail first, at several cycle durations and headings.

verdict           nothing left      something left
  effects named   explained         partly explained
  none named      nothing           unexplained

The answer: verdict; causes with strength, value, interval and what to do; how well held-out gaits are predicted; what
is left; the next experiment; then details. Of long lists the first are printed, diagnosis.json has all.
An effect's strength is its trace over the noise level. Where noise makes as much, or the value's interval holds what
changes nothing, it is below detection: not named.
`or instead` are effects that the data cannot tell from the one above; `next-experiment.csv` is the gait that would.
The extended model holds what is named. If anything is named on any stage, it also holds unnamed effects (below
detection, or the first one refused) where gaits that were not fitted are predicted better with them.

With a reference, that campaign is diagnosed first; what the model gets wrong there is no news.
If something acts in some of the trials alone (a screw that came loose on the way), these are diagnosed by themselves,
too: their answer follows, and is in changed-trials/. List trials in the order in which they were played.

Writes report.html (begin there; it needs no other file), diagnosis.json, baseline-model.toml and extended-model.toml,
figures as PNG and SVG.
Exit code 0 whatever the verdict, 2 where the campaign or the model cannot be read; of several campaigns 1 where one
of them could not be diagnosed.
"""

from __future__ import annotations

import argparse
import os

from serpenoid.cli import campaigns, options


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `diagnose`."""
    parser.set_defaults(kept_if_stopped=campaigns.KEPT)
    help_line = "folder with campaign.toml, or the file itself; of several, a table of all answers"
    parser.add_argument("campaign", nargs="+", metavar="CAMPAIGN", help=help_line)
    parser.add_argument(
        "--model",
        metavar="FILE",
        help="problem or model file: baseline medium (default: the campaign's) and effects that are known, "
        "of servos, cameras and medium: they are no news (an earlier extended-model.toml); eps is calibrated",
    )
    parser.add_argument("--reference", metavar="CAMPAIGN", help="an earlier one of the robot: what changed since then?")
    parser.add_argument(
        "--without",
        metavar="EFFECT",
        action="append",
        default=[],
        help="leave an effect out of the catalogue, as often as you like: what would be named in its place?",
    )
    pieces = "of one campaign: pieces of its work; of several: campaigns"
    options.add_workers(parser, pieces, os.cpu_count() or 1, tasks="campaigns, each one task,")
    options.add_output(parser, "results/<campaign>/diagnosis-<hash>; of several: results/diagnoses-<hash>")


def run(args: argparse.Namespace) -> int:
    """Diagnose, write, report."""
    if len(args.campaign) > 1 or args.cluster is not None:
        from serpenoid.cli.diagnose_many import run_many

        return run_many(args)
    from serpenoid.cli.diagnose_one import run_one
    from serpenoid.parallel import limited

    with limited(args.jobs):
        return run_one(args, args.campaign[0])
