"""A campaign's files as read: tracks, logs and tables of every trial, markers given to vertices, nothing aligned."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import LEAST, LONGEST, Body
from serpenoid.errors import InputError
from serpenoid.files.store import file_digest, remember
from serpenoid.measure.campaign import CampaignFile, MotionKeys, TrialEntry, read_motion, read_table
from serpenoid.measure.cells import Floats
from serpenoid.measure.film.filled_in import without_filled_in
from serpenoid.measure.film.level import levelled
from serpenoid.measure.film.placeholders import without_placeholders
from serpenoid.measure.film.relabel import Labelled, label_vertices
from serpenoid.measure.film.repeated import without_repeated
from serpenoid.measure.formats.readers import READERS, up_axis
from serpenoid.measure.logs import PowerLog, ServoLog, read_power_log, read_servo_log
from serpenoid.measure.schedule import Schedule
from serpenoid.measure.shapes.lengths import shown_lengths, usual, without_noise
from serpenoid.measure.tracks import Tracks, in_places
from serpenoid.parallel import in_processes
from serpenoid.wording import counted

Progress = Callable[[int, int, str], None]
T = TypeVar("T")
CELL = re.compile(r"(?<=, got )'[^']*'")  # what a cell of one file holds
FEWEST_FRAMES = 8  # less is no motion
UNSEEN = "Give `edge_lengths`, or is `minimum_score` in [motion] too high (DeepLabCut: 0.6 unless given)?"


@dataclass(frozen=True)
class Files:
    """One trial's files; exchanged_back: which points had other names, and when, empty where none had; mended: what was
    done to its tracks before anything was made of them, in words."""

    entry: TrialEntry
    keys: MotionKeys
    table: Floats | None
    servo_log: ServoLog | None
    power_log: PowerLog | None
    tracks: Tracks | None
    labelled: Labelled | None
    exchanged_back: str = ""
    mended: tuple[str, ...] = ()

    def names(self, body: Body) -> list[str]:
        """What the marker of each vertex is called: in the campaign, else in the file."""
        return marker_names(self.tracks, self.keys, body)

    @property
    def schedule(self) -> Schedule | None:
        """As the campaign file promises it; its start is not known yet."""
        entry = self.entry
        if self.table is None or entry.cycle_duration_s is None:
            return None
        return Schedule(self.table, entry.cycle_duration_s, entry.cycles or 1, entry.pause_s)


def read_files(file: CampaignFile, folder: Path, progress: Progress | None = None) -> tuple[Body, tuple[Files, ...]]:
    """All files of all trials, and the body with its lengths, estimated where the campaign gives none."""
    read = of_every_trial(file.trial, lambda entry: read_trial(file, entry, folder), progress)
    body = file.body if file.lengths_given else _estimate_lengths(file, read)
    return (body.uniform() if file.uniform else body), tuple(read)


def of_every_trial(
    entries: Sequence[TrialEntry], work: Callable[[TrialEntry], T], progress: Progress | None = None
) -> list[T]:
    """`work` of every trial, in order; one InputError that names every trial at fault."""

    def begun(index: int) -> None:
        if progress is not None:
            progress(index, len(entries), entries[index].name)

    found = in_processes([(_or_fault, (work, entry)) for entry in entries], begun)
    faults = [(entry, str(one)) for entry, one in zip(entries, found, strict=True) if isinstance(one, InputError)]
    if faults:
        raise InputError(by_words([(entry.name, *_of_file(entry, words)) for entry, words in faults]))
    return found


def _or_fault(work: Callable[[TrialEntry], T], entry: TrialEntry) -> T | InputError:
    """What is wrong with a trial is said together with what is wrong with the others."""
    try:
        return work(entry)
    except InputError as error:
        return error


def _of_file(entry: TrialEntry, words: str) -> tuple[str, str, str]:
    """A fault's words without the file they begin with, that file's folder, and its name."""
    for name in (entry.joint_table, entry.motion, entry.servo_log, entry.power_log):
        before, there, rest = words.partition(f"{name}: ") if name else ("", "", "")
        whole = not before or before.endswith(os.sep)  # not the end of another file's name
        if there and whole and ": " not in before:
            return rest, before, str(name)
    return words, "", ""


def by_words(faults: Sequence[tuple[str, str] | tuple[str, str, str, str]]) -> str:
    """Lines `trials NAMES: FILES: WORDS` of (trial, words, folder, file): what is said of several is said once, with
    what the first one's file has there."""
    trials: dict[str, list[str]] = {}
    files: dict[str, list[str]] = {}
    first: dict[str, tuple[str, str]] = {}
    for trial, words, *file in faults:
        alike = CELL.sub("", words)
        trials.setdefault(alike, []).append(f"`{trial}`")
        files.setdefault(alike, []).extend(file[1:])
        first.setdefault(alike, ("".join(file[:1]), words))
    said = []
    for alike, names in trials.items():
        folder, words = first[alike]
        of = ", ".join(dict.fromkeys(files[alike]))
        where = f"{folder}{of}: " if of else ""
        said.append(f"trial{'s' * (len(names) > 1)} {', '.join(names)}: {where}{words}")
    return "\n".join(said)


def content(file: CampaignFile, folder: Path) -> list[tuple[str, str]]:
    """Name and SHA-256 of every file that a campaign is made from, and of the joint tables it is compared with."""
    named = [n for t in file.trial for n in (t.joint_table, t.motion, t.servo_log, t.power_log) if n is not None]
    tables = {(folder / t.joint_table).parent for t in file.trial if t.joint_table is not None}
    beside = [path for place in sorted(tables) for path in sorted(place.glob("*.csv"))]
    paths = [Path(os.path.realpath(path)) for path in dict.fromkeys([*(folder / n for n in named), *beside])]
    return [(str(path), file_digest(path)) for path in paths]


def unchanged(file: CampaignFile, folder: Path, then: list[tuple[str, str]], found: T) -> T:
    """What was made of a campaign's files, if these still are what they were `then` (see `content`). InputError else: a
    copy that still runs must not be kept as what it will have become."""
    if content(file, folder) != then:
        raise InputError(f"{folder}: its files were written while they were read. Run it again when they are complete.")
    return found


def kept_of_files(name: str, file: CampaignFile, folder: Path, make: Callable[[], T], *more: Any) -> T:
    """What `make` makes of a campaign's files and `more`, from an earlier run if these are the same."""
    now = content(file, folder)
    return remember(lambda: unchanged(file, folder, now, make()), name, file, now, *more)


def check_frames(tracks: Tracks) -> None:
    """InputError where so few of them are no motion."""
    frames = len(tracks.time_s)
    if frames < FEWEST_FRAMES:
        raise InputError(f"{tracks.source}: {counted(frames, 'frame')}; a motion takes {FEWEST_FRAMES} or more.")


def read_trial(file: CampaignFile, entry: TrialEntry, folder: Path) -> Files:
    """Read one trial's files."""
    keys, tracks = file.motion_of(entry), read_motion(file, entry, folder)
    labelled, exchanged = None, ""
    mended: tuple[str, ...] = ()
    if tracks is not None:
        tracks, mended = _mended(tracks, keys.up_axis or up_axis(keys.format))
        check_frames(tracks)
        edges = file.body.edges_m if file.lengths_given and tracks.scale_known else None
        labelled = label_markers(tracks, keys, edges, file.body)
        if said := _without_effect(file, entry, tracks):
            labelled = replace(labelled, said=said)
        if keys.undo_exchanges:
            from serpenoid.measure.consistency.exchanged import named_as_in_most, told  # SciPy, long to import

            vertices, found = named_as_in_most(labelled.vertices, tracks.time_s)
            labelled = replace(labelled, vertices=vertices)
            exchanged = told(found, marker_names(tracks, keys, file.body), tracks.time_s)
    log = read_servo_log(folder / entry.servo_log, file.servo_log) if entry.servo_log else None
    _of_every_joint(log, file.body)
    power = read_power_log(folder / entry.power_log) if entry.power_log else None
    return Files(entry, keys, read_table(entry, file.body, folder), log, power, tracks, labelled, exchanged, mended)


def _mended(tracks: Tracks, up: str) -> tuple[Tracks, tuple[str, ...]]:
    """Tracks without frames and points that nobody saw, in the plane of their floor; and what was done, in words."""
    tracks, absent = without_placeholders(tracks)
    tracks, again = without_repeated(tracks)
    tracks, made = without_filled_in(tracks)
    tracks, turned = levelled(tracks, up)
    return tracks, tuple(words for words in (absent, again, made, turned) if words)


def _of_every_joint(log: ServoLog | None, body: Body) -> None:
    """Refuse a log of more or fewer joints than the body's: nobody could say which joint a column is of."""
    if log is not None and (count := log.position.shape[1]) != body.joint_count:
        raise InputError(
            f"{log.source}: has the positions of {count} joint{'s' * (count != 1)}, the body has {body.joint_count}. "
            "Check `vertices` and `joints` in [body], and `position` in [servo_log]; or leave `servo_log` out."
        )


def label_markers(tracks: Tracks, keys: MotionKeys, edges: Floats | None, body: Body) -> Labelled:
    """Tracks as vertices 0 .. N - 1, NaN where none has a marker, by names and edge lengths (N - 1,), if known."""
    markers = None if _labels_alone(tracks, keys) else keys.markers
    marked, first = keys.marked(body.vertices), keys.first_point or tracks.first_point
    if tracks.first_point not in (None, first):
        raise InputError(
            f'{tracks.source}: says that its first point is the {tracks.first_point}: leave `first_point = "{first}"` '
            "in [motion] out, or correct the file."
        )
    found = label_vertices(tracks, markers, _between(marked, edges, body), len(marked), first == "head")
    vertices = np.full((len(found.vertices), body.vertices, 2), np.nan)
    vertices[:, marked] = found.vertices
    return replace(found, vertices=vertices, relabelled=tuple((name, marked[k]) for name, k in found.relabelled))


def _labels_alone(tracks: Tracks, keys: MotionKeys) -> bool:
    """Whether `markers` only says what vertices are called, of a file whose points are the vertices in their order:
    where it names one of those points, it says which of them are taken, and in which order."""
    of_vertices = keys.format is not None and READERS[keys.format].vertices
    return of_vertices and not {*tracks.names} & {*(keys.markers or ())}


def _without_effect(file: CampaignFile, entry: TrialEntry, tracks: Tracks) -> str:
    """What is said of `markers` that are for such a file, and name none of its points; else ""."""
    keys = file.motion_of(entry)
    of_another = entry.markers is None and entry.format not in (None, file.motion.format)
    if not keys.markers or not _labels_alone(tracks, keys) or of_another or not file.tracked_only:
        return ""
    return (
        f"`markers` names none of its points, which are called `{tracks.names[0]}` .. `{tracks.names[-1]}` (in the "
        "order of their columns): it chooses none of them, and puts none elsewhere. Use these names, or leave it out"
    )


def marker_names(tracks: Tracks | None, keys: MotionKeys, body: Body) -> list[str]:
    """What the marker of each vertex is called: in the campaign, or in the file where it gives points in order."""
    names, marked = keys.labels(body.vertices), keys.marked(body.vertices)
    in_order = keys.markers is None and tracks is not None and not any(tracks.unlabelled)
    if tracks is None or not in_order or len(tracks.names) != len(marked):
        return names
    head_first = (keys.first_point or tracks.first_point) == "head"
    for vertex, name in zip(marked, tracks.names[::-1] if head_first else tracks.names, strict=True):
        names[vertex] = name if keys.vertices is None else f"{name} (vertex {vertex})"
    return [f"vertex_{k}" for k in range(body.vertices)] if tracks.names == in_places(len(marked)) else names


def _between(marked: Sequence[int], edges: Floats | None, body: Body) -> Floats | None:
    """Distances (M - 1,) of neighbouring markers; None where they are unknown, or a joint between two changes one."""
    found = None if edges is None else stated_between(marked, edges, body)
    return None if found is None or np.isnan(found).any() else found


def stated_between(vertices: Sequence[int], edges: Floats, body: Body) -> Floats:
    """Distances (M - 1,) between successive ones of M vertices, by edge lengths (N - 1,); NaN across a joint."""
    bent = [any(a < joint < b for joint in body.joint_vertices) for a, b in pairwise(vertices)]
    return np.where(bent, np.nan, np.diff(np.concatenate([[0.0], np.cumsum(edges)])[list(vertices)]))


def ever_seen(vertices: Floats) -> NDArray[np.int64]:
    """Which vertices (F, N, 2) have a marker that is ever seen."""
    return np.flatnonzero(np.isfinite(vertices[..., 0]).any(axis=0))


def neighbour_ratio(vertices: Floats, body: Body) -> float:
    """Measured over stated distance of neighbours, the median; NaN where no two are ever seen together."""
    shown = ever_seen(vertices)
    distances = np.linalg.norm(np.diff(vertices[:, shown], axis=1), axis=2)
    if body.is_animal and len(shown) == body.vertices:
        distances = shown_lengths(body, vertices)
    stated = stated_between(shown.tolist(), body.edges_m, body)
    known = np.isfinite(distances).any(axis=0) & np.isfinite(stated)
    return float(np.median(np.nanmedian(distances[:, known], axis=0) / stated[known])) if known.any() else np.nan


def _estimate_lengths(file: CampaignFile, read: Sequence[Files]) -> Body:
    """The body with the usual edge lengths over all recordings, by what its points show; where these stand along an
    animal's curve is known from the lengths, which are therefore found once more."""
    body = file.body
    for _ in range(2 if body.is_animal else 1):
        together = _shown(body, read)
        never = np.flatnonzero(~np.isfinite(together).any(axis=0))
        if len(never):
            labels = next(files for files in read if files.labelled is not None).names(body)
            seen = {
                k for files in read if files.labelled is not None for k in ever_seen(files.labelled.vertices).tolist()
            }
            if unseen := [f"`{label}`" for k, label in enumerate(labels) if k not in seen]:
                are = "is" if len(unseen) == 1 else "are"
                raise InputError(
                    f"[body] has no lengths, and {', '.join(unseen)} {are} never seen, in no frame of any recording. "
                    f"{UNSEEN} Of an animal, leave such points out: name the others as `markers`, and count `vertices` "
                    "again."
                )
            pairs = ", ".join(f"`{labels[k]}` and `{labels[k + 1]}`" for k in never)
            raise InputError(f"[body] has no lengths, and these neighbours are never seen together: {pairs}. {UNSEEN}")
        body = body.changed(edge_lengths=_within_reason(_lengths(body, together)))
    return body


def _within_reason(edges: Floats) -> tuple[float, ...]:
    """Edges (N - 1,) that a body can have."""
    odd = edges[(edges < LEAST) | (edges > LONGEST)]
    if odd.size:
        raise InputError(
            f"[body] has no lengths, and by its points an edge is {odd[0]:.3g} m long (median of all frames). Is "
            "`length_unit` in [motion] right? Are numbers among them that stand for nothing?"
        )
    return tuple(edges.tolist())


def other_lengths(body: Body, read: Sequence[Files], blocks: int) -> Floats:
    """What lengths would be estimated from all frames but a block's, for every block: (blocks, N - 1)."""
    together = _shown(body, read)
    whole, found = _lengths(body, together), []
    for part in np.array_split(np.arange(len(together)), blocks):
        left = np.delete(together, part, axis=0)
        ever = np.isfinite(left).any(axis=0)
        found.append(np.where(ever, _middle(body, np.where(ever, left, 0.0)), whole))
    return np.stack(found)


def _shown(body: Body, read: Sequence[Files]) -> Floats:
    """Lengths of the edges in every frame of all recordings: (F, N - 1)."""
    shown = [(f.tracks.time_s, f.labelled.vertices) for f in read if f.tracks is not None and f.labelled is not None]
    distances = [without_noise(body, *each) if body.is_animal else shown_lengths(body, each[1]) for each in shown]
    if not distances:
        raise InputError("[body] has no lengths and no trial has a motion file to estimate them from.")
    return np.concatenate(distances)


def _lengths(body: Body, together: Floats) -> Floats:
    """Of every edge (N - 1,); InputError where one is never seen."""
    ever = np.isfinite(together).any(axis=0)
    edges = np.full(together.shape[1], np.nan)
    edges[ever] = _middle(body, together[:, ever])
    if not np.isfinite(edges).all() or (edges <= 0).any():
        raise InputError("[body] has no lengths, and some neighbouring markers are never seen together.")
    return edges


def _middle(body: Body, together: Floats) -> Floats:
    """Of columns (F, c) the medians, of an animal the means of what is usual: its edges are short beside noise, which
    lengthens one by what it shortens the next by, and means keep that."""
    return usual(together) if body.is_animal else np.asarray(np.nanmedian(together, axis=0))
