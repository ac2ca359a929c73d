"""A campaign's files as claims to be checked, and what becomes of contradictions: refused, or said in every answer."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from serpenoid.body import Body
from serpenoid.errors import InputError
from serpenoid.measure.campaign import CampaignFile, load_campaign_file
from serpenoid.measure.cells import Floats, clock
from serpenoid.measure.consistency.blame import Contradiction
from serpenoid.measure.consistency.check import Verdict, check
from serpenoid.measure.consistency.claim import Claim, outline
from serpenoid.measure.consistency.copies import copied_films, copied_logs
from serpenoid.measure.consistency.exchanged import exchanges, told
from serpenoid.measure.consistency.fallen import fallen
from serpenoid.measure.consistency.films import Films, films_of, wrong_edges
from serpenoid.measure.consistency.frozen import frozen, frozen_said, hung, hung_said
from serpenoid.measure.consistency.geometry import Plane, marker_faults
from serpenoid.measure.consistency.hanging import hanging, hanging_unmoved
from serpenoid.measure.consistency.layout import layout
from serpenoid.measure.consistency.leaps import leap
from serpenoid.measure.consistency.lengths import other_bodies
from serpenoid.measure.consistency.lost_frames import Lost, set_on
from serpenoid.measure.consistency.reach import reach
from serpenoid.measure.consistency.rivals import ODDS
from serpenoid.measure.consistency.signals import Signal
from serpenoid.measure.formats.columns import AngleUnit
from serpenoid.measure.formats.readers import up_axis
from serpenoid.measure.logs import ServoLog
from serpenoid.measure.remark import Remark, remarks_of
from serpenoid.measure.shapes.links import marker_angles
from serpenoid.measure.tracks import Tracks
from serpenoid.measure.trial_files import Files, by_words, ever_seen, label_markers, neighbour_ratio, read_files
from serpenoid.parallel import in_processes
from serpenoid.table_file import read_table as read_joint_table

Believed = tuple[Body, tuple[Files, ...], dict[str, tuple[Remark, ...]]]
Reader = Callable[[CampaignFile, Path], Believed]
MOST_TABLES = 100  # that a campaign is compared with
PLAYED = {"play", "pause"}  # phases of a servo log in which the table is followed


def believe(
    file: CampaignFile, folder: Path, body: Body, read: Sequence[Files]
) -> tuple[tuple[Files, ...], dict[str, tuple[Remark, ...]]]:
    """All files, films' clocks set on where frames are missing, and remarks on every trial by name. Raises InputError
    with every contradiction and its likely cure.

    A trial with `believe = true` is computed all the same, its clock as it is, and the contradiction is among its
    remarks.
    """
    films = films_of(file, body, read)
    verdict = check_files(file, folder, body, read, films)
    believed = {files.entry.name for files in read if files.entry.believe}
    refused = [c for c in verdict.contradictions if c.trial not in believed]
    if refused:
        raise InputError(
            by_words([(c.trial, c.said) for c in refused])
            + "\nThe campaign contradicts itself, so nothing is computed from it. Mend campaign.toml, or set "
            "`believe = true` in a trial to go on regardless."
        )
    hang = {one.trial for one in verdict.contradictions if one.kind == "hanging"}
    remarks: dict[str, list[Remark]] = defaultdict(list)
    for trial, words in verdict.remarks:
        remarks[trial].append(Remark(words))
    for files in read:
        remarks[files.entry.name] += remarks_of(_noticed(files, body, files.entry.name in hang))
    if films is not None and not any(one.kind == "length" for one in verdict.contradictions):
        for trial, remark in films.said.items():
            remarks[trial].append(remark)
    for one in verdict.contradictions:
        remarks[one.trial].append(Remark(f"believed against its data: {one.words} ({one.cure})"))
    torn = {trial: places for trial, places in verdict.torn.items() if trial not in believed}
    mended = tuple(_set_on(files, torn.get(files.entry.name, ())) for files in read)
    return mended, {trial: tuple(said) for trial, said in remarks.items()}


def _noticed(files: Files, body: Body, hangs: bool) -> list[str]:
    """What one trial's own files show; hangs: whether it is a contradiction already that its film stands still."""
    said = []
    if files.exchanged_back:
        said.append(f"names put back as in most of the recording: {files.exchanged_back}")
    said.extend(files.mended)
    if files.servo_log is not None and (count := files.servo_log.repeated):
        said.append(f"{count} rows of the servo log are the row before them to the last character: each is read once")
    if files.servo_log is not None and (absent := files.servo_log.absent):
        said.append(f"the servo log has no column {', '.join(absent)}, which [servo_log] names: is it misspelt?")
    if files.labelled is not None and (still := frozen_said(frozen(files.labelled.vertices), files.names(body))):
        said.append(still)
    if files.labelled is not None and files.tracks is not None:
        stops = hung_said(hung(files.labelled.vertices), files.tracks.time_s)
        said += [stops] if stops else []
        stands = hanging_unmoved(files.labelled.vertices, files.tracks.time_s)
        said += [stands.said] if stands and not hangs else []
    return said


def _set_on(files: Files, torn: Sequence[Lost]) -> Files:
    if files.tracks is None or not torn:
        return files
    return replace(files, tracks=replace(files.tracks, time_s=set_on(files.tracks.time_s, torn)))


def read_believed(file: CampaignFile, folder: Path) -> Believed:
    """All files of all trials, the body, and remarks on every trial by name; InputError as in `believe`."""
    body, read = read_files(file, folder)
    return body, *believe(file, folder, body, read)


def contradictions(path: str | Path) -> tuple[Contradiction, ...]:
    """All contradictions of a campaign folder, whatever `believe` says."""
    file, folder = load_campaign_file(path)
    body, read = read_files(file, folder)
    return check_files(file, folder, body, read, films_of(file, body, read)).contradictions


def check_files(file: CampaignFile, folder: Path, body: Body, read: Sequence[Files], films: Films | None) -> Verdict:
    """Markers first: where they contradict the body, shapes mean nothing, and nothing else is looked at."""
    seen = in_processes([(_seen, (file, body, files)) for files in read])
    markers = [fault for faults, _ in seen for fault in faults]
    markers += copied_films(read) + (wrong_edges(films) if file.lengths_given else _lengths(body, read))
    if markers:
        return Verdict(tuple(markers), (), ())
    verdict = check([claim for _, claim in seen if claim is not None], _tables(read, folder))
    own = {files.entry.name: files for files in read}
    said = [_likeliest(file, body, own[c.trial], c) if c.kind == "nothing" else c for c in verdict.contradictions]
    accused = {one.trial for one in said}
    copies = [(one.trial, one.said) for one, other in copied_logs(read) if not accused & {one.trial, other}]
    return replace(verdict, contradictions=tuple(said), remarks=(*verdict.remarks, *copies))


def _likeliest(file: CampaignFile, body: Body, files: Files, lost: Contradiction) -> Contradiction:
    """Where nothing explains a motion the contract is not believed any more: what markers make likelier is said,
    of the whole recording or of a part."""
    if files.tracks is None or files.labelled is None:
        return lost
    found = _exchanged(body, files, 0.0) or _markers(file, body, files, 0.0)
    return found[0] if found else lost


def _seen(file: CampaignFile, body: Body, files: Files) -> tuple[list[Contradiction], Claim | None]:
    """What is wrong with a trial's markers; else what it claims, its witnesses' periods known."""
    faults = _leaps(files) or _exchanged(body, files) or _fallen(body, files) or _markers(file, body, files)
    if faults:
        return faults, None
    claim = _claim(body, files, file.servo_log.angle_unit)
    stands = None if files.labelled is None else hanging(claim, files.labelled.vertices)
    if stands is not None:
        return [Contradiction(claim.trial, "hanging", stands.words, stands.cure, np.inf)], None
    for signal in (claim.servos, claim.film):
        if signal is not None and signal.enough:
            _ = signal.period_s  # goes with it
    return [], claim


def _leaps(files: Files) -> list[Contradiction]:
    """All markers somewhere else from one frame to the next."""
    if files.tracks is None or files.labelled is None:
        return []
    words = leap(files.labelled.vertices, files.tracks.time_s)
    cure = (
        "was another body tracked, did positions run away, or is the film cut there? Leave such cells empty, or end "
        "the trial before (`to_s`), and begin another there (`from_s`)"
    )
    return [] if words is None else [Contradiction(files.entry.name, "leap", f"its markers {words}", cure, np.inf)]


def _exchanged(body: Body, files: Files, odds: float = ODDS) -> list[Contradiction]:
    """Points whose names are exchanged for a part of the recording."""
    if files.tracks is None or files.labelled is None:
        return []
    time, labels = files.tracks.time_s, files.names(body)
    found = exchanges(files.labelled.vertices, time, odds)
    if not found:
        return []
    words = f"its markers have {told(found, labels, time)}"
    cure = (
        "set `undo_exchanges = true` (names that hold for most of the recording are right), exchange them there in the "
        "file, or leave that part out by `from_s` and `to_s`"
    )
    return [Contradiction(files.entry.name, "markers", words, cure, max(one.gain for one in found))]


def _fallen(body: Body, files: Files) -> list[Contradiction]:
    """A marker that lies on the floor from some moment on."""
    if files.tracks is None or files.labelled is None or body.is_animal:
        return []
    shown = ever_seen(files.labelled.vertices).tolist()
    names, time = files.names(body), files.tracks.time_s
    cure = "did it fall off? Leave its cells empty from there on, or end the trial there: `to_s = {}`"
    return [
        Contradiction(files.entry.name, "fallen", f"its marker {one.words(names[shown[one.marker]], time)}",
                      cure.format(clock(time[one.frame])), np.inf)
        for one in fallen(files.labelled.vertices[:, shown])[:1]
    ]  # fmt: skip


def _markers(file: CampaignFile, body: Body, files: Files, odds: float = ODDS) -> list[Contradiction]:
    if files.tracks is None or files.labelled is None:
        return []
    tracks, keys, vertices = files.tracks, files.keys, files.labelled.vertices
    edges = body.edges_m if file.lengths_given else None
    if edges is not None and not tracks.scale_known:
        edges = edges * neighbour_ratio(vertices, body)
        if np.isnan(edges).any():  # nothing tells how large a pixel is
            return []
    shown = list(keys.marked(body.vertices)) if edges is None else ever_seen(vertices).tolist()
    plan = layout(vertices[:, shown], None if edges is None else reach(body, edges, vertices, shown))
    if len(shown) < 2 or not len(plan.points):
        return []
    every = files.names(body)

    def other(floor: Floats) -> Floats:
        changed = Tracks(tracks.time_s, tracks.names, floor, tracks.source, tracks.unlabelled, tracks.scale_known)
        return label_markers(changed, keys, edges, body).vertices[:, shown]

    up = keys.up_axis or up_axis(keys.format)
    plane = None if tracks.space is None else Plane(tracks.space, up, other)
    found = marker_faults(plan, [every[k] for k in shown], plane)
    certain = [fault for fault in found[:1] if fault.gain > odds]
    return [Contradiction(files.entry.name, f.kind, f"its markers {f.words}", f.cure, f.gain) for f in certain]


def _lengths(body: Body, read: Sequence[Files]) -> list[Contradiction]:
    """Trials of another body than the others', where lengths are estimated from all of them together."""
    vertices = {files.entry.name: files.labelled.vertices for files in read if files.labelled is not None}
    cure = "make a campaign for each animal, or give one length unit and scale to all recordings"
    words = "its body is {:.3g} times as long as in trial `{}`, and lengths are estimated from all trials together"
    return [
        Contradiction(one.trial, "length", words.format(one.factor, one.other), cure, one.gain)
        for one in other_bodies(vertices, body.edges_m)
    ]


def _claim(body: Body, files: Files, angle_unit: AngleUnit) -> Claim:
    cameras = servos = commands = shown = None
    if files.tracks is not None and files.labelled is not None:
        cameras = Signal(files.tracks.time_s, marker_angles(body, files.labelled.vertices))
        if not cameras.enough:
            shown = outline(body, files.tracks.time_s, files.labelled.vertices)
    log = files.servo_log
    if log is not None:
        servos = Signal(log.time_s, log.position)
        commands = None if log.command is None else Signal(*_played(log, log.command))
    return Claim(files.entry.name, _label(files), files.schedule, cameras, servos, commands, shown, angle_unit)


def _played(log: ServoLog, values: Floats) -> tuple[Floats, Floats]:
    """The rows of a log in which the table is followed."""
    if log.phase is None or not PLAYED & set(log.phase):
        return log.time_s, values
    played = np.array([phase in PLAYED for phase in log.phase])
    return log.time_s[played], values[played]


def _label(files: Files) -> str:
    return Path(files.entry.joint_table or "the joint table").stem


def _tables(read: Sequence[Files], folder: Path) -> Mapping[str, Floats]:
    """All joint tables by name: those of the trials, and what lies beside them in their folders."""
    named = [folder / files.entry.joint_table for files in read if files.entry.joint_table is not None]
    found: dict[str, Floats] = {}
    for path in dict.fromkeys([*named, *(beside for one in named for beside in sorted(one.parent.glob("*.csv")))]):
        if len(found) < MOST_TABLES and path.stem not in found:
            with suppress(InputError):
                found[path.stem] = read_joint_table(path)
    return found
