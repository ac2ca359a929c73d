"""Friction laws: what the floor does to a contact point. Formulas and names in EFFECTS.md.

v_t, v_n: velocity along the rolling direction and to its left [m/s], s: scrub, half-track times turning rate [m/s];
forces divided by the drag level, so in m/s; a scrub force times the half-track is a moment.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from blind.snake import SNAKE10, Floats, Robot

CREEP = 1e-3  # m/s, softens signs and norms
POWER_SPEED = 0.1  # m/s

# world positions (S, N, 2), time (S,) -> forces on the vertices (S, N, 2)
ExternalForce = Callable[[Floats, Floats], Floats]


@dataclass(frozen=True)
class Patch:
    strength: float
    x: float
    y: float
    radius: float

    def factor(self, world: Floats) -> Floats:
        """At places (.., 2)."""
        distance2 = (world[..., 0] - self.x) ** 2 + (world[..., 1] - self.y) ** 2
        return np.asarray(1 + self.strength * np.exp(-distance2 / (2 * self.radius**2)))


@dataclass(frozen=True)
class PhaseSlip:
    """Vertex that loses its grip between two phases of the cycle (outside the catalogue)."""

    vertex: int
    centre: float
    width: float
    left_over: float


WAYS = ("ellipse", "components", "plain")
SHAPES: tuple[Callable[[Floats], Floats], ...] = (
    lambda x: x / np.sqrt(1 + x**2), np.tanh, lambda x: 2 / np.pi * np.arctan(np.pi / 2 * x)
)  # fmt: skip


@dataclass(frozen=True)
class Dry:
    """Dry friction instead of drag: |f| = w S(q / speed), of one slip or of each way by itself (outside the catalogue).

    ways: q^2 = v_n^2 + e^2 v_t^2, of forces in an ellipse; each way alone, of forces in a box; or |v|, whose force has
    the direction of linear drag. shape: S, one of SHAPES.
    """

    ways: str
    shape: int
    speed: float

    def over_slip(self, q: Floats, creep: float) -> Floats:
        """S(q / speed) / q [s/m]; softer where the solver asks for it."""
        speed = np.sqrt(self.speed**2 + creep**2 - CREEP**2)
        x = np.maximum(q / speed, 1e-9)
        return np.asarray(SHAPES[self.shape](x) / x / speed)


@dataclass(frozen=True)
class Ground:
    """Everything medium; defaults are neutral and give F_k = -w_k (eps v_t T_k + v_n N_k)."""

    eps: float
    robot: Robot = SNAKE10
    creep: float = CREEP
    seizure: dict[int, float] = field(default_factory=dict)
    roughness: dict[int, float] = field(default_factory=dict)
    share: dict[int, float] = field(default_factory=dict)
    tyres: dict[int, float] = field(default_factory=dict)
    dry: Dry | None = None
    crossover_speed: float = 0.0
    rolling_crossover: float = 0.0
    saturation_speed: float = np.inf
    forward_backward: float = 0.0
    left_right: float = 0.0
    half_track: float = 0.0
    mount: float = 0.0
    toe: float = 0.0
    pull: tuple[float, float] = (0.0, 0.0)
    patches: tuple[Patch, ...] = ()
    grip_patches: tuple[Patch, ...] = ()
    gradient: tuple[float, float] = (0.0, 0.0)
    drift_rate: float = 0.0
    exponent: float = 1.0
    inertia: float = 0.0
    added_mass: float = 0.0
    contact_offset: float = 0.0
    phase_slips: tuple[PhaseSlip, ...] = ()
    external: tuple[ExternalForce, ...] = ()

    @property
    def linear(self) -> bool:
        """Is the force linear in the velocity?"""
        odd = self.forward_backward, self.left_right, self.crossover_speed, self.rolling_crossover
        return self.dry is None and not any(odd) and np.isinf(self.saturation_speed) and self.exponent == 1

    @property
    def knows_place(self) -> bool:
        """Does the force depend on where the body is or how it is turned?"""
        return bool(self.patches or self.grip_patches or any(self.gradient) or any(self.pull) or self.external)

    @property
    def inertial(self) -> bool:
        return self.inertia > 0 or self.added_mass > 0

    @property
    def drag_weights(self) -> Floats:
        w = self.robot.weights
        for vertex, share in self.share.items():
            w[vertex] = max(w[vertex] + share, 0.0)
        return w

    @property
    def locked(self) -> Floats:
        """The part of each wheel that slides and does not roll, (N,)."""
        part = np.zeros(self.robot.vertices)
        for vertex, s in self.seizure.items():
            part[vertex] = s
        return part

    def rolling(self, time: Floats) -> Floats:
        """Tangential coefficient of the part of each wheel that rolls, (S, N)."""
        rough = np.ones(self.robot.vertices)
        for vertex, more in self.roughness.items():
            rough[vertex] += more
        return self.eps * rough * np.exp(self.drift_rate * time[..., None]) * (1 - self.locked)

    def bite(self, world: Floats) -> Floats:
        """What each tyre resists sideways, over what the others do elsewhere (S, N)."""
        tyre = np.ones(self.robot.vertices)
        for vertex, change in self.tyres.items():
            tyre[vertex] += change
        factor = np.broadcast_to(tyre, world.shape[:-1]).copy()
        for p in self.grip_patches:
            factor *= p.factor(world)
        return factor

    def level(self, world: Floats, phase: Floats) -> Floats:
        """Weight of each contact (S, N): load, patch, gradient, phase slip."""
        w = np.broadcast_to(self.drag_weights, world.shape[:-1]).copy()
        for p in self.patches:
            w *= p.factor(world)
        if any(self.gradient):
            w *= np.exp(world @ np.array(self.gradient))
        for s in self.phase_slips:
            away = np.abs((phase - s.centre + 0.5) % 1 - 0.5)
            w[..., s.vertex] *= np.where(away < s.width / 2, s.left_over, 1.0)
        return w

    def force(
        self, level: Floats, rolling: Floats, v_t: Floats, v_n: Floats, s: Floats | None = None
    ) -> tuple[Floats, ...]:
        """Tangential and normal force on each contact; with a scrub `s`, its force too."""
        across = (v_n,) if s is None else (v_n, s)
        if self.dry is not None:
            return self._dry(self.dry, level, rolling, v_t, across)
        factor = level
        if self.crossover_speed or self.exponent != 1:
            speed = np.sqrt(sum((u**2 for u in across), v_t**2) + self.creep**2)
            factor = factor * ((speed / POWER_SPEED) ** (self.exponent - 1) + self.crossover_speed / speed)
        rolls, grips = -factor * rolling * v_t, -factor
        if self.rolling_crossover:
            rolls = rolls - level * rolling * v_t * self.rolling_crossover / np.sqrt(v_t**2 + self.creep**2)
        if self.forward_backward:
            rolls = rolls * (1 - self.forward_backward * v_t / np.sqrt(v_t**2 + self.creep**2))
        slides = self.locked * v_t
        if np.isfinite(self.saturation_speed):
            slip2 = sum((u**2 for u in across), slides**2)
            grips = grips / np.sqrt(1 + slip2 / self.saturation_speed**2)
        f_t = rolls + grips * slides
        if self.left_right:
            grips = grips * (1 + self.left_right * v_n / np.sqrt(v_n**2 + self.creep**2))
        return f_t, *(grips * u for u in across)

    def _dry(
        self, dry: Dry, level: Floats, rolling: Floats, v_t: Floats, across: tuple[Floats, ...]
    ) -> tuple[Floats, ...]:
        """The same by dry friction; asymmetries multiply what they do on drag."""
        locked, rolls = self.locked, rolling
        n2 = sum((u**2 for u in across), np.zeros_like(v_t))
        if dry.ways == "ellipse":
            rolls = rolling**2 / np.maximum(1 - locked, 1e-12)
            m_t = m_n = dry.over_slip(np.sqrt(n2 + (rolls + locked) * v_t**2), self.creep)
        elif dry.ways == "components":
            m_t, m_n = (dry.over_slip(q, self.creep) for q in (np.abs(v_t), np.sqrt(n2)))
        else:
            m_t = m_n = dry.over_slip(np.sqrt(n2 + v_t**2), self.creep)
        easier = 1 - self.forward_backward * v_t / np.sqrt(v_t**2 + self.creep**2)
        harder = 1 + self.left_right * across[0] / np.sqrt(across[0] ** 2 + self.creep**2)
        f_t = -level * m_t * (rolls * easier + locked) * v_t
        return f_t, *(-level * m_n * harder * u for u in across)

    def external_force(self, world: Floats, time: Floats) -> Floats | None:
        """World-frame forces on the vertices (S, N, 2), or None."""
        if not any(self.pull) and not self.external:
            return None
        total = self.drag_weights[:, None] * np.array(self.pull) + np.zeros_like(world)
        for pulling in self.external:
            total = total + pulling(world, time)
        return total
