"""`serpenoid new campaign --film`: a campaign of an animal, begun with its first film."""

from __future__ import annotations

import json
import shlex
import shutil
from pathlib import Path
from typing import Any, get_args

from serpenoid.body import ANIMALS, Body
from serpenoid.errors import InputError
from serpenoid.files.schema import plain_name, validate
from serpenoid.measure.campaign import MotionKeys
from serpenoid.measure.formats.columns import TimeUnit
from serpenoid.measure.formats.readers import READERS
from serpenoid.measure.tracks import NoTime, Tracks
from serpenoid.measure.trial_files import check_frames
from serpenoid.scaffold.questions import Answers, Question, existing, named, one_of, or_empty, words
from serpenoid.wording import meant

FILM = Question("film", "Track file of an animal, the first trial (empty: a robot)", "", existing)
OF_A_FILM = (
    Question("kind", "Does the animal swim or crawl: swimmer, crawler?", "crawler", one_of(*ANIMALS), only="film"),
    Question(
        "first-point",
        "Which end of the body is the first point in the film, where the film does not say: tail, head?",
        "tail",
        one_of("tail", "head"),
        only="film",
    ),
    Question(
        "length-unit",
        "Unit of the film's points: m, cm, mm, um, px, bl (empty: the file's or tracker's own, else m)",
        "",
        or_empty(one_of("m", "cm", "mm", "um", "px", "bl")),
        only="film",
    ),
    Question(
        "time-unit",
        "Unit of the times of a long or tidy film: s, ms, us, ns (empty: s)",
        "",
        or_empty(one_of(*get_args(TimeUnit))),
        only="film",
    ),
    Question(
        "columns",
        "Columns of a long or tidy film, as time=t,point=point,x=x,y=y (empty: the format's own)",
        "",
        named,
        only="film",
    ),
    Question(
        "markers",
        "Points of the body from tail to head, where the film has them in another order, as tail,center,nose; "
        "others are left out (empty: all, as the film has them)",
        "",
        words,
        only="film",
    ),
    Question("individual", "Whose points, where the film shows several animals (empty: there is one)", "", str,
             only="film"),
)  # fmt: skip
ENDS = {"head": ("head", "snout", "nose", "rostrum"), "tail": ("tail",)}  # of names of points
OTHER = {"head": "tail", "tail": "head"}
LONG = {"time": "t", "point": "point", "x": "x", "y": "y"}


def campaign_of(answers: Answers, folder: Path) -> list[str]:
    """Copy the film into the campaign's folder; returns the sections of campaign.toml."""
    film = answers["film"]
    try:
        name = plain_name(film.stem)
    except ValueError as error:
        raise InputError(
            f"--film: its name becomes the trial's, which {error}, got {film.stem!r}. Rename it."
        ) from None
    try:
        said, tracks = _read(film, answers)
        check_frames(tracks)
    except InputError as error:
        raise InputError(f"{error}{_options(str(error))}") from None
    points = [n for n, fragment in zip(tracks.names, tracks.unlabelled, strict=True) if not fragment]
    if answers["markers"]:
        points = _in_order(answers["markers"], points, answers["first-point"])
        said |= {"markers": points}
    else:
        _refuse_end_inside(points)
        if tracks.first_point is None:
            _refuse_other_end(points, answers["first-point"])
            said |= {"first_point": answers["first-point"]}
        if READERS[answers["format"]].named:
            said |= {"markers": points[::-1] if said.pop("first_point", tracks.first_point) == "head" else points}
    body = validate(Body, {"kind": answers["kind"], "vertices": len(points)}, str(film))
    trial = {"name": name, "motion": f"{name}/{film.name}"}
    if answers["individual"]:
        trial |= {"individual": answers["individual"]}
    (folder / name).mkdir(parents=True, exist_ok=True)
    if film.resolve() != (folder / name / film.name).resolve():
        shutil.copyfile(film, folder / name / film.name)
    return [
        "[body]",
        f'kind = "{body.kind}"   # or {", ".join(word for word in ANIMALS if word != body.kind)}',
        f"vertices = {body.vertices}   # points along the body, those of the film",
        "# Lengths along the body are estimated from the films, if no `edge_lengths` (metres, tail to head) say them.",
        "",
        "[motion]                     # how the films are to be read; a trial may override any key",
        *(f"{key} = {_toml(value)}{COMMENTS.get(key, '')}" for key, value in said.items()),
        "",
        "[[trial]]",
        *(f"{key} = {_toml(value)}" for key, value in trial.items()),
        "",
    ]


COMMENTS = {
    "markers": "   # tail first; leave out what is not on the midline, and count `vertices` again",
    "first_point": "   # the end of the body where the points begin: `measure` says which end leads",
}


def _in_order(wanted: tuple[str, ...], there: list[str], first_point: str) -> list[str]:
    """Points as they were asked for, tail first; InputError where the film has them not, or names say the contrary."""
    strange = next((name for name in wanted if name not in there), None)
    if strange is not None:
        raise InputError(
            f"--markers: the film has no point `{strange}`; it has {', '.join(there)}.{meant(strange, there)}"
        )
    ends = [_ends_of(name) for name in (wanted[0], wanted[-1])]
    if first_point == "head" or ends == [{"head"}, {"tail"}]:
        turned = ",".join(wanted[::-1])
        why = "begins with the head" if ends == [{"head"}, {"tail"}] else "with --first-point head beside it"
        raise InputError(
            f"--markers: is from tail to head, and {why}, got {','.join(wanted)}. Give --markers {turned}."
        )
    return list(wanted)


def _ends_of(name: str) -> set[str]:
    """Which end of the body a point's name says that it is."""
    return {end for end, words in ENDS.items() if any(word in name.casefold() for word in words)}


def _refuse_other_end(points: list[str], said: str) -> None:
    """Names of both end points may say where the head is."""
    ends = [_ends_of(name) for name in points]
    if ends and (ends[0], ends[-1]) == ({OTHER[said]}, {said}):
        raise InputError(
            f"--first-point: not the {said}, as the first point of the film is `{points[0]}` and the last "
            f"`{points[-1]}`. Give --first-point {OTHER[said]}."
        )


def _refuse_end_inside(points: list[str]) -> None:
    """Where a name says that a point is an end of the body, and it stands between others, they are not in order."""
    said = [_ends_of(name) for name in points]
    for name, ends in zip(points[1:-1], said[1:-1], strict=True):
        if len(ends) == 1 and not any(end in outer for outer in (said[0], said[-1]) for end in ends):
            tails, heads = ([p for p, e in zip(points, said, strict=True) if e == {end}] for end in ("tail", "head"))
            along = [*tails, *(p for p in points if p not in tails + heads), *heads]
            raise InputError(
                f"--film: has `{name}` between other points, in the order {', '.join(points)}. Say their order from "
                f"tail to head, perhaps --markers {shlex.quote(','.join(along))}."
            )


def _read(film: Path, answers: Answers) -> tuple[dict[str, Any], Tracks]:
    """What [motion] says of the film, without what was left to the format, and its points.

    Frames per second are said of files that carry no time: in others they would take the place of the file's own.
    """
    kind, form = READERS[answers["format"]], answers["format"]
    for option in ("time-unit", "columns"):
        if answers[option] and form not in ("tidy", "long"):
            raise InputError(f"--{option}: is for tidy and long films, got --format {form}. Leave it out.")
    unit = answers["length-unit"] or (kind.unit if kind.unit == "px" or form in ("tidy", "long", "array") else None)
    columns = answers["columns"] or (LONG if form == "long" else None)
    said = {"format": form, "length_unit": unit, "time_unit": answers["time-unit"], "columns": columns}
    said = {key: value for key, value in said.items() if value is not None}
    own = said | {"individual": answers["individual"] or None}
    rate = {"frames_per_second": answers["frames-per-second"]}

    def read(more: dict[str, float]) -> Tracks:
        return kind.read(film, validate(MotionKeys, own | more, str(film)))

    try:
        return said, read({})
    except NoTime:
        return said | rate, read(rate)


def _options(said: str) -> str:
    """What keys of a campaign file that a refusal names are called here, where there is none yet."""
    names = [*(q.name for q in OF_A_FILM), "frames-per-second"]
    told = [f"--{name}" for name in names if f"`{name.replace('-', '_')}" in said]
    return f" Here: {', '.join(told)}." if told else ""


def _toml(value: Any) -> str:
    """A value of a key; columns on one line."""
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {_toml(text)}' for key, text in value.items())} }}"
    return f"{value:g}" if isinstance(value, float) else json.dumps(value, ensure_ascii=False)
