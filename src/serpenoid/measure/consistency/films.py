"""What all films of a campaign show of the lengths that it states, together, or one by one where their scales differ.

    r_ie = log(shown / said) of edge e in film i = scale_i + edge_e + rest_ie

Scales differ where F = var(scale) / var(rest) is no chance, and they are `APART`. What links of another direction phi
on the floor are longer by within films tells a stretched camera, and may be what films differ by:

    log(shown) of edge e in film i, about its mean there = c_e . x + rest,    x = (cos 2 phi, sin 2 phi), about its mean
    F = (squares that one c takes off / 2) / (squares that every edge's own c_e takes off beyond / (2 (E - 1)))

Noise that lasts from frame to frame is in both squares of F alike. A marker beside its place gives edges c_e of their
own, for where a link points goes with how joints are bent.

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
from serpenoid.measure.consistency.lengths import PARTS, Shown, all_longer, beside_film, turned, wrong_edge
from serpenoid.measure.consistency.rivals import CERTAIN
from serpenoid.measure.remark import Remark
from serpenoid.measure.trial_files import Files, ever_seen, stated_between

APART = 0.005  # of a length: a lens and where on its floor a body is make less of a whole film
TINY = np.finfo(float).tiny
BY_IT = ", and differ by which way links point in them"
WITHIN = 0.25  # of how much films differ: what differs as much within them is no camera that was moved, nor is less


@dataclass(frozen=True)
class Films:
    """Trials whose films have a scale, what they show together of stated lengths (see `beside_film`), and the points
    (F, N, 2) of each."""

    trials: tuple[str, ...]
    shown: tuple[Shown, Floats, list[str], bool]
    points: tuple[Floats, ...]

    @property
    def said(self) -> dict[str, Remark]:
        """What is said of every trial by name: the same of all, or of each whose film has another scale."""
        shown, stated, _, all_marked = self.shown
        if back := turned(shown, stated, all_marked):
            return dict.fromkeys(self.trials, Remark(back))
        longer, directed = self._longer(self.points), self._by_direction()
        if not _differ(longer):
            if directed.certain and directed.share > max(APART, self.shown[0].noise.max() / 2):
                return dict.fromkeys(self.trials, _stretched(directed.share))
            words = beside_film(*self.shown)
            remark = Remark(words) if all_longer(self.shown[0]) is None else Remark(words, "scale")
            return dict.fromkeys(self.trials, remark) if words else {}
        if not _differ(longer - directed.along):
            return dict.fromkeys(self.trials, _stretched(directed.share, BY_IT))
        scales = longer.mean(axis=1)
        if self._as_different_within(scales):
            return dict.fromkeys(self.trials, _by_place(scales))
        return {t: _another(scale, scales) for t, scale in self._own(scales).items()}

    @property
    def scales(self) -> dict[str, float]:
        """By the name of its trial the log scale of every film that has another than stated; none where films do not
        differ by their scales alone."""
        longer = self._longer(self.points)
        if not _differ(longer) or not _differ(longer - self._by_direction().along):
            return {}
        scales = longer.mean(axis=1)
        return {} if self._as_different_within(scales) else self._own(scales)

    def taken(self, scales: dict[str, float]) -> dict[str, Remark]:
        """What is said where these films are taken in the scale in which links are as long as stated."""
        every = self._longer(self.points).mean(axis=1)
        return {t: _another(scale, every, taken=True) for t, scale in scales.items()}

    def _own(self, scales: Floats) -> dict[str, float]:
        """Those that are another than stated by more than films differ by within."""
        little = WITHIN * np.ptp(scales)
        return {t: float(s) for t, s in zip(self.trials, scales, strict=True) if abs(s) > little}

    def _as_different_within(self, scales: Floats) -> bool:
        """Whether films differ as much within as from each other."""
        within = [np.ptp(self._longer(np.array_split(one, PARTS)).mean(axis=1)) for one in self.points]
        return bool(np.median(within) > WITHIN * np.ptp(scales))

    def _by_direction(self) -> Directed:
        """What links that turn within films show, of edges that all of them show."""
        known = self._known
        steps = [np.diff(points, axis=1)[:, known] for points in self.points]
        twice = [2 * np.arctan2(s[..., 1], s[..., 0]) for s in steps]
        turns = [np.stack([np.cos(t), np.sin(t)], axis=2) for t in twice]  # (F, E, 2)
        sizes = [np.log(np.maximum(np.linalg.norm(s, axis=2), TINY)) for s in steps]
        about = np.nan_to_num(np.concatenate([x - np.nanmean(x, axis=0) for x in turns]))  # hidden: no part in any sum
        longer = np.nan_to_num(np.concatenate([x - np.nanmean(x, axis=0) for x in sizes]))
        squares, products = np.einsum("fea,feb->eab", about, about), np.einsum("fea,fe->ea", about, longer)
        found = np.linalg.pinv(squares.sum(axis=0), hermitian=True) @ products.sum(axis=0)
        own = (np.linalg.pinv(squares, hermitian=True) @ products[..., None])[..., 0]
        together = float(found @ products.sum(axis=0))
        return Directed(
            2 * float(np.hypot(*found)),
            np.array([np.nanmean(x, axis=0) @ found for x in turns]),
            _chance(together, float((own * products).sum()) - together, len(products)) < 1 - CERTAIN,
        )

    @property
    def _known(self) -> NDArray[np.bool_]:
        """Which edges all films show, and are stated."""
        return np.asarray(np.all([Shown.of([points], self.shown[1]).known for points in self.points], axis=0))

    def _longer(self, recordings: Sequence[Floats]) -> Floats:
        """r of the edges (n, E) that all of n recordings show."""
        each = [Shown.of([points], self.shown[1]) for points in recordings]
        known = np.all([one.known for one in each], axis=0)
        return np.array([one.longer[known[one.known]] for one in each])


@dataclass(frozen=True)
class Directed:
    """share: by which the longest direction on the floor is longer than the one across; along (n, E): what that makes
    of the lengths in each film; certain: whether edges agree on it beyond chance."""

    share: float
    along: Floats
    certain: bool


def _chance(together: float, apart: float, edges: int) -> float:
    """How likely edges whose own c_e are chance agree as much by the squares that both take off."""
    if edges < 2:
        return 1.0
    return float(fdtrc(2, 2 * (edges - 1), (edges - 1) * together / max(apart, TINY)))


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


def _another(scale: float, scales: Floats, taken: bool = False) -> Remark:
    """Of a film whose log scale is another than that of others; taken: whether it is set right."""
    own, apart = 100 * abs(np.expm1(scale)), 100 * np.expm1(np.ptp(scales))
    factor = f"{np.exp(-scale):.4g}"
    left = (
        f"Taken here times {factor}, as links are then as long as told. If that is so, give its positions"
        if taken
        else "Left so it counts as chance of repeats, and hides what is smaller. Give the positions of this film"
    )
    words = (
        f"all links are {own:.2g} % {'longer' if scale > 0 else 'shorter'} in this film than `edge_lengths`, and "
        f"films of this campaign differ by {apart:.2g} %: was a camera moved, or calibrated anew? {left} times "
        f"{factor} (of pixels: so many times its `metres_per_pixel`)"
    )
    return Remark(words, "cameras")


def _stretched(share: float, differ: str = "") -> Remark:
    """Of films in which links are longer along one direction; differ: what is said if films differ by that."""
    words = (
        f"films show links up to {100 * share:.2g} % longer along one direction on the floor than across{differ}: is "
        "the camera's scale another along x than along y, or are its axes not square? Left so it counts as marker "
        "noise and moves what is fitted. Calibrate the camera"
    )
    return Remark(words, "cameras")


def _by_place(scales: Floats) -> Remark:
    """Of films within which it changes as much."""
    least, most = 100 * np.expm1(scales.min()), 100 * np.expm1(scales.max())
    words = (
        f"films show all links {least:+.2g} to {most:+.2g} % longer than `edge_lengths`, and as different within a "
        "film: perspective, or a lens that distorts? Left so it counts as marker noise and moves what is fitted. "
        "Calibrate the camera over the whole floor"
    )
    return Remark(words, "cameras")


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
