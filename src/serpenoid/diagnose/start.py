"""Where a diagnosis begins: the baseline medium, and effects of it that are known."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

from serpenoid.body import Body
from serpenoid.diagnose.data.windows.tracks import NoPath
from serpenoid.diagnose.inference.doubt.middles import PIECES
from serpenoid.diagnose.stages.baseline import Baseline, check_same
from serpenoid.effects.active import ActiveEffect
from serpenoid.errors import InputError
from serpenoid.files import schema
from serpenoid.files.inputs import RECORDING_BYTES, read_bytes
from serpenoid.files.kinds import kind_of
from serpenoid.files.schema import Record
from serpenoid.measure.campaign import CampaignFile
from serpenoid.medium import OpenMedium
from serpenoid.model import Model
from serpenoid.wording import listed

SAME = 0.01  # of the mean: numbers of a body that two files give alike, but for rounding
ANEW = ("rate", "jumps")  # marks of what differs between recordings
SAID = {"medium", "effects", "body"}  # what of a problem or model file a diagnosis begins from


class _Known(Record):
    effects: tuple[ActiveEffect, ...] = ()


def baseline(path: str | Path | None, file: CampaignFile, body: Body) -> Model:
    """The recorded body in the medium of a problem or model file (else of the campaign, else a first guess), with the
    effects that a model file says are known.

    Effects have their places at vertices: where drag sits at edges, `body` is the one with vertices in their middles
    (`at_middles`), or an animal's, whose points are dense.
    """
    medium, known = file.medium or OpenMedium(), tuple[ActiveEffect, ...]()
    if path is not None:
        data = _model(path)
        if "medium" in data:
            medium = schema.validate(OpenMedium, data["medium"], str(path))
        known = schema.validate(_Known, {"effects": data.get("effects", [])}, str(path)).effects
    return Model(body, medium.guessed().model_copy(update={"dissipation": "vertex"}), known)


def law_is_open(path: str | Path | None, file: CampaignFile) -> bool:
    """Whether no file says which law the medium follows."""
    stated = _model(path).get("medium") if path is not None else None
    if stated is not None:
        return not isinstance(stated, dict) or "law" not in stated
    return file.medium is None or "law" not in file.medium.model_fields_set


def at_middles(path: str | Path | None, file: CampaignFile) -> int:
    """In the middles of how many pieces of the recorded body's edges drag sits: [medium] says so, or the body of a
    model that a diagnosis wrote; 0: at its vertices."""
    data = _model(path) if path is not None else {}
    if pieces := _cut_into(data, file):
        return pieces
    stated = data.get("medium") if isinstance(data.get("medium"), dict) else None
    where = stated.get("dissipation") if stated else file.medium and file.medium.dissipation
    return int(where == "edge")


def _cut_into(data: dict[str, Any], file: CampaignFile) -> int:
    """In how many pieces of each edge of the recorded body the one of a model has middles; 0: it is another body."""
    stated = data.get("body")
    if not isinstance(stated, dict):
        return 0
    bodies = {pieces: file.body.with_middles(pieces) for pieces in (1, PIECES)}
    said = stated.get("vertices"), stated.get("joints")
    return next((p for p, b in bodies.items() if (b.vertices, list(b.joint_vertices)) == said), 0)


def _model(path: str | Path) -> dict[str, Any]:
    """What a problem or model file says. Raises InputError about a file of another kind, which would say nothing."""
    data = schema.read_toml(path, "model")
    found = kind_of(data)
    if found not in (None, "problem", "model"):
        raise InputError(
            f"{path}: is a {found} file, where --model takes a problem or model file. Leave --model out: the "
            "campaign's own [medium] is the baseline, or a first guess, and eps is calibrated either way."
        )
    if not SAID & data.keys():
        raise InputError(f"{path}: says nothing of a model: it has no [medium], no [[effects]] and no [body].")
    return data


def _vertices(data: dict[str, Any]) -> Any:
    body = data.get("body")
    return body.get("vertices") if isinstance(body, dict) else None


def taken_for_granted(model: Model, law_open: bool, without: frozenset[str], notice: Callable[[str], None]) -> Baseline:
    """The effects of a model, each at its stage. What every recording has anew, steps across gaps and the rate of two
    clocks, is looked for all the same: `notice` hears so."""
    moving = tuple(e for e in model.effects if e.effect.moves)
    anew = tuple(e for e in model.effects if e.effect.marks in ANEW)
    for effect in anew:
        notice(f"`{effect.name}` of the model file is not taken for granted: every recording has its own.")
    others = tuple(e for e in model.effects if e not in moving and e not in anew)
    return Baseline(replace(model, effects=moving), others=others, without=without, law_open=law_open)


def check_reference(
    path: str | Path, earlier: CampaignFile, campaign: str | Path, file: CampaignFile, option: str = "--reference"
) -> None:
    """Refuse, before either is diagnosed, a reference where one of the two campaigns is of tracked points alone, of
    another body, or of the same recordings."""
    if file.tracked_only:
        raise InputError(
            f"{campaign}: has tracked points alone, so no other campaign repeats its shapes. Leave {option} out, "
            "diagnose each by itself, and compare what both say of K."
        )
    if earlier.tracked_only:
        raise InputError(
            f"{option} {path}: has tracked points alone: no robot can be compared with it. Name an earlier campaign "
            "of the same robot, with its joint tables or servo logs."
        )
    if earlier.lengths_given and file.lengths_given:  # else trials tell them
        check_same(earlier.body, file.body)
    own = _recordings(campaign, file)
    if own and own <= _recordings(path, earlier):
        raise InputError(
            f"{option} {path}: its recordings are those of {campaign}, byte by byte: nothing can have changed between "
            "them. Name the earlier campaign, or put the later recordings in their place."
        )


def _recordings(path: str | Path, file: CampaignFile) -> set[tuple[str, float | None, float | None]]:
    """Which films a campaign has, and what part of each."""
    folder = Path(path) if Path(path).is_dir() else Path(path).parent
    films = [(t, folder / t.motion) for t in file.trial if t.motion]
    read = {film: sha256(read_bytes(film, RECORDING_BYTES)).hexdigest() for _, film in films}
    return {(read[film], t.from_s, t.to_s) for t, film in films}


def check_body(path: str | Path | None, file: CampaignFile) -> None:
    """InputError where a file describes another robot than the one that was recorded; animals' points are resampled."""
    data = _model(path) if path is not None else {}
    vertices = _vertices(data)
    if vertices not in (None, file.body.vertices) and not _cut_into(data, file):
        joints = data["body"].get("joints")
        cut = isinstance(joints, list) and len(joints) == file.body.joint_count
        cure = (
            "Both have as many joints: give the campaign the [body] of this file, and [motion] the `vertices` that "
            f"have a marker, as `serpenoid new campaign --problem {shlex.quote(str(path))}` does."
            if cut
            else "Give the problem file of the robot that was recorded."
        )
        raise InputError(
            f"{path}: a body of {vertices} vertices, but the campaign `{file.name}` records one of "
            f"{file.body.vertices}. {cure}"
        )


def rootless(path: str, none: NoPath, effects: Sequence[ActiveEffect]) -> str:
    """That the model of a file has no path along a trial, and what to do."""
    said = [f"`{e.called}` ({', '.join(f'{k} = {v:.3g}' for k, v in e.parameters.items())})" for e in effects]
    cure = (
        f"Drop {'one of its effects' if said[1:] else 'its effect'}, or set it nearer to the value that changes nothing"
        f": {listed(said)}."
        if said
        else "Leave numbers of [medium] but `law` out: they are calibrated."
    )
    return f"{path}: {none}, so that it says nothing of how the body moved there. {cure}"


def unlike_body(path: str | Path | None, file: CampaignFile) -> str:
    """Which lengths or weights of the two files differ, as a sentence: the campaign's are used. Empty: none do."""
    data = _model(path).get("body") if path is not None else None
    if not isinstance(data, dict) or data.get("vertices") != file.body.vertices:
        return ""
    other, own = schema.validate(Body, data, str(path)), file.body
    pairs = {"edge_lengths": (other.edges, own.edges), "weights": (other.vertex_weights, own.vertex_weights)}
    said = {"edge_lengths": file.lengths_given, "weights": True}
    shares = {name: max(abs(a / a.sum() - b / b.sum()) * len(a)) for name, (a, b) in pairs.items() if said[name]}
    differ = [f"`{name}` by up to {share:.0%} of the mean" for name, share in shares.items() if share > SAME]
    if not differ:
        return ""
    words = " and ".join(differ)
    return f"{path}: [body] differs from that of the campaign `{file.name}`, {words}; the campaign's is used."


def unlike_kind(path: str | Path | None, file: CampaignFile) -> str:
    """Of which kind a file's body is that tracked points are not of, as a sentence; empty: of theirs, or of none."""
    body = _model(path).get("body") if path is not None else None
    kind = body.get("kind") if isinstance(body, dict) else None
    if kind in (None, file.body.kind):
        return ""
    recorded = file.body.kind or "body without `kind`"
    return (
        f"{path}: its [body] is a {kind}, and the campaign `{file.name}` records a {recorded}: of the file [medium] "
        "and [[effects]] alone are used."
    )
