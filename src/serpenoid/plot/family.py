"""The family of gaits over the dissipation coefficient c: displacement, dissipation, their Pareto front, the gaits.

Legend: n gaits; Delta displacement [body lengths per cycle], D normalised dissipation T * E.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from serpenoid.body import Floats
from serpenoid.gaits import EllipseGait
from serpenoid.performance import between, moving, pareto_front
from serpenoid.plot.gait import FINE, X_LABEL, Y_LABEL
from serpenoid.plot.style import BLUE, CHAIN_MAP, FAINT, GREEN, GREY, RED, dress, fill_equal

C_LABEL = "dissipation coefficient c"
DELTA_LABEL, D_LABEL = "displacement [body lengths / cycle]", "dissipation [normalised]"
SAMPLES = 300  # along a curve: two pixels apart
OneGait = tuple[str, float, float]  # name, displacement, dissipation
PARAMETERS = {
    "sigma": (BLUE, "flatness σ"),
    "a": (GREEN, "half axis a [rad / body length]"),
    "xi": (RED, "waves per body length ξ"),
}


@dataclass(frozen=True)
class Family:
    """A sweep: c, displacement and dissipation (n,), gait parameters (n, k) and their names; NaN rows are failures."""

    c: Floats
    displacement: Floats
    dissipation: Floats
    gaits: Floats
    names: tuple[str, ...] = EllipseGait.NAMES

    def solved(self) -> Family:
        """Without the failures, c rising."""
        numbers = np.column_stack([self.c, self.displacement, self.dissipation, self.gaits])
        good = np.flatnonzero(np.isfinite(numbers).all(1))
        return self._of(good[np.argsort(self.c[good], kind="stable")])

    def moving(self) -> Family:
        """The gaits that move; at a large c the best that can be done is to stand still."""
        return self._of(moving(self.displacement))

    def _of(self, kept: NDArray[np.intp] | NDArray[np.bool_]) -> Family:
        return Family(self.c[kept], self.displacement[kept], self.dissipation[kept], self.gaits[kept], self.names)

    def between(self, first: int = 0) -> Family:
        """What it does between its gaits, from the given one on; parameters of gaits are not interpolated."""
        at = np.unique(np.concatenate([self.c[first:], np.linspace(self.c[first], self.c[-1], SAMPLES)]))
        delta, spent = between(self.c, self.displacement, self.dissipation, at)
        return Family(at, delta, spent, np.full((at.size, self.gaits.shape[1]), np.nan), self.names)


def against_c(family: Family, values: Floats, ax: Axes, label: str, title: str = "", colour: str = BLUE) -> Axes:
    """A line with a dot per gait."""
    ax.plot(family.c, values, "o-", color=colour, markersize=4, linewidth=1.5)
    ax.set_ylim(*_around(values))
    ax.ticklabel_format(useOffset=False)
    return dress(ax, title, C_LABEL, label)


def _around(values: Floats) -> tuple[float, float]:
    """Ends of an axis; a prescribed value is a level line, whose rounding is not magnified."""
    middle, span = (values.max() + values.min()) / 2, float(np.ptp(values))
    half = 0.6 * span if span > 1e-6 else 0.1 * abs(middle) or 1.0
    return float(middle - half), float(middle + half)


def pareto(family: Family, ax: Axes) -> Axes:
    """Displacement against dissipation, coloured by c; gaits that no other one beats are joined and ringed."""
    front = np.flatnonzero(pareto_front(family.displacement, family.dissipation))
    front = front[np.argsort(family.dissipation[front])]
    x, y = family.dissipation, family.displacement
    ring: dict[str, Any] = {"marker": "o", "markersize": 9, "markerfacecolor": "none", "markeredgewidth": 0.9}
    ax.plot(x[front], y[front], color=GREY, linewidth=1.2, zorder=1, label="not dominated", **ring)
    ax.scatter(x, y, c=family.c, cmap=CHAIN_MAP, s=26, linewidths=0, zorder=3)
    ax.set(xlim=_around(x), ylim=_around(y))
    ax.ticklabel_format(useOffset=False)
    return dress(ax, "Pareto front", D_LABEL, DELTA_LABEL)


def one_gait(beside: OneGait, ax: Axes) -> Axes:
    """Another gait among those of the front, with room about it."""
    name, y, x = beside
    ax.plot([x], [y], "*", color=RED, markersize=13, markeredgewidth=0, zorder=4, label=name)
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    room = 0.05 * (right - left), 0.05 * (high - low)
    ax.set(xlim=(min(left, x - room[0]), max(right, x + room[0])), ylim=(min(low, y - room[1]), max(high, y + room[1])))
    return ax


def gait_parameters(family: Family, ax: Axes, name: str, title: str = "") -> Axes:
    """One of the gait's parameters `sigma`, `a`, `xi` against c."""
    colour, label = PARAMETERS[name]
    return against_c(family, family.gaits[:, family.names.index(name)], ax, label, title, colour)


def gait_curves(family: Family, ax: Axes) -> Axes:
    """The gait curves coloured by c; of a gait and its mirror image (w -> -w, equal in cost) the nearer to the last."""
    span = np.ptp(family.c) or 1.0
    centre = np.zeros(2)
    for c, q in zip(family.c, family.gaits, strict=True) if family.names == EllipseGait.NAMES else ():
        sign = -1.0 if q[1:3] @ centre < 0 else 1.0
        centre = sign * q[1:3]
        curve = sign * EllipseGait.from_parameters(q).curve(FINE)
        ax.plot(*curve.T, color=CHAIN_MAP((c - family.c[0]) / span), linewidth=1.2)
    ax.axhline(0, color=FAINT, linewidth=1, zorder=0.5)
    ax.axvline(0, color=FAINT, linewidth=1, zorder=0.5)
    fill_equal(ax)
    return dress(ax, "Gaits in shape space", X_LABEL, Y_LABEL, grid=False)
