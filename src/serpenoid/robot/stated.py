"""What is said of a table in the record beside it: how long a cycle lasts, what its joints may do, a transient or not.

Of results that is solution.json; of what `play` recorded play.json, which knows no limits of the body; of an exported
table the JSON file of the table's own name.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from serpenoid.body import LONGEST_CYCLE_S
from serpenoid.errors import InputError
from serpenoid.files.inputs import read_json
from serpenoid.joint_range import JointLimit, Limit, limit_words
from serpenoid.wording import counted, listed

SHORTEST_CYCLE_S = 0.001
RESULTS = "solution.json"
RECORDS = RESULTS, "play.json"
NEEDED = "cycle_duration_s", "transient"  # the first may be null: nobody says
NEEDED_OF_RESULTS = *NEEDED, "body", "limits_held"
Speed = Annotated[float, Field(gt=0)]


class _Part(BaseModel):
    """Other keys of a record are not the robot's matter."""

    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False, strict=True)


class _Body(_Part):
    joint_limit_deg: JointLimit | None = None
    joint_speed_limit_rpm: Speed | None = None


class _Held(_Part):
    joint_limits: bool = True
    joint_speed_limits: bool = True


class Stated(_Part):
    """The part of a record that the robot needs."""

    cycle_duration_s: Annotated[float, Field(ge=SHORTEST_CYCLE_S, le=LONGEST_CYCLE_S)] | None = None
    body: _Body = _Body()
    limits_held: _Held = _Held()
    transient: bool = False
    kind: str | None = None
    status: str | None = None
    message: str = ""
    rows_that_cross: int | None = None

    @property
    def doubts(self) -> list[str]:
        """What is to be known of the gait before a robot plays it: it is no optimum, or the body crosses itself."""
        refused = self.kind == "optimum" and self.status != "solved"
        doubts = [f"`solve` found no optimum, {self.status}: {self.message}"] if refused else []
        if self.rows_that_cross:
            doubts.append(
                f"the body crosses itself in {counted(self.rows_that_cross, 'row')}: links may hit each other"
            )
        return doubts

    @property
    def joint_limit_deg(self) -> Limit | None:
        """None where there is none or the problem file switched it off."""
        return self.body.joint_limit_deg if self.limits_held.joint_limits else None

    @property
    def joint_speed_limit_rpm(self) -> float | None:
        """None where there is none or the problem file switched it off."""
        return self.body.joint_speed_limit_rpm if self.limits_held.joint_speed_limits else None

    @property
    def switched_off(self) -> list[str]:
        """The declared limits that the problem file switched off, as a reader names them."""
        angle, speed = self.body.joint_limit_deg, self.body.joint_speed_limit_rpm
        off = [] if angle is None or self.limits_held.joint_limits else [f"joint limit of {limit_words(angle)} degrees"]
        return off + ([] if speed is None or self.limits_held.joint_speed_limits else [f"speed limit of {speed:g} rpm"])


def own_record(table: Path) -> Path:
    """Where what is stated of an exported table is."""
    return table.with_suffix(".json")


def record_of(table: Path) -> Path | None:
    """A table's own record, or its folder's."""
    records = own_record(table), *(table.parent / name for name in RECORDS)
    return next((record for record in records if record.exists()), None)


def read_stated(table: Path) -> Stated:
    """What `record_of` a table says; nothing is stated where there is none. InputError if it is broken or lacks what a
    robot needs."""
    remedy = "Write the results again, or copy joint_table.csv to a folder of its own and play that."
    file = record_of(table)
    if file is None:
        return Stated()
    try:
        record = read_json(file)
        stated = Stated.model_validate(record)
    except InputError as error:
        raise InputError(f"{error} {remedy}") from None
    except ValidationError as error:
        fault = error.errors()[0]
        place = ".".join(map(str, fault["loc"])) or "the record"
        raise InputError(f"{file}: {place}: {fault['msg']}, got {str(fault['input'])[:40]}. {remedy}") from None
    needed = NEEDED_OF_RESULTS if file.name == RESULTS else NEEDED
    missing = [f"`{key}`" for key in needed if key not in record]
    if missing:
        raise InputError(f"{file}: lacks {listed(missing)}, without which its gait is not played. {remedy}")
    return stated
