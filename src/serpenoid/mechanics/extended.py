"""The step's residual with effects: one vertex as symbols.

    residual(g_0, g_1) = drag + dt (c_0 P + c_1 P_1 + c_2 P_2) = 0        (3 equations: force, moment about the origin)

drag: the wrench that the floor opposes to the step, less what pushes; P, P_1, P_2: momentum of this step and of the two
before it, with the coefficients of the backward difference (BDF2). Without effects the residual is the gradient of the
step energy, so the roots are those of the baseline. Poses and wrenches are in the frame of the floor, dimensionless
(body length, total weight 1, one step); effects see metres and seconds: this file is the edge. Poses and moments are
about an origin near the body, given with the setting: far from home a moment about home would lose digits.

The function holds every medium effect of the catalogue, neutral unless its coordinates say otherwise: one library for
all extended models, and derivatives by effects that a model does not have (`vertices` sums over a body and its steps).
Most models lack what is costly: Newton's method takes a third to an eighth of the time with functions that hold less
(`held_for`).
Legend: M elements, P coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import lru_cache
from typing import TypeVar

import casadi as ca
import numpy as np

from serpenoid.effects.base import MediumEffect
from serpenoid.effects.catalogue import medium_effects
from serpenoid.effects.element import Drag, Element, cross
from serpenoid.mechanics.energy import move, planar_rotation, softening_length
from serpenoid.mechanics.functions import CSE
from serpenoid.mechanics.kinematics import unit_edges
from serpenoid.media import LAWS, Law

SETTING = 6  # body length [m], duration [s] of the step, its middle [s since the start], origin (x, y), softening
Kinds = tuple[MediumEffect, ...]
T = TypeVar("T", Element, Drag)


def coordinate_count(kinds: Kinds) -> int:
    """P: the parameters' coordinates and `present`, for each effect."""
    return sum(len(kind.parameters) + 1 for kind in kinds)


def held_for(acting: frozenset[str]) -> frozenset[str]:
    """Names of the medium effects that a function must hold where these act: what costs little, and one that is costly;
    where several of these act all that there are, so that few libraries serve all models."""
    costly = frozenset(kind.name for kind in medium_effects() if kind.costly)
    every = frozenset(kind.name for kind in medium_effects())
    return every if len(acting & costly) > 1 else (every - costly) | (acting & costly)


def wrench(
    kinds: Kinds, law: Law, before: ca.SX, after: ca.SX, poses: ca.SX, medium: ca.SX, setting: ca.SX, theta: ca.SX
) -> ca.SX:
    """Drag (3), momentum (3) and energy of one vertex; elements (6, `with_links`) in their body frames.

    medium = (weight, eps). Forces are in units of the drag level, that of a slip of 1 m/s (dry friction: of any).
    The energy is the work over the law's degree: the potential, but for its softening.
    """
    length, duration = setting[0], setting[1]
    element = _element(before, after, poses, medium, setting)
    offsets = [0, *(sum(len(k.parameters) + 1 for k in kinds[: i + 1]) for i in range(len(kinds)))]
    symbols = [kind.symbols(part) for kind, part in zip(kinds, ca.vertsplit(theta, offsets), strict=True)]
    for kind, p in zip(kinds, symbols, strict=True):
        element = _kept(kind, element, kind.on_element(element, p))
    ratio = law.form_ratio(element.anisotropy_ratio)
    soft = softening_length(before[:4], after[:4], setting[5]) * length / duration
    multipliers = law.multipliers(*element.squared_slips, element.along(ratio), soft)
    force, moment, axle = ca.SX.zeros(2), ca.SX(0), ca.SX(0)
    for wheel, arm in zip(element.wheels, reversed(element.contacts), strict=True):
        drag = Drag.baseline(element, wheel, *multipliers)
        for kind, p in zip(kinds, symbols, strict=True):
            drag = _kept(kind, drag, kind.on_drag(drag, p))
        resistance = element.grip * drag.resistance(wheel, ratio) / 2
        scrub = element.grip * drag.scrubbing / 2 * element.axle * element.turning
        force, moment, axle = force + resistance, moment + cross(arm, resistance), axle + scrub
    power = ca.dot(force, element.contact_velocity) + axle * element.turning
    energy = power / law.degree * (duration / length) ** law.degree
    moment += axle
    force, moment = force - element.push, moment - cross(element.middle, element.push)
    resisted = ca.vertcat(force, moment / length) * duration / length
    momentum = ca.vertcat(element.momentum, cross(element.middle, element.momentum) / length) / length
    return ca.vertcat(resisted, momentum, energy)


def _kept(kind: MediumEffect, before: T, after: T) -> T:
    """What an effect made of an element or a drag; TypeError, with its name, where it is none or a part of it has
    another shape: CasADi would spread a number over both directions."""
    if not isinstance(after, type(before)):
        wanted, got = type(before).__name__, type(after).__name__
        raise TypeError(f"effect `{kind.name}`: must give back its {wanted}, got {got}. Does it lack a `return`?")
    for part in fields(before):
        was, now = (getattr(record, part.name) for record in (before, after))
        if now is not was and _shapes(was) != _shapes(now):
            shapes = f"{_shapes(was)}, got {_shapes(now)}"
            raise TypeError(f"effect `{kind.name}`: `{part.name}` must have the shape {shapes}.")
    return after


def _shapes(part: ca.SX | tuple[ca.SX, ...]) -> str:
    return " and ".join(str(ca.SX(symbols).shape) for symbols in (part if isinstance(part, tuple) else (part,)))


def _element(before: ca.SX, after: ca.SX, poses: ca.SX, medium: ca.SX, setting: ca.SX) -> Element:
    length, duration, time = ca.vertsplit(setting[:3])
    b, a = move(poses[:3], before[:4]), move(poses[3:], after[:4])
    points, tangents = (length * b[:2], length * a[:2]), (b[2:], a[2:])
    links = (planar_rotation(poses[2]) @ before[4:], planar_rotation(poses[5]) @ after[4:])
    weight, eps = ca.vertsplit(medium)
    nothing, zero = ca.SX(0), ca.SX.zeros(2)
    return Element(
        points=points,
        tangents=tangents,
        links=links,
        contacts=points,
        wheels=tangents,
        origin=length * setting[3:5],
        weight=weight,
        grip=weight,
        anisotropy_ratio=eps,
        locked=nothing,
        axle=nothing,
        time=time,
        duration=duration,
        push=zero,
        momentum=zero,
    )


def with_links(elements: ca.SX) -> ca.SX:
    """Elements (4, M) at vertices, with the direction of the edge on the tail's side below (6, M); tail: its own."""
    links = unit_edges(elements[:2, :])
    return ca.vertcat(elements, ca.horzcat(links[:, 0], links))


@dataclass(frozen=True)
class Vertex:
    """A function of one vertex in one step; the outputs `summed` add up over the vertices, others stand side by side.

    It takes (before (6), after (6), poses (6), medium (2), setting (6), theta (P)).
    """

    function: ca.Function
    summed: tuple[int, ...]


def parameter_rows(kinds: Kinds, placed: bool) -> list[tuple[str, str, int]]:
    """(effect, parameter, row of theta) of all parameters of effects with a place, or without one."""
    rows, start = [], 0
    for kind in kinds:
        if (kind.place is not None) == placed:
            rows += [(kind.name, p.name, start + i) for i, p in enumerate(kind.parameters)]
        start += len(kind.parameters) + 1
    return rows


@lru_cache(maxsize=32)
def vertex_functions(law: str, held: frozenset[str] | None = None) -> dict[str, Vertex]:
    """With the medium effects `held` (None: all; derivatives by others are zero), in a medium of this law:

    balance:     -> drag and momentum (6), energy, derivatives of the six by the second pose (6, 3)
    coupled:     -> the same, derivatives by both poses (6, 6)
    sensitivity: -> derivatives of drag and momentum by eps and by the parameters of effects without a place
                 (6, 1 + G), and by those with one (6, L), vertex by vertex
    """
    kinds = medium_effects()
    inputs = _symbols(coordinate_count(kinds))
    before, after, poses, medium, setting, theta = inputs
    some = kinds if held is None else tuple(kind for kind in kinds if kind.name in held)
    value, eps = wrench(some, LAWS[law], before, after, poses, medium, setting, _of(some, theta)), medium[1]

    def slope(by: ca.SX) -> ca.SX:
        return ca.densify(ca.jacobian(value[:6], by))

    everywhere = [theta[row] for _, _, row in parameter_rows(kinds, placed=False)]
    somewhere = [theta[row] for _, _, row in parameter_rows(kinds, placed=True)]
    parts = {
        "balance": ([value[:6], value[6], slope(poses[3:])], (0, 1, 2)),
        "coupled": ([value[:6], value[6], slope(poses)], (0, 1, 2)),
        "sensitivity": ([slope(ca.vertcat(eps, *everywhere)), slope(ca.vertcat(*somewhere))], (0,)),
    }
    return {
        name: Vertex(ca.Function(f"vertex_{name}", inputs, outputs, CSE), summed)
        for name, (outputs, summed) in parts.items()
    }


def _of(some: Kinds, theta: ca.SX) -> ca.SX:
    """The coordinates of some effects, of those of all."""
    ends = np.cumsum([0, *(len(kind.parameters) + 1 for kind in medium_effects())])
    parts = zip(medium_effects(), ca.vertsplit(theta, ends.tolist()), strict=True)
    return ca.vertcat(*(part for kind, part in parts if kind in some))


def _symbols(coordinates: int) -> list[ca.SX]:
    shapes = {"before": 6, "after": 6, "poses": 6, "medium": 2, "setting": SETTING, "theta": coordinates}
    return [ca.SX.sym(name, size) for name, size in shapes.items()]
