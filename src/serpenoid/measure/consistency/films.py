"""What all films of a campaign show of the lengths that it states, together, or one by one where their scales differ.

    r_ie = log(shown / said) of edge e in film i = scale_i + edge_e + rest_ie

Scales differ where F = var(scale) / var(rest) is no chance, and they are `APART`. What links of another direction on
the floor are longer by within films, a cos 2 phi + b sin 2 phi, may be what films differ by: a camera is stretched.

Legend: n films, E edges, F frames.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from serpenoid.body import Body
from serpenoid.measure.campaign import CampaignFile
from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.blame import Contradiction
from serpenoid.measure.consistency.lengths import PARTS, Shown, beside_film, wrong_edge
from serpenoid.measure.consistency.rivals import CERTAIN
from serpenoid.measure.trial_files import Files, ever_seen, stated_between

APART = 0.005  # of a length: a lens and where on its floor a body is make less of a whole film
TINY = np.finfo(float).tiny
WITHIN = 0.25  # of how much films differ: what differs as much within them is no camera that was moved, nor is less


@dataclass(frozen=True)
class Films:
    """Trials whose films have a scale, what they show together of stated lengths (see `beside_film`), and the points
    (F, N, 2) of each."""

    trials: tuple[str, ...]
    shown: tuple[Shown, Floats, list[str], bool]
    points: tuple[Floats, ...]

    @property
    def said(self) -> dict[str, str]:
        """What is said of every trial by name: the same of all, or of each whose film has another scale."""
        longer = self._longer(self.points)
        if not _differ(longer):
            words = beside_film(*self.shown)
            return dict.fromkeys(self.trials, words) if words else {}
        directed, along = self._by_direction()
        if not _differ(longer - along):
            return dict.fromkeys(self.trials, _stretched(directed))
        scales = longer.mean(axis=1)
        within = [np.ptp(self._longer(np.array_split(one, PARTS)).mean(axis=1)) for one in self.points]
        little = WITHIN * np.ptp(scales)
        if np.median(within) > little:
            return dict.fromkeys(self.trials, _by_place(scales))
        return {t: _another(s, scales) for t, s in zip(self.trials, scales, strict=True) if abs(s) > little}

    def _by_direction(self) -> tuple[float, Floats]:
        """By which share the longest direction is longer than the one across, of links that turn within films, and what
        that makes of the lengths (n, E) in each film that all show."""
        known = self._known
        steps = [np.diff(points, axis=1)[:, known] for points in self.points]
        twice = [2 * np.arctan2(s[..., 1], s[..., 0]) for s in steps]
        turns = [np.stack([np.cos(t), np.sin(t)], axis=2) for t in twice]  # (F, E, 2)
        sizes = [np.log(np.maximum(np.linalg.norm(s, axis=2), TINY)) for s in steps]
        seen = np.concatenate([np.isfinite(x).ravel() for x in sizes])
        about = np.concatenate([(x - np.nanmean(x, axis=0)).reshape(-1, 2) for x in turns])[seen]
        longer = np.concatenate([(x - np.nanmean(x, axis=0)).ravel() for x in sizes])[seen]
        found = np.linalg.lstsq(about, longer, rcond=None)[0]
        return 2 * float(np.hypot(*found)), np.array([np.nanmean(x, axis=0) @ found for x in turns])

    @property
    def _known(self) -> NDArray[np.bool_]:
        """Which edges all films show, and are stated."""
        return np.asarray(np.all([Shown.of([points], self.shown[1]).known for points in self.points], axis=0))

    def _longer(self, recordings: Sequence[Floats]) -> Floats:
        """r of the edges (n, E) that all of n recordings show."""
        each = [Shown.of([points], self.shown[1]) for points in recordings]
        known = np.all([one.known for one in each], axis=0)
        return np.array([one.longer[known[one.known]] for one in each])


def _differ(longer: Floats) -> bool:
    """Whether films differ in scale by r (n, E): beyond chance, and by enough."""
    count, edges = longer.shape
    if count < 2 or edges < 2:
        return False
    scale = longer.mean(axis=1)
    rest = longer - scale[:, None] - longer.mean(axis=0) + longer.mean()
    left = max(float((rest**2).sum()) / (edges - 1), TINY)
    chance = fdtrc(count - 1, (count - 1) * (edges - 1), edges * (count - 1) * float(scale.var(ddof=1)) / left)
    return bool(chance < 1 - CERTAIN and np.ptp(scale) > APART)


def _another(scale: float, scales: Floats) -> str:
    """Of a film whose log scale is another than that of others."""
    own, apart = 100 * abs(np.expm1(scale)), 100 * np.expm1(np.ptp(scales))
    return (
        f"all links are {own:.2g} % {'longer' if scale > 0 else 'shorter'} in this film than `edge_lengths`, and films "
        f"of this campaign differ by {apart:.2g} %: was a camera moved, or calibrated anew? Left so it counts "
        "as chance of repeats, and hides what is smaller. Give the positions of this film times "
        f"{np.exp(-scale):.4g} (of pixels: so many times its `metres_per_pixel`)"
    )


def _stretched(directed: float) -> str:
    """Of films that differ by which way links point in them."""
    return (
        f"films show links up to {100 * directed:.2g} % longer along one direction on the floor than across, and "
        "differ by which way links point in them: is the camera's scale another along x than along y, or are its axes "
        "not square? Left so it counts as marker noise and moves what is fitted. Calibrate the camera"
    )


def _by_place(scales: Floats) -> str:
    """Of films within which it changes as much."""
    least, most = 100 * np.expm1(scales.min()), 100 * np.expm1(scales.max())
    return (
        f"films show all links {least:+.2g} to {most:+.2g} % longer than `edge_lengths`, and as different within a "
        "film: perspective, or a lens that distorts? Left so it counts as marker noise and moves what is fitted. "
        "Calibrate the camera over the whole floor"
    )


def films_of(file: CampaignFile, body: Body, read: Sequence[Files]) -> Films | None:
    """None where nothing is stated, or nothing seen."""
    if body.is_animal or not file.lengths_given:
        return None
    films = {
        f.entry.name: f for f in read if f.tracks is not None and f.tracks.scale_known and f.keys.length_unit != "bl"
    }
    marked = {name: f.labelled.vertices for name, f in films.items() if f.labelled is not None}
    if not marked:
        return None
    shown = sorted({k for points in marked.values() for k in ever_seen(points).tolist()})
    stated = stated_between(shown, body.edges_m, body)
    names, seen = next(iter(films.values())).names(body), [points[:, shown] for points in marked.values()]
    labels = [names[k] for k in shown]
    together = (Shown.of(seen, stated), stated, labels, len(shown) == body.vertices)
    return Films(tuple(marked), together, tuple(seen))


def wrong_edges(films: Films | None) -> list[Contradiction]:
    """One link that all films together show of another length."""
    found = None if films is None else wrong_edge(*films.shown)
    if films is None or found is None:
        return []
    words, cure, gain = found
    return [Contradiction(trial, "length", words, cure, gain) for trial in films.trials]
