"""Column names of one's own: a role's columns are a list of names, or one name with `*` where the numbers stand."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Sequence
from math import pi
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from serpenoid.errors import InputError
from serpenoid.files.schema import Line, Record

Names = Annotated[Line | tuple[Line, ...], Field(union_mode="left_to_right")]
TimeUnit = Literal["s", "ms", "us", "ns"]
AngleUnit = Literal["rad", "deg", "ticks"]
TURN = 4096.0  # ticks of a Dynamixel X servo
RADIANS: dict[str, float] = {"rad": 1.0, "deg": pi / 180, "ticks": 2 * pi / TURN}
SECONDS: dict[str, float] = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
IN_BRACKETS = re.compile(r"[\[(]\s*([^\W\d]{1,3}|\N{DEGREE SIGN})\s*[\])]")
SPELT = str.maketrans({"\N{MICRO SIGN}": "u", "\N{GREEK SMALL LETTER MU}": "u", "\N{DEGREE SIGN}": "deg"})
LONGEST_SHOWN = 60  # characters of a name
NUMBERED = "a list of names, or one with `*` where their numbers stand"


class MotionColumns(Record):
    """Which columns of a motion file say what; `time` or `frame`."""

    time: Line | None = None
    frame: Line | None = None
    point: Line | None = Field(default=None, description="long: the point's number or name (none: by its row)")
    individual: Line | None = Field(default=None, description="long: whose point it is, where a file shows several")
    x: Names | None = Field(default=None, description=f"long: a name; tidy: {NUMBERED}, tail first")
    y: Names | None = Field(default=None, description="as x")


class ServoColumns(Record):
    """Which columns of a servo log say what."""

    time: Line = "t_s"
    position: Names = Field(default="position_*", description=f"{NUMBERED}, joint_1 first")
    command: Names = Field(default="command_*", description="as position; may be missing")
    phase: Line = "phase"
    cycle: Line = "cycle"
    step: Line = "step"


class ServoKeys(Record):
    """How servo logs are to be read."""

    columns: ServoColumns = ServoColumns()
    time_unit: TimeUnit = "s"
    angle_unit: AngleUnit = "rad"
    ticks_per_turn: Annotated[float, Field(gt=0, le=1e9)] = Field(default=TURN, description="of `ticks`; AX: 1228.8")
    zero_ticks: Annotated[float, Field(ge=0, le=1e9)] = Field(default=TURN / 2, description="straight; AX: 512")

    @property
    def scale(self) -> tuple[float, float]:
        """What is straight, in the log's unit, and one of it [rad]."""
        if self.angle_unit == "ticks":
            return self.zero_ticks, 2 * pi / self.ticks_per_turn
        return 0.0, RADIANS[self.angle_unit]


def numbered(header: Sequence[str], wanted: str | Sequence[str], role: str, path: Path) -> list[str]:
    """The columns that `wanted` means, in order; with `*`, none where no column is called so.

    Raises InputError for a name that is not there, and where numbers behind `*` leave one out.
    """
    if not isinstance(wanted, str):
        for name in wanted:
            find_column(header, name, role, path)
        return list(wanted)
    if wanted.count("*") != 1:
        raise InputError(f"{path}: `columns`: `{role}` must be {NUMBERED}, got {wanted!r}.")
    form = re.compile(r"([0-9]{1,6})".join(map(re.escape, wanted.split("*"))))
    found = sorted((int(m[1]), name) for name in header if (m := form.fullmatch(name)))
    for (before, _), (number, name) in zip(found, found[1:], strict=False):
        if number != before + 1:
            missing = wanted.replace("*", str(before + 1))
            raise InputError(
                f"{path}: row 1: column `{missing}` is missing before `{name}`. Is it called otherwise, or not there? "
                "A list names the columns one by one."
            )
    return [name for _, name in found]


def by_words(header: Sequence[str], across: str, up: str, path: Path) -> tuple[tuple[str, ...], list[list[str]]]:
    """The words for which `*` stands in names of columns, as they follow each other in the file, and the columns of x
    and of y. Raises InputError for one that has no column of the other."""
    words = []
    for wanted in (across, up):
        form = re.compile("(.+)".join(map(re.escape, wanted.split("*"))))
        found = [m[1] for name in header if "*" in wanted and (m := form.fullmatch(name))]
        words.append(found)
    kinds = Counter(re.sub(r"[0-9]+", "*", word) for word in words[0])
    if len(kinds) > 1 and min(kinds.values()) > 1:
        raise InputError(
            f"{path}: `columns`: `*` of `{across}` stands for several kinds of points: {shown(list(kinds))}. Say more "
            "of the name beside it, or list the names one by one."
        )
    alone = [word for word in words[0] + words[1] if (word in words[0]) != (word in words[1])]
    if alone:
        raise InputError(
            f"{path}: `columns`: `{alone[0]}` in place of `*` has a column of x or of y alone; the file has "
            f"{shown(header)}. A list names the columns one by one."
        )
    return tuple(words[0]), [[wanted.replace("*", word) for word in words[0]] for wanted in (across, up)]


def has_columns(header: Sequence[str], columns: MotionColumns) -> bool:
    """Whether a row has all the columns that are named, and one at least of each that stands for several."""

    def there(wanted: str | tuple[str, ...] | None) -> bool:
        if not isinstance(wanted, str) or wanted.count("*") != 1:
            return set([wanted] if isinstance(wanted, str) else wanted or ()) <= set(header)
        form = re.compile("(.+)".join(map(re.escape, wanted.split("*"))))
        return any(form.fullmatch(name) for name in header)

    return all(
        there(wanted)
        for wanted in (columns.time, columns.frame, columns.point, columns.individual, columns.x, columns.y)
    )


def find_column(header: Sequence[str], name: str, role: str, path: Path, cure: str = "") -> int:
    """The place of a column; InputError where it is not there, or there twice."""
    if name not in header:
        raise InputError(f"{path}: row 1: no column `{name}` (for `{role}`); the file has {shown(header)}.{cure}")
    if header.count(name) > 1:
        raise InputError(f"{path}: row 1: column `{name}` (for `{role}`) is there twice.")
    return header.index(name)


def refuse_other_unit(names: Sequence[str], unit: str, known: Collection[str], key: str, path: Path) -> None:
    """Refuse columns whose own names say another of the `known` units, in brackets, than the one they are read in."""
    for name in names:
        for said in (word.translate(SPELT) for word in IN_BRACKETS.findall(name)):
            if said in known and said != unit:
                raise InputError(
                    f'{path}: row 1: column `{name}` says {said}, and is read in {unit}: `{key} = "{said}"` in '
                    "campaign.toml, or correct the header."
                )


def shown(header: Sequence[str]) -> str:
    """The first names of a header."""
    return ", ".join(name[:LONGEST_SHOWN] for name in header[:6]) + (", ..." if len(header) > 6 else "")
