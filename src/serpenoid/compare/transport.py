"""Cost of transport from the power log: CoT = P / (m g v), electrical; and what of P is idle.

P = P_idle + k * (dissipation rate), both by non-negative least squares over cycles; the rate is the model's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from serpenoid.body import Floats
from serpenoid.compare.three import Comparison
from serpenoid.measure.clock import find_offset
from serpenoid.measure.trial import Trial
from serpenoid.performance import GRAVITY


@dataclass(frozen=True)
class CyclePower:
    """One cycle: mean electrical power while moving, speed, cost of transport, and the model's dissipation rate."""

    trial: str
    gait: str
    dissipation_coefficient: float | None
    power_W: float
    speed_m_s: float
    cost_of_transport: float
    dissipation_rate: float  # [1/s^2]: sum of w |v|^2-like terms, body lengths, weights summing to one
    aligned: bool  # False: the power log has no common motion with the schedule; its whole-record mean is used


@dataclass(frozen=True)
class CostPoint:
    """Mean and SD over trials at one (gait label without c, c)."""

    gait: str
    dissipation_coefficient: float | None
    mean: float
    std: float
    trials: int


@dataclass(frozen=True)
class PowerModel:
    """P = idle_W + coefficient_W * dissipation rate, with standard errors; r2 of the fit."""

    idle_W: float
    coefficient_W: float
    idle_sd: float
    coefficient_sd: float
    r2: float
    cycles: int


def cycle_power(trial: Trial, comparison: Comparison, mass_kg: float) -> CyclePower | None:
    """Power and cost of transport of one compared cycle; None without power log, scale or schedule."""
    if trial.power_log is None or trial.metres is None or trial.schedule is None:
        return None
    offset = power_offset(trial)
    first, last = trial.schedule.window_s(comparison.cycle)
    last = first + trial.schedule.cycle_duration_s
    time = trial.power_log.time_s + (offset or 0.0)
    inside = (time >= first) & (time <= last)
    aligned = offset is not None and bool(inside.sum() >= 3)
    power = float(trial.power_log.power_W[inside].mean() if aligned else trial.power_log.power_W.mean())
    speed = comparison.exp.displacement * trial.metres / trial.schedule.cycle_duration_s
    moving = comparison.time_s[:-1] <= last
    steps = np.diff(comparison.time_s)
    rate = float((comparison.resim.step_energy / steps)[moving].sum() / (last - first))
    cost = power / (mass_kg * GRAVITY * speed) if speed > 0 else float("inf")
    return CyclePower(trial.name, trial.gait, trial.dissipation_coefficient, power, speed, cost, rate, aligned)


def power_offset(trial: Trial) -> float | None:
    """Power meter's clock to the cameras': power is laid over the commanded joint speed."""
    if trial.power_log is None or trial.schedule is None or trial.start_source == "none":
        return None
    end = trial.schedule.end_s
    grid = np.arange(trial.schedule.start_s - 1.0, end + 1.0, 0.02)
    command = trial.schedule.commanded(grid)
    effort = np.sqrt((np.gradient(command, 0.02, axis=0) ** 2).sum(axis=1))
    logged = trial.power_log
    scaled = (logged.power_W - logged.power_W.mean()) / max(float(logged.power_W.std()), 1e-12) * effort.std()
    found = find_offset(grid, effort[:, None], logged.time_s, scaled[:, None])
    return None if found is None or found.correlation < 0.3 else found.offset_s


def cost_points(cycles: list[CyclePower]) -> tuple[CostPoint, ...]:
    """Mean and SD over trials for every gait and c; repeats of a trial's cycles are averaged first."""
    points = []
    keys = dict.fromkeys((c.gait, c.dissipation_coefficient) for c in cycles)
    for gait, coefficient in keys:
        mine = [c for c in cycles if (c.gait, c.dissipation_coefficient) == (gait, coefficient)]
        per_trial = [
            np.mean([c.cost_of_transport for c in mine if c.trial == name]) for name in {c.trial for c in mine}
        ]
        std = float(np.std(per_trial, ddof=1)) if len(per_trial) > 1 else float("nan")
        points.append(CostPoint(gait, coefficient, float(np.mean(per_trial)), std, len(per_trial)))
    return tuple(points)


def fit_power(cycles: list[CyclePower]) -> PowerModel | None:
    """Idle power and dissipation coefficient; None for fewer than 3 cycles or one dissipation rate only."""
    rate, power = np.array([c.dissipation_rate for c in cycles]), np.array([c.power_W for c in cycles])
    if len(cycles) < 3 or not np.isfinite(rate).all() or np.ptp(rate) <= 1e-9 * max(rate.max(), 1e-12):
        return None
    design = np.stack([np.ones_like(rate), rate], axis=1)
    (idle, coefficient), _ = nnls(design, power)
    left = power - design @ np.array([idle, coefficient])
    variance = float(left @ left) / max(len(power) - 2, 1)
    sd = np.sqrt(np.diag(variance * np.linalg.inv(design.T @ design)))
    total = float(((power - power.mean()) ** 2).sum())
    r2 = 1 - float(left @ left) / total if total > 0 else float("nan")
    return PowerModel(float(idle), float(coefficient), float(sd[0]), float(sd[1]), r2, len(cycles))


def by_coefficient(points: tuple[CostPoint, ...]) -> dict[str, Floats]:
    """Gait family (label up to `-c`) -> rows (c, mean, std), sorted by c; only points that have a c."""
    families: dict[str, list[tuple[float, float, float]]] = {}
    for point in points:
        if point.dissipation_coefficient is not None:
            family = point.gait.rsplit("-c", 1)[0]
            families.setdefault(family, []).append((point.dissipation_coefficient, point.mean, point.std))
    return {family: np.array(sorted(rows)) for family, rows in families.items()}
