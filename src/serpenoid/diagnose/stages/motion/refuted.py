"""Which shapes the motion is judged by where markers refute what servos read.

Where markers show a joint bent otherwise than its servo reads, and no effect of observation says why, one of the two
is wrong: the reading (a link that bends, a horn that slips) or the marker (it moves on the body). The motion is a
third witness: the shapes by which the model of what is known misses less of it, eps fitted, are those that it is
judged by. Where that is what markers show, there is nothing between joint and marker: their zeros and gaps are in it.

Legend: F frames, m joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.noise.noise import residuals
from serpenoid.diagnose.data.recordings.recording import Recording, held_out_labels
from serpenoid.diagnose.data.shapes.geometry import way
from serpenoid.diagnose.data.windows.tracks import NoPath, tracker
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR
from serpenoid.diagnose.inference.fits.finding import VISIBLE, Named, Stage
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.motion.choose_motion import eps_alone, with_a_path
from serpenoid.diagnose.stages.observation.beyond_readings import Beyond, beyond
from serpenoid.diagnose.stages.observation.elastic import elastic
from serpenoid.diagnose.stages.observation.play_under_load import play_under_load
from serpenoid.files.store import remembered
from serpenoid.measure.clock import bridged
from serpenoid.measure.shapes.links import marker_angles
from serpenoid.wording import listed

GIVES = "look for what gives way between servo and link, as a horn or an elastic part does"
MOVES = "look for markers there that move on the body"


@dataclass(frozen=True)
class Believed:
    """Recordings and the observation model that the motion is judged by, and what is said of shapes that are in doubt,
    empty where none are; named: what gives way at joints at which markers are believed."""

    recordings: tuple[Recording, ...]
    seen: Observation
    words: str = ""
    named: tuple[Named, ...] = ()


def shapes_believed(
    recordings: Sequence[Recording], seen: Observation, observation: Stage, baseline: Baseline
) -> Believed:
    """By readings, or by markers at joints at which these refute the readings: by what misses less of the motion."""
    read = Believed(tuple(recordings), seen)
    joints = refuted(observation, recordings[0].body.joint_count)
    if not joints or any(never_shown(r, joints) for r in recordings):
        return read
    trials = [beyond(r, seen) for r in recordings]
    shown = by_markers(trials, seen, joints)
    try:
        (by_readings, by_shown), _ = with_a_path(baseline, lambda known: (missed(read, known), missed(shown, known)))
    except NoPath:
        return read
    which = f"joint{'s' if len(joints) > 1 else ''} {listed([str(j + 1) for j in joints])}"
    off = f"a window is off by {1e3 * by_shown:.3g} mm by what markers show, by {1e3 * by_readings:.3g} mm by readings"
    if by_readings <= by_shown:
        clear = by_readings < (1 - LAW_ERROR) * by_shown
        return replace(read, words=f"motion sides with the readings at {which}: {off}; {MOVES}") if clear else read
    loose = play_under_load(trials, joints, baseline.without)
    others = [j for j in joints if j + 1 not in {n.effect.place for n in loose}]
    springy = elastic(trials, shown.recordings, seen, others)
    clear = by_shown < (1 - LAW_ERROR) * by_readings
    sides = "motion sides with the markers" if clear else "motion is judged by the bend that markers show"
    gives = [GIVES] if clear and not loose and not springy else []
    words = "; ".join([f"{sides} at {which}: {off}", *_have_play(loose), *_are_elastic(springy), *gives])
    return replace(shown, words=words, named=loose)


def _are_elastic(joints: Sequence[tuple[int, float]]) -> list[str]:
    """What is said of joints that give way in proportion to load, if any do, and what of it load does not make."""
    if not joints:
        return []
    which, least = listed([str(joint + 1) for joint, _ in joints]), max(share for _, share in joints)
    if len(joints) == 1:
        return [f"joint {which} gives way in proportion to the torque that drag makes there, but for {least:.0%}: look "
                "for an elastic link, horn or bracket"]  # fmt: skip
    return [f"joints {which} give way in proportion to the torques that drag makes there, but for {least:.0%} at most: "
            "look for elastic links, horns or brackets"]  # fmt: skip


def _have_play(named: Sequence[Named]) -> list[str]:
    """What is said of joints with play under load, if any have it."""
    if not named:
        return []
    places = listed([str(n.effect.place) for n in named])
    if len(named) == 1:
        return [f"joint {places} has play, and load decides at which end of its gap the link lies"]
    return [f"joints {places} have play, and load decides at which ends of their gaps the links lie"]


def refuted(observation: Stage, joints: int) -> list[int]:
    """Joints (from 0) that are visibly bent otherwise than readings say, beside everything that is named."""
    squares = np.array(observation.squares[:joints])
    return [int(j) for j in np.flatnonzero(squares > 1 + VISIBLE**2)] if not observation.settled else []


def never_shown(r: Recording, joints: Sequence[int]) -> bool:
    """Whether markers of one of these joints are never seen together."""
    return not np.isfinite(marker_angles(r.body, r.markers)[:, list(joints)]).any(axis=0).all()


def by_markers(trials: Sequence[Beyond], seen: Observation, joints: Sequence[int]) -> Believed:
    """Bends of these joints as markers show them: nothing is between the two any more."""
    zeros, gaps = seen.zeros.copy(), seen.gaps.copy()
    zeros[list(joints)] = gaps[list(joints)] = 0.0
    shown = tuple(replace(t.recording, shown=bends(t, joints)) for t in trials)
    return Believed(shown, replace(seen, zeros=zeros, gaps=gaps))


def bends(trial: Beyond, joints: Sequence[int]) -> Floats:
    """Angles (F, m) [rad] by which markers show these joints bent on each frame: what an observation model says, and
    what it leaves of the markers' angles, on straight lines while they are hidden; NaN of other joints."""
    found = np.full(trial.told.shape, np.nan)
    some = list(joints)
    found[:, some] = trial.told[:, some] + bridged(trial.recording.time, trial.shown[:, some])
    return found


@remembered
def missed(by: Believed, baseline: Baseline) -> float:
    """RMS [m] of what the model of what is known misses of a window's way, with eps fitted. Raises NoPath where it has
    no path along these shapes."""
    motion, fit = eps_alone(tracker(by.recordings, by.seen), held_out_labels(by.recordings), baseline, None)
    squares = np.concatenate(residuals(motion.tracks, fit.predictions)) ** 2
    return way(by.recordings[0].body, np.nanmean(squares, axis=0))
