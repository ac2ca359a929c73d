"""What was so already: an earlier (healthy) campaign as the baseline of a later one.

Of the earlier campaign its own diagnosis is made first. What it names becomes part of the baseline; what it leaves is
the model's habitual error, and is taken out of the later campaign where the same gait was played at the same speed:
window by window from the motion, moment by moment from the servos' readings. What a change changes of this error is in
proportion to what the change does (inference/search/discrepancy.py); where a gait is new, all of the error is in
doubt. What explains the error is a guess where names are stand-ins: the change is fitted beside other guesses, too
(`otherwise`): eps alone, what was found and refused, and every law of the body's own that explains alone what eps does
not. It is named beside the guess that makes both campaigns likeliest, and it may be none
(inference/doubt/explanations.py).

Legend: W windows of a trial, R log rows, m joints.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.noise.motion import Motion, Repeated
from serpenoid.diagnose.data.noise.noise import residuals, window_noise
from serpenoid.diagnose.data.noise.paths import repeated
from serpenoid.diagnose.data.noise.repeats import UNLIKE, by_setting, chance_from
from serpenoid.diagnose.data.recordings.clocks import pooled
from serpenoid.diagnose.data.recordings.recording import Recording, held_as_all_told
from serpenoid.diagnose.data.windows.tracks import make_tracks
from serpenoid.diagnose.data.windows.windows import Track
from serpenoid.diagnose.diagnose import Diagnosis
from serpenoid.diagnose.inference.doubt.explanations import laws
from serpenoid.diagnose.inference.fits.finding import Named
from serpenoid.diagnose.inference.fits.medium import linearised
from serpenoid.diagnose.inference.search.select import retracked
from serpenoid.diagnose.record import record
from serpenoid.diagnose.stages.actuation.choose_set_points import plays
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.diagnose.stages.actuation.set_points import by_table
from serpenoid.diagnose.stages.baseline import Baseline, read_by_servos
from serpenoid.diagnose.stages.motion.values_of_motion import ratio_interval
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import Parameter
from serpenoid.measure.clock import bridged
from serpenoid.model import Model
from serpenoid.wording import listed

Setting = tuple[str, float]


@dataclass(frozen=True)
class Habit:
    """The model's habitual error in one setting: table (T, m) [rad], mean error and its noise (W, 3), NaN unknown; mesh
    (W, 3): what the mesh of the steps adds to it, which is not in it."""

    table: Floats
    error: Floats
    noise: Floats
    mesh: Floats

    def fits(self, track: Track) -> bool:
        """Whether the trial is of the same gait."""
        table = _played(track)
        return table.shape == self.table.shape and bool(np.abs(table - self.table).max() < 1e-3)


@dataclass(frozen=True)
class Explanation:
    """A model of the earlier campaign, and what it leaves: chi squared, and by settings."""

    model: Model
    chi2: float
    habits: dict[Setting, Habit]

    def error(self, track: Track) -> tuple[Floats, Floats]:
        """Habitual error of each window and its noise (B - 1, 3) each, NaN where nothing is known of it."""
        count = len(track.playing)
        error, noise = np.full((count, 3), np.nan), np.full((count, 3), np.nan)
        habit = self.habits.get(track.recording.setting)
        if habit is not None and habit.fits(track):
            n = min(count, len(habit.error))
            error[:n], noise[:n] = habit.error[:n], habit.noise[:n]
        return error, noise

    def with_mesh(self, track: Track) -> Floats:
        """The same error (B - 1, 3) and the mesh's: what steps on the mesh miss, whatever model its error is of."""
        error = self.error(track)[0]
        known = np.flatnonzero(np.isfinite(error).any(axis=1))
        if len(known):
            error[known] += self.habits[track.recording.setting].mesh[known]
        return error


@dataclass(frozen=True)
class Reference(Baseline):
    """seen: the earlier observation model, squares: what it left (see `Stage`); explained: the earlier motion, by the
    baseline's model and then by rivals; servos: the earlier readings and what explains them. others: effects that were
    there before, beside the motion's. missed_m: what repeats shared and nothing accounted for, RMS of a window [m].
    named: what the earlier motion was found to show; again: what its repeats tell; interval: of its eps. tracks: the
    earlier trials.
    usual, largest (3,) [m, m, rad]: RMS error of a window while playing, largest difference between two repeats'.
    """

    seen: Observation
    explained: tuple[Explanation, ...]
    usual: Floats
    largest: Floats
    servos: Plays
    missed_m: float
    squares: tuple[float, ...] = ()
    named: tuple[Named, ...] = ()
    again: Repeated = Repeated()
    interval: tuple[float, float] = (0.0, np.inf)
    tracks: tuple[Track, ...] = ()

    @property
    def earlier(self) -> Repeated:
        """Of its repeats."""
        return self.again

    @property
    def rate(self) -> tuple[float, float]:
        """As it was, where that was named."""
        named = any(e.effect.marks == "rate" for e in self.known)
        return pooled([r.clock for r in self.servos.recordings]) if named else super().rate

    @property
    def unlike(self) -> Floats:
        """Repeats differed before, and a change may make them differ more."""
        return UNLIKE * self.largest

    @property
    def ratio(self) -> float:
        """The earlier campaign's."""
        return self.model.medium.anisotropy_ratio

    def ratio_before(self, tracks: Sequence[Track]) -> tuple[float, float]:
        """The model's, where all gaits were played before: what is wrong with it is in what it left."""
        taken = self.ratio
        if all(np.isfinite(self.explained[0].error(t)[0][t.playing & t.usable]).all() for t in tracks):
            return taken, taken
        return min(taken, self.interval[0]), max(taken, self.interval[1])

    @property
    def ratio_doubt(self) -> tuple[float, float]:
        """By the earlier answer's interval: a model that predicts well may hold what is no cause, and another eps."""
        low, high = self.interval
        return min(low / self.ratio, 1.0), max(high / self.ratio, 1.0)

    def rows_held(self, recordings: Sequence[Recording]) -> bool | None:
        """As they were taken then: one player plays the robot. What readings follow best is open where clear commands
        of logs are others than then, or were goals."""
        now, then = held_as_all_told(recordings), held_as_all_told(self.servos.recordings)
        return None if self.servos.goals or (now and now != then) else self.servos.held

    @property
    def rows_said(self) -> bool:
        """By logs with clear commands, all of them."""
        return held_as_all_told(self.servos.recordings) == {self.servos.held}

    @property
    def inadequate(self) -> bool:
        """It was found to be so."""
        return self.missed_m > 0

    def doubt_of(self, effect: ActiveEffect) -> Floats:
        """What was named is known as well as its interval says, and it may not have been there at all where it was
        perhaps a stand-in; so may not what was too weak to be named."""
        taken = {e.key: e for e in self.model.effects}.get(effect.key)
        if taken is None:
            return super().doubt_of(effect)
        before, unsure = {n.effect.key: n for n in self.named}.get(effect.key), self.guessed(effect)
        return np.array([
            _off(p, p.coordinate(taken.parameters[p.name]), before.intervals[p.name] if before else (), unsure)
            for p in effect.effect.parameters
        ])  # fmt: skip

    def guessed(self, effect: ActiveEffect) -> bool:
        """It was perhaps a stand-in, or too weak to be named."""
        sure = {n.effect.key for n in self.named if not n.stand_in}
        return effect.key in {e.key for e in self.model.effects} - sure

    def observation(self) -> Observation:
        """As it was before."""
        return self.seen

    def corrected(self, tracks: Sequence[Track]) -> tuple[Track, ...]:
        """Tracks whose offset holds the habitual error. Where nothing was played twice, then or now, what a later trial
        differs by from the earlier one tells the chance of both."""
        once = chance_from(tracks) == chance_from(self.tracks) == "residuals"
        return tuple(self._corrected(t, once) for t in tracks)

    def _corrected(self, track: Track, once: bool) -> Track:
        error, noise = self.explained[0].error(track)
        unknown, noise = np.isnan(error), np.zeros_like(noise) if once else noise
        doubt = np.where(unknown, np.where(track.playing[:, None], self.usual, 0.0), noise)
        offset = track.offset + np.where(unknown, 0.0, error)
        return replace(track, offset=offset, doubt=doubt, recurs=unknown)  # what is known has the chance of one trial

    def otherwise(self, motion: Motion) -> tuple[tuple[Motion, Model, float], ...]:
        """The corrected tracks beside the rivals, where what the model missed repeated; weight: what the baseline
        left there over what the rival left."""
        if not self.inadequate:
            return ()
        found = []
        for rival in self.explained[1:]:
            changes = [rival.with_mesh(t) - self.explained[0].with_mesh(t) for t in motion.tracks]
            tracks = [
                replace(t, offset=t.offset + np.nan_to_num(c)) for t, c in zip(motion.tracks, changes, strict=True)
            ]
            found.append(
                (
                    replace(
                        motion,
                        tracks=tuple(tracks),
                        held=rival.model.effects,
                        ratio=rival.model.medium.anisotropy_ratio,
                    ),
                    rival.model,
                    self.explained[0].chi2 / rival.chi2,
                )
            )
        return tuple(found)

    def beside(self, model: Model) -> Reference:
        """With another explanation as the baseline, the others beside it."""
        explained = sorted(self.explained, key=lambda e: e.model != model)
        return replace(self, model=model, explained=tuple(explained))

    def instead(self, trial: str) -> Reference | None:
        """With what explains it best of what is left without the model, which is no explanation of shapes along which
        its steps have no root; where nothing with effects does, with eps alone."""
        left = sorted((e for e in self.explained if e.model != self.model), key=lambda e: (not e.model.effects, e.chi2))
        if not left:
            return None
        then, now = (called(m) for m in (self.model, left[0].model))
        remark = (
            f"the reference is explained by {now}, not by {then}: steps of that model have no root along the shapes of "
            f"trial `{trial}`"
        )
        return replace(self, model=left[0].model, explained=tuple(left), remarks=(*self.remarks, remark))

    def begun(self, recordings: Sequence[Recording]) -> tuple[Recording, ...]:
        """Trials whose logs do not say when they began, where their readings meet what servos did before as those of
        the same gait did then: what the model habitually misses has its moment in the cycle."""
        unsaid = {r.name: r for r in recordings if r.by_servos and not r.start_said and r.told is None}
        if not unsaid:
            return tuple(recordings)
        then, now = (self._late(some) for some in (self.servos.recordings, unsaid.values()))
        before = {r.setting: late for r, late in zip(self.servos.recordings, then, strict=True)}
        late = {name: s - before.get(r.setting, 0.0) for (name, r), s in zip(unsaid.items(), now, strict=True)}
        return tuple(r.later(late.get(r.name, 0.0)) for r in recordings)

    def _late(self, recordings: Iterable[Recording]) -> list[float]:
        """By how much later than promised [s] readings meet best what servos did then."""
        return replace(by_table(list(recordings), self.servos.held), known=self.servos.known).late([])

    def plays(self, recordings: Sequence[Recording]) -> Plays:
        """Readings with the earlier ones' error taken out: that of a gait played then is in both, and is no noise. A
        change of something else may change it by as much as it is, beyond noise; of a new gait all of it is there."""
        now, then = plays(recordings, self.rows_held(recordings)), self.servos
        left = then.readings - then.realised([])
        scattered = np.where(then.read, left**2, 0.0).sum(axis=0) / then.often
        error = np.maximum(scattered - then.noise**2, 0.0)
        habit, new = np.zeros_like(now.readings), np.ones(len(now.readings), dtype=bool)
        noisy = np.zeros(len(now.readings))  # of the earlier readings' noise squared, what is in those between them
        for number, r in enumerate(now.recordings):
            for other, earlier in enumerate(then.recordings):
                if earlier.setting == r.setting and np.array_equal(earlier.schedule.table, r.schedule.table):
                    mine, theirs = now.trials == number, then.trials == other
                    at, known = now.times[number], then.times[other]
                    habit[mine] = bridged(known, left[theirs], at)
                    later = np.interp(at, known, np.arange(len(known))) % 1
                    noisy[mine] = later**2 + (1 - later) ** 2
                    new[mine] = False
        return replace(
            now,
            without=self.without,
            known=then.known,
            habit=habit,
            noise=np.sqrt(now.noise**2 + noisy.mean() * then.noise**2 + new.mean() * error),
            unsure=np.sqrt(error),
        )


def _off(p: Parameter, taken: float, ends: Sequence[float | None], unsure: bool) -> tuple[float, float]:
    """From a coordinate as it is taken to the least and the most it may be: in an interval, and nothing if unsure."""
    every = [p.coordinate(np.inf if end is None else end) for end in ends]
    every += [p.resting] if unsure and p.neutral is not None else []
    return min([0.0, *(x - taken for x in every)]), max([0.0, *(x - taken for x in every)])


def reference_of(d: Diagnosis) -> Reference:
    """From the diagnosis of the earlier campaign."""
    found = d.motion.selection
    motion, model = found.motion, d.extension.model
    own = about(d, model)
    errors = _left(own, model)
    playing = np.concatenate([e[t.playing] for t, e in zip(motion.tracks, errors, strict=True)])
    mine = {e.key for e in model.effects}
    others = tuple(n.effect for n in d.named if n.effect.key not in mine)
    read = [t.recording for t in motion.tracks if isinstance(t.recording, Recording)]
    servos = replace(as_taken(read), known=read_by_servos(others))
    usual = np.sqrt(np.nanmean(playing**2, axis=0))
    largest = np.abs(window_noise(motion.tracks, errors)[1]).max(axis=0, initial=0.0)
    wrong = d.motion.stage.discrepancy_m
    guesses = laws(found) if wrong else []
    rivals = [f.model for f in (found.null, found.settled, *(r.fit for r in found.refused), *guesses)]
    about_each = {model: own} | {rival: about(d, rival) for rival in dict.fromkeys(rivals) if rival != model}
    explained = [_explanation(there, explanation) for explanation, there in about_each.items()]
    return Reference(
        model, d.seen, tuple(explained), usual, largest, servos, wrong, d.stages[1].squares,
        d.motion.stage.named, repeated(motion, found.settled.predictions), ratio_interval(found, d.motion.stage),
        motion.tracks, others=others, without=d.baseline.without,
    )  # fmt: skip


def as_taken(recordings: Sequence[Recording]) -> Plays:
    """Readings beside rows as they were taken in the answer: beside films whose clocks are laid again, readings may
    tell otherwise."""
    return plays(recordings, recordings[0].schedule.held)


def about(d: Diagnosis, model: Model) -> Motion:
    """The earlier motion on tracks about a model: what the mesh misses is that of the model. As it is of animals."""
    motion = d.motion.selection.motion
    recordings = [t.recording for t in motion.tracks if isinstance(t.recording, Recording)]
    if len(recordings) < len(motion.tracks):
        return motion
    again = retracked(motion, lambda other: make_tracks(recordings, d.seen, other), model)
    shifted = [replace(t, shifted=own.shifted) for t, own in zip(again.tracks, motion.tracks, strict=True)]
    return replace(again, tracks=tuple(shifted))


def _explanation(motion: Motion, model: Model) -> Explanation:
    errors = _left(motion, model)
    white = [w.of(e, np.asarray(np.isfinite(e).all(axis=1))) for w, e in zip(motion.white, errors, strict=True)]
    chi2 = sum(float((x**2).sum()) for x in white)
    return Explanation(model, chi2, _habits(motion, errors))


def _left(motion: Motion, model: Model) -> list[Floats]:
    return residuals(motion.tracks, linearised(motion, model, model.effects)[1])


def _habits(motion: Motion, errors: Sequence[Floats]) -> dict[Setting, Habit]:
    return {setting: _habit(motion, errors, trials) for setting, trials in by_setting(motion.tracks).items()}


def _habit(motion: Motion, errors: Sequence[Floats], trials: Sequence[int]) -> Habit:
    """Mean over the trials of one setting."""
    count = min(len(errors[i]) for i in trials)
    own = np.stack([errors[i][:count] for i in trials])
    times = np.isfinite(own).sum(axis=0)
    mean = np.where(times > 0, np.nansum(own, axis=0) / np.maximum(times, 1), np.nan)
    first = motion.tracks[trials[0]]
    noise = motion.noise.of(first)[:count] / np.sqrt(np.maximum(times, 1))
    mesh = np.mean([motion.tracks[i].offset[:count] for i in trials], axis=0)
    return Habit(_played(first), *in_other_cycles(mean, noise, first.phase[:count]), mesh)


def in_other_cycles(mean: Floats, noise: Floats, phase: Floats) -> tuple[Floats, Floats]:
    """Errors (W, 3) and noise; where a window was not seen, the mean over the cycles in which its phase was.

    How far windows of one phase differ from their mean, of all phases together, is what that is in doubt by.
    """
    mean, noise, here = mean.copy(), noise.copy(), [phase == p for p in np.unique(phase)]
    seen = [mean[at][np.isfinite(mean[at]).all(axis=1)] for at in here]
    freedom = sum(len(x) - 1 for x in seen if len(x))
    if not freedom:
        return mean, noise
    scatter = np.sqrt(sum(((x - x.mean(axis=0)) ** 2).sum(axis=0) for x in seen if len(x)) / freedom)
    for at, known in zip(here, seen, strict=True):
        unknown = at & ~np.isfinite(mean).all(axis=1)
        if len(known):
            mean[unknown], noise[unknown] = known.mean(axis=0), scatter * np.sqrt(1 + 1 / len(known))
    return mean, noise


def _played(track: Track) -> Floats:
    """The joint table of a trial; empty where there is none."""
    return track.recording.schedule.table if isinstance(track.recording, Recording) else np.empty((0, 0))


def called(model: Model) -> str:
    """What explains a reference, in words."""
    return listed([f"`{e.called}`" for e in model.effects]) if model.effects else "eps alone"


KEPT = (
    "verdict", "effects", "alternatives", "anisotropy_ratio", "law", "gain", "noise_level_m",
    "noise_over_markers", "left", "residual_pattern",
)  # fmt: skip


def summary(d: Diagnosis) -> dict[str, Any]:
    """What the later diagnosis reports about the earlier campaign; eps is that of the extended model, which the later
    one begins from, and no better known than that and what is named tell; `answer`: as the earlier answer has it."""
    said = record(d)
    own = said["anisotropy_ratio"]
    eps, (low, high) = d.model.medium.anisotropy_ratio, own["interval"]
    ratio = {"after": eps, "interval": [min(low, eps), max(high, eps)]}
    ratio |= {"answer": {"value": own["after"], "interval": own["interval"]}}
    return {key: said[key] for key in KEPT} | {"anisotropy_ratio": own | ratio}
