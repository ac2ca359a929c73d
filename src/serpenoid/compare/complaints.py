"""What is wrong with a fit, in words: what the data do not say, what the model does not follow, noise that is none."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from serpenoid.body import Floats
from serpenoid.compare.likelihood import Solution
from serpenoid.compare.parameters import bounds
from serpenoid.medium import MOST
from serpenoid.model import Model

CORRELATED = 0.95  # two fitted numbers whose errors are this correlated cannot be told apart by these data
OFF = 1.5  # times the noise, or a part of the least that chance makes of it: something is wrong
CHANCE = 0.01
SLENDER = 0.5  # eps of a slender body in water: drag sideways is at most twice that lengthwise
NEAR_ONE = 1e-3  # of eps: to where a fit's own tolerance ends


def complaints(
    solution: Solution, model: Model, sd: Floats, interval: Floats, correlation: Floats, trials: int
) -> tuple[str, ...]:
    """All of them; sd (P,), interval (P, 2) and correlation (P, P) of the numbers fitted to so many trials."""
    found = [model.sparse_drag] if model.sparse_drag and not model.body.is_animal else []
    lows, highs = bounds(solution.names, model)
    ended, known = at_bounds(solution, model), determined(solution.names, sd, model)
    if not solution.converged:
        found.append("the fit did not converge: the data may not determine these numbers")
    for i, name in enumerate(solution.names):
        if not known[i]:
            found.append(f"these data do not determine `{name}`")
        if ended[i]:
            found.append(_at_bound(name, float(solution.values[i]), solution.noise_scale))
        elif interval[i, 0] <= lows[i] or interval[i, 1] >= highs[i]:
            found.append(f"the interval of `{name}` reaches its bound: these data do not limit it there")
        for j in range(i):
            if abs(correlation[i, j]) > CORRELATED:
                pair = f"`{solution.names[j]}` and `{name}`"
                found.append(f"{pair} cannot be told apart by these data (correlation {correlation[i, j]:.3f})")
    highest = [float(i[1]) for n, i in zip(solution.names, interval, strict=True) if n == "anisotropy_ratio"]
    water = [said for end in highest for said in beyond_water(model, end, "campaign.toml")]
    return (*found, *water, *_size(solution, model, trials))


def determined(names: Sequence[str], sd: Floats, model: Model) -> NDArray[np.bool_]:
    """Which of the numbers (P,) the data tell at all: a 95 % interval that is longer than all they can be leaves them
    where the fit began, and they are no estimates."""
    lows, highs = bounds(tuple(names), model)
    return np.asarray(sd <= 0.5 * (highs - lows))


def failed(solution: Solution, model: Model) -> bool:
    """Whether the numbers are no estimates: the fit did not converge, or ran into a bound that data lead beyond."""
    return not solution.converged or bool(solution.noise_scale > OFF and at_bounds(solution, model).any())


def at_bounds(solution: Solution, model: Model) -> NDArray[np.bool_]:
    """Which of the fitted numbers (P,) ended at a bound."""
    lows, highs = bounds(solution.names, model)
    return np.asarray((solution.values <= lows * 1.001) | (solution.values >= highs * 0.999))


def least_by_chance(freedom: int) -> float:
    """What is left, in times the noise, where chance makes less in one fit of a hundred."""
    return float(np.sqrt(chdtri(max(freedom, 1), 1 - CHANCE) / max(freedom, 1)))


def _at_bound(name: str, value: float, scale: float) -> str:
    """Where the data are followed there the bound is an answer; otherwise they ask for more than the model has."""
    if scale <= OFF:
        return f"`{name}` is {value:.4g}, as far as it goes, and there the model follows these data"
    said = f"`{name}` ran into its bound {value:.4g}: the model cannot follow these data"
    if name == "anisotropy_ratio" and abs(value - 1) < NEAR_ONE:
        return (
            f"{said}. A body that moves the way its bends run slips more easily sideways than lengthwise (K < 1: "
            "bristles, parapodia), and K = 1 is no estimate of it: let fits look there, "
            f"`[medium] anisotropy_ratio_bounds = [0.01, {MOST:g}]`"
        )
    return said


def beyond_water(model: Model, highest: float, file: str) -> list[str]:
    """Whether drag has to be more unlike sideways and lengthwise than a fluid makes it, with nobody's word on that.

    highest: the upper end of eps. file: where bounds would stand.
    """
    if model.body.kind != "swimmer" or not model.law.linear or model.medium.anisotropy_ratio_bounds is not None:
        return []
    if not highest < SLENDER:
        return []
    return [
        f"K is above {1 / SLENDER:g}, the most that slender-body theory allows a body in water: drag alone is not what "
        f"moves a swimmer there, however well it follows. `[medium] anisotropy_ratio_bounds = [{SLENDER:g}, 1]` in "
        f"{file} keeps fits and diagnoses to what water does (not for one in sand or mud)"
    ]


def _size(solution: Solution, model: Model, trials: int) -> list[str]:
    """Whether what is left is as large as the noise, which is told by how markers miss the links."""
    scale, least = solution.noise_scale, least_by_chance(solution.freedom)
    if scale > OFF:
        others = "; what trials differ by shows how far they are off at least" if trials > 1 else ""
        return [
            f"what is left is {scale:.1f} times the measurement noise: the model is wrong somewhere, and intervals "
            "hold only if it is right: they do not say how far these numbers are from the body's own"
            f"{others}{_asked(model)}"
        ]
    if scale >= least / OFF:
        return []
    cause = (
        "its points or lengths" if model.body.is_animal else "a marker beside its place, a wrong length, a wrong scale"
    )
    return [
        f"what is left is only {scale:.2f} times the measurement noise, where chance leaves {least:.2f} times or more: "
        f"most of what passes for noise is an error that stays ({cause}), which may be in these numbers, "
        "and the noise interval means little; `serpenoid diagnose` looks for it"
    ]


def _asked(model: Model) -> str:
    """What leaves more than noise and no number of the model: another law, and of an animal what its film may hide."""
    law = ["another law of drag, dry or quadratic (`serpenoid diagnose` asks)"] if model.law.linear else []
    film = [
        "a body that goes on beyond its outermost points (track both tips)",
        "a camera or a medium that drifts (0.01 body lengths a second are enough)",
    ]
    causes = [*law, *(film if model.body.is_animal else [])]
    return f"; it may be {', or '.join(causes)}" if causes else ""
