"""What a contract may say instead: every single fault that people make, with the words that cure it.

A fault is one thing wrong: another table, a table played backwards or from another row, joints in another order, signs
flipped, another duration of cycle or pause, another rate of the recording. `diagnose` may add its own (`Fault` with any
schedule) and have them scored beside these.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.match import (
    Course,
    Match,
    Prior,
    commanded_at,
    course_of,
    explained_by,
    match_columns,
)
from serpenoid.measure.consistency.signals import Sampled
from serpenoid.measure.formats.columns import RADIANS, AngleUnit
from serpenoid.measure.logs import TICK
from serpenoid.measure.schedule import Schedule
from serpenoid.wording import counted

OWN = "name the trial's own file in `{}`"
BOTH, TABLE_AND_LOG = "table and log", "`joint_table` and the servo log"  # as one source
SAME_TABLE = 1e-6  # rad: tables written with six decimals
STOPS = 5  # moments about the one that is seen, a twelfth of a cycle apart: servos take time to come to rest
ROLLS = 12  # starting rows that are tried, a twelfth of a cycle apart; one twelfth is not told from play in the joints
UNITS = {"milliseconds": 1e3, "microseconds": 1e6, "nanoseconds": 1e9}
ANGLE_WORDS = {"rad": "radians", "deg": "degrees", "ticks": "ticks of a servo"}
FARTHEST = 100.0  # times as long or as short as the schedule: no frame rate, only a unit or other times make so much
NEAR = 0.05  # a schedule nearer than the clocks that `match` tries is no other hypothesis
ROUGHLY = 0.25  # the same where nothing but a unit makes so much: an only cycle's length is known by where it ends
MOTION_ALONE = "are its times in seconds (`time_unit`), and those of this motion alone (`from_s`, `to_s`)?"
IN_ONE = {True: ", in one film", False: ", in one trial"}  # what is wrong everywhere may be so in a single one
KINDS = 9  # of faults, alike in prior odds


@dataclass(frozen=True)
class Fault:
    """One thing that the contract may have wrong. `everywhere`: it would be so in every trial (wiring, markers).

    log_share: log prior probability among all faults. cures: where it depends on which source is wrong (the joint
    "table", the servo "log", the "markers"), in the place of `cure`.
    """

    kind: str
    words: str
    cure: str
    course: Course
    log_share: float
    everywhere: bool = False
    timed: Callable[[float], tuple[str, str] | None] | None = (
        None  # words and cure at a rate found more exactly, if any
    )
    cures: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Wiring:
    """One joint turned round or two exchanged, nothing laid anew: log evidence relative to the contract, and the share
    of the motion's variance that it explains; cures: see `Fault`."""

    words: str
    cure: str
    cures: Mapping[str, str]
    log_share: float
    gain: float
    explained: float


def schedule_faults(
    schedule: Schedule,
    label: str,
    tables: Mapping[str, Floats],
    periods_s: Sequence[float],
    moving_s: float,
    each_s: float,
) -> list[Fault]:
    """All faults of a schedule that need it laid over the signal anew; `periods_s`: what the signal's own may be;
    moving_s: how long the joints move; each_s: from a row of the signal to the next."""
    return [
        *_other_tables(schedule, label, tables), *_backwards(schedule, label), *turned(course_of(schedule), label),
        *_rolled(schedule), *_timed(schedule, periods_s, each_s), *_more_cycles(schedule, moving_s),
    ]  # fmt: skip


def _other_tables(schedule: Schedule, label: str, tables: Mapping[str, Floats]) -> list[Fault]:
    own = schedule.table
    others = {n: t for n, t in tables.items() if t.shape[1] == own.shape[1] and not _same(t, own)}
    share = -np.log(KINDS * max(len(others), 1))
    return [
        Fault("table", f"follow `{name}`, not `{label}`", f"name `{name}` in `joint_table`",
              course_of(replace(schedule, table=table)), share,
              cures={"table": f"name `{name}` in `joint_table`", "log": OWN.format("servo_log"),
                     "markers": OWN.format("motion")})
        for name, table in others.items()
    ]  # fmt: skip


def _more_cycles(schedule: Schedule, moving_s: float) -> list[Fault]:
    """As many cycles as last as long as the joints move, where that is more than promised."""
    shown = round((moving_s + schedule.pause_s) / schedule.period_s)
    if shown <= schedule.cycles:  # fewer: the recording may begin late or end early, or the robot stopped
        return []
    words = f"show {counted(shown, 'cycle')}, and `cycles` says {schedule.cycles}"
    longer = course_of(replace(schedule, cycles=shown))
    return [Fault("cycles", words, f"set `cycles = {shown}`", longer, -float(np.log(KINDS)))]


def _backwards(schedule: Schedule, label: str) -> list[Fault]:
    """From row 0 back, and from the last row, as rows in reverse order are played."""
    words, cure = f"follow `{label}` played backwards", "reverse the rows of `joint_table`"
    back = schedule.table[::-1]
    return [Fault("reversed", words, cure, course_of(replace(schedule, table=table)), -np.log(2 * KINDS))
            for table in (np.roll(back, 1, axis=0), back)]  # fmt: skip


def turned(course: Course, label: str) -> list[Fault]:
    """All signs flipped, joints counted from the other end, head and tail exchanged: alike in every trial."""
    first = "`joint_1` is the joint next to the tail"
    made: list[tuple[str, str, str, str, Callable[[Floats], Floats]]] = [
        ("signs", "all signs flipped", "flip the signs of {}",
         "check `up_axis` and the direction of the joints, or is the film `mirrored`?", lambda angles: -angles),
        ("order", "its joints in reversed order", f"{first}: reverse the columns of {{}}",
         "`markers` run from tail to head: reverse them, and is the film `mirrored`?", lambda angles: angles[:, ::-1]),
        ("ends", "head and tail exchanged", f"{first}: reverse the columns of {{}} and flip their signs",
         "`markers` run from tail to head: reverse them (or set `first_point`)", lambda angles: -angles[:, ::-1]),
    ]  # fmt: skip
    return [
        Fault(kind, f"follow `{label}` with {words}", of_markers, course.changed(change), -np.log(KINDS), True,
              cures=cures_of(columns) | {"markers": of_markers, BOTH: columns.format(TABLE_AND_LOG)})
        for kind, words, columns, of_markers, change in made
    ]  # fmt: skip


def in_one_trial(course: Course, label: str, filmed: bool) -> list[Fault]:
    """The same in one trial, whatever the others show: of its film, or of what was played, where servos tell it."""
    of_film = {
        "signs": "is this film `mirrored`? Set `mirrored = true` in the trial",
        "order": "do `markers` run from head to tail in this film, and is it `mirrored`? Set both in the trial",
        "ends": "do `markers` run from head to tail in this film? Reverse them (or set `first_point`) in the trial",
    }
    played = f"was another gait than `{label}` played in this trial? Name in `joint_table` what was"
    return [
        replace(
            fault, kind=fault.kind + IN_ONE[filmed], cure=of_film[fault.kind] if filmed else played, everywhere=False,
            cures={},
        )
        for fault in turned(course, label)
    ]  # fmt: skip


def stopped(course: Course, label: str, after_s: float, cure: str) -> list[Fault]:
    """What was begun and not brought to its end: still from some seconds after its start on."""
    tries = after_s + course.period_s * (np.arange(STOPS) - STOPS // 2) / ROLLS
    share = -float(np.log(KINDS * STOPS))
    words = f"follow `{label}` for {after_s:.3g} s, and stand still from then on"
    cure = f"did the robot stop (battery, a fuse, a stall)? {cure}"
    return [Fault("stopped", words, cure, course.stopped(float(t)), share) for t in tries if t > 0]


def cures_of(columns: str) -> dict[str, str]:
    """A cure of columns, of the joint table's and of the servo log's."""
    return {"table": columns.format("`joint_table`"), "log": columns.format("the servo log")}


def _timed(schedule: Schedule, periods_s: Sequence[float], each_s: float) -> list[Fault]:
    found = []
    duration, pause = schedule.cycle_duration_s, schedule.pause_s
    made: list[tuple[str, float, float]] = []
    for period in periods_s:
        ratio = period / schedule.period_s
        made.append(("rate", duration * ratio, pause * ratio))
        if period > pause:
            made.append(("duration", period - pause, pause))
        if period > duration and schedule.cycles > 1:  # nothing shows how long the pause after an only cycle is
            made.append(("pause", duration, period - duration))
    for kind, new_duration, new_pause in made:
        timed = replace(schedule, cycle_duration_s=new_duration, pause_s=new_pause)
        said = partial(_time_words, kind, schedule, new_duration, new_pause, each_s)
        at_once = said(1.0)
        if at_once is not None and (kind != "rate" or pause > 0):
            share = -float(np.log(KINDS * len(made)))
            found.append(Fault(kind, *at_once, course_of(timed), share, timed=said))
    return found


def _time_words(
    kind: str, schedule: Schedule, duration: float, pause: float, each_s: float, rate: float
) -> tuple[str, str] | None:
    """None where the schedule so timed is the promised one, but for a clock."""
    duration, pause = rate * duration, rate * pause
    ratios = (duration / schedule.cycle_duration_s, (duration + pause) / schedule.period_s)
    if np.abs(np.log(ratios)).max() < NEAR:
        return None
    says = f"`cycle_duration_s` says {schedule.cycle_duration_s:.3g}"
    cycle, rest = resolved(duration, each_s), resolved(pause, each_s)
    if kind == "duration":
        return f"show a cycle of {cycle} s, and {says}", f"set `cycle_duration_s = {cycle}`"
    if kind == "pause":
        return (
            f"show a pause of {rest} s after every cycle, and `pause_s` says {schedule.pause_s:g}",
            f"set `pause_s = {rest}`",
        )
    factor = duration / schedule.cycle_duration_s
    timed = f"`cycle_duration_s = {cycle}` and `pause_s = {rest}`"
    return (
        f"run {rounded(factor)} times as long as the schedule (a cycle of {cycle} s, and {says})",
        in_other_unit(factor) or f"check the frame rate of the recording, {timed}",
    )


def resolved(seconds: float, each_s: float) -> str:
    """As few digits, of three at most, as are within half a row of a recording whose rows are `each_s` apart."""
    few = (0.0, *(float(f"{seconds:.{digits}g}") for digits in (1, 2)))
    return rounded(next((number for number in few if abs(number - seconds) <= each_s / 2), seconds))


def rounded(number: float) -> str:
    """Three digits, and no power of ten where a reader can count the zeros."""
    if number and not 1e-9 < abs(number) < 1e12:
        return f"{number:.0e}"
    return np.format_float_positional(number, precision=3, fractional=False, trim="-")


def in_other_unit(longer: float, near: float = NEAR) -> str | None:
    """The cure where something lasts a thousand, a million or a billion times as long, or as short, as it should."""
    for unit, many in UNITS.items():
        if abs(np.log(longer / many)) < near:
            return f"are its times {unit}? Set `time_unit`, or give seconds"
        if abs(np.log(longer * many)) < near:
            return f"its times were read as {unit}: are they seconds? Set `time_unit`"
    return None


def other_unit(longer: float) -> tuple[str, str] | None:
    """Words and cure where a motion lasts so many times as long as the schedule that nothing but a unit makes."""
    if not longer > 0 or 1 / FARTHEST < longer < FARTHEST:
        return None
    cure = in_other_unit(longer, ROUGHLY) or MOTION_ALONE
    return f"run {rounded(10.0 ** round(np.log10(longer)))} times as long as the schedule", cure


def other_angles(times: Floats, unit: AngleUnit) -> tuple[str, str] | None:
    """Words and cure where every joint (m,) of a servo log moves as many times as far as promised as another unit of
    angles makes: a weak servo has its own factor, and no servo so small a one."""
    for other, one in RADIANS.items():
        factor = RADIANS[unit] / one
        if other != unit and len(times) and np.abs(np.log(times / factor)).max() < ROUGHLY:
            words = f"in every joint {float(f'{np.median(times):.2g}'):g} times as far as {{}}: they are "
            words += f"{ANGLE_WORDS[other]}, and were read as {ANGLE_WORDS[unit]}"
            return words, f'set `angle_unit = "{other}"` in [servo_log]'
    return None


def _rolled(schedule: Schedule) -> list[Fault]:
    """Told from the contract by what the body rests in, before and after and in pauses."""
    rows = len(schedule.table)
    firsts = sorted({round(rows * k / ROLLS) % rows for k in range(2, ROLLS - 1)} - {0})
    share = -np.log(KINDS * max(len(firsts), 1))
    return [
        Fault("shift", f"begin near row {first} of the joint table, not at row 0",
              f"begin the table there: the body rests in its row {first}",
              course_of(replace(schedule, table=np.roll(schedule.table, -first, axis=0))), share)
        for first in firsts
    ]  # fmt: skip


def _same(one: Floats, other: Floats) -> bool:
    return one.shape == other.shape and bool(np.allclose(one, other, atol=SAME_TABLE))


def wiring_faults(signal: Sampled, contract: Match, prior: Prior) -> list[Wiring]:
    """Every joint turned round, every pair exchanged, at the contract's own start, but for those that change nothing:
    joints that stand at zero, pairs that are told the same."""
    evidence, residual = match_columns(signal, contract, prior)
    own, joints = contract.by_joint, len(contract.by_joint)
    kept = np.diagonal(residual[0])
    told = commanded_at(signal, contract)

    def explained(changed: dict[int, float]) -> float:
        return explained_by(np.array([changed.get(j, kept[j]) for j in range(joints)]), signal)

    share = -np.log(KINDS * joints)
    found = [
        Wiring(f"turn `joint_{j + 1}` the other way", f"flip the sign of `joint_{j + 1}`",
               cures_of(f"flip the sign of `joint_{j + 1}` in {{}}"), share, float(evidence[1, j, j] - own[j]),
               explained({j: residual[1, j, j]}))
        for j in range(joints) if np.abs(2 * told[:, j]).max() > TICK
    ]  # fmt: skip
    pairs = -np.log(KINDS * max(joints * (joints - 1) / 2, 1))
    for j, i in itertools.combinations(range(joints), 2):
        if np.abs(told[:, i] - told[:, j]).max() > TICK:
            gain = float(evidence[0, i, j] + evidence[0, j, i] - own[i] - own[j])
            words = f"have `joint_{j + 1}` and `joint_{i + 1}` exchanged"
            cure = f"exchange `joint_{j + 1}` and `joint_{i + 1}`"
            now = explained({i: residual[0, i, j], j: residual[0, j, i]})
            found.append(Wiring(words, cure, cures_of(f"{cure} in {{}}"), pairs, gain, now))
    return found
