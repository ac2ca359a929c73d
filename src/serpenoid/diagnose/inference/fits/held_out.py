"""What a fit is worth on gaits that it has not seen: to first order from the joint fit, or by fitting to the others.

The first is quick, and right where data are many and the model nearly so. One short recording that no model follows is
neither: there a parameter may run far without one of the parts.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import SYSTEMATIC
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.paths import strays, total
from serpenoid.diagnose.data.windows.windows import Prediction, columns_of
from serpenoid.diagnose.inference.fits.bounds import at_values
from serpenoid.diagnose.inference.fits.evidence import SILENT, Evidence
from serpenoid.diagnose.inference.fits.medium import Fit, fit, linearised, with_values
from serpenoid.parallel import in_processes, limited
from serpenoid.simulation.sensitivity import EPS

LeaveOut = Callable[[Motion, Fit, int], Floats]


def first_order(motion: Motion, found: Fit, label: int) -> Floats:
    """Coordinates of a fit to all gaits but one: one step from the joint fit."""
    labels = sorted(set(motion.labels))
    if len(labels) == 1:
        return found.coordinates
    values, _ = found.evidence.solve(range(len(found.coordinates)), without=labels.index(label))
    return found.coordinates + values


def fitted_again(motion: Motion, found: Fit, label: int) -> Floats:
    """The same by a fit to the others; where there are none, what is fitted is not held out."""
    others = [i for i, own in enumerate(motion.labels) if own != label]
    if not others:
        return found.coordinates
    near = [found.predictions[i] for i in others]
    return fit(part(motion, others), found.model, list(found.effects), found.coordinates, near=near).coordinates


def part(motion: Motion, index: list[int]) -> Motion:
    """Some of the tracks, as one gait each has them."""
    return replace(motion, tracks=tuple(motion.tracks[i] for i in index), labels=tuple(motion.labels[i] for i in index))


@dataclass(frozen=True)
class Unseen:
    """What is held out together: indices of the tracks, evidence and predictions of a fit without them."""

    index: list[int]
    evidence: Evidence
    predictions: tuple[Prediction, ...]


def each_held_out(motion: Motion, found: Fit, leave_out: LeaveOut) -> list[Unseen]:
    """Everything that is held out, part by part."""
    tasks = [(_unseen, (motion, found, leave_out, label)) for label in sorted(set(motion.labels))]
    with limited(1) if leave_out is first_order else nullcontext():  # in less time than it takes to fork a process
        return in_processes(tasks)


def _unseen(motion: Motion, found: Fit, leave_out: LeaveOut, label: int) -> Unseen:
    effects = list(found.effects)
    index = [i for i, own in enumerate(motion.labels) if own == label]
    model = with_values(found.model, effects, leave_out(motion, found, label), motion.held)
    near = [found.predictions[i] for i in index]
    evidence, predictions = linearised(part(motion, index), model, effects, near=near)
    return Unseen(index, evidence, predictions)


def fails(before: float, after: float, noise_level: float, open_m: float) -> bool:
    """Whether names make held-out paths stray farther [m], by more than noise and what other gaits leave open."""
    return after > hypot(before, noise_level, open_m)


def left_open(motion: Motion, found: Fit) -> Floats:
    """Path RMS [m] of every trial by which a fit without its gait is expected to be off, to first order, on top of the
    noise level: what the other gaits leave open of eps and the effects."""
    labels, evidence = sorted(set(motion.labels)), found.evidence
    if len(labels) == 1:
        return np.zeros(len(motion.tracks))
    told = [i for i in range(len(found.coordinates)) if evidence.matrix[:, i, i].sum() > SILENT]
    columns = [EPS, *columns_of(at_values(found.model, found.effects))]
    spread = SYSTEMATIC * max(1.0, np.sqrt(found.chi2 / evidence.count.sum()))
    squares = []
    for track, label, p in zip(motion.tracks, motion.labels, found.predictions, strict=True):
        covariance = evidence.solve(told, without=labels.index(label))[1]
        by = p.by([columns[i] for i in told])
        squares.append(strays(track, p.displacement, by @ np.linalg.cholesky(covariance) * spread))
    return np.sqrt(squares)


def of_each_gait(motion: Motion, values: Floats) -> dict[str, float]:
    """RMS of the values of its trials, by the gait's name; none where something else than gaits is held out."""
    gaits = [t.recording.gait for t in motion.tracks]
    if not len(set(gaits)) == len(set(motion.labels)) == len(set(zip(gaits, motion.labels, strict=True))) > 1:
        return {}
    return {name: total(values[[own == name for own in gaits]]) for name in dict.fromkeys(gaits)}


def held_out(motion: Motion, found: Fit, leave_out: LeaveOut = first_order) -> list[Prediction]:
    """Every trial predicted with parameters fitted to the other gaits."""
    parts = each_held_out(motion, found, leave_out)
    by_track = {i: p for u in parts for i, p in zip(u.index, u.predictions, strict=True)}
    return [by_track[i] for i in range(len(motion.tracks))]
