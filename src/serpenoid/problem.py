"""Problem files: a body, a medium, a gait and a task, as one validated value.

Precedence: what `--set` assigns, then the file, then the defaults below.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from functools import reduce
from operator import or_
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, TypeAlias

import numpy as np
from pydantic import Field, PrivateAttr, ValidationError, model_validator

from serpenoid.body import LONGEST_CYCLE_S, Body
from serpenoid.effects.active import ActiveEffect
from serpenoid.errors import InputError
from serpenoid.files import schema
from serpenoid.files.inputs import read_bytes
from serpenoid.files.schema import Record
from serpenoid.files.writing import short_hash
from serpenoid.gaits import EllipseBounds, EllipseGait, Gait, GaitBounds, GaitFamily, families
from serpenoid.gaits.lifted import Lift, LiftedGait, lifted
from serpenoid.joint_range import Limit, ranges_deg
from serpenoid.lifting import fault
from serpenoid.media import DEFAULT
from serpenoid.medium import MOST, Medium
from serpenoid.model import Model
from serpenoid.model_file import read_model_file
from serpenoid.objectives import Demand, Displacement, Term, demands, terms
from serpenoid.objectives.contradictions import contradiction
from serpenoid.objectives.efficiency import Efficiency
from serpenoid.objectives.heading import Heading
from serpenoid.objectives.shape import Shape
from serpenoid.objectives.term import Ask, Rows
from serpenoid.wording import listed

LEFT_OPEN = ("extended-model.toml", "diagnosis.json")  # what of a diagnosis tells the cases that a gait must serve
MOST_C = 1e6  # body lengths per unit of dissipation: beyond, moving is worth nothing
MOST_POSITIONS = 5_000_000  # of vertices in one trajectory: 80 MB
if TYPE_CHECKING:
    AnyGait: TypeAlias = Gait
    AnyBounds: TypeAlias = GaitBounds
    AnyTerm: TypeAlias = Term
    AnyDemand: TypeAlias = Demand
else:
    AnyGait = reduce(or_, families().values())
    AnyBounds = Annotated[reduce(or_, (kind.Bounds for kind in families().values())), Field(discriminator="family")]
    AnyTerm = Annotated[reduce(or_, terms()), Field(discriminator="kind")]
    AnyDemand = Annotated[reduce(or_, demands()), Field(discriminator="kind")]


class About(Record):
    """What the problem asks, where it comes from and what number to expect."""

    question: str = ""
    source: str = ""
    expected: str = ""


class Constraints(Record):
    """Constraints on a gait; the limits that the body declares hold unless they are switched off here."""

    joint_limits: bool | None = Field(default=None, description="false: joint_limit_deg of the body does not hold")
    joint_speed_limits: bool | None = Field(
        default=None, description="false: joint_speed_limit_rpm of the body, at task.cycle_duration_s, does not hold"
    )
    straight: bool = Field(default=False, description="no heading change over a cycle")
    heading_change_rad: float | None = Field(default=None, description="prescribed heading change over a cycle")
    spatial_frequency: Annotated[float, Field(gt=0)] | None = Field(default=None, description="fixes xi")

    @model_validator(mode="after")
    def _one_heading(self) -> Self:
        if self.straight and self.heading_change_rad is not None:
            raise ValueError("`straight` is `heading_change_rad = 0`: give one of the two")
        return self


class Robust(Record):
    """Cases that one gait must serve together; `[task.robust]`. Demands and limits hold in every case."""

    over: Literal["worst", "mean"] = Field(default="worst", description="best worst case, or best mean")
    anisotropy_ratio: tuple[float, float] | None = Field(default=None, description="an interval of ratios")
    models: tuple[str, ...] = Field(default=(), description="model files, relative to the problem file")
    diagnosis: str | None = Field(default=None, description="folder of `diagnose`: extended model and alternatives")

    @property
    def files(self) -> tuple[str, ...]:
        """All that it reads, relative to the problem file."""
        return self.models if self.diagnosis is None else tuple(f"{self.diagnosis}/{name}" for name in LEFT_OPEN)

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        given = [self.anisotropy_ratio is not None, bool(self.models), self.diagnosis is not None]
        if sum(given) != 1:
            raise ValueError("give one of `anisotropy_ratio`, `models` and `diagnosis`")
        pair = self.anisotropy_ratio
        if pair is not None and not 0 < pair[0] < pair[1] <= MOST:
            raise ValueError(f"`anisotropy_ratio` needs [lower, upper] with 0 < lower < upper <= {MOST:g}")
        return self


class Task(Record):
    """What to compute."""

    steps: int = Field(default=50, ge=3, le=100_000, description="T: steps per cycle, rows of the joint table")
    transient: bool = Field(default=False, description="not closed: T + 1 rows played once, from shape to shape")
    cycles: int = Field(default=1, ge=1, le=100_000, description="cycles to simulate and draw")
    cycle_duration_s: schema.Duration | None = Field(default=None, description="seconds per cycle")
    objectives: tuple[AnyTerm, ...] = Field(default=(Displacement(),), description="terms; default: displacement")
    demands: tuple[AnyDemand, ...] = Field(default=(), description="requirements beside limits")
    c: float = Field(
        default=0.0, ge=0, le=MOST_C, description="weight of the normalised dissipation T * E beside the objectives"
    )
    bounds: AnyBounds = Field(default=EllipseBounds(), description="where the optimiser may look; by family")
    constraints: Constraints = Constraints()
    robust: Robust | None = Field(default=None, description="cases that one gait must serve together")


class Power(Record):
    """Electrical power P = P_idle + k * dissipation rate, for the cost of transport."""

    idle_W: Annotated[float, Field(ge=0)]
    dissipation_J: Annotated[float, Field(gt=0, description="energy per unit of normalised dissipation T * E")]


class Problem(Record):
    """A complete problem file."""

    file_kind: ClassVar[str | None] = "problem"

    about: About = About()
    body: Body
    medium: Medium
    gait: AnyGait = Field(default=EllipseGait(), discriminator="family")
    task: Task = Task()
    lift: Lift | None = Field(default=None, description="parts of the body are lifted: gaits in space")
    power: Power | None = None
    effects: tuple[ActiveEffect, ...] = Field(default=(), description="see `serpenoid effects`")
    _folder: Path = PrivateAttr(default=Path("."))
    _name: str = PrivateAttr(default="problem")
    _source: str = PrivateAttr(default="problem")
    _body_note: str | None = PrivateAttr(default=None)

    def __repr__(self) -> str:
        body, task = self.body, self.task
        return f"<Problem {self._name}: {body.vertices} vertices, {self.gait.family} gait, {task.steps} steps>"

    __str__ = __repr__

    @model_validator(mode="before")
    @classmethod
    def _bounds_of_the_family(cls, data: Any) -> Any:
        """Bounds are read as those of the gait's family, which is named once, in [gait]."""
        if not isinstance(data, dict) or not isinstance(data.get("task", {}), dict):
            return data
        gait, task = data.get("gait", {}), data.get("task", {})
        family = gait.get("family", "ellipse") if isinstance(gait, dict) else getattr(gait, "family", "ellipse")
        bounds = task.get("bounds", {})
        if not isinstance(family, str) or family not in families():  # one fault, not two
            return data | {"task": {key: value for key, value in task.items() if key != "bounds"}}
        return data if not isinstance(bounds, dict) else data | {"task": task | {"bounds": {"family": family} | bounds}}

    @model_validator(mode="after")
    def _limits_exist(self) -> Self:
        wanted = self.task.constraints
        if wanted.joint_limits and self.body.joint_limit_deg is None:
            raise ValueError("task.constraints.joint_limits needs `joint_limit_deg` in [body]")
        if wanted.joint_speed_limits and self.body.joint_speed_limit_rpm is None:
            raise ValueError("task.constraints.joint_speed_limits needs `joint_speed_limit_rpm` in [body]")
        if wanted.joint_speed_limits and self.task.cycle_duration_s is None:
            raise ValueError("task.constraints.joint_speed_limits needs `cycle_duration_s` in [task]")
        frequency, bounds = wanted.spatial_frequency, getattr(self.task.bounds, "xi", None)
        if frequency is not None and bounds is not None and not bounds[0] <= frequency <= bounds[1]:
            remedy = "widen the bounds or choose a frequency within"
            raise ValueError(f"task.constraints.spatial_frequency {frequency:g} is outside task.bounds.xi; {remedy}")
        if self.task.transient and self.task.cycles > 1:
            raise ValueError("task.cycles must be 1 with `transient`; what does not come back is played once")
        size = self.task.steps * self.task.cycles * self.body.vertices
        if size > MOST_POSITIONS:
            raise ValueError(f"task.steps * task.cycles * body.vertices must be at most {MOST_POSITIONS}, is {size}")
        self.model.step_duration(self.task.steps)  # refuses effects that do not fit the body, or lack the clock
        return self

    @model_validator(mode="after")
    def _ratios_in_bounds(self) -> Self:
        pair = self.task.robust and self.task.robust.anisotropy_ratio
        low, high = self.medium.limits(0.0, 1.0)
        if pair and not low <= pair[0] < pair[1] <= high:
            raise ValueError(
                f"task.robust.anisotropy_ratio {list(pair)} is not within {low:g} .. {high:g}; "
                "`anisotropy_ratio_bounds` in [medium] says how far ratios may go"
            )
        return self

    @model_validator(mode="after")
    def _gait_fits(self) -> Self:
        joints, steps = self.body.joint_count, self.task.steps
        said = self.gait.misfit(joints, steps) or self.gait.misstated(joints, steps + self.task.transient)
        if said is not None:
            raise ValueError(f"[gait] {said}")
        return self

    @model_validator(mode="after")
    def _lift_fits(self) -> Self:
        said = None if self.lift is None else fault(self.lift, self.gait, self.model, self.task.bounds, self._goals)
        if said is None and self.lift is not None and isinstance(self.joint_limit_deg, tuple):
            said = "`joint_limit_deg` must be one number, which holds for yaw and pitch; a range says nothing of pitch"
        if said is not None:
            raise ValueError(f"[lift]: {said}")
        return self

    @property
    def _goals(self) -> tuple[Term | Demand, ...]:
        return (*self.task.objectives, *self.task.demands)

    @model_validator(mode="after")
    def _demands_meet(self) -> Self:
        task, rows = self.task, Rows(self.task.steps, self.body.joint_count, not self.task.transient)
        wanted = 0.0 if task.constraints.straight else task.constraints.heading_change_rad
        others = [] if wanted is None else [("[task.constraints]", Ask("heading after 1 cycle", wanted, wanted))]
        if self.joint_limit_deg is not None:
            ranges = np.deg2rad(ranges_deg(self.joint_limit_deg, self.body.joint_count)).tolist()
            asked = [zip(d.asks(rows), ranges, strict=True) for d in task.demands if isinstance(d, Shape)]
            joints = {ask.quantity: pair for each in asked for ask, pair in each}
            others += [("[body] joint_limit_deg", Ask(joint, *joints[joint])) for joint in sorted(joints)]
        if not self.model.law.linear and any(isinstance(term, Efficiency) for term in task.objectives):
            raise ValueError(
                f"[[task.objectives]] efficiency: is one of viscous drag; with {self.model.law.title} ask for transport"
            )
        fault = contradiction(task.demands, rows, self.body.edges, others)
        if fault is not None:
            raise ValueError(fault)
        return self

    @property
    def joint_limit_deg(self) -> Limit | None:
        """The body's joint limit, None where there is none or it is switched off."""
        return None if self.task.constraints.joint_limits is False else self.body.joint_limit_deg

    @property
    def joint_speed_limit_rpm(self) -> float | None:
        """The body's speed limit, None where there is none or it is switched off."""
        return None if self.task.constraints.joint_speed_limits is False else self.body.joint_speed_limit_rpm

    @property
    def model(self) -> Model:
        """Body, medium and effects, with the task's clock."""
        return Model(self.body, self.medium, self.effects, self.task.cycle_duration_s)

    def family_of(self, gait: Gait | None = None) -> GaitFamily:
        """The family of `gait` (default the problem's own) for this body and table, within the task's bounds."""
        gait, task = gait or self.gait, self.task
        if (said := gait.misfit(self.body.joint_count, task.steps)) is not None:
            raise InputError(f"[gait] {said}.")
        bend = gait.bend if isinstance(gait, LiftedGait) else gait
        bounds = task.bounds if task.bounds.family == bend.family else bend.Bounds(family=bend.family)
        frequency = task.constraints.spatial_frequency
        if frequency is not None and "xi" in type(bounds).model_fields:
            bounds = bounds.fixed(xi=(frequency, frequency))
        gait = gait if self.lift is None else lifted(gait, self.lift)
        return gait.of(self.body.joint_count, task.steps + task.transient, bounds, not task.transient)

    @property
    def odd_duration(self) -> str | None:
        """A sentence where no limbless body takes as long for a cycle."""
        duration = self.task.cycle_duration_s
        if duration is None or duration <= LONGEST_CYCLE_S:
            return None
        return f"a cycle of {duration:g} s is longer than any gait's ({LONGEST_CYCLE_S:g} s). Milliseconds?"

    @property
    def odd_units(self) -> tuple[str, ...]:
        """What looks to be told in another unit, or is far from any body, as sentences: lengths, limits, mass and
        weights of the body, its drag, seconds, turns."""
        headings = [t for t in self.task.objectives if isinstance(t, Heading)]
        turns = [("[[task.objectives]] target_rad", t.target_rad / t.cycles) for t in headings]
        turns += [("task.constraints.heading_change_rad", self.task.constraints.heading_change_rad or 0.0)]
        said = [(name, turn, " in one cycle") for name, turn in turns]
        said += [(f"gait.{name}", turn, "") for name, turn in self.gait.rotations.items()]
        far = [(name, turn, when) for name, turn, when in said if abs(turn) > 2 * np.pi]
        return (
            *self.body.odd_units,
            *(said for said in (self.medium.odd_ratio, self.model.odd_weight) if said),
            *([] if self.odd_duration is None else [self.odd_duration]),
            *(f"{name}: {turn:g} rad are more than a whole turn{when}. Degrees?" for name, turn, when in far),
        )

    @property
    def name(self) -> str:
        """The file's name without its ending."""
        return self._name

    @property
    def folder(self) -> Path:
        """The file's folder: joint tables are named relative to it."""
        return self._folder

    @property
    def body_note(self) -> str | None:
        """That the body is the model file's, and how it differs from the problem file's; None where it does not."""
        return self._body_note

    @contextmanager
    def named_by(self, key: str) -> Iterator[None]:
        """What is wrong with a file that a key names begins with the problem file and the key."""
        try:
            yield
        except InputError as error:
            raise InputError(f"{self._source}: {key}: {error}") from None

    @property
    def hash(self) -> str:
        """Changes with any number in the problem, and with the files that [task.robust] names. Raises InputError."""
        data = self.model_dump(mode="json", exclude=None if self.effects else {"effects"})
        medium = data["medium"]
        if self.lift is None:
            del data["lift"]
        if self.medium.anisotropy_ratio_bounds is None:
            del medium["anisotropy_ratio_bounds"]
        if self.task.robust is None:
            del data["task"]["robust"]
        else:
            named = [read_bytes(self.folder / name) for name in self.task.robust.files]
            data["task"]["robust"]["contents"] = [hashlib.sha256(content).hexdigest() for content in named]
        if self.medium.law == DEFAULT:
            del medium["law"]
        if not self.model.law.softened:
            del medium["softening"]
        holds = {"joint_limits": self.joint_limit_deg, "joint_speed_limits": self.joint_speed_limit_rpm}
        data["task"]["constraints"] |= {name: limit is not None for name, limit in holds.items()}
        return short_hash(data)


def load(
    path: str | Path,
    set: list[str] | None = None,  # noqa: A002
    model: str | Path | None = None,
) -> Problem:
    """Read a problem file; `set` holds `section.key=value` assignments as on the command line.

    `model` names a model file: its medium, effects and (where it has one) body replace the problem's; a limit of the
    joints that its body does not state stays the problem's.
    Raises InputError that names file, section, key, rule, value and remedy.
    """
    if not isinstance(path, str | Path) or not isinstance(model, str | Path | None):
        got = type(path if not isinstance(path, str | Path) else model).__name__
        raise InputError(f"sp.load: takes the path of a file, got {got}. Is it read already?")
    if not isinstance(set, list | tuple | None) or not all(isinstance(assignment, str) for assignment in set or []):
        raise InputError(f"`set` must be a list of assignments, set=['task.c=0.5'], got {set!r}.")
    path = Path(path)
    data = schema.read_toml(path, "problem")
    own = data.get("body")
    if model is not None:
        data |= _with_limits(read_model_file(model), own)
    data = schema.override(_of_another_family(data, set or []), set or [])
    gait = data.get("gait")
    if isinstance(gait, dict):
        gait.setdefault("family", _family(gait))
    source = str(path) if model is None else f"{path} with --model {model}"
    problem = schema.validate(Problem, data, source)
    problem._folder, problem._name, problem._source = path.parent, path.stem, source
    if model is not None:
        problem._body_note = _other_body(problem.body, schema.override({"body": own}, set or []), model)
    return problem


def _other_body(body: Body, own: dict[str, Any], model: str | Path) -> str | None:
    """How a model's body differs from the problem's own, which may not even be whole; None: in no number."""
    said = f"the body is that of {Path(model).name}, not the problem's"
    try:
        stated = Body.model_validate(own["body"])
    except ValidationError:
        return said
    here, there = (_numbers(b) for b in (body, stated))
    if differing := [name for name, number in here.items() if number != there[name]]:
        sizes = (f"{b.vertices} vertices, {b.total_length_m:.4g} m" for b in (stated, body))
        return f"{said}: {' -> '.join(sizes)}; it differs in {listed(differing)}"
    return None


def _numbers(body: Body) -> dict[str, Any]:
    """What of a body a motion and its limits depend on, however it is written."""
    return {
        "vertices": body.vertices,
        "edge lengths": body.edges_m.round(9).tolist(),  # nanometres
        "weights": body.vertex_weights.round(9).tolist(),
        "joints": body.joint_vertices,
        "mass": body.mass_kg,
        "joint limits": (body.joint_limit_deg, body.joint_speed_limit_rpm),
    }


def _of_another_family(data: dict[str, Any], assignments: list[str]) -> dict[str, Any]:
    """`--set gait.family=...` begins [gait] and [task.bounds] anew: the file's are parameters of its own family."""
    wanted = schema.override({}, assignments).get("gait", {})
    gait, task = data.get("gait", {}), data.get("task", {})
    if not (isinstance(wanted, dict) and isinstance(gait, dict) and isinstance(task, dict)):
        return data
    if "family" not in wanted or wanted["family"] == _family(gait):
        return data
    return data | {"gait": {}, "task": {key: value for key, value in task.items() if key != "bounds"}}


def _family(gait: dict[str, Any]) -> Any:
    return gait.get("family", "table" if "path" in gait or "file" in gait else "ellipse")


def _with_limits(model: dict[str, Any], body: Any) -> dict[str, Any]:
    """A model is fitted to motion and says nothing about what the joints stand."""
    if "body" not in model or not isinstance(body, dict):
        return model
    limits = {key: body[key] for key in ("joint_limit_deg", "joint_speed_limit_rpm") if key in body}
    return model | {"body": limits | model["body"]}
