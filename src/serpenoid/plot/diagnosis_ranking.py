"""What each candidate of the stage of motion would gain to first order, and which of them were chosen."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from serpenoid.diagnose.inference.fits.prices import gained_by_chance
from serpenoid.effects.catalogue import find
from serpenoid.plot.room import settle
from serpenoid.plot.style import BLUE, INK, SMALL, dress, figure, legend_above

if TYPE_CHECKING:
    from serpenoid.diagnose.inference.search.names import Key
    from serpenoid.diagnose.inference.search.select import Selection

MOST = 12  # and what was chosen
PALE = "#9CC3DB"
WIDE = 30.0  # times what chance gains: beyond, the line of chance would touch the axis


def ranking_figure(found: Selection) -> Figure:
    """A bar for each of the best candidates and of what was chosen, beside what the best of so many gains by chance."""
    gains = ranked(found)
    fig = figure(7.4, 1.3 + 0.24 * max(len(gains), 3))
    ax = fig.add_subplot()
    dress(ax, "", "chi squared gained to first order, less its parameters' price", "")
    bars(gains, [e.key for e in found.best.effects], ax, reasons(found))
    chance(list(gains.values()), len(found.scores), ax)
    legend_above(ax, 1)
    ax.grid(visible=False, axis="y")
    settle(fig, ax, above=0.1 + 0.2 * len(ax.get_legend_handles_labels()[1]))
    return fig


def ranked(found: Selection) -> dict[Key, float]:
    """The most that a candidate gains alone, wherever a scan put it, best first; 0 of what was chosen and has none."""
    most: dict[Key, float] = dict.fromkeys((e.key for e in found.best.effects), 0.0)
    for name, place, gain in found.scores:
        most[name, place] = max(most.get((name, place), 0.0), gain)
    order = sorted(most, key=lambda key: -most[key])
    chosen = {e.key for e in found.best.effects}
    return {key: most[key] for i, key in enumerate(order) if key in chosen or (i < MOST and most[key] > 0)}


def reasons(found: Selection) -> dict[Key, str]:
    """Why candidates that were chosen at first are not named."""
    weak = {t.added.key: "its trace in the path is below noise" for t in found.undetected}
    refused = {
        r.effect.key: "pushed beyond its bound"
        if r.beyond
        else f"takes away {r.share:.0%} of what is left, as a wrong effect could"
        for r in found.refused
    }
    return weak | refused


def bars(gains: dict[Key, float], chosen: list[Key], ax: Axes, why: dict[Key, str]) -> Axes:
    """One below the other; a word in the place of a bar that has no length, and on one why it was not chosen."""
    names = [name if place is None else f"{name} at {find(name).place} {place}" for name, place in gains]
    ax.barh(names, list(gains.values()), color=[BLUE if key in chosen else PALE for key in gains])
    for row, (key, gain) in enumerate(gains.items()):
        place: Mapping[str, Any] = {"transform": ax.get_yaxis_transform(), "fontsize": SMALL, "va": "center"}
        if not gain:
            ax.text(0.01, row, "gains nothing alone", **place)
        elif key in why and key not in chosen:
            ax.text(0.99, row, why[key], ha="right", **place)
    ax.invert_yaxis()
    if chosen:
        ax.plot([], [], "s", color=BLUE, label="chosen")
    if others := set(gains) - set(chosen):
        usual = "less in full, or another explains it"
        known = (
            "why is written there"
            if others <= set(why)
            else f"as written, else {usual}"
            if others & set(why)
            else usual
        )
        ax.plot([], [], "s", color=PALE, label=f"not chosen: {known}")
    return ax


def chance(gains: list[float], tries: int, ax: Axes) -> Axes:
    """What chance gains, on a scale on which it is seen."""
    needed = gained_by_chance(tries)
    shown = [needed, *(g for g in gains if g > 0)]
    if max(shown) > WIDE * needed:
        ax.set_xscale("log")
        ax.set_xlim(0.5 * min(shown), 2 * max(shown))
    else:
        ax.ticklabel_format(axis="x", style="plain")
        ax.set_xlim(0, 1.05 * max(shown))
    ax.axvline(needed, color=INK, lw=1.0, ls="--", label=f"{needed:.0f}: what the best of {tries} gains by chance")
    return ax
