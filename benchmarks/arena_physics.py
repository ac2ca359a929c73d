"""Numbers of the arena: displacement, sensitivity to the time step, anisotropy, speed.

python benchmarks/arena_physics.py > results/benchmarks/arena_physics.md       (about two minutes)
"""

from __future__ import annotations

import sys
import time

import numpy as np

from serpenoid.arena.assembly import Assembly
from serpenoid.arena.robot import Robot
from serpenoid.arena.world import World

ROBOT = Robot()
LENGTH = float(ROBOT.edge_lengths_m.sum())
WEIGHTS = ROBOT.vertex_masses_kg / ROBOT.mass_kg


def table(a: float, sigma: float, xi: float, rows: int = 50) -> np.ndarray:
    """Joint angles (rows, 10): edge angle = integral of kappa at the edge's midpoint, joint = their difference."""
    edges = ROBOT.edge_lengths_m / LENGTH
    middle, k = np.cumsum(edges) - edges / 2, 2 * np.pi * xi
    phase = 2 * np.pi * np.arange(rows)[:, None] / rows
    w1, w2 = a * np.cos(phase), a * sigma * np.sin(phase)
    return np.diff((w1 * (1 - np.cos(k * middle)) + w2 * np.sin(k * middle)) / k, axis=1)


REFERENCE, SECOND, THIRD = table(6, 1, 1), table(5, 0.6, 1.2), table(8, 0.5, 0.8)


def played(robot: Robot, joint_table: np.ndarray, duration: float = 5.0) -> tuple[float, float, float]:
    """Forward displacement of the second cycle [body lengths], mean power [W], simulated over processor time."""
    world = World(Assembly.healthy(robot))
    world.place(joint_table[0])
    begin, power, centres = time.process_time(), [], []
    ahead = world.markers()[-1, :2] - world.markers()[0, :2]
    for count in range(2 * len(joint_table)):
        if count == len(joint_table):
            centres.append(WEIGHTS @ world.markers()[:, :2])
        world.command(joint_table[count % len(joint_table)])
        while world.time_s < (count + 1) * duration / len(joint_table) - 1e-9:
            world.step()
            power.append(world.power())
    moved = (WEIGHTS @ world.markers()[:, :2] - centres[0]) @ ahead / np.linalg.norm(ahead) / LENGTH
    return float(moved), float(np.mean(power)), 2 * duration / (time.process_time() - begin)


def dragged(direction: tuple[float, float], speed: float) -> float:
    """Force over weight that keeps the straight robot sliding at `speed` [m/s]."""
    world = World(Assembly.healthy(ROBOT))
    world.place(np.zeros(10))
    along, mass = np.array(direction), world.model.body_mass[:, None]
    forces, gain, tail = [], 50.0, 0.0
    for _ in range(round(1.5 / ROBOT.timestep_s)):
        velocity = world.data.cvel[1:, 3:5].mean(axis=0) @ along
        error = speed - velocity
        tail += 400.0 * error * ROBOT.timestep_s
        push = gain * error + tail
        world.data.xfrc_applied[:, :2] = push * mass * along
        forces.append(push)
        world.step()
    return float(np.mean(forces[len(forces) // 2 :]) / 9.81)


def lines() -> list[str]:
    finer = [ROBOT.model_copy(update={"timestep_s": ROBOT.timestep_s / n}) for n in (1, 2, 4)]
    reference = played(ROBOT, REFERENCE)
    rows = [f"| reference gait, 5 s | {reference[0]:.3f} |"]
    rows += [f"| reference gait, {d:g} s | {played(ROBOT, REFERENCE, d)[0]:.3f} |" for d in (2.5, 10.0)]
    rows.append(f"| reversed in time | {played(ROBOT, REFERENCE[-np.arange(50)])[0]:.3f} |")
    for name, gait in (("reference", REFERENCE), ("a 5, sigma 0.6, xi 1.2", SECOND), ("a 8, sigma 0.5, xi 0.8", THIRD)):
        found = ", ".join(f"{played(robot, gait)[0]:.3f}" for robot in finer)
        rows.append(f"| {name}: time step 1/360, 1/720, 1/1440 s | {found} |")
    along, across = [dragged((1.0, 0.0), v) for v in (0.02, 0.1, 0.2)], dragged((0.0, 1.0), 0.1)
    return [
        "# The arena in numbers",
        "",
        "`python benchmarks/arena_physics.py`. Even mats, healthy robot, second of two cycles.",
        "",
        "| forward displacement | body lengths per cycle |",
        "| --- | --- |",
        *rows,
        "",
        "- Dragged straight at 0.02, 0.1, 0.2 m/s, force over weight: lengthwise "
        + ", ".join(f"{force:.3f}" for force in along)
        + f"; sideways {across:.3f}. Anisotropy "
        + ", ".join(f"{force / across:.2f}" for force in along)
        + ".",
        f"- Electrical power of the reference gait {reference[1]:.1f} W.",
        f"- {reference[2]:.1f} times faster than real time on one core, by processor time.",
    ]


if __name__ == "__main__":
    sys.stdout.write("\n".join(lines()) + "\n")
