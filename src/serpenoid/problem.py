"""Problem files: a body, a medium, a gait and a task, as one validated value.

Precedence: what `--set` assigns, then the file, then the defaults below.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, PrivateAttr, model_validator

from serpenoid import schema
from serpenoid.body import Body
from serpenoid.effects.active import ActiveEffect
from serpenoid.files import short_hash
from serpenoid.gaits import EllipseGait, TableGait
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.model_file import read_model_file
from serpenoid.schema import Record

Range = tuple[float, float]


class About(Record):
    """What the problem asks, where it comes from and what number to expect."""

    question: str = ""
    source: str = ""
    expected: str = ""


class Bounds(Record):
    """Where the optimiser may look. Equal ends fix a parameter; `theta` unset is free."""

    sigma: Range = (0.0, 1.0)
    x_c: Range = (-6.0, 6.0)
    y_c: Range = (-6.0, 6.0)
    theta: Range | None = None
    a: Range = (0.0, 15.0)
    xi: Range = (0.5, 2.5)

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        for name in EllipseGait.NAMES:
            pair = getattr(self, name)
            if pair is not None and pair[0] > pair[1]:
                raise ValueError(f"`{name}` needs [lower, upper] with lower <= upper")
        if self.sigma[0] < -1 or self.sigma[1] > 1:
            raise ValueError("`sigma` must lie in [-1, 1]")
        if self.a[0] < 0 or self.xi[0] <= 0:
            raise ValueError("`a` must not be negative, and `xi` must be positive")
        return self


class Constraints(Record):
    """Constraints that can be switched on."""

    joint_limits: bool = Field(default=False, description="keep every row within the body's joint_limit_deg")
    joint_speed_limits: bool = Field(default=False, description="body's joint_speed_limit_rpm at task.cycle_duration_s")
    straight: bool = Field(default=False, description="no heading change over a cycle")
    heading_change_rad: float | None = Field(default=None, description="prescribed heading change over a cycle")
    spatial_frequency: Annotated[float, Field(gt=0)] | None = Field(default=None, description="fixes xi")

    @model_validator(mode="after")
    def _one_heading(self) -> Self:
        if self.straight and self.heading_change_rad is not None:
            raise ValueError("`straight` is `heading_change_rad = 0`: give one of the two")
        return self


class Task(Record):
    """What to compute."""

    steps: int = Field(default=50, ge=3, le=100_000, description="T: steps per cycle, rows of the joint table")
    cycles: int = Field(default=1, ge=1, description="cycles to simulate and draw")
    cycle_duration_s: Annotated[float, Field(gt=0)] | None = Field(default=None, description="seconds per cycle")
    objective: Literal["displacement"] = "displacement"
    c: float = Field(default=0.0, ge=0, description="weight of the normalised dissipation T * E beside -displacement")
    bounds: Bounds = Bounds()
    constraints: Constraints = Constraints()


class Power(Record):
    """Electrical power P = P_idle + k * dissipation rate, for the cost of transport."""

    idle_W: Annotated[float, Field(ge=0)]
    dissipation_J: Annotated[float, Field(gt=0, description="energy per unit of normalised dissipation T * E")]


class Problem(Record):
    """A complete problem file."""

    about: About = About()
    body: Body
    medium: Medium
    gait: EllipseGait | TableGait = Field(default=EllipseGait(), discriminator="family")
    task: Task = Task()
    power: Power | None = None
    effects: tuple[ActiveEffect, ...] = Field(default=(), description="see `serpenoid effects`")
    _folder: Path = PrivateAttr(default=Path("."))
    _name: str = PrivateAttr(default="problem")

    @model_validator(mode="after")
    def _limits_exist(self) -> Self:
        wanted = self.task.constraints
        if wanted.joint_limits and self.body.joint_limit_deg is None:
            raise ValueError("task.constraints.joint_limits needs `joint_limit_deg` in [body]")
        if wanted.joint_speed_limits and self.body.joint_speed_limit_rpm is None:
            raise ValueError("task.constraints.joint_speed_limits needs `joint_speed_limit_rpm` in [body]")
        if wanted.joint_speed_limits and self.task.cycle_duration_s is None:
            raise ValueError("task.constraints.joint_speed_limits needs `cycle_duration_s` in [task]")
        self.model.step_duration(self.task.steps)  # refuses effects that do not fit the body, or lack the clock
        return self

    @property
    def model(self) -> Model:
        """Body, medium and effects, with the task's clock."""
        return Model(self.body, self.medium, self.effects, self.task.cycle_duration_s)

    @property
    def name(self) -> str:
        """The file's name without its ending."""
        return self._name

    @property
    def folder(self) -> Path:
        """The file's folder: joint tables are named relative to it."""
        return self._folder

    @property
    def hash(self) -> str:
        """Changes with any number in the problem."""
        data = self.model_dump(mode="json", exclude=None if self.effects else {"effects"})
        if self.medium.anisotropy_ratio_bounds is None:
            del data["medium"]["anisotropy_ratio_bounds"]
        return short_hash(data)


def load(
    path: str | Path,
    set: list[str] | None = None,  # noqa: A002
    model: str | Path | None = None,
) -> Problem:
    """Read a problem file; `set` holds `section.key=value` assignments as on the command line.

    `model` names a model file: its medium, effects and (where it has one) body replace the problem's.
    Raises InputError that names file, section, key, rule, value and remedy.
    """
    path = Path(path)
    data = schema.read_toml(path)
    if model is not None:
        data |= read_model_file(model)
    data = schema.override(data, set or [])
    gait = data.get("gait")
    if isinstance(gait, dict):
        gait.setdefault("family", "table" if "path" in gait else "ellipse")
    problem = schema.validate(Problem, data, str(path))
    problem._folder, problem._name = path.parent, path.stem
    return problem
