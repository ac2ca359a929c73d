"""What is said of a recording of points alone before any work: which end leads, where bends run, whether it stretches.

run of the bends = sum (k_{j+1} k_j' - k_j k_{j+1}') / sum |.|        > 0: from head to tail, k: joint angles
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Body
from serpenoid.measure.animals.beside_midline import beside_midline, said
from serpenoid.measure.animals.folded import folded
from serpenoid.measure.animals.followed import followed
from serpenoid.measure.animals.picture import as_if_alike, picture
from serpenoid.measure.animals.smoothed import said_of_smoothing
from serpenoid.measure.animals.uneven import uneven
from serpenoid.measure.cells import Floats, listed
from serpenoid.measure.clock import ROBUST
from serpenoid.measure.consistency.signals import LEAST_ROWS, Signal
from serpenoid.measure.film.quality import Jump
from serpenoid.measure.shapes.lengths import shown_lengths
from serpenoid.measure.shapes.smooth import best_window, smooth, smoother
from serpenoid.measure.trial import Motion

SHORT = 2.0  # periods: under that, nothing shows what one beat has of its own
LEAST_EDGES = 5.0  # a wave: docs/measuring-method.md has what K comes out as with fewer
LONG = 10_000  # frames: fits take minutes, and say no more than a tenth of them
SLOWEST = 2.0  # seconds between frames: of an animal that moves slower films are asked about their clock
FINER = {'milliseconds (`time_unit = "ms"`)': 1e-3, 'microseconds (`time_unit = "us"`)': 1e-6}
SURE = 3.0  # standard errors of a variance: beyond them, a body stretches and its points do not only scatter
BOTH = 6.0  # over the second differences there are: the variance of lengths' variance over that of their noise
ONE_BODY = 2.0
# times: points next to each other on one body are never farther apart than so many times their least distance. A part
# that bends into a half circle is pi / 2 times as short, one with waves of stretching of 20 % grows to 1.5 times its
# least length (docs/measuring-method.md: a prickleback's parts vary by 12 %, a larva's whole length by 4 %); two
# animals, each anywhere in a round dish, are 7 times as far apart in 5 % of the frames as they are in another 5 %
TAILS, OF_TAILS = (0.05, 0.95), 1.645  # of frames; SDs of normal noise from their middle
DRAWS = 20  # of white noise, smoothed as lengths are
MOST_TOLD = 3  # moments
RIGID = (
    "its points are taken for joints of rigid links: of an animal, or another body that bends along its length, K "
    'comes out 8 to 35 % too small so. For one set `kind = "swimmer"` or `"crawler"` in [body]'
)
STANDING = 0.05  # of the way that bends run: less has no direction
LEAST_SHARE = 0.005  # of a path: less is told as 0 %


def leading(motion: Motion) -> float:
    """Share of the path that is travelled head first (0 .. 1), by the centroid along the mean heading."""
    step, heading = np.diff(motion.smooth_poses[:, :2], axis=0), motion.smooth_poses[:-1, 2]
    along = step[:, 0] * np.cos(heading) + step[:, 1] * np.sin(heading)
    along = along[np.isfinite(along)]
    total = np.abs(along).sum()
    return float(along[along > 0].sum() / total) if total > 0 else 0.5


def bends_run(motion: Motion) -> float:
    """+1: every bend runs from head to tail, -1: from tail to head; near 0: they stand."""
    angles, rate = motion.smooth_angles[:-1], np.diff(motion.smooth_angles, axis=0)
    turning = angles[:, 1:] * rate[:, :-1] - angles[:, :-1] * rate[:, 1:]
    turning = turning[np.isfinite(turning).all(axis=1)]
    total = np.abs(turning).sum()
    return float(turning.sum() / total) if total > 0 else 0.0


def way_of_bends(motion: Motion) -> str:
    """Which way its bends run most of the time; empty where they run neither way."""
    run = bends_run(motion)
    if abs(run) <= STANDING:
        return ""
    return "from head to tail" if run > 0 else "from tail to head"


def edges_per_wave(motion: Motion) -> float:
    """Edges that one wave of bending spans, from the mean phase that each joint lags behind the next; infinite: none.

    phase: of the beat; where nothing repeats
    phase = arg sum_t z_{j+1} conj(z_j),     z: analytic signals of the joint angles in the longest stretch
    """
    if motion.beat is not None and motion.beat.waves:
        return (motion.joint_angles.shape[1] + 1) / abs(motion.beat.waves)
    from scipy.signal import hilbert  # as long to import as all the rest, and robots need it not

    run = max(motion.runs, key=lambda r: r.stop - r.start)
    angles = motion.smooth_angles[run]
    bends: NDArray[np.complex128] = hilbert(angles - angles.mean(axis=0), axis=0)
    phase = abs(float(np.angle((bends[:, 1:] * bends[:, :-1].conj()).sum())))
    return 2 * np.pi / phase if phase > 0 else np.inf


@dataclass(frozen=True)
class Stretch:
    """How a length of a body varies: SD, SD of its white noise [body lengths], whether that is more than noise, and the
    share of the path (0 ..) that a body could crawl with it."""

    spread: float
    noise: float
    sure: bool
    share: float


def stretching(body: Body, motion: Motion) -> Stretch:
    """Of the body's length."""
    lengths = shown_lengths(body, motion.markers).sum(axis=1)
    return _stretch(motion, lengths, float(Signal(motion.time_s, lengths[:, None]).noise_variance[0]))


def sliding(body: Body, motion: Motion) -> tuple[Stretch, float]:
    """Of the way along the body to the point that moves most along it, beyond what the length of the whole does; and
    the SD, beyond noise, of edges in proportion to the whole. Noise is that of the usual point. The curve between
    points is guessed: surely more is what chords show, too, and what is more than arcs differ from those by."""
    lengths = shown_lengths(body, motion.markers)
    seen = np.isfinite(lengths).all(axis=1)
    if not seen.any():
        return Stretch(0.0, 0.0, False, 0.0), 0.0
    chords = np.asarray(np.linalg.norm(np.diff(motion.markers, axis=1), axis=2))
    whole = lengths.sum(axis=1) / np.sum(body.edges)
    ways, straight = _ways(body, lengths), _ways(body, chords)
    edges = lengths / np.asarray(body.edges) - whole[:, None]
    most = int(np.argmax(ways[seen].var(axis=0)))
    noise = float(np.median(Signal(motion.time_s, ways).noise_variance))
    found, by_chords = (_stretch(motion, way[:, most], noise) for way in (ways, straight))
    guessed = float((ways - straight)[seen, most].var())
    beyond = edges[seen].var(axis=0) - Signal(motion.time_s, edges).noise_variance
    surely = found.sure and by_chords.sure and found.spread**2 > noise + guessed
    return replace(found, sure=surely), float(np.sqrt(max(beyond.mean(), 0.0)))


def farther_apart(motion: Motion) -> float:
    """How many times farther the usual neighbouring points are apart at their farthest than at their nearest, in all
    but the most extreme frames, beyond noise; 1 where frames are few."""
    apart = np.asarray(np.linalg.norm(np.diff(motion.markers, axis=1), axis=2))
    apart = apart[:, np.isfinite(apart).sum(axis=0) >= LEAST_ROWS]
    if not apart.size:
        return 1.0
    low, high = np.nanquantile(apart, TAILS, axis=0)
    by_noise = OF_TAILS**2 * Signal(motion.time_s, apart).noise_variance
    half = np.sqrt(np.maximum(((high - low) / 2) ** 2 - by_noise, 0.0))
    middle = (high + low) / 2
    return float(np.median((middle + half) / (middle - half)))


def _ways(body: Body, lengths: Floats) -> Floats:
    """From the tail to every point between the ends (F, N - 2), less its share of the whole."""
    share = np.cumsum(body.edges) / np.sum(body.edges)
    return np.asarray((np.cumsum(lengths, axis=1) - lengths.sum(axis=1)[:, None] * share)[:, :-1])


def _stretch(motion: Motion, lengths: Floats, variance: float) -> Stretch:
    """A body crawls with lengths (F,), of such noise, forward by as much as they grow, never back,

        sum |dL| / 2 / sum |dx|      L: smoothed lengths, x: the centroid

    less what white noise alone, smoothed as they are, would crawl.
    """
    runs = [r for run in motion.runs if len(r := np.arange(run.start, run.stop)[np.isfinite(lengths[run])])]
    if not runs:
        return Stretch(0.0, float(np.sqrt(variance)), False, 0.0)
    rng = np.random.default_rng(0)
    noise = np.sqrt(variance) * rng.normal(size=(len(lengths), DRAWS))
    drawn = np.column_stack([lengths, noise])
    ways = sum((_way(motion.time_s[r], drawn[r], variance) for r in runs), start=np.zeros(1 + DRAWS))
    crawled = max(float(ways[0] - ways[1:].mean()), 0.0) / 2
    path = sum(
        float(np.linalg.norm(np.diff(motion.smooth_poses[run, :2], axis=0), axis=1).sum()) for run in motion.runs
    )
    seen = lengths[np.concatenate(runs)]
    robust = float(ROBUST * np.median(np.abs(seen - np.median(seen))))
    triples = int(np.isfinite(np.diff(lengths, n=2)).sum())
    limit = variance * (1 + SURE * np.sqrt(BOTH / max(triples, 1)))
    sure = triples >= LEAST_ROWS and min(robust, float(seen.std())) ** 2 > limit
    return Stretch(float(seen.std()), float(np.sqrt(variance)), bool(sure), crawled / path if path > 0 else 0.0)


def _way(time_s: Floats, columns: Floats, variance: float) -> Floats:
    """Sum of changes (K,) of columns (F, K), all smoothed as the first one asks it."""
    window = best_window(time_s, columns[:, :1], np.full_like(columns[:, :1], variance))
    return np.asarray(np.abs(np.diff(smooth(columns, *smoother(time_s, window)), axis=0)).sum(axis=0))


def remarks(body: Body, motion: Motion, stated: bool = True) -> tuple[str, ...]:
    """Sentences on direction and length; what looks wrong comes with its cure. stated: the file gives the lengths."""
    back = folded(motion.markers)
    if back:
        return (back,)  # all else that could be said comes of it
    rigid = () if body.is_animal else (RIGID,)
    held = followed(motion.markers)
    if held:
        return (*rigid, held, *_clock(motion), *_length(motion))
    head_first = leading(motion)
    which = "head first" if head_first > 0.5 else "tail first"
    way = way_of_bends(motion)
    bends = f"run {way}" if way else "stand, or run to and fro"
    if not Signal(motion.time_s, motion.poses[:, :2]).moves:
        still = "stays where it is: by its points, no farther away than their noise"
        return (*rigid, still, *_clock(motion), *_length(motion))
    found = [*rigid, f"moves {which} ({max(head_first, 1 - head_first):.0%} of the path), its bends {bends}"]
    if head_first < 0.5 and way == "from tail to head":
        found.append(
            "as head and tail would if exchanged, or in a film that runs backwards: if it swam forwards, set "
            "`first_point` (or reverse `markers`)"
        )
    apart = uneven(body, motion.markers) if body.is_animal and stated else ""
    seen = [apart] if apart else _sampling(motion)
    aside = beside_midline(body.edges, motion.smooth_angles) if body.is_animal else None
    seen += [said(aside, body.edges)] if aside else []
    shown = picture(body, motion) if body.is_animal else None
    seen += shown.said() if shown else []
    seen += said_of_smoothing(motion) if body.is_animal else []
    stretching = _stretching(body, as_if_alike(body, motion, shown) if shown else motion)
    return (*found, *_clock(motion), *_cuts(motion), *seen, *stretching, *_length(motion))


def _cuts(motion: Motion) -> list[str]:
    """Where the whole body is somewhere else and goes on from there; there and back it would be no run."""
    leaps = {jump.frame for jump in motion.jumps if jump.vertex is None and _all_of_it(motion, jump)}
    ends = {run.stop for run in motion.runs} & leaps
    moments = [between(*motion.time_s[run.start - 1 : run.start + 1]) for run in motion.runs if run.start in ends]
    if not moments:
        return []
    also = f" and {len(moments) - MOST_TOLD} more" if len(moments) > MOST_TOLD else ""
    split = (
        f"`to_s = {moments[0]}` in the first and `from_s = {moments[0]}` in the second"
        if len(moments) == 1
        else "each begins and ends (`from_s`, `to_s`) at these moments"
    )
    return [
        f"its whole body is elsewhere from one frame to the next at {listed(moments[:MOST_TOLD])}{also} s: is the film "
        "cut there, was the camera moved, or is it another animal? Every side is used by itself, but displacements "
        f"go across: name the file in {len(moments) + 1} trials, {split}"
    ]


def _all_of_it(motion: Motion, jump: Jump) -> bool:
    """Whether most points leap as far as their centroid: where they do not, a few that are wild draw it aside."""
    steps = np.linalg.norm(motion.markers[jump.frame] - motion.markers[jump.frame - 1], axis=1)
    seen = np.isfinite(steps)
    return bool(not seen.any() or np.median(steps[seen]) > jump.size / 2)


def between(before_s: float, after_s: float) -> str:
    """A moment between two frames, with as few digits as tell it from both."""
    digits = max(0, int(np.ceil(-np.log10((after_s - before_s) / 4))))
    return f"{(before_s + after_s) / 2:.{digits}f}"


def _clock(motion: Motion) -> list[str]:
    """Frames that are farther apart than any film of a moving animal has them."""
    apart = float(np.median(np.diff(motion.time_s)))
    unit = next((words for words, seconds in FINER.items() if apart * seconds <= SLOWEST), None)
    if apart <= SLOWEST or unit is None:
        return []
    return [f"its frames are {apart:.3g} s apart: are times in {unit}?"]


def _sampling(motion: Motion) -> list[str]:
    edges, points = edges_per_wave(motion), motion.joint_angles.shape[1] + 2
    if points == 3:
        return [
            "3 points have one joint, which shows no wave and moves no body by drag: no K can be told from them; track "
            f"{LEAST_EDGES:g} edges or more for each wave on the body"
        ]
    if not edges < LEAST_EDGES:
        return []
    return [
        f"{points} points show {(points - 1) / edges:.2g} waves, {edges:.2g} edges a wave: under {LEAST_EDGES:g} the "
        "curve between them is guessed, K comes out too large and what is left looks like a cause; track more points, "
        "or if single points scatter, which makes 2 edges a wave, take every second or third"
    ]


def _stretching(body: Body, motion: Motion) -> list[str]:
    """As a whole, and in places while other places shorten; of noise that lasts neither is said."""
    if motion.stretches.alike:
        return []
    if (times := farther_apart(motion)) > ONE_BODY:
        return [
            f"its neighbouring points are {times:.2g} times as far apart at some times as at others (beyond noise), "
            "which points of a body that bends and stretches are not. Are they points of one body, and in their order "
            "along it? Where each is another animal's (as trackers of groups write them) K means nothing"
        ]
    found, whole = [], stretching(body, motion)
    if whole.sure and whole.share >= LEAST_SHARE:
        found.append(
            f"its length varies by {whole.spread:.1%} (SD; noise {whole.noise:.1%}), and links of the model are rigid: "
            "by lengthening and shortening (peristalsis) a body could crawl "
            f"{min(whole.share, 1):.0%} of this path, which no fit accounts for"
        )
    left = "points are put back along it" if motion.stretches.any else "this passes for noise of the points"
    places, edges = sliding(body, motion)
    if places.sure and places.share >= LEAST_SHARE:
        found.append(
            f"distances of its neighbouring points vary by {edges:.1%} (SD beyond noise) while others make up for it: "
            "it stretches in places (peristalsis), or points slide along it. Links of the model are rigid, "
            f"{left}, and no fit accounts for the {min(places.share, 1):.0%} of this path that a body could crawl with "
            "it"
        )
    return found


def _length(motion: Motion) -> list[str]:
    frames = sum(run.stop - run.start for run in motion.runs)
    found = motion.beat
    seconds = sum(float(motion.time_s[run.stop - 1] - motion.time_s[run.start]) for run in motion.runs)
    if found is None:
        return [f"{seconds:.3g} s, and nothing repeats in it: a fit is possible, but says nothing about other beats"]
    period = found.period_s
    if seconds < SHORT * period:
        return [f"too short: {seconds:.3g} s are {seconds / period:.2g} periods; intervals hold for this beat alone"]
    if frames > LONG:
        part = f"`from_s` and `to_s` with {20 * period:.3g} s (20 periods) tell nearly as much"
        return [f"long: {frames} frames, {seconds / period:.0f} periods; {part}"]
    return []
