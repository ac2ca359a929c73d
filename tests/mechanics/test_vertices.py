"""Steps with every effect at once, in SIMD: the same numbers as CasADi's maps, for bodies of any number of vertices."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.effects.catalogue import medium_effects
from serpenoid.mechanics import vertices
from serpenoid.mechanics.compile import find_compiler
from serpenoid.mechanics.extended import coordinate_count
from serpenoid.media import LAWS


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
