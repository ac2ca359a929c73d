"""Whether gaits bear out what others name, where nothing was played twice: a push in one trial is a law there, too.

Noise is then what a model leaves, and a name that mends the one trial in which something happened leaves little. It
fails where the gait is predicted from the others. A change of eps, which all gaits show, may make up for another one:
each gait for itself, and then the others do not predict it, however often they were played.
"""

from __future__ import annotations

from dataclasses import replace

from serpenoid.diagnose.data.noise.paths import path_noise, total
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR
from serpenoid.diagnose.inference.fits.held_out import fails, left_open
from serpenoid.diagnose.inference.fits.medium import Fit
from serpenoid.diagnose.residuals.gain import Scores
from serpenoid.diagnose.stages.motion.choose_motion import MotionFinding
from serpenoid.diagnose.stages.motion.ratio_change import RatioChange
from serpenoid.diagnose.stages.motion.stand_ins import beyond_markers

ANOTHER_RATIO = (
    "nothing was played twice, and another anisotropy ratio, which mends most, leaves more than a third of what it "
    "does: it may make up for another change"
)
NOT_OF_ALL = (
    "another anisotropy ratio, fitted to the other gaits, leaves paths of a gait off by more than noise and what those "
    "leave open: it may make up for another change"
)
NOT_BORNE_OUT = (
    "nothing was played twice, and what is named does not carry over to other gaits: it may be what happened in one "
    "trial"
)


def borne_out(found: MotionFinding, extension: Fit, before: Scores, after: Scores) -> MotionFinding:
    """What is named of the floor; a stand-in, and words for what is left, where held-out paths go astray by it and
    nothing was played twice."""
    motion = found.selection.motion
    if not motion.unrepeated or not found.stage.named:
        return found
    open_m = total(left_open(motion, extension))
    if not fails(total(before.path), total(after.path), found.selection.noise_level_m, open_m):
        return found
    named = tuple(replace(n, stand_in=n.stand_in or n.effect.effect.moves) for n in found.stage.named)
    return replace(found, stage=replace(found.stage, named=named, words=(*found.stage.words, NOT_BORNE_OUT)))


def beside_another_ratio(
    found: MotionFinding, changed: RatioChange | None, extension: Fit, held_out_m: float
) -> MotionFinding:
    """With words for what is left beside a change of eps that may make up for another. Where nothing was played twice:
    what is left beyond the markers' noise, if eps does less than 1 / LAW_ERROR times as much. Where nothing is named:
    if held-out paths are off by `held_out_m` [m], the less of what the fit and its extension leave, and that is more
    than noise, at most, and what the other gaits leave open."""
    motion, words = found.selection.motion, []
    if changed is None:
        return found
    if motion.unrepeated and LAW_ERROR * changed.strength < beyond_markers(motion):
        words.append(ANOTHER_RATIO)
    if not found.stage.named:
        noise = path_noise(motion, extension.predictions)
        if fails(0.0, held_out_m, noise.farthest * found.selection.noise_level_m, total(left_open(motion, extension))):
            words.append(NOT_OF_ALL)
    if not words:
        return found
    return replace(found, stage=replace(found.stage, words=(*found.stage.words, *words)))
