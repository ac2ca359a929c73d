"""The whole diagnosis: three stages from command to motion, a verdict, and what it rests on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from serpenoid.diagnose.data.cameras.columns import all_keys
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.noise.paths import path_error, total
from serpenoid.diagnose.data.recordings.markers_by_trial import put_back
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.recordings.relaid import bent_by
from serpenoid.diagnose.data.tracked import TrackedRecording
from serpenoid.diagnose.data.windows.windows import Prediction
from serpenoid.diagnose.inference.doubt.together import laws_together
from serpenoid.diagnose.inference.fits.finding import Divided, Named, Rival, Stage
from serpenoid.diagnose.inference.fits.held_out import LeaveOut, first_order, fitted_again, held_out
from serpenoid.diagnose.inference.fits.medium import Fit
from serpenoid.diagnose.inference.search.tries import unclear
from serpenoid.diagnose.residuals.gain import Scores, scores
from serpenoid.diagnose.stages.actuation.expected import carried
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.ladder import Climbed, Step, motion_step, motion_steps, shape_steps
from serpenoid.diagnose.stages.motion.borne_out import beside_another_ratio, borne_out
from serpenoid.diagnose.stages.motion.choose_motion import MotionFinding, Searched, choose_motion
from serpenoid.diagnose.stages.motion.choose_tracked import choose_tracked
from serpenoid.diagnose.stages.motion.ratio_change import RatioChange, ratio_changed
from serpenoid.diagnose.stages.motion.refuted import shapes_believed
from serpenoid.diagnose.stages.observation.beside_markers import no_larger
from serpenoid.diagnose.stages.observation.choose_observation import choose_observation
from serpenoid.diagnose.stages.observation.laid_beside import laid_beside, of_play
from serpenoid.diagnose.stages.observation.witness import of_servos
from serpenoid.model import Model

if TYPE_CHECKING:
    from serpenoid.diagnose.changed_trials import ChangedTrials

RELAID = 3  # a clock that play has drawn aside by 1 ms is off by 0.05 ms after the first
NO_LOG = "no servo log: shapes are what the points show"


@dataclass(frozen=True)
class DragRatio:
    """K of an animal and its 95 % interval; by_frames: as `fit` has it, else 1 / eps of the answer's windows."""

    value: float
    low: float
    high: float
    by_frames: bool

    @property
    def told(self) -> float | None:
        """The value, if the data determine it."""
        return self.value if np.isfinite(self.value) else None


@dataclass(frozen=True)
class Diagnosis:
    """Verdict, stages from top to bottom, the motion's evidence, and scores on held-out gaits before and after.

    held_out: every trial predicted by a fit to the other gaits, baseline and extended.
    baseline: what was taken for granted; seen: the observation model; extension: the fit that the extended model takes
    over, with what is too weak to be named where paths of held-out gaits need it. drag_ratio: of an animal, K if the
    law of the answer is all there is. changed: trials in which something acts alone, if it does. grows: of such trials,
    how much it may differ among them (`Divided.grows`).
    """

    verdict: str
    baseline: Baseline
    seen: Observation
    stages: tuple[Stage, ...]
    motion: MotionFinding
    extension: Fit
    before: Scores
    after: Scores
    held_out: tuple[tuple[Prediction, ...], tuple[Prediction, ...]]
    ladder: tuple[Step, ...]
    drag_ratio: DragRatio | None = None
    ratio_change: RatioChange | None = None
    changed: ChangedTrials | None = None
    grows: float = 0.0

    @property
    def divided(self) -> Divided | None:
        """Which trials something acts in alone, by the first stage that tells."""
        return next((s.divided for s in self.stages if s.divided is not None and s.divided.changed), None)

    @property
    def named(self) -> tuple[Named, ...]:
        """All effects named."""
        return tuple(n for stage in self.stages for n in stage.named)

    @property
    def rivals(self) -> tuple[Rival, ...]:
        """What cannot be told apart from them."""
        return tuple(r for stage in self.stages for r in stage.rivals)

    @property
    def words(self) -> tuple[str, ...]:
        """What is left above chance."""
        return tuple(f"{stage.name}: {w}" for stage in self.stages for w in stage.words)

    @property
    def model(self) -> Model:
        """The extended model: what was known before, what the motion's fit found, and what the upper stages did."""
        fitted = self.extension.model
        named = (e for stage in self.stages for e in stage.acting)
        every = {e.key: e for e in (*self.baseline.known, *named, *fitted.effects, *self.extension.effects)}
        gone = {e.key for stage in self.stages for e in stage.gone}
        return Model(fitted.body, fitted.medium, tuple(e for key, e in every.items() if key not in gone))


def diagnose(
    recordings: Sequence[Recording],
    baseline: Baseline,
    say: Callable[[str], None],
    searched: Searched = lambda found: None,
    climbed: Climbed = lambda steps: None,
) -> Diagnosis:
    """From recordings to a verdict on what is new beside the baseline."""
    say("command against shape")
    recordings, servos, actuation = of_servos(baseline.begun(recordings), baseline)
    recordings = carried(recordings, servos, [*actuation.acting, *(n.effect for n in actuation.undetected)])
    say("shape against markers")
    observation, seen = Stage("observation", left=np.nan, skipped=NO_LOG), Observation.neutral(baseline.model.body)
    if all(r.by_servos for r in recordings):
        observation, seen, recordings = _seen(recordings, baseline)
    steps = shape_steps(servos, recordings, actuation, observation, seen)
    climbed(steps)
    say("shape against motion")
    believed = shapes_believed(recordings, seen, observation, baseline)
    words = (*observation.words, *filter(None, [believed.words]))
    observation = replace(observation, words=words, named=(*observation.named, *believed.named))
    shown = put_back(believed.recordings, believed.seen, observation.each)
    motion = choose_motion(shown, believed.seen, baseline, say, searched)
    baseline = motion.baseline or baseline
    motion = beside_changes(motion, (actuation, observation), baseline, seen)
    stages = (actuation, observation, motion.stage)
    steps += motion_steps(servos, recordings, stages, seen, motion)
    return concluded(baseline, seen, stages, motion, steps, say)


def _seen(recordings: Sequence[Recording], baseline: Baseline) -> tuple[Stage, Observation, tuple[Recording, ...]]:
    """The stage of observation, by clocks that are laid over each other again beside what it finds; where something is
    left, also by clocks that are laid beside play at every joint, if that leaves less."""
    found = _by_clocks(recordings, baseline)
    play = of_play(recordings, baseline.without)
    if found[0].settled or not play:
        return found
    again, moved = laid_beside(recordings, baseline.observation(), play)
    other = _by_clocks(again, baseline) if moved else found
    return other if other[0].left < found[0].left else found


def _by_clocks(recordings: Sequence[Recording], baseline: Baseline) -> tuple[Stage, Observation, tuple[Recording, ...]]:
    """The same, from these clocks on."""
    every, known = set(all_keys(recordings[0].body)), baseline.observation()
    recordings, _ = bent_by(recordings, known)
    for _ in range(RELAID):
        stage, seen = choose_observation(recordings, known, baseline.without, baseline.squares, baseline.rate)
        if not seen.corrects:
            break
        keys = [n.effect.key for n in (*stage.named, *stage.undetected) if n.effect.key in every]
        again, moved = laid_beside(recordings, known, keys)
        again, bent = bent_by(again, seen)
        if not (moved or bent):
            break
        recordings = again
    return stage, seen, tuple(recordings)


def beside_changes(
    found: MotionFinding, above: Sequence[Stage], baseline: Baseline, seen: Observation
) -> MotionFinding:
    """Names of the floor beside what the stages above name, and leave. What markers show by a law that is not known,
    poses and lengths show, too: names of the floor may stand for it, and for what nothing explains if they do no more.
    With a reference, beside a change of the body's shapes, they may mend the law about it, where that is known to be
    wrong, as they may beside a larger one of the floor."""
    named = [n for stage in above for n in stage.named]
    unknown = any(n.stand_in and n.effect.effect.site == "observation" for n in named)
    unknown = unknown or any(stage.mend and not stage.settled for stage in above)
    shapes = any(n.effect.effect.site == "actuation" for n in named)
    wrong = baseline.inadequate or found.stage.discrepancy_m > 0
    every = unknown or (baseline.ratio is not None and shapes and wrong)
    small = [key for s in above if any(s.news) for key in no_larger(found.selection, seen, s.news)]
    doubted = tuple(_stand_in(n) if every or n.effect.key in small else n for n in found.stage.named)
    stage = replace(found.stage, named=doubted)
    return replace(found, stage=_undivided(stage) if above[0].mend else stage)


def _undivided(stage: Stage) -> Stage:
    """Without trials in which something acts alone: where a marker is off its place, repeats in which it is hidden in
    other frames differ by that."""
    told = stage.divided.words if stage.divided is not None else ""
    return replace(stage, divided=None, hiding="", words=tuple(w for w in stage.words if w != told))


def _stand_in(named: Named) -> Named:
    """What is named of the floor is perhaps a stand-in."""
    return replace(named, stand_in=named.stand_in or named.effect.effect.site == "medium")


def diagnose_tracked(
    recordings: Sequence[TrackedRecording],
    baseline: Baseline,
    say: Callable[[str], None],
    searched: Searched,
) -> Diagnosis:
    """The same where there are tracked points alone: the stage of motion, and why the others are skipped."""
    actuation = Stage("actuation", left=np.nan, skipped="no servo log and no joint table: nothing was commanded")
    observation = Stage("observation", left=np.nan, skipped=NO_LOG)
    say("shape against motion")
    motion = choose_tracked(recordings, baseline, say, searched)
    stages = (actuation, observation, motion.stage)
    return concluded(baseline, baseline.observation(), stages, motion, (motion_step(motion),), say, fitted_again)


def concluded(
    baseline: Baseline,
    seen: Observation,
    stages: tuple[Stage, ...],
    motion: MotionFinding,
    ladder: tuple[Step, ...],
    say: Callable[[str], None],
    leave_out: LeaveOut = first_order,
) -> Diagnosis:
    """The verdict of three stages, and the gain."""
    say("gain on held-out gaits")
    found = motion.selection
    jumps = any(n.effect.effect.marks == "jumps" for n in motion.stage.named)
    if unclear(found.best):
        leave_out = fitted_again  # to first order fits are alike with and without a gait where little is left
    predicted = tuple(held_out(found.motion, found.null, leave_out))
    extension, better = found.best, tuple(held_out(found.motion, found.best, leave_out))
    extensions = found.extensions if any(stage.named for stage in stages) else ()
    bare = () if motion.stage.named else (found.null,)
    for other in filter(None, (*extensions, *bare, laws_together(found))):
        unseen = tuple(held_out(found.motion, other, leave_out))
        if path_error(found.motion, unseen, jumps) < path_error(found.motion, better, jumps):
            extension, better = other, unseen
    before, after = scores(found.motion, predicted), scores(found.motion, better, jumps)
    motion = borne_out(motion, extension, before, after)
    changed = ratio_changed(motion, baseline)
    strays = min(total(before.path), total(after.path))
    alone, motion = motion, beside_another_ratio(motion, changed, extension, strays)
    if motion is not alone:  # beside what is left, gaits must agree about it
        changed = ratio_changed(motion, baseline)
    stages = (*stages[:-1], motion.stage)
    return Diagnosis(
        verdict(stages, changed is not None), baseline, seen, stages, motion, extension, before, after,
        (predicted, better), ladder, ratio_change=changed,
    )  # fmt: skip


def verdict(stages: Sequence[Stage], changed: bool = False) -> str:
    """One of four: only what has no structure left on any stage is explained, and not by names that stand for what
    servos do, or markers show, by another law. changed: whether eps is another than in the reference."""
    named = any(stage.named for stage in stages)
    partly = any(n.stand_in and n.effect.effect.site != "medium" for stage in stages for n in stage.named)
    settled = all(stage.settled for stage in stages) and not partly
    if settled:
        return "explained" if named or changed else "nothing"
    return "partly explained" if named else "unexplained"
