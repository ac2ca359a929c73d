"""Whole figures of a simulation, a solution, a sweep and a multi-start, written as PNG and SVG."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from serpenoid.body import Floats
from serpenoid.gaits import Gait
from serpenoid.objectives.obstacles import Obstacle
from serpenoid.plot import joints, optima, space
from serpenoid.plot.animate import animation
from serpenoid.plot.body import shapes
from serpenoid.plot.both import save
from serpenoid.plot.cases import cases_figure
from serpenoid.plot.gait import gait_curve, shapes_around, start_label
from serpenoid.plot.motion import motion
from serpenoid.plot.style import PHASE_MAP, colour_bar, figure, legend_above
from serpenoid.plot.sweep import costs_figure, family_figure, front_figure
from serpenoid.plot.world import cycles_asked, obstacles, targets
from serpenoid.problem import Problem
from serpenoid.self_contact import crosses_itself
from serpenoid.trajectory import LiftedTrajectory, Trajectory
from serpenoid.wording import up_to

if TYPE_CHECKING:
    from serpenoid.optimise.multistart import MultiStart
    from serpenoid.optimise.solution import Solution
    from serpenoid.plot.family import Family, OneGait

MANY_JOINTS = 24
ANIMATED_CYCLES = 2


def simulation_figures(
    folder: str | Path, problem: Problem, trajectory: Trajectory, table: Floats, gait: Gait
) -> list[str]:
    """Gait, motion, joints and animation of one motion; what has no numbers to draw (a failed motion) is left out."""
    names = save(joints_figure(table, problem), folder, "joints")
    if np.isfinite(trajectory.vertices).all():
        names += save(motion_figure(trajectory, problem), folder, "motion")
        if gait.curve(np.zeros(1)) is not None:
            names += save(gait_figure(gait, trajectory), folder, "gait")
        duration, joint_vertices = problem.task.cycle_duration_s, problem.body.joint_vertices
        cycles = None if problem.task.transient else max(ANIMATED_CYCLES, cycles_asked(problem))
        film, dots = Path(folder) / "animation.gif", _countable(joint_vertices)
        animation(film, trajectory, cycles, duration, dots, lambda ax: obstacles(problem, targets(problem, ax)))
        names.append("animation.gif")
    return names


def solution_figures(folder: str | Path, solution: Solution) -> list[str]:
    """The figures of a solution's re-simulated motion; of a robust gait also what it does in each case."""
    trajectory = solution.trajectory
    if isinstance(trajectory, LiftedTrajectory):
        names = spatial_figures(folder, solution.problem, trajectory, solution.table)
        return names + (save(cases_figure(solution), folder, "cases") if solution.cases else [])
    names = simulation_figures(folder, solution.problem, solution.trajectory, solution.table, solution.gait)
    return names + (save(cases_figure(solution), folder, "cases") if solution.cases else [])


def spatial_figures(folder: str | Path, problem: Problem, trajectory: LiftedTrajectory, table: Floats) -> list[str]:
    """Joints, and of a motion in space also bodies, tracks on the floor and a film."""
    names = save(spatial_joints_figure(table, problem), folder, "joints")
    if np.isfinite(trajectory.vertices).all():
        names += save(space.lifted_figure(trajectory, problem), folder, "motion")
        names += save(space.prints_figure(trajectory, problem), folder, "prints")
        space.film(Path(folder) / "animation.gif", trajectory)
        names.append("animation.gif")
    return names


def sweep_figures(folder: str | Path, data: Family, beside: OneGait | None = None) -> list[str]:
    """The family over c, its Pareto front, the cost of transport of gaits that move: of two gaits or more."""
    family = data.solved()
    if family.c.size < 2:
        return []
    made = {"family": family_figure(family), "pareto": front_figure(family, beside)}
    moving = family.moving()
    if moving.c.size > 1:
        made["cost-of-transport"] = costs_figure(moving)
    return [file for name, figure in made.items() for file in save(figure, folder, name)]


def multistart_figures(folder: str | Path, result: MultiStart) -> list[str]:
    """Costs of all starts, and the distinct optima."""
    return save(optima.optima_figure(result), folder, "optima")


def gait_figure(gait: Gait, trajectory: Trajectory) -> Figure:
    """Gait curve with the body shapes around it."""
    fig = figure(6.2, 5.4)
    ax = fig.add_subplot()
    steps = trajectory.steps_per_cycle
    gait_curve(gait, ax, steps)
    start_label(ax, gait)
    shapes_around(gait, shapes(trajectory.poses[:steps], trajectory.vertices[:steps]), ax)
    colour_bar(ax, PHASE_MAP, 0, 1, joints.X_LABEL, pad=0.02, aspect=35)
    return fig


def motion_figure(trajectory: Trajectory, problem: Problem, cycles: int | None = None) -> Figure:
    """Bodies along the path: eight a cycle, fewer of each where cycles are several."""
    cycles = cycles or cycles_asked(problem)
    fig = figure(8.6, 4.0)
    ax = fig.add_subplot()
    one = "The motion" if problem.task.transient else "A cycle"
    shown = f"; {cycles} cycles" if cycles > 1 else ""
    own = "" if problem.task.robust is None else "\nin the problem's own medium; each case: cases.png"
    title = f"{trajectory_words(trajectory, one)}{shown}{contact_words(trajectory)}{own}"
    bodies = 9 if cycles == 1 else max(1, min(4, 12 // cycles)) * cycles + 1
    dots = _countable(problem.body.joint_vertices) if cycles == 1 else ()
    walls = any(isinstance(demand, Obstacle) for demand in problem.task.demands)
    motion(trajectory, ax, cycles, bodies, title, problem.body.told_length_m, dots, bar_within=not walls)
    targets(problem, ax)
    obstacles(problem, ax)
    legend_above(ax, 5)
    when = joints.ONCE if problem.task.transient else joints.X_LABEL
    colour_bar(ax, PHASE_MAP, 0, 1, when, cax=ax.inset_axes((1.02, 0.0, 0.02, 1.0)))
    slope = float(np.ptp(ax.get_ylim()) / np.ptp(ax.get_xlim()))
    width = min(6.9, 5.0 / slope)
    fig.set_size_inches(max(width + 1.7, 5.4), max(width * slope, 1.2) + 1.15 + 0.3 * walls)
    return fig


def trajectory_words(trajectory: Trajectory, one: str = "A cycle") -> str:
    """What one cycle (or the whole of a transient) does, in a line."""
    steps = trajectory.steps_per_cycle
    dx, dy, turn = trajectory.poses[steps] - trajectory.poses[0]
    turns, spent = (rounded(*v) for v in ((np.rad2deg(turn), 1), (trajectory.dissipation_of(steps), 3)))
    return f"{one} moves {np.hypot(dx, dy):.3f} body lengths, turns {turns}°, dissipates {spent}"


def rounded(value: float, digits: int) -> str:
    """A number with its sign as printers set it, and none before a zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "−")


def contact_words(trajectory: Trajectory) -> str:
    """A warning where the chain crosses itself."""
    rows = int(crosses_itself(trajectory.vertices[: trajectory.steps_per_cycle]).sum())
    return f"\nThe body crosses itself in {rows} of {trajectory.steps_per_cycle} rows!" if rows else ""


def _countable(joint_vertices: tuple[int, ...]) -> tuple[int, ...]:
    """Joints worth a dot each: of a body with very many they would cover it."""
    return joint_vertices if len(joint_vertices) <= MANY_JOINTS else ()


def joints_figure(table: Floats, problem: Problem) -> Figure:
    """Joint angles with limits; joint speeds too where the cycle's duration is known."""
    duration, body, closed = problem.task.cycle_duration_s, problem.body, not problem.task.transient
    fig = figure(8.6, 5.6 if duration else 3.2)
    axes = fig.subplots(2 if duration else 1, 1, squeeze=False)[:, 0]
    most = np.rad2deg(np.abs(table).max())
    joints.joint_angles(table, axes[0], body.joint_limit_deg, f"Joint angles, {up_to(most, '°')}", closed)
    if duration:
        speeds = joints.speeds_rpm(table, duration, closed)
        whole = "a cycle" if closed else "the whole motion"
        title = f"Joint speeds, {up_to(float(np.abs(speeds).max()), ' rpm')} with {whole} in {duration:g} s"
        joints.joint_speeds(speeds, axes[1], body.joint_speed_limit_rpm, title, closed)
    joints.joint_bar(list(axes), table.shape[1])
    return fig


def spatial_joints_figure(table: Floats, problem: Problem) -> Figure:
    """Yaw and pitch of all joints, (T, 2 m), with their limit."""
    body, closed = problem.body, not problem.task.transient
    fig, m = figure(8.6, 5.6), table.shape[1] // 2
    axes = fig.subplots(2, 1)
    for ax, angles, word in zip(axes, (table[:, :m], table[:, m:]), ("Yaw", "Pitch"), strict=True):
        most = np.rad2deg(np.abs(angles).max())
        joints.joint_angles(angles, ax, body.joint_limit_deg, f"{word} of the joints, {up_to(most, '°')}", closed)
    joints.joint_bar(list(axes), m)
    return fig
