"""Write a campaign as an ordinary folder (docs/campaign-format.md), and its seal somewhere else."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from blind.cameras import ServoLog
from blind.campaign import Campaign, Trial


def _numbers(values: object) -> str:
    return "[" + ", ".join(f"{v:.6g}" for v in np.asarray(values)) + "]"


def _table(path: Path, header: str, rows: list[str]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([header, *rows]) + "\n")


def _rows(columns: np.ndarray, fmt: str) -> list[str]:
    line = ",".join([fmt] * columns.shape[1])
    return [(line % tuple(row)).replace("nan", "") for row in columns.tolist()]


def _motion(path: Path, trial: Trial) -> None:
    time = trial.film.time + trial.clocks.camera_t0
    columns = np.column_stack([time, trial.film.markers.reshape(len(time), -1)])
    header = "t_s," + ",".join(f"x_{k},y_{k}" for k in range(trial.film.markers.shape[1]))
    _table(path, header, _rows(columns, "%.5f"))


def _servo(path: Path, log: ServoLog, seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = len(log.time)
    voltage = 11.4 - 0.02 * np.arange(n) / n + 0.05 * rng.integers(-1, 2, n)
    joints = range(1, log.position.shape[1] + 1)
    header = ",".join(
        ["t_s,phase,cycle,step", *[f"{name}_{j}" for name in ("command", "position") for j in joints]]
        + [f"voltage_{j}" for j in joints]
    )
    values = np.column_stack([log.command, log.position])
    line = ",".join(["%.6f"] * values.shape[1])
    rows = [
        f"{t:.5f},{phase},{cycle},{step},{line % tuple(v)}" + f",{volt:.2f}" * len(joints)
        for t, phase, cycle, step, v, volt in zip(
            log.time.tolist(), log.phase, log.cycle, log.step, values.tolist(), voltage.tolist(), strict=True
        )
    ]
    _table(path, header, rows)


def _toml(c: Campaign) -> str:
    robot, tools = c.world.ground.robot, c.protocol.instruments
    markers = ["tail", *[f"joint_{j}" for j in range(1, robot.joints + 1)], "head"]
    lines = [
        "format = 1",
        f'name = "{c.protocol.name}, {c.identity}"',
        'description = "repeated gaits on a flat floor"',
        "",
        "[body]",
        f"vertices = {robot.vertices}",
        f"edge_lengths = {_numbers(robot.edges)}",
        f"weights = {_numbers(robot.weights)}",
        f"mass_kg = {robot.mass_kg}",
        "",
        "[motion]",
        'format = "tidy"',
        'length_unit = "m"',
        f"markers = {json.dumps(markers)}",
        f"frames_per_second = {tools.frames_per_second}",
    ]
    for t in c.trials:
        plan = t.setting.plan
        lines += [
            "",
            "[[trial]]",
            f'name = "{t.name}"',
            f'gait = "gait{t.setting.gait + 1:02d}"',
            f'joint_table = "gaits/gait{t.setting.gait + 1:02d}.csv"',
            f"cycle_duration_s = {plan.cycle_s}",
            f"cycles = {plan.cycles}",
            f"pause_s = {plan.pause_s}",
            f'motion = "{t.name}/motion.csv"',
        ]
        lines += [f'servo_log = "{t.name}/servo.csv"'] if tools.log_hertz else []
    return "\n".join(lines) + "\n"


def write(c: Campaign, folder: Path) -> None:
    """The campaign folder: nothing in it tells what is hidden, or the seed."""
    folder.mkdir(parents=True, exist_ok=True)
    for i, t in enumerate(c.trials):
        gait = folder / "gaits" / f"gait{t.setting.gait + 1:02d}.csv"
        if not gait.exists():
            header = ",".join(f"joint_{j}" for j in range(1, c.world.ground.robot.joints + 1))
            _table(gait, header, _rows(t.setting.plan.table, "%.6f"))
        _motion(folder / t.name / "motion.csv", t)
        if c.protocol.instruments.log_hertz:
            _servo(folder / t.name / "servo.csv", t.log, i)
    (folder / "campaign.toml").write_text(_toml(c))


def seal(c: Campaign, path: Path) -> None:
    """What was hidden; to be opened only after the diagnosis has been written."""
    path.parent.mkdir(parents=True, exist_ok=True)
    truth = {"identity": c.identity, "seed": c.seed, "eps": c.eps, "effects": [e.as_dict() for e in c.effects]}
    path.write_text(json.dumps(truth, indent=1))
