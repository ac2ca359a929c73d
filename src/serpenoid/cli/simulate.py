"""Simulate the gait of a problem file: trajectory, displacement, dissipation, pictures.

    serpenoid simulate problems/reference.toml
    serpenoid simulate problems/snake10.toml --set gait.a=4 --set task.cycles=3
    serpenoid simulate problems/snake10.toml --model extended-model.toml    # with effects: see `serpenoid effects`

With [lift], the midpoints of the `phase` and `bias` ranges are used; give both ends the same value to fix them.

Writes solution.json, joint_table.csv, trajectory.csv and figures; says what the motion is with many steps. Lengths are
in body lengths, dissipation is the normalised T * E (weights sum to one): it converges as the number of steps T grows,
the raw energy falls as 1 / T.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from serpenoid.cli import options
from serpenoid.cli.claim import sign
from serpenoid.wording import percent

if TYPE_CHECKING:
    from serpenoid.problem import Problem
    from serpenoid.trajectory import Trajectory


SET = "--set "  # begins how the command line asks for other steps


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `simulate`."""
    options.add_problem(parser)
    options.add_output(parser, "results/<problem>/simulate-<hash>")


def run(args: argparse.Namespace) -> int:
    """Simulate, write, report."""
    from serpenoid.cli.goals import clear_lines, dissipation_name, goal_lines, in_cycles, mesh_lines, speed_lines
    from serpenoid.joint_limits import limit_lines
    from serpenoid.optimise.outcomes import clear_of_itself, clear_of_obstacles, fine_clear_of_obstacles
    from serpenoid.problem import load
    from serpenoid.results import default_folder, weight_warning, write_simulation
    from serpenoid.self_contact import crossing_warning
    from serpenoid.simulation.mesh import FINER
    from serpenoid.simulation.problem import mesh_of, more_steps, on_meshes, simulate
    from serpenoid.trajectory import floor_lines

    problem = load(args.problem, args.set, args.model)
    options.warn_of_problem(problem)
    folder = options.output_folder(args, default_folder(problem, "simulate"), problem.hash, *_table(problem))
    with options.progress_bar(args, "simulating", 3) as advance:
        size = f"{problem.task.cycles * problem.task.steps} steps of {problem.body.vertices} vertices"
        advance(0, size)
        result = simulate(problem)
        sign(args)
        motion = result.trajectory
        advance(1, f"{size}: with 2 and 4 times as many steps")
        meshes = on_meshes(problem, result.table) if motion.status.ok else []
        mesh = mesh_of(problem, result.table, meshes) if meshes else None
        figures = not args.no_figures and motion.status.ok
        advance(2, f"{size}: writing{' and drawing' * figures}")
        record = write_simulation(folder, result, figures, mesh)
        advance(3)
    if not motion.status.ok:
        options.complain(motion.status.value)
        options.report(args, record, [])
        return 1
    several = problem.task.cycles > 1
    together = in_cycles(problem.task.cycles) * several
    finer = more_steps(problem, FINER * motion.steps_per_cycle, SET)
    lines = [
        f"displacement      {motion.displacement:z.6f} body lengths{together}",
        *speed_lines(problem, motion.displacement, problem.task.cycles),
        f"forward part      {motion.forward_displacement:+z.6f} body lengths along the mean heading{together}",
        f"heading change    {options.signed(motion.heading_change)} rad{together}",
        f"{dissipation_name(problem.medium.law)}{motion.dissipation:z.6f}{together}{_raw(problem, motion)}",
        f"largest residual  {motion.residual:.1e}",
        *_softening_lines(problem, motion),
        *goal_lines(record),
        *[f"{'':18}goals are judged from the motion of the first cycle"] * (several and bool(record["goals"])),
        *([] if mesh is None else mesh_lines(mesh, record["goals"], finer, "one cycle: " * several)),
        *_rows_lines(problem, len(result.table)),
        *clear_lines(
            clear_of_obstacles(problem, result.table, motion),
            fine_clear_of_obstacles(problem, result.table, meshes[-1]),
            clear_of_itself(problem, result.table),
            motion.steps_per_cycle,
            finer,
        ),
        *floor_lines(motion),
        *limit_lines(problem, result.table),
        *crossing_warning(motion),
        *weight_warning(problem),
        f"written to        {folder}",
    ]
    options.report(args, record, lines, folder)
    return 0


def _raw(problem: Problem, motion: Trajectory) -> str:
    """E without the factor T^(degree - 1), where the law has one."""
    return f"   (raw E {motion.energy_raw:.6g})" if problem.model.law.degree > 1 else ""


HARDER = 10.0  # leaves a hundredth of the error, where parts stick a fifth (results/benchmarks/softening.md)


def _softening_lines(problem: Problem, motion: Trajectory) -> list[str]:
    """What the softening of a law changes, found by simulating with a tenth of it."""
    from serpenoid.simulation.problem import simulate

    medium = problem.medium
    if not problem.model.law.softened:
        return []
    share = medium.softening / HARDER
    harder = problem.model_copy(update={"medium": medium.model_copy(update={"softening": share})})
    found = simulate(harder).trajectory
    if not found.status.ok:
        return [f"softening         {medium.softening:g}; with {share:g} no motion was found to compare it with"]
    change = motion.displacement - found.displacement
    part = f" ({percent(abs(change) / found.displacement)})" if not found.stands_still else ""
    what = f"with {share:g} the displacement is {found.displacement:z.6f}"
    return [f"softening         {medium.softening:g} changes it by {change:+.1e}{part}: {what}"]


def _rows_lines(problem: Problem, rows: int) -> list[str]:
    """A line where a joint table has other rows than the steps that the file asks for."""
    task = problem.task
    if rows == task.steps + task.transient or "steps" not in task.model_fields_set:
        return []
    return [f"note              the joint table is played as it is, {rows} rows: task.steps = {task.steps} is not used"]


def _table(problem: Problem) -> list[str]:
    """The joint table's content, where the gait is one."""
    from serpenoid.cli.claim import content_of

    path = getattr(problem.gait, "path", None)
    with problem.named_by("[gait] path"):
        return content_of(problem.folder / path) if path else []
