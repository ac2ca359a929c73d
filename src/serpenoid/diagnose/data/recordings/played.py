"""How fast what was commanded ran on the readings' clock: a film's nominal frame rate or a player's loop may be wrong.

By how much later than promised cycle n is read grows with n, whatever servos do alike in every cycle:

    late_n = late_0 + rate n period

One rate for all trials, a beginning for each; the scatter of what is left says how well it is known. Labels and
commands of a log say when rows were due: such trials have no rate of their own, but commands that keep to the log's
clock make a cycle as long as that clock says, on the film.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import ndtri, stdtrit

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import ERROR
from serpenoid.diagnose.data.recordings.clocks import Clock, pooled
from serpenoid.diagnose.data.recordings.recording import UNSURE_CYCLE, Recording
from serpenoid.diagnose.data.shapes.course import Course
from serpenoid.diagnose.data.shapes.smooth import scatter
from serpenoid.measure.remark import Remark

ROUNDS = 4  # each is as much nearer as a cycle's end is off by its rate


def at_played_rate(recordings: Sequence[Recording]) -> tuple[Recording, ...]:
    """Schedules as they ran on the readings' clock, where that is told from the promise beyond chance and noise."""
    found, told = list(recordings), 0.0
    for _ in range(ROUNDS):
        lates = {i: late for i, r in enumerate(found) if not r.start_said and (late := lateness(r)) is not None}
        rate = _rate([(late, found[i].schedule.period_s) for i, late in lates.items()])
        if not rate or not (told or any(_seen(found[i], rate) for i in lates)):
            break
        told = (1 + told) * (1 + rate) - 1
        for i, late in lates.items():
            found[i] = _replayed(found[i], rate, late)
    if not told:
        return tuple(recordings)
    lasting = sorted({r.schedule.cycle_duration_s for r, now in zip(recordings, found, strict=True) if now is not r})
    return tuple(
        now if now is r else replace(now, remarks=(*r.remarks, Remark(_words(r, told, lasting))))
        for r, now in zip(recordings, found, strict=True)
    )


def by_their_commands(recordings: Sequence[Recording]) -> tuple[Recording, ...]:
    """Schedules as the log's clock has them on the film, where commands follow it and nowhere the film's alone. One
    clock gives all commands: trials whose own do not say when rows were due follow those that do."""
    told = [r for r in recordings if r.told is not None and r.clock.rate_sd > 0]
    if not told or not all(r.told is not None and r.told.by_log for r in told):
        return tuple(recordings)
    rate = 1 / (1 + pooled([r.clock for r in told])[0]) - 1
    lasting = sorted({r.schedule.cycle_duration_s for r in recordings if r.clock.rate_sd > 0})
    seen = _beyond_chance([r.clock for r in told])
    seen = seen and _beyond_chance([r.clock.told_apart for r in told])
    seen = seen and any(_seen(r, rate) for r in told)

    def on_film(r: Recording) -> Recording:
        words = (Remark(_words(r, rate, lasting)),) if seen else ()
        return replace(_at_rate(r, rate), remarks=(*r.remarks, *words))

    follow = [r.clock.rate_sd > 0 and (r.told is not None or (seen and r.commands is not None)) for r in recordings]
    return tuple(on_film(r) if own else r for r, own in zip(recordings, follow, strict=True))


def _beyond_chance(clocks: Sequence[Clock]) -> bool:
    """Whether the rate of all is more than chance makes, at the stated error."""
    rate, sd = pooled(clocks)
    return bool(abs(rate) > -ndtri(ERROR / 2) * sd)


def lateness(r: Recording) -> Floats | None:
    """By how much later than promised (n,) [s] each cycle is read, NaN where it is not whole; None: no two are."""
    s, time = r.schedule, r.read_at
    mesh = np.arange(0.0, s.cycles * s.period_s, s.cycle_duration_s / (4 * len(s.table)))
    course, found = Course(mesh, s.commanded(mesh)), np.full(s.cycles, np.nan)
    for cycle in range(s.cycles):
        begin, end = cycle * s.period_s, cycle * s.period_s + s.cycle_duration_s
        rows = (time >= begin) & (time <= end)
        if time[-1] >= end and np.isfinite(r.position[rows]).any():
            found[cycle] = course.late(time[rows], r.position[rows], UNSURE_CYCLE * s.cycle_duration_s)
    return np.asarray(found, float) if np.isfinite(found).sum() > 1 else None


def _rate(lates: Sequence[tuple[Floats, float]]) -> float:
    """Of all trials; 0 where chance makes as much, at the stated error."""
    begun = [np.where(np.isfinite(late), np.arange(len(late)) * period, np.nan) for late, period in lates]
    if not begun:
        return 0.0
    x = np.concatenate([b - np.nanmean(b) for b in begun])
    y = np.concatenate([late - np.nanmean(late) for late, _ in lates])
    known = np.isfinite(x)
    x, y, freedom = x[known], y[known], int(known.sum()) - len(lates) - 1
    if freedom < 1:
        return 0.0
    rate = float(x @ y / (x @ x))
    sd = float(np.sqrt(((y - rate * x) ** 2).sum() / freedom / (x @ x)))
    return rate if abs(rate) > stdtrit(freedom, 1 - ERROR / 2) * sd else 0.0


def _seen(r: Recording, rate: float) -> bool:
    """Whether what a rate does to the readings, its trial's beginning free, is as large as their noise at any joint."""
    time = r.read_at
    inside = (time > 0) & (time < r.schedule.cycles * r.schedule.period_s)
    told = r.schedule.commanded(time[inside])
    away = time[inside] - time[inside].mean()
    moved = rate * away[:, None] * np.gradient(told, time[inside], axis=0)
    with np.errstate(invalid="ignore"):
        return bool((np.sqrt((moved**2).mean(axis=0)) > scatter(r.position[inside] - told, r.by_servos)).any())


def _replayed(r: Recording, rate: float, late: Floats) -> Recording:
    """The schedule at its rate, t0 where its cycles are read to begin; how late each is, is that of its middle."""
    s = r.schedule
    middles = np.arange(len(late)) * s.period_s + s.cycle_duration_s / 2
    late_s = float(np.nanmean(late - rate * middles))
    unsure = max(r.t0_spread, UNSURE_CYCLE * s.cycle_duration_s * (1 + rate))  # as unsure as before
    return replace(_at_rate(r, rate).later(late_s), t0_spread=unsure)


def _at_rate(r: Recording, rate: float) -> Recording:
    """The recording with a schedule that ran so much slower, and what had been asked."""
    s = r.schedule
    slower = replace(s, cycle_duration_s=s.cycle_duration_s * (1 + rate), pause_s=s.pause_s * (1 + rate))
    return replace(r, schedule=slower, asked_cycle_s=r.asked_cycle_s or s.cycle_duration_s)


def _words(r: Recording, rate: float, lasting: Sequence[float]) -> str:
    """One clock, one sentence, whatever cycles last [s] in the trials it is said of."""
    which = "more" if rate < 0 else "fewer"
    digits = max(4, 2 - int(np.floor(np.log10(abs(rate)))))  # as many as tell them apart
    on_film, promised = (", ".join(f"{f * duration:.{digits}g}" for duration in lasting) for f in (1 + rate, 1.0))
    each = ", in this order" if len(lasting) > 1 else ""
    said = f"a cycle lasts {on_film} s on the film's clock, and `cycle_duration_s` says {promised}{each}: "
    on_log = (1 + rate) * (1 + r.clock.rate) - 1
    if r.by_servos and abs(on_log) < abs(rate) / 2:
        said += "on the servo log's clock it lasts as long as promised, so the film's is wrong; check its"
    else:
        said += "the film's clock or the player's is wrong; check the"
    return (
        f"{said} frame rate (a film with {100 * abs(rate):.2g} % {which} seconds would agree). Cycles are taken as "
        "they were filmed; speeds and times are those of the film"
    )
