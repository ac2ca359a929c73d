"""What a gait is asked for: one objective and any number of constraints, as symbolic expressions of its motion.

The symbols stand for poses, joint angles, dissipation and gait parameters of a cycle. Whoever needs the numbers (the
NLP, the certificate, derivative-free searches, sweeps, reports) evaluates the same Functions at its own motion.

Legend: T steps, R rows of the joint table, m joints, n gait parameters.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import casadi as ca

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.objectives.checked import expression as checked
from serpenoid.objectives.checked import interval, scalar
from serpenoid.objectives.frames import composed, place, placed
from serpenoid.wording import meant

NOWHERE = 1e-180  # body lengths^2: far below rounding; its power -3/2, in second derivatives, is finite
NEAR = 1e-6  # body lengths: less than any mesh can tell


@dataclass(frozen=True)
class Gaps:
    """of: points (2, K) to a column of gaps, which change no faster than their point moves.

    convex: each gap is a convex function of its point, as distances to convex obstacles are; proofs are cheaper then.
    """

    of: Callable[[ca.SX], ca.SX]
    convex: bool = False


class Apart(Protocol):
    """Gaps (K) between parts of the body with derivatives of their own: functions of the joint
    table (m R) as one column."""

    @property
    def least(self) -> float:
        """What they stay above."""

    @property
    def count(self) -> int:
        """K."""

    def value(self, table: ca.MX) -> ca.MX:
        """Gaps (K)."""

    def jacobian(self, table: ca.MX) -> ca.MX:
        """Their derivatives (K, m R)."""

    def hessian(self, table: ca.MX, multipliers: ca.MX) -> ca.MX:
        """Second derivatives (m R, m R) of multipliers . gaps."""


class UnknownName(InputError, AttributeError):
    """A name that criteria do not have, read or set: misspelt, it would ask nothing."""


@dataclass
class Criteria:
    """Symbols of one cycle; add to them with `minimise`, `also_minimise` and `subject_to`.

    poses (3, T + 1): body frames from the origin on [body lengths, rad], in space (6, T + 1), see `frames`;
    joint_angles (m, R) [rad], the joint table; dissipation: T times E; gait (n): the family's parameters; c: weight of
    the dissipation, which sweeps vary. chain: from a row's joint angles to the vertices (2, N) in the body frame, if
    the body is known; in space `raised`: from the gait and the row's number to vertices (3, N). in_place: whether
    demands want the cycle to end where it began. What is asked of places and headings is asked of the first three
    numbers of a pose: along the floor.
    """

    steps: int
    rows: int
    joints: int
    size: int
    names: tuple[str, ...] = ()
    chain: Callable[[ca.SX], ca.SX] | None = None
    pose_size: int = 3
    raised: Callable[[ca.SX, int], ca.SX] | None = None
    in_place: bool = False
    moved: ca.SX = field(init=False)
    poses: ca.SX = field(init=False)
    angles: ca.SX = field(init=False)
    joint_angles: ca.SX = field(init=False)
    dissipation: ca.SX = field(init=False)
    gait: ca.SX = field(init=False)
    c: ca.SX = field(init=False)
    objective: ca.SX = field(init=False)
    added: list[tuple[ca.SX, Floats, Floats]] = field(init=False, default_factory=list)

    clear_of: list[Gaps] = field(init=False, default_factory=list)
    apart: list[Apart] = field(init=False, default_factory=list)

    def __post_init__(self) -> None:
        d = self.pose_size
        self.moved = ca.SX.sym("poses", d * self.steps)
        self.poses = ca.horzcat(ca.SX.zeros(d, 1), ca.reshape(self.moved, d, self.steps))
        self.angles = ca.SX.sym("joint_angles", self.joints * self.rows)
        self.joint_angles = ca.reshape(self.angles, self.joints, self.rows)
        self.dissipation, self.c = ca.SX.sym("dissipation"), ca.SX.sym("c")
        self.gait = ca.SX.sym("gait", self.size)
        self.objective = ca.SX(0)

    if not TYPE_CHECKING:  # checkers would take every name for one that is there

        def __getattr__(self, name: str) -> None:
            """What is not there, asked for."""
            raise AttributeError(name) if name.startswith("_") else self._unknown(name)

    def __setattr__(self, name: str, value: object) -> None:
        if name not in {own.name for own in fields(self)}:
            raise self._unknown(name)
        super().__setattr__(name, value)

    def _unknown(self, name: str) -> UnknownName:
        names = [own for own in dir(self) if not own.startswith("_")]
        if name in names:  # methods and what is made of the symbols
            return UnknownName(f"criteria: `{name}` cannot be set. Ask by minimise(...) or subject_to(...).")
        hint = meant(name, names) or f" There are {', '.join(names)}."
        return UnknownName(f"criteria: there is no `{name}`.{hint}")

    @cached_property
    def known(self) -> set[int]:
        """All symbols, by element."""
        return {element.element_hash() for element in ca.symvar(ca.vertcat(*self.inputs))}

    @property
    def displacement(self) -> ca.SX:
        """Distance of the centroid over the cycle, along the floor [body lengths].

        Its slope at a distance of exactly zero is zero and not 0 / 0. The kink there tells a search that stands still;
        where demands want that (`in_place`) it is rounded off within NEAR, by a polynomial of the squared distance that
        joins it with equal first and second derivatives.
        """
        squared = ca.sumsqr(self.poses[:2, -1])
        if not self.in_place:
            return ca.sqrt(ca.fmax(squared, NOWHERE))
        u, far = ca.fmin(squared / NEAR**2, 1.0), ca.sqrt(ca.fmax(squared, NEAR**2))
        return ca.if_else(squared < NEAR**2, NEAR * u * (15 - u * (10 - 3 * u)) / 8, far)

    @property
    def heading_change(self) -> ca.SX:
        """Turn over the cycle [rad]."""
        return self.poses[2, -1]

    @property
    def bends(self) -> ca.SX:
        """Joint angles (m, R) in the body's own plane; in space pitches (m, R) come after them [rad]."""
        return self.joint_angles if self.pose_size == 3 else self.joint_angles[: self.joints // 2, :]

    @property
    def changes(self) -> ca.SX:
        """Changes of the joint angles from row to row, shape (m, T) [rad]."""
        angles = self.joint_angles
        return (ca.horzcat(angles[:, 1:], angles[:, 0]) if self.rows == self.steps else angles[:, 1:]) - angles[
            :, : self.steps
        ]

    def row(self, share: float) -> int:
        """The row nearest to a part of the cycle; the last of a closed gait is the first again."""
        return round(share * self.steps) % self.rows

    def vertices(self, row: int) -> ca.SX:
        """Vertices (2 or 3, N), tail to head, at a row 0 .. T, as they are commanded [body lengths]."""
        at = row % self.rows
        body = self.body(self.joint_angles[:, at]) if self.raised is None else self.raised(self.gait, at)
        return placed(self.poses[:, row], body)

    def centre(self, row: int) -> ca.SX:
        """Where the body frame is (2 or 3) at a row 0 .. T [body lengths]."""
        return place(self.poses[:, row])

    def count_turns(self) -> None:
        """Have every step turn by less than half a turn: a heading that is a whole turn off is the same pose."""
        turns = ca.vec(self.poses[2, 1:] - self.poses[2, :-1])
        self.subject_to(turns, -ca.pi, ca.pi)

    def body(self, angles: ca.SX) -> ca.SX:
        """Vertices (2, N) in the body frame of joint angles (m)."""
        if self.chain is None:
            raise InputError("points of the body need a body: it is known where a problem is solved.")
        return self.chain(angles)

    def after(self, cycles: int) -> ca.SX:
        """Pose (3 or 6) after the cycle was played `cycles` times: its net motion, composed with itself."""
        pose = ca.SX.zeros(self.pose_size)
        for _ in range(cycles):
            pose = composed(pose, self.poses[:, -1])
        return pose

    def minimise(self, expression: ca.SX) -> None:
        """Replace the objective."""
        self.objective = scalar(expression, "minimise", self.known)

    def also_minimise(self, expression: ca.SX) -> None:
        """Add to the objective."""
        self.objective = self.objective + scalar(expression, "also_minimise", self.known)

    def subject_to(self, expression: ca.SX, lower: Floats | float, upper: Floats | float) -> None:
        """Add `lower <= expression <= upper` (scalars or columns)."""
        column = ca.vec(checked(expression, "subject_to", self.known))
        self.added.append((column, *interval(lower, upper, column.numel())))

    def keep_clear(self, gaps: Callable[[ca.SX], ca.SX], convex: bool = False) -> None:
        """Keep `gaps` of all points of the body in the world from falling below zero at any time; see `Gaps`."""
        self.clear_of.append(Gaps(gaps, convex))

    def keep_apart(self, gaps: Apart) -> None:
        """Keep parts of the body apart: constraints after all others."""
        self.apart.append(gaps)

    @property
    def count(self) -> int:
        """Number of all constraints: expressions, then gaps between parts of the body."""
        return int(self.constraints.numel()) + sum(gaps.count for gaps in self.apart)

    @property
    def constraints(self) -> ca.SX:
        """All constraint expressions in one column."""
        return ca.vertcat(*(expression for expression, _, _ in self.added)) if self.added else ca.SX(0, 1)

    @property
    def inputs(self) -> list[ca.SX]:
        """Arguments of every Function made from the criteria: g_1 .. g_T (3 T), angles (m R), dissipation, gait, c."""
        return [self.moved, self.angles, self.dissipation, self.gait, self.c]

    @property
    def function(self) -> ca.Function:
        """`inputs` -> objective, constraints."""
        return ca.Function("criteria", self.inputs, [ca.densify(self.objective), ca.densify(self.constraints)])

    @property
    def separable(self) -> bool:
        """Whether the dissipation enters as a constant (or c) times itself, and no constraint has it."""
        by, others = ca.gradient(self.objective, self.dissipation), ca.vertcat(*self.inputs[:-1])
        in_constraints = ca.jacobian(self.constraints, self.dissipation).nnz() > 0
        return not in_constraints and not any(ca.which_depends(by, others, 1, True))

    def needs(self, symbol: ca.SX) -> bool:
        """Whether objective or constraints depend on `symbol`."""
        if self.apart and symbol is self.angles:
            return True
        both = ca.vertcat(self.objective, self.constraints)
        return ca.jacobian(both, symbol).nnz() > 0
