"""Steps with every effect at once, in SIMD: the same numbers as CasADi's maps, for bodies of any number of vertices."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from serpenoid.effects.catalogue import medium_effects
from serpenoid.mechanics import vertices
from serpenoid.mechanics.compile import find_compiler
from serpenoid.mechanics.extended import coordinate_count, held_for, vertex_functions, with_links
from serpenoid.media import LAWS

EVERY = frozenset(kind.name for kind in medium_effects())


def given(steps: int, elements: int) -> list[np.ndarray]:
    """Chains, poses, settings, a medium and every effect at about its typical size."""
    rng = np.random.default_rng(steps + elements)
    before = rng.normal(size=(steps, elements, 4))
    after = before + 0.01 * rng.normal(size=before.shape)
    for chain in (before, after):
        chain[..., 2:] /= np.linalg.norm(chain[..., 2:], axis=-1, keepdims=True)
    first = rng.normal(size=(steps, 3))
    poses = np.hstack([first, first + 0.01 * rng.normal(size=first.shape)])
    settings = np.tile([1.2, 0.02, 0.0, 0.0, 0.0, 1e-3], (steps, 1))
    settings[:, 2] = np.linspace(0, 5, steps)
    medium = np.tile([1 / elements, 0.1], (elements, 1))
    typical = [c for kind in medium_effects() for c in (*(p.coordinate(p.typical) for p in kind.parameters), 1.0)]
    theta = np.tile(typical, (elements, 1)) * rng.uniform(0.5, 1.0, size=(elements, coordinate_count(medium_effects())))
    return [before, after, poses, settings, medium, theta]


@pytest.mark.skipif(not find_compiler(), reason="no C compiler here")
@pytest.mark.parametrize(("steps", "elements"), [(1, 3), pytest.param(67, 5, marks=pytest.mark.slow), (128, 4)])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("which", ["balance", "coupled", "sensitivity"])
def test_many_steps_at_once_are_casadis_own(which: str, law: str, steps: int, elements: int) -> None:
    numbers = given(steps, elements)
    wide = vertices.over_steps(which, law)(*numbers)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SERPENOID_COMPILE", "0")
        vertices.over_steps.cache_clear()
        mapped = vertices.over_steps(which, law)(*numbers)
    vertices.over_steps.cache_clear()
    for a, b in zip(wide, mapped, strict=True):
        size = np.abs(b).max()  # softened signs cancel eleven digits of a part of a sum, which may be larger than that
        np.testing.assert_allclose(a, b, rtol=0, atol=3e-11 * size)


@pytest.mark.parametrize("name", [None, "grip_saturation", "added_mass"])
def test_what_is_held_for_few_effects_gives_what_all_give_where_the_others_are_neutral(name: str | None) -> None:
    acting = frozenset({"slope", "load"} if name is None else {"slope", "load", name})
    held = held_for(acting)
    assert acting <= held < EVERY
    before, after, poses, settings, medium, theta = given(9, 5)
    for kind, at in zip(medium_effects(), starts(), strict=True):
        if kind.name not in acting:
            theta[:, at : at + len(kind.parameters)] = [p.resting for p in kind.parameters]
    ends = [with_links(ca.DM(x[0].T)) for x in (before, after)]
    numbers = [[end[:, k] for end in ends] + [poses[0], medium[k], settings[0], theta[k]] for k in range(5)]
    for which in ("balance", "coupled"):
        some, every = (vertex_functions("viscous", h)[which].function for h in (held, None))
        for at_vertex in numbers:
            for a, b in zip(some(*at_vertex), every(*at_vertex), strict=True):
                np.testing.assert_allclose(a.full(), b.full(), rtol=0, atol=3e-13 * np.abs(b.full()).max())


def test_where_several_costly_effects_act_all_are_held() -> None:
    assert held_for(frozenset({"grip_saturation", "rolling_resistance"})) == EVERY


def test_what_does_not_say_that_it_is_costly_takes_a_step_no_twice_as_long() -> None:
    light, bare = (instructions(held) for held in (held_for(frozenset()), frozenset[str]()))
    assert light < 2 * bare


def instructions(held: frozenset[str]) -> int:
    return int(vertex_functions("viscous", held)["balance"].function.n_instructions())


def starts() -> list[int]:
    """The first coordinate of each effect."""
    return np.cumsum([0, *(len(kind.parameters) + 1 for kind in medium_effects())])[:-1].tolist()
