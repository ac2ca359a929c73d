"""The family of gaits over the dissipation coefficient c: what it moves, dissipates and costs to transport.

A gait that minimises -Delta + c D has Delta' = c D' along the family. Its cost of transport (p + D) / Delta, with p the
idle energy of a cycle in the units of D, is therefore stationary where p = Delta / c - D: each c is the best for one idle
level. Legend: n gaits; Delta displacement [body lengths per cycle], D normalised dissipation T * E.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from serpenoid.body import Floats
from serpenoid.gaits import EllipseGait
from serpenoid.plot.gait import FINE, X_LABEL, Y_LABEL
from serpenoid.plot.style import BLUE, CHAIN_MAP, FAINT, GREEN, GREY, INK, ORANGE, RED, SMALL, dress, legend_above

C_LABEL = "dissipation coefficient c"
DELTA_LABEL, D_LABEL = "displacement [body lengths / cycle]", "dissipation [normalised, T·E]"
P_LABEL = "idle energy per cycle p [units of D]"


@dataclass(frozen=True)
class Family:
    """A sweep: c, displacement and dissipation (n,), gait parameters (n, 6); NaN rows are failures."""

    c: Floats
    displacement: Floats
    dissipation: Floats
    gaits: Floats

    def solved(self) -> Family:
        """Without the failures, c rising."""
        numbers = np.column_stack([self.c, self.displacement, self.dissipation, self.gaits])
        good = np.flatnonzero(np.isfinite(numbers).all(1))
        order = good[np.argsort(self.c[good], kind="stable")]
        return Family(self.c[order], self.displacement[order], self.dissipation[order], self.gaits[order])

    @property
    def best_idle(self) -> Floats:
        """The idle level p at which each gait has the least cost of transport, inf at c = 0."""
        with np.errstate(divide="ignore"):
            return np.where(self.c > 0, self.displacement / self.c, np.inf) - self.dissipation

    def cost_of_transport(self, idle: float) -> Floats:
        """(p + D) / Delta, in units of D per body length."""
        return (idle + self.dissipation) / self.displacement


def non_dominated(displacement: Floats, dissipation: Floats) -> np.ndarray:
    """Which gaits no other one beats: nothing moves at least as far for at most as much, and better in one; (n,) bool."""
    far = displacement[None] >= displacement[:, None]
    cheap = dissipation[None] <= dissipation[:, None]
    better = (displacement[None] > displacement[:, None]) | (dissipation[None] < dissipation[:, None])
    return ~(far & cheap & better).any(1)


def against_c(family: Family, values: Floats, ax: Axes, label: str, title: str = "", colour: str = BLUE) -> Axes:
    """A line with a dot per gait."""
    ax.plot(family.c, values, "o-", color=colour, markersize=4, linewidth=1.5)
    ax.margins(y=0.12)
    return dress(ax, title, C_LABEL, label)


def pareto(family: Family, ax: Axes, title: str = "Pareto front") -> Axes:
    """Displacement against dissipation, coloured by c; gaits that no other one beats are joined and ringed."""
    front = np.flatnonzero(non_dominated(family.displacement, family.dissipation))
    front = front[np.argsort(family.dissipation[front])]
    x, y = family.dissipation, family.displacement
    ax.plot(x[front], y[front], color=GREY, linewidth=1.2, zorder=1, label="not dominated")
    ax.scatter(x[front], y[front], s=70, facecolors="none", edgecolors=GREY, linewidths=0.9, zorder=2)
    ax.scatter(x, y, c=family.c, cmap=CHAIN_MAP, s=26, linewidths=0, zorder=3)
    ax.margins(0.08)
    return dress(ax, title, D_LABEL, DELTA_LABEL)


def cost_of_transport(
    family: Family, ax: Axes, idle_levels: Sequence[float], title: str = "Cost of transport (p + D) / Δ"
) -> Axes:
    """A curve per idle level p, its least value starred."""
    for p, colour in zip(idle_levels, CHAIN_MAP(np.linspace(0, 1, len(idle_levels))), strict=True):
        cost = family.cost_of_transport(p)
        least = int(cost.argmin())
        ax.plot(family.c, cost, color=colour, linewidth=1.6)
        ax.plot(family.c[least], cost[least], "*", color=colour, markersize=12, markeredgecolor="white", zorder=4)
        ax.annotate(
            f"p = {p:.3g}", (family.c[-1], cost[-1]), xytext=(5, 0), textcoords="offset points", color=colour,
            fontsize=SMALL, va="center", annotation_clip=False,
        )  # fmt: skip
    ax.plot([], [], "*", color=GREY, markersize=10, label="least cost")
    ax.set_ylim(0, None)
    legend_above(ax, 1)
    return dress(ax, title, C_LABEL, "cost of transport [units of D / body length]")


def idle_interval(family: Family, between: tuple[float, float] = (1.0, 2.0)) -> tuple[float, float] | None:
    """Idle levels (lower, upper) whose least cost of transport lies at a c `between`; None where the sweep ends short."""
    if family.c.size < 2 or family.c.min() > between[0] or family.c.max() < between[1]:
        return None
    delta, d = (np.interp(between, family.c, values) for values in (family.displacement, family.dissipation))
    first, last = delta / np.array(between) - d
    return float(last), float(first)


def idle_levels(family: Family, ax: Axes, between: tuple[float, float] = (1.0, 2.0)) -> Axes:
    """For each idle level the c of least cost; the levels that put it `between` two values are shaded."""
    real = family.c > 0
    ax.semilogy(family.c[real], family.best_idle[real], "o-", color=BLUE, markersize=4, linewidth=1.5)
    ends = idle_interval(family, between)
    if ends is not None:
        ax.axhspan(*ends, color=ORANGE, alpha=0.25, linewidth=0)
        ax.vlines(between, 0, 1, transform=ax.get_xaxis_transform(), color=GREY, linewidth=1, linestyle="--")
        ax.text(
            0.97, 0.95, f"least cost at {between[0]:g} < c < {between[1]:g}\nfor {ends[0]:.3f} < p < {ends[1]:.3f}",
            transform=ax.transAxes, ha="right", va="top", fontsize=SMALL, color=INK,
        )  # fmt: skip
    return dress(ax, "Idle level for which c is best: p = Δ/c − D", C_LABEL, P_LABEL)


def gait_parameters(family: Family, ax: Axes, name: str, title: str = "") -> Axes:
    """One of the gait's parameters against c."""
    colour, label = PARAMETERS[name]
    return against_c(family, family.gaits[:, EllipseGait.NAMES.index(name)], ax, label, title, colour)


PARAMETERS = {
    "sigma": (BLUE, "flatness σ"),
    "a": (GREEN, "half axis a [rad / body length]"),
    "xi": (RED, "waves per body length ξ"),
}


def gait_curves(family: Family, ax: Axes, title: str = "Gaits in shape space") -> Axes:
    """The gait curves coloured by c. Of a gait and its mirror image (w -> -w, equal in cost) the one nearer the last."""
    span = np.ptp(family.c) or 1.0
    centre = np.zeros(2)
    for c, q in zip(family.c, family.gaits, strict=True):
        curve = EllipseGait.from_parameters(q).curve(FINE)
        sign = -1.0 if q[1:3] @ centre < 0 else 1.0
        centre = sign * q[1:3]
        ax.plot(*(sign * curve).T, color=CHAIN_MAP((c - family.c[0]) / span), linewidth=1.2)
    ax.axhline(0, color=FAINT, linewidth=1, zorder=0.5)
    ax.axvline(0, color=FAINT, linewidth=1, zorder=0.5)
    ax.set_aspect("equal")
    return dress(ax, title, X_LABEL, Y_LABEL, grid=False)
