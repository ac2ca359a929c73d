"""Read a campaign of recordings and say what is in it, what is missing, and how good it is.

    serpenoid measure recordings/2024-09-foam
    serpenoid measure problems/campaigns/lamprey.toml --json

A campaign is a folder with campaign.toml and, per trial, a motion file (in a format that is listed below), a servo
log and a power log; any of them may be missing (docs/campaign-format.md). A broken file is named with row and column,
and nothing is half-read. Writes campaign.json, of an animal its mean beat as a problem file, and a picture of every
trial: markers on the floor, what was hidden when, commanded against measured joint angles. Position jumps are reported,
not smoothed away.
"""

from __future__ import annotations

import argparse
from collections.abc import Container, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from serpenoid.cli import campaigns, options
from serpenoid.cli.claim import sign
from serpenoid.wording import counted

if TYPE_CHECKING:
    from serpenoid.measure.trial import Motion, Trial

MOST_TOLD = 10  # gaps and jumps of a trial


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `measure`."""
    parser.epilog = campaigns.formats_line()
    campaigns.add_campaign(parser)
    options.add_output(parser, "results/<campaign>/measure-<hash>")


def run(args: argparse.Namespace) -> int:
    """Read, write, report."""
    from serpenoid.compare.records import campaign_record
    from serpenoid.files.writing import provenance, write_json
    from serpenoid.measure.animals.mean_beat import write_beat

    campaign = campaigns.read(args)
    folder = campaigns.folder(args, args.campaign, "measure")
    record = campaign_record(campaign) | {"provenance": provenance(campaign=campaign.file.name)}
    sign(args)
    write_json(folder / "campaign.json", record)
    if not args.no_figures:
        from serpenoid.plot.figures import save
        from serpenoid.plot.recording import repeats, trial_figure
        from serpenoid.plot.style import figure

        with options.progress_bar(args, "drawing", len(campaign.trials)) as advance:
            for done, trial in enumerate(campaign.trials):
                advance(done, trial.name)
                if trial.motion is not None:
                    save(trial_figure(trial), folder, f"trial-{trial.name}")
            for label, trials in campaign.gaits.items():
                if len(trials) > 1:
                    fig = figure(7.0, 2.8)
                    repeats(trials, fig.add_subplot())
                    save(fig, folder, f"repeats-{label}")
            advance(len(campaign.trials))
    lines = [f"{campaign.file.name}: {counted(len(campaign.trials), 'trial')}, {campaign.body.vertices} vertices"]
    if campaign.lengths_estimated:
        how = "means less what noise adds" if campaign.body.is_animal else "medians"
        lines.append(f"edge lengths estimated from the recordings ({how})")
    shared = shared_notes(campaign.trials)
    lines += [f"note              {who}: {note}" for note, who in shared.items()]
    for trial in campaign.trials:
        played = write_beat(folder, trial, campaign.file.medium)
        lines += [*trial_lines(trial, shared), *([] if played is None else [played])]
    lines += made_up(args.campaign)
    options.report(args, record, [*lines, f"written to        {folder}"], folder)
    return 0


def made_up(campaign: str | Path) -> list[str]:
    """A line where the campaign still holds the trial that `new campaign` made up."""
    from serpenoid.files.inputs import read_text
    from serpenoid.scaffold.campaign import BEGIN, EXAMPLE

    file = Path(campaign)
    if BEGIN not in read_text(file / "campaign.toml" if file.is_dir() else file):
        return []
    return [
        f"warning           trial `{EXAMPLE}` is made up; `serpenoid campaign add` takes it out with the first trial"
    ]


def shared_notes(trials: Sequence[Trial]) -> dict[str, str]:
    """What is noted of several trials, each with their names: said once, before all of them."""
    from serpenoid.measure.usage import trials_of
    from serpenoid.wording import some_trials

    every = [trial.name for trial in trials]
    of = trials_of((trial.name, trial.notes) for trial in trials)
    return {note: some_trials(who, every) for note, who in of.items() if len(who) > 1}


def trial_lines(trial: Trial, said: Container[str] = ()) -> list[str]:
    """One trial in a few lines, without notes that were said of several trials."""
    kinds = {
        "motion": trial.motion,
        "table": trial.schedule,
        "servo log": trial.servo_log,
        "power log": trial.power_log,
    }
    there = [name for name, value in kinds.items() if value is not None]
    missing = [name for name, value in kinds.items() if value is None]
    lines = [f"\n{trial.name}", f"  has               {', '.join(there) or 'nothing'}"]
    if missing:
        lines.append(f"  missing           {', '.join(missing)}")
    motion = trial.motion
    if motion is not None:
        length = motion.time_s[-1] - motion.time_s[0]
        lines.append(f"  frames            {len(motion.time_s)} in {length:.2f} s, {motion.hidden_said}")
        lines.append(f"  body              {_body_words(trial, motion)}")
        lines += _beat_lines(trial, motion)
        unit = metric(trial.metres * motion.marker_sd) if trial.metres else f"{motion.marker_sd:.5f} body lengths"
        misfit = "of points about a body of constant length" if trial.body.is_animal else "misfit of the rigid links"
        lines.append(f"  marker noise      {unit} ({misfit})")
        lines.append(f"  seconds           {_seconds_words(trial, motion)}")
        for p in trial.passages:
            what = "displacement" if trial.schedule is None else f"cycle {p.cycle + 1}"
            lines.append(f"  {what:18}{trial.displacement(p):.4f} body lengths")
        long = [gap for gap in motion.gaps if not gap.short]
        lines += [f"  long gap          {gap.duration_s:.2f} s from frame {gap.first + 1}" for gap in long[:MOST_TOLD]]
        if len(long) > MOST_TOLD:
            most = max(gap.duration_s for gap in long)
            lines.append(f"  long gap          and {len(long) - MOST_TOLD} more, {most:.2f} s at most (campaign.json)")
        for jump in motion.jumps[:MOST_TOLD]:
            who = "whole body" if jump.vertex is None else f"vertex {jump.vertex}"
            lines.append(f"  jump              {who} by {jump.size:.4f} body lengths at {jump.time_s:.3f} s")
        if len(motion.jumps) > MOST_TOLD:
            lines.append(f"  jump              and {len(motion.jumps) - MOST_TOLD} more (campaign.json)")
        if motion.relabelled:
            lines.append(f"  relabelled        {len(motion.relabelled)} unlabelled fragment(s) by the chain's geometry")
        if motion.unused:
            lines.append(f"  not used          {', '.join(motion.unused[:6])}")
    if trial.servo is not None:
        servo = trial.servo
        lines.append(f"  servo clock       {servo.offset.offset_s:+.4f} s (correlation {servo.offset.correlation:.4f})")
        lines.append(f"  servo scatter     {servo.sd:.5f} rad about the markers' angles")
    return lines + [f"  note              {note}" for note in trial.notes if note not in said]


def _beat_lines(trial: Trial, motion: Motion) -> list[str]:
    """How an animal bends: what a table commands needs no telling."""
    import numpy as np

    from serpenoid.measure.animals.animal import way_of_bends

    found = motion.beat if trial.schedule is None else None
    if found is None:
        return []
    bent = ", ".join(f"{angle:.0f}" for angle in np.degrees(found.amplitude_rad))
    run = (
        f"{abs(found.waves):.3g} waves on the body {way_of_bends(motion)}".rstrip()
        if found.runs
        else "bends that stand"
    )
    return [
        f"  gait              {1 / found.period_s:.4g} Hz, {run}",
        f"  bending           joints 1 to {len(found.amplitude_rad)}: amplitudes {bent} degrees",
    ]


def _promised(trial: Trial) -> str:
    """What the campaign says of the period, where there are pauses."""
    schedule = trial.schedule
    if schedule is None or not schedule.pause_s:
        return ""
    return f" (cycle and pause: {schedule.cycle_duration_s:g} + {schedule.pause_s:g} s)"


def metric(metres: float) -> str:
    """A length in the unit that people would use of it."""
    unit, size = next(((u, s) for u, s in (("m", 1.0), ("mm", 1e-3)) if metres >= 0.01 * s), ("um", 1e-6))
    return f"{metres / size:.4g} {unit}"


def _seconds_words(trial: Trial, motion: Motion) -> str:
    """Used, dropped, and what belongs to no cycle."""
    from serpenoid.measure.usage import usage

    used = usage(trial)
    rest = float(motion.time_s[-1] - motion.time_s[0]) - used.promised_s
    return f"{used}, {rest:.4g} s outside the cycles" if rest >= 0.01 else str(used)


def _body_words(trial: Trial, motion: Motion) -> str:
    """Length and period: where units of length or time are wrong, these two numbers show it."""
    length = f"{metric(trial.metres)} long" if trial.metres else "of unknown length (pixels)"
    return f"{length}; its bending repeats {_period_words(trial, motion)}"


def _period_words(trial: Trial, motion: Motion) -> str:
    """What plays a table repeats it exactly; an animal's beats are as they come."""
    from serpenoid.measure.consistency.signals import Signal

    if trial.schedule is None:
        found = motion.beat
        return f"every {found.period_s:.4g} s (single beats: SD {found.spread_s:.2g} s)" if found else "at no period"
    period = Signal(motion.time_s, motion.joint_angles).repeats_s
    return (f"every {period:.4g} s" if period else "at no period") + _promised(trial)
