"""`campaign.toml`: which trials there are, how their files are read, what was commanded (docs/campaign-format.md)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, field_validator, model_validator

from serpenoid.body import Body
from serpenoid.errors import InputError
from serpenoid.files.schema import Duration, FilePath, Line, Name, Record, Text, load
from serpenoid.measure.cells import Floats
from serpenoid.measure.formats.columns import MotionColumns, ServoKeys, TimeUnit
from serpenoid.measure.formats.readers import FORMATS, READERS, MotionFormat
from serpenoid.measure.tracks import METRES, LengthUnit, Tracks
from serpenoid.medium import OpenMedium
from serpenoid.table_file import read_table as read_joint_table

Positive = Annotated[float, Field(gt=0)]
OF_A_FORMAT = {"columns", "time_unit"}
NotNegative = Annotated[float, Field(ge=0)]


class MotionKeys(Record):
    """How a motion file is to be read; every key may be overridden in a trial."""

    format: MotionFormat | None = Field(default=None, description=FORMATS)
    length_unit: LengthUnit | None = Field(
        default=None, description="m | cm | mm | um | px | bl, where the file does not say"
    )
    metres_per_pixel: Positive | None = Field(
        default=None, description="what a pixel is on the floor, where points are in pixels: lengths are then in metres"
    )
    mirrored: bool | None = Field(
        default=None, description="true: left and right are exchanged (seen from below, or rows counted the other way)"
    )
    up_axis: Literal["x", "y", "z"] | None = Field(default=None, description="the axis that points up (motive, trc: y)")
    markers: tuple[Line, ...] | None = Field(default=None, description="marker name of vertex 0 (tail) .. N-1 (head)")
    vertices: tuple[int, ...] | None = Field(
        default=None, description="vertices with a marker, in increasing order; default all 0 .. N-1"
    )
    undo_exchanges: bool | None = Field(
        default=None, description="true: points whose names the tracker exchanges for a while get them back"
    )
    individual: Line | None = Field(default=None, description="whose points are read, where a file shows several")
    frames_per_second: Positive | None = Field(default=None, description="for formats without a time column")
    minimum_score: float | None = Field(default=None, description="points that a tracker is less sure of are hidden")
    columns: MotionColumns | None = Field(default=None, description="tidy, long: the file's own column names")
    time_unit: TimeUnit | None = Field(default=None, description="s | ms | us | ns, of a tidy or long file")
    first_point: Literal["tail", "head"] | None = Field(default=None, description="where point or column numbers start")

    @field_validator("length_unit", mode="before")
    @classmethod
    def _unit(cls, unit: Any) -> Any:
        if isinstance(unit, str) and unit not in METRES:
            raise ValueError(
                f"must be {', '.join(METRES)}; multiply positions by what one of yours is in one of these (an inch is "
                '25.4 mm), or say "bl": K needs no unit'
            )
        return unit

    @model_validator(mode="after")
    def _roles(self) -> Self:
        if self.markers is not None and len(set(self.markers)) != len(self.markers):
            raise ValueError("`markers` names one marker twice")
        if self.vertices is not None and list(self.vertices) != sorted(set(self.vertices)):
            raise ValueError(f"`vertices` must be increasing vertex numbers, tail = 0, got {list(self.vertices)}")
        return self

    def marked(self, count: int) -> tuple[int, ...]:
        """Which of `count` vertices have a marker."""
        return tuple(range(count)) if self.vertices is None else self.vertices

    def labels(self, count: int) -> list[str]:
        """What the marker of each of `count` vertices is called."""
        named = dict(zip(self.marked(count), self.markers or (), strict=False))
        return [named.get(vertex, f"vertex {vertex}") for vertex in range(count)]

    def over(self, other: MotionKeys) -> MotionKeys:
        """These keys, and `other`'s where these are not given; columns are those of a format."""
        mine = {
            key: value
            for key, value in self.model_dump().items()
            if key in MotionKeys.model_fields and value is not None
        }
        another = self.format is not None and self.format != other.format
        theirs = {key: value for key, value in other.model_dump().items() if not (another and key in OF_A_FORMAT)}
        return MotionKeys.model_validate({**theirs, **mine})


class TrialEntry(MotionKeys):
    """One trial: what was commanded, and where its files are."""

    name: Name = Field(description="unique; names the trial's figures")
    gait: Name | None = Field(default=None, description="trials with one label and cycle duration are repeats")
    joint_table: FilePath | None = Field(default=None, description="CSV, T rows of joint_1..joint_m [rad]")
    cycle_duration_s: Duration | None = Field(default=None, description="time for T steps")
    cycles: Annotated[int, Field(ge=1, le=100_000)] | None = Field(
        default=None, description="how often the table is played"
    )
    pause_s: NotNegative = Field(default=0.0, description="after every cycle, holding row 0")
    dissipation_coefficient: NotNegative | None = Field(default=None, description="c the gait was optimised with")
    motion: FilePath | None = Field(default=None, description="motion file")
    servo_log: FilePath | None = None
    power_log: FilePath | None = None
    from_s: float | None = Field(default=None, description="use the motion file from here (its own clock)")
    to_s: float | None = Field(default=None, description="... to here")
    believe: bool = Field(default=False, description="go on where this trial's data contradict what is promised here")

    @model_validator(mode="after")
    def _schedule(self) -> Self:
        if self.joint_table is not None and self.cycle_duration_s is None:
            raise ValueError("`joint_table` needs `cycle_duration_s`: the time for its T steps")
        if self.from_s is not None and self.to_s is not None and self.to_s <= self.from_s:
            raise ValueError(f"`to_s` must be after `from_s`, got {self.to_s:g}")
        return self


class CampaignFile(Record):
    """`campaign.toml` as it stands."""

    file_kind: ClassVar[str | None] = "campaign"

    format: Literal[1]
    name: Line
    description: Text = ""
    source: Text = Field(default="", description="where the data come from, shown beside every figure")
    body: Body
    medium: OpenMedium | None = Field(default=None, description="what Sim and Resim assume; default: what fits find")
    motion: MotionKeys = MotionKeys()
    servo_log: ServoKeys = Field(default=ServoKeys(), description="how servo logs are to be read")
    trial: tuple[TrialEntry, ...] = Field(min_length=1, max_length=10_000)

    @model_validator(mode="after")
    def _names(self) -> Self:
        names = [trial.name for trial in self.trial]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"trial names must be unique, but `{', '.join(twice)}` is there twice")
        if self.body.is_animal and not self.tracked_only:
            raise ValueError(
                f'kind = "{self.body.kind}" is an animal, and has neither `servo_log` nor `joint_table`: of a robot '
                'say "wheeled robot", "crawling robot" or "swimming robot"'
            )
        for trial in self.trial:
            markers, marked = trial.markers or self.motion.markers, trial.vertices or self.motion.vertices
            last, count = self.body.vertices - 1, self.body.vertices if marked is None else len(marked)
            if marked is not None and (not marked or marked[0] < 0 or marked[-1] > last):
                raise ValueError(f"trial `{trial.name}`: `vertices` must be from 0 to {last}, got {list(marked)}")
            if markers is not None and len(markers) != count:
                raise ValueError(f"trial `{trial.name}`: `markers` needs {count} names, got {len(markers)}")
        return self

    @property
    def lengths_given(self) -> bool:
        """False: edge lengths are estimated from the recordings."""
        return self.body.edge_lengths is not None or self.body.length_m is not None

    @property
    def tracked_only(self) -> bool:
        """Whether nothing says what was commanded or what servos read: points alone, as of an animal."""
        return not any(trial.servo_log or trial.joint_table for trial in self.trial)

    @property
    def uniform(self) -> bool:
        """Whether the body's weight goes with its length: an animal whose weights are not given."""
        robot = self.body.kind is not None and not self.body.is_animal
        return self.body.weights is None and not robot and (self.body.is_animal or self.tracked_only)

    def motion_of(self, trial: TrialEntry) -> MotionKeys:
        return trial.over(self.motion)


def load_campaign_file(path: str | Path) -> tuple[CampaignFile, Path]:
    """Read `campaign.toml` (or the folder it is in). Returns it and the folder its paths are relative to."""
    if not isinstance(path, str | Path):
        wanted = "the path of a campaign's folder, or of its campaign.toml"
        raise InputError(f"`campaign` must be {wanted}, got {type(path).__name__}.")
    named, path = str(path), Path(path)
    cure = "`serpenoid new campaign` writes one to start from; docs/campaign-format.md says what is in it."
    if not named or not path.exists():  # an empty name would be the folder one is in
        raise InputError(f"{named or repr(named)}: no such file or folder. {cure}")
    if path.is_dir():
        path = path / "campaign.toml"
        if not path.is_file():
            raise InputError(
                f"{path}: is a folder, where a file of this name belongs."
                if path.is_dir()
                else f"{path.parent}: holds no campaign.toml. {cure}"
            )
    return load(CampaignFile, path), path.parent


def read_motion(file: CampaignFile, trial: TrialEntry, folder: Path) -> Tracks | None:
    """The trial's motion file as tracks, cut to from_s..to_s; None where it has none."""
    if trial.motion is None:
        return None
    keys, path = file.motion_of(trial), folder / trial.motion
    if keys.format is None:
        raise InputError(f"`format` is missing in [motion]: one of {FORMATS}.")
    tracks = in_metres(READERS[keys.format].read(path, keys), keys.metres_per_pixel)
    if keys.mirrored:
        tracks = replace(tracks, floor=tracks.floor * (1.0, -1.0))
    if trial.from_s is not None or trial.to_s is not None:
        tracks = tracks.between(trial.from_s, trial.to_s)
    return tracks


def in_metres(tracks: Tracks, metres_per_pixel: float | None) -> Tracks:
    """Pixels with their scale; raises InputError where points are in a length already."""
    if metres_per_pixel is None:
        return tracks
    if tracks.scale_known:
        raise InputError(
            f"{tracks.source}: `metres_per_pixel` is given, and these points are in a length already. Leave it out, or "
            'say `length_unit = "px"` where they are pixels.'
        )
    return replace(tracks, floor=tracks.floor * metres_per_pixel, scale_known=True)


def read_table(trial: TrialEntry, body: Body, folder: Path) -> Floats | None:
    """The commanded joint table (T, m) [rad], or None."""
    return None if trial.joint_table is None else read_joint_table(folder / trial.joint_table, body.joint_count)
