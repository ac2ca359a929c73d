"""Which effects of the medium (and steps or drift of the camera frame) the motion shows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from serpenoid.diagnose.data.chance import NORMAL, largest_factor
from serpenoid.diagnose.data.motion import Motion, Noise
from serpenoid.diagnose.data.noise import noise_uncertain, over_markers, residuals
from serpenoid.diagnose.data.observation import Observation
from serpenoid.diagnose.data.paths import path_error, path_noise
from serpenoid.diagnose.data.recording import Recording, held_out_labels
from serpenoid.diagnose.data.repeats import chance_from
from serpenoid.diagnose.data.shared import discrepancy
from serpenoid.diagnose.data.tracks import NoPath, make_tracks, tracker
from serpenoid.diagnose.data.untestable import beyond_bounds, left_out, not_on_offer, of_other_laws
from serpenoid.diagnose.data.untold import untold
from serpenoid.diagnose.data.windows import Prediction, Track
from serpenoid.diagnose.inference.at_one_vertex import AtOneVertex, at_one_vertex, words_of
from serpenoid.diagnose.inference.differing import Differing, differing
from serpenoid.diagnose.inference.discrepancy import size_done
from serpenoid.diagnose.inference.explanations import acts
from serpenoid.diagnose.inference.finding import VISIBLE, Divided, Named, Stage
from serpenoid.diagnose.inference.groups import Swap, groups
from serpenoid.diagnose.inference.growing import grows_instead
from serpenoid.diagnose.inference.jumps import find_jumps
from serpenoid.diagnose.inference.law_doubt import Coordinate, Doubted, doubted, yielding
from serpenoid.diagnose.inference.law_error import LAW_ERROR
from serpenoid.diagnose.inference.left_open import believed
from serpenoid.diagnose.inference.medium import Fit, candidates_of, fit_eps, fit_guided
from serpenoid.diagnose.inference.middles import Amid, drag_amid_edges
from serpenoid.diagnose.inference.names import Key, Refused, Weak
from serpenoid.diagnose.inference.other_law import of_another_law
from serpenoid.diagnose.inference.places import placed
from serpenoid.diagnose.inference.profile import in_its_range
from serpenoid.diagnose.inference.same_ratio import as_much_as_another_ratio
from serpenoid.diagnose.inference.select import Retrack, Selection, calibrated, retracked, select
from serpenoid.diagnose.residuals.from_trial_to_trial import after_some, as_floors_do, more_than_before, one_in_each
from serpenoid.diagnose.residuals.in_some_trials import one_cause_in_some
from serpenoid.diagnose.residuals.residual_words import astray, pattern
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.law_of_medium import (
    SAME,
    law_of,
    numbers_settled,
    slipping_sideways,
    with_own_numbers,
)
from serpenoid.diagnose.stages.other_explanations import beside_others, beside_rivals
from serpenoid.diagnose.stages.values_of_motion import beside_known, named_of, ratio_beside, ratio_interval
from serpenoid.model import Model
from serpenoid.wording import NOT_NAMED

GUESS = Noise(np.array([5e-4, 5e-4, 1e-3]), np.array([1e-4, 1e-4, 3e-4]))
TOLD = 0.01  # of what is left: refused effects that would take less are not spoken of

Found = TypeVar("Found")
Searched = Callable[[Selection], None]  # hears what is named and why, before its rivals and intervals are known


@dataclass(frozen=True)
class MotionFinding:
    """The stage's finding and everything it rests on; baseline: beside which of several it was found."""

    stage: Stage
    selection: Selection
    swaps: tuple[Swap, ...]
    before_m: float
    after_m: float
    baseline: Baseline | None = None


def choose_motion(
    recordings: Sequence[Recording],
    seen: Observation,
    baseline: Baseline,
    say: Callable[[str], None],
    searched: Searched = lambda found: None,
) -> MotionFinding:
    """Calibrate eps, select effects, say what is left."""

    track = tracker(recordings, seen)

    def amid(about: Model) -> tuple[Track, ...]:
        return make_tracks([r.with_middles() for r in recordings], seen.with_middles(), about)

    return choose_on_tracks(track, held_out_labels(recordings), baseline, say, amid=amid, searched=searched)


def choose_on_tracks(
    track: Callable[[Model], tuple[Track, ...]],
    labels: tuple[int, ...],
    baseline: Baseline,
    say: Callable[[str], None],
    untestable: Mapping[str, str] | None = None,
    amid: Callable[[Model], tuple[Track, ...]] | None = None,
    searched: Searched = lambda found: None,
) -> MotionFinding:
    """The same on what `track` makes about a model, as it was seen; labels: what is held out together.

    untestable: effects that are no candidates, and why. amid: makes tracks about a model with vertices amid the edges.
    """
    begun: list[tuple[Baseline, tuple[Motion, Fit]]] = []  # of the last one: it is asked for more than once

    def alone(other: Baseline) -> tuple[Motion, Fit]:
        if not begun or begun[0][0] is not other:
            begun[:] = [(other, eps_alone(track, labels, other, untestable))]
        return begun[0][1]

    def beside(other: Baseline) -> Selection:
        motion, null = alone(other)
        return select(motion, null.model, lambda about: other.corrected(track(about)), say)

    baseline = with_own_numbers(baseline, lambda known: alone(known)[0])
    baseline = slipping_sideways(baseline, alone)
    chosen, baseline = numbers_settled(*with_a_path(baseline, beside), beside)
    chosen, baseline = beside_others(chosen, baseline, beside, alone)
    asked = baseline.ratio is None  # with a reference it is known
    say("which law the medium follows")
    middles = drag_amid_edges(chosen, amid) if asked and amid is not None else Amid()
    law = law_of(chosen, baseline, beside, middles.misses) if asked else SAME
    chosen, baseline = law.selection or chosen, law.baseline or baseline
    parts = differing(chosen, baseline.inadequate)
    if parts is None:
        chosen = believed(chosen, lambda found: explained(found, baseline.inadequate, beside_rivals(found, baseline)))
    chosen = about_nothing(chosen, lambda model: baseline.corrected(track(model)))
    searched(chosen)  # what this alone shows can be drawn while rivals are fitted
    say("what else it could be")
    found = finding(chosen, baseline.inadequate, beside_rivals(chosen, baseline), parts)
    barred = not_looked_for(baseline, untestable)
    drag_at = "" if law.words else middles.words
    stage = beside_earlier(found.stage, baseline)
    stage = replace(stage, untestable=barred, laws=law.rivals, law_taken=law.words, drag_at=drag_at)
    return replace(found, stage=stage, baseline=baseline)


def with_a_path(baseline: Baseline, beside: Callable[[Baseline], Found]) -> tuple[Found, Baseline]:
    """What is found beside a baseline, or, where its model has no path, beside the next explanation of what was so
    already. Raises NoPath where none has one."""
    try:
        return beside(baseline), baseline
    except NoPath as none:
        other = baseline.instead(none.trial)
        if other is None:
            raise
    return with_a_path(other, beside)


def about_nothing(chosen: Selection, retrack: Retrack) -> Selection:
    """Where a search found effects and none is believed, on tracks about the model without them: what a mesh misses is
    that of the model, and of one that is refused it may be large."""
    if chosen.settled.effects or not chosen.refused:
        return chosen
    again = placed(retracked(chosen.motion, retrack, chosen.null.model), chosen.null)
    motion, null = calibrated(again, fit_guided(again, chosen.null))
    level = path_noise(motion, null.predictions).level_m
    return replace(chosen, motion=motion, null=null, best=null, bases=(), settled=null, noise_level_m=level)


def not_looked_for(baseline: Baseline, untestable: Mapping[str, str] | None) -> dict[str, str]:
    """Effects that are no candidates, and why."""
    return {**left_out(baseline.without), **beyond_bounds(baseline.model), **(untestable or {})}


def eps_alone(
    track: Callable[[Model], tuple[Track, ...]],
    labels: tuple[int, ...],
    baseline: Baseline,
    untestable: Mapping[str, str] | None,
) -> tuple[Motion, Fit]:
    """The motion beside a baseline, and eps calibrated to it. Raises NoPath."""
    model = baseline.model
    barred = not_looked_for(baseline, untestable)
    absent = frozenset(barred) | not_on_offer(model.body) | of_other_laws(model.medium.law)

    def about(known: Model) -> tuple[Motion, Fit]:
        tracks = baseline.corrected(track(known))
        motion = Motion(tracks, GUESS, labels, known.effects, baseline.unlike, absent, baseline.ratio, baseline.earlier)
        return motion, fit_eps(motion, known)

    motion, found = about(model)
    try:
        return about(found.model)
    except NoPath:
        return motion, found


def finding(
    found: Selection,
    inadequate: bool = False,
    beside: Sequence[tuple[Motion, Fit, float]] = (),
    parts: Differing | None = None,
) -> MotionFinding:
    """The selection in words and intervals; inadequate: its baseline's law is known to be another than the floor's;
    beside: what is settled on, fitted beside other explanations of what the baseline's law misses; parts: that differ,
    so that what is left is no error of the law."""
    motion, best, noise_level = found.motion, found.best, found.noise_level_m
    before = path_error(motion, found.null.predictions)
    missed_m = 0.0 if parts is not None else discrepancy(motion, found.settled.predictions)
    wrong = () if parts is not None else explained(found, inadequate, beside)
    doubt = doubted(wrong) if parts is None else parts.doubt
    named = [named_of(found, base, e, doubt) for e, base in zip(best.effects, found.bases, strict=True)]
    doubtful = frozenset[Key]() if parts is None else parts.as_well
    named = [n if n.effect.key in doubtful else in_its_range(motion, found.settled, n, wrong) for n in named]
    swaps = groups(found)
    jumps = find_jumps(motion, found.settled.predictions, noise_level, missed_m, len(candidates_of(best)))
    undetected = [undetected_of(f, noise_level) for f in found.undetected]
    if jumps is not None:
        (named if jumps.strength >= VISIBLE else undetected).append(jumps)
    words, divided = _left_over(found, parts, mend=jumps is not None)
    divided, hiding = (None, divided.words) if divided is not None and divided.hint else (divided, "")
    unlike = ""
    alone: tuple[AtOneVertex, ...] = ()
    if words and parts is None:
        alone = at_one_vertex(found)
        words = (*words, *as_much_as_another_ratio(found), *refusals(found.refused), *words_of(alone))
    if parts is not None and (parts.told or _left_over(found, None, mend=jumps is not None)[0]):
        words, unlike = (*words, parts.words), parts.kind
        named = [replace(n, stand_in=n.effect.key in doubtful) for n in named]
    if wrong:
        named = with_stand_ins(found, named, inadequate)
    if wrong and motion.ratio is not None:
        share = missed_m / size_done(motion, found.settled)
        named = [of_a_law(n, share, doubt) for n in named]
    elsewhere = {a.effect.key for a in alone}
    named = [replace(n, stand_in=True) if n.effect.key in elsewhere else n for n in named]
    after = strayed(found, parts, jumps is not None and jumps in named)
    if (
        words and named and not wrong and astray(motion, _predicted(found, parts), after)
    ):  # by paths alone: few windows show less
        named = [n if n is jumps else m for n, m in zip(named, with_stand_ins(found, named, inadequate), strict=True)]
    if wrong:
        named = mending(found, named, before, after)
    if motion.ratio is None and chance_from(motion.tracks) == "residuals":
        named = beside_what_is_left(motion, named)
    if motion.ratio is None:
        named = beside_paths(named, after / noise_level)
    named = amid_points(motion, named)
    known = divided is not None and bool(divided.cause)  # by what repeats differ by: it is told
    growing = grows_instead(found) if not known and any(n.effect.effect.moves for n in named) else ""
    if growing:
        named = [replace(n, stand_in=n.stand_in or n.effect.effect.moves) for n in named]
        words = (*words, growing)
    ends = None if parts is None else ratio_beside(parts, found.settled)
    rivals, weak = tuple(s.rival for s in swaps), tuple(undetected)
    stage = Stage("motion", tuple(named), rivals, weak, after / noise_level, words, discrepancy_m=missed_m)
    stage = another_law(found, replace(stage, unlike=unlike, ratio=ends, divided=divided, hiding=hiding))
    return MotionFinding(stage, found, swaps, before, after)


def beside_earlier(stage: Stage, baseline: Baseline) -> Stage:
    """The names of a stage, without stand-ins that may change nothing. What was known of the same effect before puts
    its value in doubt, and not that it has changed."""
    wide = {n.effect.key: beside_known(n, baseline.doubt_of(n.effect)) for n in stage.named}
    stage = stage.naming(stage.named)
    named, weak = (tuple(wide.get(n.effect.key, n) for n in some) for some in (stage.named, stage.undetected))
    return replace(stage, named=named, undetected=weak)


def beside_what_is_left(motion: Motion, named: Sequence[Named]) -> list[Named]:
    """Names where nothing was played twice: what is left beyond the markers' noise may be an error of the law, and what
    does less than 1 / LAW_ERROR times as much may be a part of that."""
    beyond = beyond_markers(motion)
    return [
        replace(n, stand_in=n.stand_in or (n.effect.effect.moves and beyond > LAW_ERROR * n.strength)) for n in named
    ]


def beyond_markers(motion: Motion) -> float:
    """What of the noise is none of the markers', in noise levels; 0 where chance may make as much."""
    ratio = over_markers(motion) or 1.0
    return float(np.sqrt(1 - ratio**-2)) if ratio > largest_factor(noise_uncertain(motion)) else 0.0


def beside_paths(named: Sequence[Named], left: float) -> list[Named]:
    """Names beside the path error that is left over its noise level: what does less than that is beyond the noise may
    be a part of it, though in few windows noise may make as much."""
    beyond = float(np.sqrt(max(left**2 - 1, 0.0)))
    return [replace(n, stand_in=n.stand_in or (n.effect.effect.moves and beyond > n.strength)) for n in named]


def amid_points(motion: Motion, named: Sequence[Named]) -> list[Named]:
    """Names of a body that is known at points: what effects do is computed on straight links between them, and a name
    that does no more than the others are off by for that may mend it."""
    coarse = NORMAL * float(np.sqrt(np.mean([t.coarse**2 for t in motion.tracks])))
    squares = [n.strength**2 if n.effect.effect.moves else 0.0 for n in named]
    off = [coarse * float(np.sqrt(sum(squares[:i] + squares[i + 1 :]))) for i in range(len(named))]
    return [
        replace(n, stand_in=n.stand_in or (n.effect.effect.moves and 0 < x >= n.strength))
        for n, x in zip(named, off, strict=True)
    ]


def another_law(found: Selection, stage: Stage) -> Stage:
    """The stage; where names that are no stand-ins yet look like another law, all are marked, and it says why. With a
    reference eps is given, and names are changes."""
    if found.motion.ratio is not None or not any(n.effect.effect.moves and not n.stand_in for n in stage.named):
        return stage
    model = found.settled.model
    why = of_another_law(model.medium, model.body.vertices, stage.named, ratio_interval(found, stage))
    if not why:
        return stage
    named = tuple(replace(n, stand_in=n.stand_in or n.effect.effect.moves) for n in stage.named)
    return replace(stage, named=named, words=(*stage.words, why))


def left_of(before: float, after: float, noise: float) -> float:
    """How much of a path error remains, beyond noise."""
    was, remains = (float(np.sqrt(max(x**2 - noise**2, 0.0))) for x in (before, after))
    return remains / was if was > 0 else float(after >= before)


def mending(found: Selection, named: Sequence[Named], before: float, after: float) -> list[Named]:
    """Names, marked where they mend windows of a law that is wrong, and not the path: beside a reference, where of what
    all of them do there, or one of them does, LAW_ERROR remains or more; before, after: path errors [m]."""
    most = 1.0 if found.motion.ratio is None else LAW_ERROR
    bases = zip(found.best.effects, found.bases, strict=True)
    without = {e.key: path_error(found.motion, base.predictions) for e, base in bases}
    remains = [
        max(left_of(error, after, found.noise_level_m) for error in (before, without.get(n.effect.key, before)))
        for n in named
    ]
    return [
        replace(n, stand_in=n.stand_in or (n.effect.effect.moves and share >= most))
        for n, share in zip(named, remains, strict=True)
    ]


def of_a_law(named: Named, share: float, doubt: Mapping[Coordinate, Doubted]) -> Named:
    """A change beside a reference, where what repeats shares is left of what all changes do: it is another law's from
    LAW_ERROR on, as on the stages above; what acts by the floor's law may do more or less there for as much."""
    if share > LAW_ERROR and named.effect.effect.moves:
        named = replace(named, stand_in=True)
    return yielding(named, share, doubt) if acts(named.effect) else named


def strayed(found: Selection, parts: Differing | None, mend: bool) -> float:
    """Path error [m] of all that is there, as the verdict takes it; mend: of steps across gaps, too."""
    return path_error(found.motion, _predicted(found, parts), mend)


def _predicted(found: Selection, parts: Differing | None) -> Sequence[Prediction]:
    """By what is named, what is below detection, and parts that differ."""
    return found.settled.predictions if parts is None else parts.predictions


def explained(
    found: Selection, inadequate: bool, beside: Sequence[tuple[Motion, Fit, float]] = ()
) -> Sequence[tuple[Motion, Fit, float]]:
    """Where the law of what is named is known to be wrong, what is settled on beside every explanation of that."""
    motion, settled = found.motion, found.settled
    if not found.best.effects or not (inadequate or discrepancy(motion, settled.predictions) > 0):
        return ()
    alone = [(motion, found.best, 1.0)] if found.undetected else []  # what is below detection may mend the law, too
    return ((motion, settled, 1.0), *alone, *beside)


def with_stand_ins(found: Selection, named: Sequence[Named], inadequate: bool) -> list[Named]:
    """Names, and whether each may be there for a cause that the catalogue does not hold, if what the model misses
    repeats, or what its reference missed did.

    Of the floor, or of the cameras' frame, that may be all of it; with a reference, too, if that missed nothing. What
    a reference missed is no news, and what takes away most is the change; what stands beside it may mend the law about
    it, whose error is in proportion to what the change does. What trials that were not laid alike differ by is news.
    """
    motion = found.motion
    no_news = motion.ratio is not None and inadequate
    if not no_news or untold(motion, residuals(motion.tracks, found.settled.predictions)) is not None:
        return [replace(n, stand_in=n.effect.effect.moves) for n in named]
    gains = {e.key: base.chi2 - found.best.chi2 for e, base in zip(found.best.effects, found.bases, strict=True)}
    most = max(gains.values(), default=0.0)
    return [replace(n, stand_in=gains.get(n.effect.key, most) < most) for n in named]


def refusals(refused: Sequence[Refused]) -> tuple[str, ...]:
    """Why effects that the search tried are not named, what takes away most first."""
    most = {r.effect.key: r for r in sorted(refused, key=lambda r: r.share) if r.share >= TOLD}
    ordered = sorted(most.values(), key=lambda r: -r.share)
    chance, beyond = [r for r in ordered if not r.beyond], [r for r in ordered if r.beyond]
    said = [f"{NOT_NAMED}a wrong effect could take away as much: {_shares(chance)}"] if chance else []
    return (*said, *(f"{NOT_NAMED}it is pushed beyond its bound: {_shares([r])}" for r in beyond))


def _shares(refused: Sequence[Refused]) -> str:
    first, *others = refused
    more = "".join(f", {r.effect.called} ({r.share:.0%})" for r in others)
    return f"{first.effect.called} ({first.share:.0%} of what is left){more}"


def undetected_of(t: Weak, noise_level_m: float) -> Named:
    """What windows show, though its trace in the path is too weak to name it."""
    return Named(t.fitted, {}, t.strength_m / noise_level_m)


def _left_over(found: Selection, parts: Differing | None, mend: bool) -> tuple[tuple[str, ...], Divided | None]:
    """What neither the effects named nor one too weak to be named, nor parts that differ, account for; and how trials
    are divided by it, if they are, or a hint at that. mend: steps across gaps are known."""
    motion, predictions = found.motion, _predicted(found, parts)
    eps = found.settled.model.medium.anisotropy_ratio
    words = pattern(motion, predictions, path_error(motion, predictions, mend))
    divided = differ = more_than_before(motion, predictions, found.null.model)
    cause = one_cause_in_some(motion, found.settled, () if differ is None else differ.changed)
    hint = cause if cause is not None and cause.hint else None
    if cause is not None and hint is None:
        divided = cause if differ is None else replace(cause, words=f"{cause.words}; {differ.words}")
    floors = () if divided is not None else as_floors_do(motion, predictions, eps)
    if divided is None and words and not floors:
        divided = after_some(motion, found.null.model)
    if divided is not None:
        return (*words, divided.words), divided
    return (*words, *(floors or (one_in_each(motion, predictions, eps) if words else ()))), hint
