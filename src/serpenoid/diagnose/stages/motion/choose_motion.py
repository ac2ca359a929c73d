"""Which effects of the medium (and steps or drift of the camera frame) the motion shows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

import numpy as np

from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.noise.motion import Motion, Noise
from serpenoid.diagnose.data.noise.paths import path_error, path_noise
from serpenoid.diagnose.data.noise.repeats import chance_from
from serpenoid.diagnose.data.noise.shared import discrepancy
from serpenoid.diagnose.data.recordings.recording import Recording, held_out_labels
from serpenoid.diagnose.data.untestable import beyond_bounds, left_out, not_on_offer, of_other_laws
from serpenoid.diagnose.data.windows.tracks import NoPath, make_tracks, tracker
from serpenoid.diagnose.data.windows.windows import Track
from serpenoid.diagnose.inference.doubt.at_one_vertex import AtOneVertex, at_one_vertex, words_of
from serpenoid.diagnose.inference.doubt.differing import Differing, differing
from serpenoid.diagnose.inference.doubt.groups import Swap, as_another_ratio, groups
from serpenoid.diagnose.inference.doubt.growing import grows_instead
from serpenoid.diagnose.inference.doubt.law_doubt import doubted
from serpenoid.diagnose.inference.doubt.left_open import believed
from serpenoid.diagnose.inference.doubt.middles import Elsewhere, Tracked, drag_elsewhere
from serpenoid.diagnose.inference.doubt.profile import in_its_range
from serpenoid.diagnose.inference.doubt.same_ratio import as_much_as_another_ratio
from serpenoid.diagnose.inference.fits.finding import VISIBLE, Named, Rival, Stage
from serpenoid.diagnose.inference.fits.jumps import find_jumps
from serpenoid.diagnose.inference.fits.medium import Fit, candidates_of, fit_eps, fit_guided
from serpenoid.diagnose.inference.fits.places import placed
from serpenoid.diagnose.inference.search.discrepancy import size_done
from serpenoid.diagnose.inference.search.names import Key, Weak
from serpenoid.diagnose.inference.search.ratio_held import as_it_was_or_another, held
from serpenoid.diagnose.inference.search.select import Retrack, Selection, calibrated, retracked, select
from serpenoid.diagnose.residuals.residual_words import astray
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.motion.law_of_medium import (
    SAME,
    law_of,
    numbers_settled,
    slipping_sideways,
    with_own_numbers,
)
from serpenoid.diagnose.stages.motion.left_over import left_over, predicted_by, refusals, strayed
from serpenoid.diagnose.stages.motion.other_explanations import beside_others, beside_rivals, instead
from serpenoid.diagnose.stages.motion.stand_ins import (
    amid_points,
    another_law,
    beside_paths,
    beside_what_is_left,
    explained,
    mending,
    of_a_law,
    with_stand_ins,
)
from serpenoid.diagnose.stages.motion.values_of_motion import beside_known, named_of, ratio_beside
from serpenoid.model import Model
from serpenoid.wording import ANY_RATIO

GUESS = Noise(np.array([5e-4, 5e-4, 1e-3]), np.array([1e-4, 1e-4, 3e-4]))

Found = TypeVar("Found")
Searched = Callable[[Selection], None]  # hears what is named and why, before its rivals and intervals are known


@dataclass(frozen=True)
class MotionFinding:
    """The stage's finding and everything it rests on; baseline: beside which of several it was found; elsewhere: the
    model whose drag acts elsewhere on the body, where that leaves less."""

    stage: Stage
    selection: Selection
    swaps: tuple[Swap, ...]
    before_m: float
    after_m: float
    baseline: Baseline | None = None
    elsewhere: Model | None = None


def choose_motion(
    recordings: Sequence[Recording],
    seen: Observation,
    baseline: Baseline,
    say: Callable[[str], None],
    searched: Searched = lambda found: None,
) -> MotionFinding:
    """Calibrate eps, select effects, say what is left."""

    track = tracker(recordings, seen)

    def amid(about: Model, pieces: int) -> tuple[Track, ...]:
        return make_tracks([r.with_middles(pieces) for r in recordings], seen.with_middles(pieces), about)

    return choose_on_tracks(track, held_out_labels(recordings), baseline, say, amid=amid, searched=searched)


def choose_on_tracks(
    track: Callable[[Model], tuple[Track, ...]],
    labels: tuple[int, ...],
    baseline: Baseline,
    say: Callable[[str], None],
    untestable: Mapping[str, str] | None = None,
    amid: Tracked | None = None,
    searched: Searched = lambda found: None,
) -> MotionFinding:
    """The same on what `track` makes about a model, as it was seen; labels: what is held out together.

    untestable: effects that are no candidates, and why. amid: makes tracks about a model with vertices amid pieces of
    the edges.
    """
    begun: list[tuple[Baseline, tuple[Motion, Fit]]] = []  # of the last one: it is asked for more than once

    def alone(other: Baseline) -> tuple[Motion, Fit]:
        if not begun or begun[0][0] is not other:
            begun[:] = [(other, eps_alone(track, labels, other, untestable))]
        return begun[0][1]

    def beside(other: Baseline) -> Selection:
        motion, null = alone(other)

        def searched_on(motion: Motion, model: Model) -> Selection:
            return select(motion, model, lambda about: other.corrected(track(about)), say)

        free = partial(searched_on, motion, null.model)
        if not other.ratio_known(motion.tracks):
            return free()
        same, bare = held(motion, other.model)
        return as_it_was_or_another(searched_on(same, bare.model), free, other.inadequate)

    def nothing(other: Baseline) -> tuple[Motion, Fit]:
        motion, null = alone(other)
        return held(motion, other.model) if chosen.motion.ratio_held else (motion, null)

    baseline = with_own_numbers(baseline, lambda known: alone(known)[0])
    baseline = slipping_sideways(baseline, alone)
    chosen, baseline = numbers_settled(*with_a_path(baseline, beside), beside)
    chosen, baseline, first = beside_others(chosen, baseline, beside, nothing)
    asked = baseline.ratio is None  # with a reference it is known
    say("which law the medium follows")
    amid_edges = Elsewhere()
    if asked and amid is not None:
        amid_edges = drag_elsewhere(chosen, amid, baseline.law_open, baseline.without)
    law = law_of(chosen, baseline, beside, amid_edges.misses) if asked else SAME
    chosen, baseline = law.selection or chosen, law.baseline or baseline
    parts = differing(chosen, baseline.inadequate)
    if parts is None:
        chosen = believed(chosen, lambda found: explained(found, baseline.inadequate, beside_rivals(found, baseline)))
    chosen = about_nothing(chosen, lambda model: baseline.corrected(track(model)))
    searched(chosen)  # what this alone shows can be drawn while rivals are fitted
    say("what else it could be")
    found = finding(chosen, baseline.inadequate, beside_rivals(chosen, baseline), parts)
    barred = not_looked_for(baseline, untestable)
    place = Elsewhere() if law.words or law.misses < amid_edges.misses else amid_edges
    stage = beside_earlier(or_instead(found.stage, instead(chosen, first)), baseline)
    stage = replace(stage, untestable=barred, laws=law.rivals, law_taken=law.words, drag_at=place.words)
    swaps = tuple(s for s in found.swaps if s.rival in stage.rivals)
    return replace(found, stage=stage, swaps=swaps, baseline=baseline, elsewhere=place.model)


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
    open_law = bool(wrong) or motion.unrepeated
    swaps = groups(found, open_law)
    jumps = find_jumps(motion, found.settled.predictions, noise_level, missed_m, len(candidates_of(best)))
    undetected = [undetected_of(f, noise_level) for f in found.undetected]
    if jumps is not None:
        (named if jumps.strength >= VISIBLE else undetected).append(jumps)
    words, divided = left_over(found, parts, mend=jumps is not None)
    divided, hiding = (None, divided.words) if divided is not None and divided.hint else (divided, "")
    unlike = ""
    alone: tuple[AtOneVertex, ...] = ()
    if words and parts is None:
        alone = at_one_vertex(found)
        words = (*words, *as_much_as_another_ratio(found), *refusals(found.refused), *words_of(alone))
    if parts is not None and (parts.told or left_over(found, None, mend=jumps is not None)[0]):
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
        words and named and not wrong and astray(motion, predicted_by(found, parts), after)
    ):  # by paths alone: few windows show less
        named = [n if n is jumps else m for n, m in zip(named, with_stand_ins(found, named, inadequate), strict=True)]
    if wrong:
        named = mending(found, named, before, after)
    if open_law:
        by_ratio = as_another_ratio(found)
        open_keys = {e.key for e in by_ratio}
        named = [replace(n, stand_in=n.stand_in or n.effect.key in open_keys) for n in named]
        words = (*words, *(f"{e.called}: {ANY_RATIO}" for e in by_ratio))
    if motion.ratio is None and chance_from(motion.tracks) == "residuals":
        named = beside_what_is_left(motion, named)
    if motion.ratio is None:
        named = beside_paths(named, after / noise_level)
    named = amid_points(motion, named)
    known = divided is not None and bool(divided.cause)  # by what repeats differ by: it is told
    asked = any(n.effect.effect.moves for n in named) or (words and not best.effects and divided is None)
    growing = grows_instead(found) if asked and not known else ""
    if growing:
        named = [replace(n, stand_in=n.stand_in or n.effect.effect.moves) for n in named]
        words = (*words, growing)
    ends = None if parts is None else ratio_beside(parts, found.settled)
    rivals, weak = tuple(s.rival for s in swaps), tuple(undetected)
    stage = Stage("motion", tuple(named), rivals, weak, after / noise_level, words, discrepancy_m=missed_m)
    stage = another_law(found, replace(stage, unlike=unlike, ratio=ends, divided=divided, hiding=hiding))
    return MotionFinding(stage, found, swaps, before, after)


def or_instead(stage: Stage, others: tuple[Rival, ...]) -> Stage:
    """With what another explanation of the reference would have in the place of a name, which is open then."""
    open_keys = {r.instead_of.key for r in others}
    named = tuple(replace(n, stand_in=n.stand_in or n.effect.key in open_keys) for n in stage.named)
    return replace(stage, named=named, rivals=(*stage.rivals, *others))


def beside_earlier(stage: Stage, baseline: Baseline) -> Stage:
    """The names of a stage, without stand-ins that may change nothing. What was known of the same effect before puts
    its value in doubt, and not that it has changed; but what stood in for another law then may do so now."""
    named = tuple(replace(n, stand_in=n.stand_in or baseline.guessed(n.effect)) for n in stage.named)
    stage = replace(stage, named=named)
    wide = {n.effect.key: beside_known(n, baseline.doubt_of(n.effect)) for n in stage.named}
    stage = stage.naming(stage.named)
    named, weak = (tuple(wide.get(n.effect.key, n) for n in some) for some in (stage.named, stage.undetected))
    return replace(stage, named=named, undetected=weak)


def undetected_of(t: Weak, noise_level_m: float) -> Named:
    """What windows show, though its trace in the path is too weak to name it."""
    return Named(t.fitted, {}, t.strength_m / noise_level_m)
