"""A campaign checked against itself: what each witness says of each promise, and which rivals are certain.

Witnesses: the servo log's commands (the table itself, but for rounding), its positions, the cameras' angles. The
schedule is laid over the first of them that a trial has; the servo log's positions are laid over the cameras. Wiring is
the same in every trial, so its evidence is summed over trials.

    posterior odds of a rival = prior odds of a fault x its share among faults x evidence ratio
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from serpenoid.measure.cells import Floats
from serpenoid.measure.clock import find_offset, held
from serpenoid.measure.consistency.blame import TIED, Contradiction, certain
from serpenoid.measure.consistency.claim import Claim, logged, same_joints
from serpenoid.measure.consistency.clock_steps import without_step
from serpenoid.measure.consistency.cut_logs import unsure_by_cycles
from serpenoid.measure.consistency.hypotheses import (
    IN_ONE,
    KINDS,
    NEAR,
    ROLLS,
    SAME_TABLE,
    Fault,
    in_one_trial,
    in_other_unit,
    other_angles,
    other_unit,
    rounded,
    schedule_faults,
    stopped,
    turned,
)
from serpenoid.measure.consistency.lost_frames import Lost, lost_frames, set_on
from serpenoid.measure.consistency.match import EXACT, HIGHEST_GAIN, PHYSICAL, Match, Prior, course_of, match
from serpenoid.measure.consistency.rivals import SURE, WIRING, Compared, Rival, compared, leads, window
from serpenoid.measure.consistency.signals import AWAY, Signal, moving_s, stopped_s
from serpenoid.measure.schedule import Schedule
from serpenoid.parallel import in_processes

MOST_ROWS = 100_000  # of a recording in a promised cycle: closer ones count in another unit
MOST_CYCLES = 1000  # of a promise are laid over a recording
UNEXPLAINED = 0.25  # of the motion's variance at least is explained by what was commanded, however damaged a robot is
# of the time that is seen as motion, which slow servos make longer; `match` fills in what lies between
SLOW_ENDS = 1.07 ** np.arange(-1, 4)
WEAK = 0.2  # joints of which most move by so much less or more than commanded are mentioned
SCALED = 0.05  # commands of a log that differ so much from the table's are another's
ALIKE = 0.1  # of a gain: those of one cause differ by less
LOG_CURE = "name that file in `servo_log`"
CURES = {"log": LOG_CURE, "markers": "are the recordings of two trials exchanged? Name each trial's own in `motion`"}
RARE = 0.01  # of rows are outliers
AHEAD_ROWS = 10  # of a log, by which readings may be ahead of commands
FAR_LESS = 0.1  # of mean squares: what exchanged columns leave, over what they leave as they are called
PROMISED = 400  # moments of a course at which it is looked at for joints that are to move


@dataclass(frozen=True)
class Verdict:
    """All contradictions of a campaign, remarks that are none, all rivals that were scored; torn: where trials' films
    lack frames that their clocks do not tell of."""

    contradictions: tuple[Contradiction, ...]
    remarks: tuple[tuple[str, str], ...]  # (trial, remark)
    rivals: tuple[Rival, ...]
    torn: Mapping[str, tuple[Lost, ...]] = field(default_factory=dict)
    leanings: Mapping[str, float] = field(default_factory=dict)  # see `_leaning`


def check(claims: Sequence[Claim], tables: Mapping[str, Floats]) -> Verdict:
    """Score every promise of every trial. `tables`: all joint tables of the campaign by label.

    Units and columns first: recordings that last a thousand times too long take as much longer to be laid over
    anything.
    """
    asked = (_in_other_units, _in_other_angles, _readings_first)
    units = [found for claim in claims for one in asked for found in one(claim)]
    if units:
        return Verdict(tuple(units), (), ())
    judged = in_processes([(_judged, (claim, claims, tables)) for claim in claims])
    rivals = [rival for one in judged for rival in one.rivals]
    lost = [found for one in judged for found in one.contradictions]
    torn = {trial: places for one in judged for trial, places in one.torn.items()}
    leanings = {trial: nats for one in judged for trial, nats in one.leanings.items()}
    return Verdict(
        (*certain(rivals, leanings), *lost), tuple(r for one in judged for r in one.remarks), tuple(rivals), torn
    )


def _in_other_units(claim: Claim) -> list[Contradiction]:
    """Witnesses whose motion lasts a thousand times the promised seconds; if two agree, the schedule may be wrong."""
    if claim.schedule is None:
        return []
    witnesses = ((claim.servos, "the servo log's positions"), (claim.film, "the recorded shapes"))
    there = [(signal, witness) for signal, witness in witnesses if signal is not None and signal.enough]
    said = [(witness, _other_unit(signal, claim.schedule)) for signal, witness in there]
    found = [(witness, told) for witness, told in said if told is not None]
    agreed = ""
    if len(found) == len(witnesses) and found[0][1] == found[1][1]:
        agreed = f"is `cycle_duration_s = {claim.schedule.cycle_duration_s:g}` in seconds? Log and film agree; or "
    return [Contradiction(claim.trial, "rate", f"{w} {words}", agreed + cure, np.inf) for w, (words, cure) in found]


def _in_other_angles(claim: Claim) -> list[Contradiction]:
    """A servo log that swings as far as another unit makes of what was promised, else of what cameras show: as long as
    a play in the joints is not known from motion, nothing laid over it tells."""
    cameras = claim.cameras if claim.cameras is not None and claim.cameras.enough else None
    log = next((s for s in (claim.commands, claim.servos) if s is not None and s.enough), None)
    if claim.schedule is not None:
        course = course_of(claim.schedule)
        promised = _swings(course.angles(np.linspace(0.0, course.period_s, PROMISED)))
    elif cameras is not None:
        promised = _swings(cameras.values[cameras.known])
    else:
        return []
    if log is None or log.values.shape[1] != len(promised):
        return []
    told = promised > AWAY * promised.max()
    times = np.maximum(_swings(log.values[log.known])[told], np.finfo(float).tiny) / promised[told]
    said = other_angles(times, claim.angle_unit)
    if said is None:
        return []
    words = f"the servo log's positions move {said[0]}".format("on film" if claim.schedule is None else "promised")
    return [Contradiction(claim.trial, "angle_unit", words, said[1], np.inf)]


def _swings(angles: Floats) -> Floats:
    """How far joints (m,) turn from one side to the other in angles (R, m), but for rare rows."""
    return np.asarray(np.ptp(np.quantile(angles, [RARE, 1 - RARE], axis=0), axis=0))


def _other_unit(signal: Signal, schedule: Schedule) -> tuple[str, str] | None:
    """By how much longer than promised it takes to repeat, or, where nothing repeats, how much longer it moves; what
    moves for too short a time may be the beginning of the promised motion, by how closely it was recorded."""
    own = signal.period_s
    if own is not None:
        return other_unit(own / schedule.period_s)
    longer = moving_s(signal) / schedule.moving_s
    each = float(np.median(np.diff(signal.time_s)))
    return None if longer < 1 and schedule.period_s < MOST_ROWS * each else other_unit(longer)


def _judged(claim: Claim, claims: Sequence[Claim], tables: Mapping[str, Floats]) -> Verdict:
    """One trial: its rivals, and what nothing explains; where frames are missing, beside the film's clock set on."""
    rivals: list[Rival] = []
    lost: list[Contradiction] = []
    remarks: list[tuple[str, str]] = []
    torn: tuple[Lost, ...] = ()
    while (stepped := _step_of_the_log(claim, tables, claims)) is not None:
        claim, said = stepped
        rivals += said
    if claim.cameras is not None and claim.servos is not None and same_joints(claim.cameras, claim.servos):
        torn = lost_frames(claim.cameras, claim.servos)
    if claim.cameras is not None and torn:
        claim = replace(claim, cameras=Signal(set_on(claim.cameras.time_s, torn), claim.cameras.values))
    found = _schedule_against_witness(claim, tables, claims), _servos_against_cameras(claim, claims)
    for one in found:
        if one is not None:
            rivals += [*one.rivals, *_wired_in_one(one.rivals, len(claims))]
            lost += _unexplained(claim, one)
            remarks += [*_weakness(claim, one.contract, one.witness), *one.doubts]
    remarks += [(claim.trial, place.said) for place in torn]
    cut = unsure_by_cycles(claim)
    remarks += [(claim.trial, cut)] if cut else []
    leaning = _leaning(claim, rivals)
    return Verdict(
        tuple(lost), tuple(remarks), tuple(rivals), {claim.trial: torn} if torn else {}, {claim.trial: leaning}
    )


def _wired_in_one(rivals: Sequence[Rival], trials: int) -> list[Rival]:
    """Joints turned round or exchanged in one trial alone: in the others nothing speaks against that."""
    one = "in this trial: in its servo log (or its table), or in its `markers`?"
    return [
        replace(
            r, kind=WIRING + IN_ONE[False], everywhere=False, cures={}, cure=f"{r.cure} {one}",
            log_share=r.log_share - float(np.log(trials)),
        )
        for r in rivals
        if r.kind == WIRING
    ]  # fmt: skip


def _readings_first(claim: Claim) -> list[Contradiction]:
    """A log whose positions come before its commands: no servo does what it is told later. In whichever order a row is
    written, that puts positions one row ahead at most; nearer than that they must follow the table more closely, too.
    Beyond a quarter of a cycle, what is late looks as though it came early."""
    servos, commands, schedule = claim.servos, claim.commands, claim.schedule
    if servos is None or commands is None or schedule is None or not (servos.enough and commands.enough):
        return []
    known = servos.known
    step = float(np.median(np.diff(commands.time_s)))
    told = commands.values[commands.known]
    shifts = step * np.arange(-AHEAD_ROWS, AHEAD_ROWS + 0.25, 0.25)
    at = commands.time_s[commands.known]
    cost = [((told - held(servos.time_s[known], servos.values[known], at - shift)) ** 2).mean() for shift in shifts]
    ahead = float(shifts[int(np.argmin(cost))])
    words = f"the servo log's positions come {1e3 * ahead:.2g} ms before its commands"
    cure = "are `command` and `position` exchanged in [servo_log]?"
    exchanged = Contradiction(claim.trial, "exchanged", words, cure, np.inf)
    if step < ahead < schedule.period_s / 4 and min(cost) < FAR_LESS * told.var(axis=0).mean():
        return [exchanged]
    if ahead <= 0 or min(cost) > FAR_LESS * cost[len(shifts) // 2]:
        return []
    course = course_of(schedule.seen_in(min(float(np.ptp(at)), MOST_CYCLES * schedule.period_s)))
    grids = [window(signal, schedule.period_s, schedule.period_s) for signal in (commands, servos)]
    of_commands, of_positions = (1 - match(grid, course, EXACT).explained for grid in grids)
    if of_positions > FAR_LESS * of_commands:
        return []
    return [exchanged]


def _leaning(claim: Claim, rivals: Sequence[Rival]) -> float:
    """By how much the film makes the joint table likelier than the servo log [nats], where these contradict each other;
    0 where it follows neither."""
    film, servos, schedule = claim.film, claim.servos, claim.schedule
    doubted = any(rival.pair == ("table", "log") and rival.lead + rival.log_share > 0 for rival in rivals)
    if not doubted or film is None or servos is None or schedule is None or not film.enough:
        return 0.0
    seconds = min(float(np.ptp(film.time_s)), MOST_CYCLES * schedule.period_s)
    courses = [course_of(schedule.seen_in(seconds)), logged(servos, servos.period_s)]
    if claim.outline is not None and film is claim.outline.shown:
        courses = [course.changed(claim.outline.of) for course in courses]
    own = film.period_s or schedule.period_s
    grid = window(film, min(schedule.period_s, own), max(schedule.period_s, own))
    table, log = (match(grid, course, PHYSICAL) for course in courses)
    return table.evidence - log.evidence if max(table.explained, log.explained) > SURE else 0.0


def _step_of_the_log(
    claim: Claim, tables: Mapping[str, Floats], claims: Sequence[Claim]
) -> tuple[Claim, list[Rival]] | None:
    """The trial with a step taken off its log's clock, and that rival beside the trial's others, unless one of these is
    likelier by far."""
    stepped = without_step(claim)
    beside = None if stepped is None else _schedule_against_witness(claim, tables, claims)
    others = [] if beside is None else [r for r in beside.rivals if not r.everywhere and leads(r, r.lead)]
    if stepped is None or any(r.lead + r.log_share > stepped[1].lead + stepped[1].log_share + TIED for r in others):
        return None
    return stepped[0], [stepped[1], *others]


def _schedule_against_witness(claim: Claim, tables: Mapping[str, Floats], claims: Sequence[Claim]) -> Compared | None:
    """The promise and its rivals laid over the first witness there is; where none explains it, also as rows that are
    held until the next is due, which of a table of few rows is another motion."""
    schedule = claim.schedule
    for signal, witness, prior in claim.witnesses:
        if schedule is not None and signal is not None and signal.enough:
            found = _laid_over(claim, schedule, (signal, witness, prior), tables, claims)
            if _explained(found) < SURE and not schedule.held:
                held = _laid_over(claim, replace(schedule, held=True), (signal, witness, prior), tables, claims)
                found = max(found, held, key=_explained)
            return _told_to_stop(found) if signal is claim.commands else found
    return None


def _laid_over(
    claim: Claim,
    schedule: Schedule,
    witness: tuple[Signal, str, Prior],
    tables: Mapping[str, Floats],
    claims: Sequence[Claim],
) -> Compared:
    """A promise, what may be wrong with it, and if that does not explain the motion, what other trials were told."""
    signal, name, prior = witness
    own = signal.period_s
    periods = _periods(signal, own, schedule)
    slower = schedule.period_s / min([schedule.period_s, *periods])
    shown = schedule.seen_in(min(slower * float(np.ptp(signal.time_s)), MOST_CYCLES * schedule.period_s))
    each_s = float(np.median(np.diff(signal.time_s[signal.known])))
    faults = schedule_faults(shown, claim.label, tables, periods, moving_s(signal), each_s)
    faults += _stopped(claim, signal, shown)
    faults += in_one_trial(course_of(shown), claim.label, filmed=signal is claim.cameras)
    faults, course = _of_any(len(claims), faults), course_of(shown)
    found = compared(claim.trial, signal, course, own, faults, name, prior)
    if found.contract.explained < SURE:
        key = "motion" if signal is claim.cameras else "servo_log"
        others = _of_other_trials(schedule, claims, key, float(np.ptp(signal.time_s)))
        faults += _of_any(len(claims), others)
        found = compared(claim.trial, signal, course, own, faults, name, prior)
    return found


def _explained(found: Compared) -> float:
    """Share of the motion's variance that the promise explains, or the rival that explains most."""
    return max([found.contract.explained, *(rival.explained for rival in found.rivals)])


def _of_other_trials(own: Schedule, claims: Sequence[Claim], key: str, seconds: float) -> list[Fault]:
    """What trials of another timing were told, as far as so many seconds show it, its rows held as its `own` are: a
    file of theirs, under `key`, instead of its own."""
    others: dict[tuple[str, float, float], tuple[str, Schedule]] = {}
    for other in claims:
        told = other.schedule
        if told is None or told.table.shape[1] != own.table.shape[1]:
            continue
        if (told.cycle_duration_s, told.pause_s) != (own.cycle_duration_s, own.pause_s):
            timed = replace(told, held=own.held)
            others.setdefault((other.label, told.cycle_duration_s, told.pause_s), (other.trial, timed))
    share = -float(np.log(KINDS * max(len(others), 1)))
    cure = f"are files of two trials exchanged? Name each trial's own in `{key}`"
    return [
        Fault(
            "file",
            f"follow what trial `{name}` was told, not their own",
            cure,
            course_of(told.seen_in(min(seconds, MOST_CYCLES * told.period_s))),
            share,
        )
        for name, told in others.values()
    ]


def _told_to_stop(found: Compared) -> Compared:
    """Commands that stop early are no contradiction, for it is known what was told: a remark."""
    stops = [r for r in found.rivals if r.kind == "stopped" and leads(r, r.lead)]
    others = [r for r in found.rivals if r.kind != "stopped"]
    if not stops:
        return replace(found, rivals=others)
    best = max(stops, key=lambda r: r.lead)
    contract = replace(found.contract, explained=best.explained, gain=np.ones_like(found.contract.gain))
    return replace(found, contract=contract, rivals=others, doubts=[*found.doubts, (best.trial, best.words)])


def _stopped(claim: Claim, signal: Signal, schedule: Schedule) -> list[Fault]:
    """Where joints come to their last place while the schedule still moves them, and stay there for longer than in a
    pause."""
    after_s, at_s = stopped_s(signal)
    early, rested = schedule.moving_s - after_s, signal.time_s[-1] - at_s
    if early < schedule.cycle_duration_s / ROLLS or rested < schedule.pause_s + schedule.cycle_duration_s / ROLLS:
        return []
    cure = "Leave this trial out" if signal is claim.servos else f"End the trial before: `to_s = {at_s:.3g}`, or less"
    return stopped(course_of(schedule), claim.label, after_s, cure)


def _of_any(trials: int, faults: Sequence[Fault]) -> list[Fault]:
    """Faults of one trial: what is wrong in a campaign may be wrong in any of its trials."""
    return [f if f.everywhere else replace(f, log_share=f.log_share - float(np.log(trials))) for f in faults]


def _periods(signal: Signal, own: float | None, schedule: Schedule) -> list[float]:
    """What the period may be [s]: a gait may repeat itself within a cycle, and a signal look alike twice.

    Where nothing repeats, as in a trial of one cycle, it is as long as the body moves, or a little longer, as it begins
    and ends slowly, or shorter, as slow servos end later.
    """
    if own is not None:
        return [own, 2 * own, own / 2]
    moving = moving_s(signal)
    return [(factor * moving + schedule.pause_s) / schedule.cycles for factor in SLOW_ENDS] if moving else []


def _servos_against_cameras(claim: Claim, claims: Sequence[Claim]) -> Compared | None:
    cameras, servos = claim.cameras, claim.servos
    if cameras is None or servos is None or not same_joints(cameras, servos):
        return None
    if abs(np.log(_slowed(cameras, servos))) <= NEAR:  # at another rate, seconds of the log are not those of the film
        cameras = _covered(cameras, servos)
    own, promised, slowed = cameras.period_s, servos.period_s, _slowed(cameras, servos)
    course = logged(servos, promised)
    joints = cameras.values.shape[1]
    logs = [(c.trial, c.servos) for c in claims if c.servos is not None and not _repeats(c, claim)]
    others = [(name, log) for name, log in logs if log.values.shape[1] == joints and log.enough]
    share = -float(np.log(KINDS * max(len(others), 1)))
    faults = [*turned(course, "the servo log"), *in_one_trial(course, "the servo log", filmed=True)]
    for name, log in others:
        words = f"follow the servo log of trial `{name}`, not their own"
        faults.append(Fault("log", words, LOG_CURE, logged(log, promised), share, cures=CURES))
    if abs(np.log(slowed)) > NEAR:
        words = f"last {rounded(slowed)} times as long as in the servo log"
        cure = in_other_unit(slowed) or "check the frame rate of the recording"
        faults.append(Fault("rate", words, cure, course.slowed(slowed), -np.log(KINDS)))
    return compared(claim.trial, cameras, course, own, _of_any(len(claims), faults), "the recorded shapes", PHYSICAL)


def _slowed(cameras: Signal, servos: Signal) -> float:
    """How many times as long as in the log the recorded shapes take to repeat; 1 where either shows no period."""
    own, promised = cameras.period_s, servos.period_s
    return own / promised if own is not None and promised is not None else 1.0


def _covered(cameras: Signal, servos: Signal) -> Signal:
    """What cameras saw while the log ran, where it ran for less than the body moved (its battery died)."""
    known = servos.known
    log_s = servos.time_s[known]
    if np.ptp(log_s) >= moving_s(cameras):
        return cameras
    found = find_offset(cameras.time_s, cameras.values, log_s, servos.values[known])
    if found is None:
        return cameras
    since, until = log_s[[0, -1]] + found.offset_s
    inside = (cameras.time_s >= since) & (cameras.time_s <= until)
    part = Signal(cameras.time_s[inside], cameras.values[inside])
    return part if part.enough else cameras


def _repeats(one: Claim, other: Claim) -> bool:
    """Whether two trials promise one motion: what tells their logs apart is chance, and what a diagnosis looks for."""
    a, b = one.schedule, other.schedule
    if one is other or a is None or b is None:
        return one is other
    alike = (a.cycle_duration_s, a.pause_s) == (b.cycle_duration_s, b.pause_s) and a.table.shape == b.table.shape
    return alike and bool(np.abs(a.table - b.table).max() < SAME_TABLE)


def _unexplained(claim: Claim, found: Compared) -> list[Contradiction]:
    """A motion that neither the contract nor any rival explains."""
    witness = found.witness
    if found.contract.explained > UNEXPLAINED or any(leads(rival, rival.lead) for rival in found.rivals):
        return []
    what = f"`{claim.label}`"
    if witness == "the recorded shapes" and claim.cameras is not None and claim.servos is not None:
        seconds, filmed = (float(np.ptp(signal.time_s)) for signal in (claim.servos, claim.cameras))
        what = f"its servo log ({seconds:.3g} s beside a recording of {filmed:.3g} s)"
    words = f"{witness} follow neither {what} nor anything else in this campaign"
    cure = "is the file of another trial named here?"
    film = claim.cameras if witness == "the recorded shapes" else None
    if film is not None and np.ptp(film.time_s) >= 2 * found.contract.course.total_s:
        cure += " Does it show more trials than this one? Give each its part by `from_s` and `to_s`"
    return [Contradiction(claim.trial, "nothing", words, cure, 0.0)]


def _weakness(claim: Claim, contract: Match, witness: str) -> list[tuple[str, str]]:
    """Where joints move less or more than promised, which: of those that were promised to move. Servos may be weak;
    commands are another table."""
    course = contract.course
    moved = np.ptp(course.angles(np.linspace(0.0, course.total_s, PROMISED)), axis=0)
    told = np.flatnonzero(moved > AWAY * moved.max())
    gains = contract.gain[told]
    middle = round(float(np.median(gains)), 2)
    exact = witness == "the servo log's commands"
    if contract.explained < 0.5 or abs(middle - 1) < (SCALED if exact else WEAK) - 1e-9 or middle >= HIGHEST_GAIN:
        return []  # at the highest gain: laid where it does not fit
    which = np.abs(gains - middle) < np.abs(gains - 1)
    least, most = gains[which].min(), gains[which].max()
    size = f"{middle:.2f}" if most - least < ALIKE * middle else f"{least:.2f} to {most:.2f}"
    who = "joints" if which.all() else ", ".join(f"`joint_{j + 1}`" for j in told[which])
    alike = ", all alike" if which.all() and most - least < ALIKE * middle else ""
    why = "another table, or this one scaled? Name in `joint_table` what was played" if exact else "weak servos?"
    move = "are told to move" if exact else "move"
    return [(claim.trial, f"{witness}: {who} {move} {size} times as far as promised{alike} ({why})")]
