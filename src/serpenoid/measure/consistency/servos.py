"""A promise as servos that are late or slow keep it: the laws of the catalogue that all servos may have at once.

No servo moves before it is told, and what is told last is done last: such servos make more of a short recording, and
other corners. So where a rival is ahead, promise and rival are laid anew as each such law of one number plays them, the
number where the evidence is best.

Legend: G grid points, m joints.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import ActuationEffect
from serpenoid.effects.catalogue import actuation_effects
from serpenoid.measure.cells import Floats
from serpenoid.measure.clock import held
from serpenoid.measure.consistency.match import DAMAGED, Course, Match, Prior, match, match_at
from serpenoid.measure.consistency.signals import Sampled
from serpenoid.simulation.servos import coordinates_of, played_from_rest

POINTS = 100  # in a period, at which set-points are played
AFTER = 1.0  # periods after the end in which what was told last is still being done
OCTAVES = 2  # on either side of where a law's own fits begin
HALVINGS = 4  # of the step, an octave, between the numbers that are tried


def with_servos(signal: Sampled, found: Match, prior: Prior) -> Match:
    """The same course as the likeliest law of all servos plays it, where that is likelier than a law's prior asks."""
    if not (found.course.told and prior.damage):  # commands are compared, or what servos did
        return found
    every = [kind for kind in actuation_effects() if kind.place is None and kind.memory and kind.shown]
    laws = [kind for kind in every if len(kind.parameters) == 1]
    price = float(np.log(DAMAGED / max(len(laws), 1)))
    likeliest = [_likeliest(signal, found, law, prior) for law in laws]
    return max([found, *(replace(m, evidence=m.evidence + price) for m in likeliest)], key=lambda m: m.evidence)


def _likeliest(signal: Sampled, found: Match, law: ActuationEffect, prior: Prior) -> Match:
    """A course as one law plays it, its coordinate by halving steps about the best of where fits begin."""
    course = found.course.slowed(1 / found.rate)
    told = course.angles(_times(course))
    quickest = np.abs(np.diff(told, axis=0)).max(axis=0) * POINTS / course.period_s
    begun = np.unique([float(np.max(start)) for start in law.starts(told, quickest)])
    tried: list[tuple[float, float, Course]] = []

    def best(coordinates: Floats) -> tuple[float, float, Course]:
        for x, made in zip(coordinates, played(course, law, coordinates), strict=True):
            tried.append((match_at(signal, made, found.rate, prior).evidence, float(x), made))
        return max(tried, key=lambda one: one[0])

    now = best(np.unique(np.outer(begun, 2.0 ** np.arange(-OCTAVES, OCTAVES + 1))))
    for halving in range(1, HALVINGS + 1):
        now = best(now[1] * 2.0 ** (np.array([-1, 1]) * 0.5**halving))
    return match(signal, now[2], prior)


def played(course: Course, law: ActuationEffect, coordinates: Floats) -> list[Course]:
    """What servos with this law make of a course, for each of its coordinates; held beyond what is played."""
    at = _times(course)
    told = course.angles(at)
    laws = [[ActiveEffect.neutral(law.name).with_coordinates([float(x)])] for x in coordinates]
    theta = np.hstack([coordinates_of(one, told.shape[1]) for one in laws])
    done = np.split(played_from_rest(theta, np.tile(told, len(laws)), np.diff(at)), len(laws), axis=1)
    return [replace(course, angles=partial(held, at, angles)) for angles in done]


def _times(course: Course) -> Floats:
    end = course.total_s + AFTER * course.period_s
    return np.linspace(0.0, end, int(POINTS * end / course.period_s) + 1)
