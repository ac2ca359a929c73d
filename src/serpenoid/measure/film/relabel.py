"""Which marker is which vertex: names where there are names, the chain's own geometry for unlabelled fragments.

A fragment is one physical marker for a while. It goes to the vertex whose distance to its seen neighbours matches the
edge lengths and whose path it continues; what matches nothing is left out and reported.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from serpenoid.errors import InputError
from serpenoid.measure.cells import Floats, listed
from serpenoid.measure.tracks import Tracks
from serpenoid.wording import counted, meant

GATE = 0.35  # of the median edge: farther from where its path leads, a point is not this vertex
REACH = 12  # frames: over a longer gap a path does not lead
EDGE_TOLERANCE = 0.15  # of an edge: marker noise and loose tape stay well inside, the next vertex well outside


@dataclass(frozen=True)
class Labelled:
    """Vertex positions (F, N, 2), NaN where hidden; which fragments were given to which vertex, and which to none."""

    vertices: Floats
    relabelled: tuple[tuple[str, int], ...]
    unused: tuple[str, ...]
    said: str = ""  # of names and markers that are passed over


def label_vertices(
    tracks: Tracks, markers: tuple[str, ...] | None, edges: Floats | None, count: int, from_head: bool
) -> Labelled:
    """Map markers to the `count` vertices, tail first. Unlabelled fragments are placed by `edges` (N - 1) [m], or,
    where these are not known, by the distances of labelled markers, if all are."""
    if markers is None and not any(tracks.unlabelled):
        return _by_order(tracks, count, from_head)
    vertices = np.full((len(tracks.time_s), count, 2), np.nan)
    named = markers or ()
    for vertex, name in enumerate(named):
        if name in tracks.names:
            vertices[:, vertex] = tracks.floor[:, tracks.names.index(name)]
    if markers is not None and not any(name in tracks.names for name in named) and not any(tracks.unlabelled):
        raise InputError(
            f"{tracks.source}: none of the campaign's `markers` is in it; it has {', '.join(tracks.names[:8])}."
            f"{_subjects(tracks.names, named)}"
        )
    others = tuple(n for m, n in enumerate(tracks.names) if n not in named and not tracks.unlabelled[m])
    _refuse_misspelt(tracks, named, others)
    free = [m for m, name in enumerate(tracks.names) if name not in named and tracks.unlabelled[m]]
    free = [m for m in free if tracks.seen[:, m].any()]
    if not free:
        return Labelled(vertices, (), others)
    if edges is None:
        never = [name for name, seen in zip(named, np.isfinite(vertices[..., 0]).any(axis=0), strict=True) if not seen]
        if never or not named:
            lacking = f"`{never[0]}` has no label in it" if never else "the campaign names no `markers`"
            raise InputError(
                f"{tracks.source}: unlabelled markers need `edge_lengths` in [body] to be told apart, where {lacking}. "
                "Or label all points of the body where they were recorded, and export the file again."
            )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # neighbours that are never seen together fit nothing
            edges = np.nanmedian(np.linalg.norm(np.diff(vertices, axis=1), axis=2), axis=0)
        found = _place_fragments(tracks, vertices, free, edges, others)
        return replace(found, said=_left_out(tracks, found, named))
    return _place_fragments(tracks, vertices, free, edges, others)


def _left_out(tracks: Tracks, found: Labelled, named: Sequence[str]) -> str:
    """What is said of fragments that found no place beside labels, by distances that these show; where one may be a
    point that is hidden meanwhile, what to do."""
    free = [m for m, name in enumerate(tracks.names) if tracks.unlabelled[m] and name in found.unused]
    if not free:
        return ""
    hidden = np.isnan(found.vertices[..., 0])
    meanwhile = (hidden & tracks.seen[:, free].any(axis=1, keepdims=True)).sum(axis=0)
    names = listed([f"`{tracks.names[m]}`" for m in free[:3]])
    said = f"{len(free)} unlabelled marker{'s' * (len(free) > 1)} left out ({names}): no place on the body fits"
    if not meanwhile.any():
        return said
    which = int(meanwhile.argmax())
    return (
        f"{said}. `{named[which]}` is hidden in {meanwhile[which]} frames that "
        "show one of them: if it is this, label it where it was recorded"
    )


def _refuse_misspelt(tracks: Tracks, named: tuple[str, ...], others: tuple[str, ...]) -> None:
    """A name that is not in the file beside markers that nobody names: one vertex would count as always hidden."""
    missing = [name for name in named if name not in tracks.names]
    if not missing or not others:
        return
    raise InputError(
        f"{tracks.source}: `markers` in [motion] names {', '.join(f'`{name}`' for name in missing)}, not in this file, "
        f"which has {', '.join(f'`{name}`' for name in others[:8])} for no vertex.{meant(missing[0], others)}"
        f"{_subjects(others, named)}"
    )


def _subjects(names: Sequence[str], wanted: Sequence[str]) -> str:
    """Which subjects a file's markers are of, where other ones are wanted: names are SUBJECT:MARKER."""
    there, asked = ({name.partition(":")[0] for name in group if ":" in name} for group in (names, wanted))
    if not there or asked & there:
        return ""
    mine = ", ".join(f"`{subject}:`" for subject in sorted(there))
    theirs = ", ".join(f"`{subject}:`" for subject in sorted(asked)) or "no subject"
    return f" Its names begin with {mine}, those of `markers` with {theirs}."


def _by_order(tracks: Tracks, count: int, from_head: bool) -> Labelled:
    if len(tracks.names) != count:
        names = ", ".join(f"`{name}`" for name in tracks.names[:3])
        raise InputError(
            f"{tracks.source}: {counted(len(tracks.names), 'marker')} for {count} vertices: in [motion], name those "
            f"of the vertices, tail first, as `markers` (the file's are {names}, ...), or say as `vertices` which have "
            "one."
        )
    if not tracks.in_order:
        raise InputError(
            f"{tracks.source}: no frame has all points, and their names do not say in which order they are along the "
            f"body: give them as `markers` in [motion], tail first; the file has {', '.join(tracks.names[:8])}."
        )
    return Labelled(tracks.floor[:, ::-1] if from_head else tracks.floor, (), ())


def _place_fragments(
    tracks: Tracks, vertices: Floats, free: list[int], edges: Floats, others: tuple[str, ...]
) -> Labelled:
    placed: list[tuple[str, int]] = []
    if not np.isfinite(vertices).any():
        seed = _seed(tracks, free, edges)
        for vertex, marker in enumerate(seed):
            _fill(vertices, vertex, tracks.floor[:, marker])
            placed.append((tracks.names[marker], vertex))
        free = [m for m in free if m not in seed]
    waiting = sorted(free, key=lambda m: int(np.flatnonzero(tracks.seen[:, m])[0]))
    while waiting:
        scores = [(_best_vertex(vertices, tracks.floor[:, m], edges), m) for m in waiting]
        usable = [((cost, vertex), m) for (cost, vertex), m in scores if vertex >= 0]
        if not usable:
            break
        (_, vertex), marker = min(usable)
        _fill(vertices, vertex, tracks.floor[:, marker])
        placed.append((tracks.names[marker], vertex))
        waiting.remove(marker)
    return Labelled(vertices, tuple(placed), others + tuple(tracks.names[m] for m in waiting))


def _fill(vertices: Floats, vertex: int, path: Floats) -> None:
    empty = ~np.isfinite(vertices[:, vertex, 0])
    vertices[empty, vertex] = path[empty]


def _best_vertex(vertices: Floats, path: Floats, edges: Floats) -> tuple[float, int]:
    """(cost, vertex) of the vertex this fragment fits best, or (inf, -1)."""
    best = (np.inf, -1)
    present = np.isfinite(path[:, 0])
    for vertex in range(vertices.shape[1]):
        if (present & np.isfinite(vertices[:, vertex, 0])).any():
            continue  # seen elsewhere at the same time
        costs = [_edge_cost(vertices, path, vertex, edges), _continuity_cost(vertices[:, vertex], path, edges)]
        known = [cost for cost in costs if np.isfinite(cost)]
        if known and max(known) <= 1:
            best = min(best, (max(known), vertex))
    return best


def _edge_cost(vertices: Floats, path: Floats, vertex: int, edges: Floats) -> float:
    """Largest median deviation from the edge lengths to seen neighbours, in tolerances; NaN: no neighbour seen."""
    worst = np.nan
    for neighbour, edge in ((vertex - 1, vertex - 1), (vertex + 1, vertex)):
        if not 0 <= neighbour < vertices.shape[1]:
            continue
        gap = np.linalg.norm(path - vertices[:, neighbour], axis=1)
        gap = gap[np.isfinite(gap)]
        if len(gap):
            worst = np.fmax(worst, np.median(np.abs(gap - edges[edge])) / (EDGE_TOLERANCE * edges[edge]))
    return float(worst)


def _continuity_cost(known: Floats, path: Floats, edges: Floats) -> float:
    """Jump between this fragment's ends and the vertex's nearest known positions, in gates; NaN: none within reach."""
    seen, mine = np.flatnonzero(np.isfinite(known[:, 0])), np.flatnonzero(np.isfinite(path[:, 0]))
    worst = np.nan
    for end, near in ((mine[0], seen[seen < mine[0]][-1:]), (mine[-1], seen[seen > mine[-1]][:1])):
        if len(near) and abs(int(near[0]) - int(end)) <= REACH:
            inside = end + 1 if end == mine[0] else end - 1
            speed = (
                (path[inside % len(path)] - path[end]) * (inside - end)
                if np.isfinite(path[inside % len(path), 0])
                else 0.0
            )
            jump = float(np.linalg.norm(path[end] - known[near[0]] - speed * (end - near[0])))
            worst = np.fmax(worst, jump / (GATE * np.median(edges)))
    return float(worst)


def _seed(tracks: Tracks, free: list[int], edges: Floats) -> list[int]:
    """A frame with a whole chain in it: the markers in the order of the vertices."""
    counts = tracks.seen[:, free].sum(axis=1)
    for frame in np.argsort(-counts, kind="stable")[:50]:
        here = [m for m in free if tracks.seen[frame, m]]
        chains = _chains(tracks.floor[frame, here], edges)
        if len(chains) == 1:
            return [here[i] for i in chains[0]]
        if len(chains) > 1:
            raise InputError(
                f"{tracks.source}: the campaign names no `markers`, and the chain fits {len(chains)} ways round. "
                "Name at least the head or tail marker there."
            )
    raise InputError(
        f"{tracks.source}: the campaign names no `markers`, and in no frame do {len(edges) + 1} form a chain with the "
        f"body's edge lengths in one way. {_to_name(tracks)}Is the length unit right, are all markers there?"
    )


def _to_name(tracks: Tracks) -> str:
    """Which markers of the file have a name, if any has: `markers` could say who is who."""
    named = [name for name, without in zip(tracks.names, tracks.unlabelled, strict=True) if not without]
    return f"Say them in [motion], tail first; the file has {', '.join(named[:20])}. " if named else ""


def _chains(points: Floats, edges: Floats) -> list[list[int]]:
    """Every order of distinct points whose successive distances are the edge lengths."""
    distance = np.linalg.norm(points[:, None] - points[None], axis=2)
    partial = [[i] for i in range(len(points))]
    for edge in edges:
        near = np.abs(distance - edge) <= EDGE_TOLERANCE * edge
        partial = [[*chain, j] for chain in partial for j in np.flatnonzero(near[chain[-1]]).tolist() if j not in chain]
    return partial
