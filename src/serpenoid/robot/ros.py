"""ROS 2 `trajectory_msgs/JointTrajectory`, as MCAP and as YAML (optional extra `serpenoid[ros]`).

The trajectory begins and ends at rest, and every pause is a rest: `joint_trajectory_controller` refuses a trajectory
whose last point has a velocity. Velocities between are central differences of the table, which goes on with its first
row, unless it is a transient: that ends, and is held, on its last one.
T: steps, m: joints.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from serpenoid.errors import InputError
from serpenoid.files.writing import atomic, write_text

TOPIC = "/joint_trajectory_controller/joint_trajectory"
SCHEMA = "trajectory_msgs/msg/JointTrajectory"
APPROACH_S = 3.0  # the controller's own way to the first row
_LINE = "=" * 80
DEFINITION = f"""std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint[] points
{_LINE}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{_LINE}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
{_LINE}
MSG: trajectory_msgs/JointTrajectoryPoint
float64[] positions
float64[] velocities
float64[] accelerations
float64[] effort
builtin_interfaces/Duration time_from_start
{_LINE}
MSG: builtin_interfaces/Duration
int32 sec
uint32 nanosec
"""


@dataclass(frozen=True)
class Trajectory:
    """K points: `times` (K,) [s] strictly increasing from above 0, `positions` and `velocities` (K, m) [rad, rad/s]."""

    times: NDArray[np.float64]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]


def make_trajectory(
    angles: NDArray[np.float64], cycle_duration_s: float, cycles: int, pause_s: float, closed: bool = True
) -> Trajectory:
    """Approach, then `cycles` cycles of the table (T, m), each followed by a pause; of a transient (T + 1, m)."""
    rows = np.concatenate([angles, angles[:1]]) if closed else angles
    steps, rest = len(rows) - 1, np.zeros(rows.shape[1])
    period = cycle_duration_s / steps
    before = np.concatenate([rows[-2:-1], rows[:-2]])
    swing = (rows[1:] - before) / (2 * period)
    points = [(APPROACH_S, rows[0], rest)]
    for cycle in range(cycles):
        start = APPROACH_S + cycle * (cycle_duration_s + pause_s)
        points += [(start + i * period, rows[i], swing[i]) for i in range(1, steps)]
        last = cycle == cycles - 1
        points.append((start + cycle_duration_s, rows[-1], rest if pause_s > 0 or last else swing[0]))
        if pause_s > 0:
            points.append((start + cycle_duration_s + pause_s, rows[-1], rest))
    times, positions, velocities = zip(*points, strict=True)
    return Trajectory(np.array(times), np.array(positions), np.array(velocities))


def to_message(trajectory: Trajectory) -> dict[str, Any]:
    """The message as nested dictionaries, of which both writers make their file."""
    points = zip(trajectory.times, trajectory.positions, trajectory.velocities, strict=True)
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
        "joint_names": [f"joint_{j + 1}" for j in range(trajectory.positions.shape[1])],
        "points": [
            {
                "positions": position.tolist(),
                "velocities": velocity.tolist(),
                "accelerations": [],
                "effort": [],
                "time_from_start": _duration(float(time)),
            }
            for time, position, velocity in points
        ],
    }


def write_yaml(path: Path, trajectory: Trajectory) -> None:
    yaml = _optional("yaml")
    write_text(path, yaml.safe_dump(to_message(trajectory), sort_keys=False, default_flow_style=None, width=10**6))


def write_mcap(path: Path, trajectory: Trajectory) -> None:
    writer_module = _optional("mcap_ros2.writer")
    with atomic(path) as temporary, temporary.open("wb") as stream:
        writer = writer_module.Writer(stream)
        schema = writer.register_msgdef(SCHEMA, DEFINITION)
        writer.write_message(topic=TOPIC, schema=schema, message=to_message(trajectory), log_time=0, publish_time=0)
        writer.finish()


def _duration(seconds: float) -> dict[str, int]:
    nanoseconds = round(seconds * 1e9)
    return {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}


def _optional(module: str) -> Any:
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError:
        raise InputError("--format ros2 needs more packages: pip install -e '.[ros]'.") from None
