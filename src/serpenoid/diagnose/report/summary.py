"""The summary on the screen: what a diagnosis says, line by line."""

from __future__ import annotations

from serpenoid.body import WHOLE_LINKS
from serpenoid.diagnose.report.sentences import (
    already_in_short,
    chance,
    drag_ratio,
    inadequacy,
    left_open,
    meaning,
    no_experiment,
    ratio,
    ratio_change,
    reference,
    rival_law,
    rows,
    seconds,
    stage_line,
    undetected,
    unreliable,
    untestable,
    within_chance,
)
from serpenoid.diagnose.report.words import (
    STAND_IN,
    Record,
    alternative,
    in_sample,
    own_place,
    parameter,
    shown,
    times,
    title,
    unseen,
)

LINKS = (
    f"{WHOLE_LINKS}: what is left may be that it does not resist its own turning (how much, and how to cut links: "
    "`remarks` in diagnosis.json)"
)


def lines(record: Record) -> list[str]:
    """The summary on the screen."""
    found = [f"first             {text}" for text in inadequacy(record)]
    verdict = "nothing found" if record["verdict"] == "nothing" else record["verdict"]
    found.append(f"verdict           {verdict}: {meaning(record)}")
    found += [f"since then        {text}" for text in ratio_change(record)]
    found += [f"law               {text}" for text in rival_law(record)]
    for e in record["effects"]:
        found.append(f"  {title(e)} ({times(e['strength_over_noise'])}){STAND_IN if e['stand_in'] else ''}")
        found += [f"    {'where':16}  {where}"] if (where := own_place(e, record)) else []
        found += [f"    {name:16}  {parameter(p)}" for name, p in e["parameters"].items()]
    found += [f"  or {alternative(e)} ({times(e['separation_over_noise'])} apart)" for e in record["alternatives"]]
    found += [f"  {text}" for text in undetected(record)]
    found += [f"reference         {text}" for text in [*reference(record), *already_in_short(record)]]
    found += [stage_line(s) + within_chance(s, record) for s in record["ladder"]]
    if record["drag_ratio"] is None:  # of an animal nobody expects servos
        found += [f"skipped           {stage}: {why}" for stage, why in record["skipped"].items()]
    found += [f"chance            {text}" for text in chance(record)]
    found += [f"not tested        {text}" for text in untestable(record)]
    found.append(f"seconds           {seconds(record)}")
    found += [f"rows              {text}" for text in rows(record)]
    found += [f"note              {LINKS if text.startswith(WHOLE_LINKS) else text}" for text in record["remarks"]]
    rms = record["gain"]["path_rms_m"]
    before, after = (shown(rms[side], record["length_unit"]) for side in ("before", "after"))
    if in_sample(record):
        found.append(f"in sample         path RMS {before} -> {after}: of one trial nothing can be held out")
    else:
        held = f"held-out {unseen(record):9}"
        found.append(f"{held}path RMS {before} -> {after}{left_open(record)}")
        found += [f"{held}{text}" for text in unreliable(record)]
    found.append(f"anisotropy ratio  {ratio(record)}")
    found += [f"K = 1 / eps       {drag_ratio(record)}"] if record["drag_ratio"] else []
    if record["next_experiment"]:
        e = record["next_experiment"]
        pose = e["start_pose"]
        start = f"from x {pose['x_m']:.2f} m, y {pose['y_m']:.2f} m, heading {pose['heading_rad']:.2f} rad"
        found.append(f"next experiment   {e['joint_table']}, {e['cycle_duration_s']:.2f} s per cycle, {start}")
    elif record["drag_ratio"] is None:
        found.append(f"next experiment   {no_experiment(record)}")
    return found + [f"left              {text}" for text in record["residual_pattern"]]
