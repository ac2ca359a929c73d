"""What is hidden in the arena's robot for a diagnosis with a healthy campaign as reference, and what may be said of it.

An answer names effect and place; place None: the effect has none. Those outside the catalogue have no name: all that is
asked is that none is given.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from serpenoid.effects.catalogue import find

STRENGTH = 3.0  # what a change must be of what repeats differ by, for a name to be required
Name = tuple[str, int | None]


@dataclass(frozen=True)
class Hidden:
    """Changes (`[robot.changes.NAME]` with keys), the answers that name them, whether the catalogue can at all."""

    changes: dict[str, dict[str, float]] = field(default_factory=dict)
    answers: tuple[Name, ...] = ()
    outside: bool = False

    @property
    def toml(self) -> str:
        """The protocol's sections."""
        parts = []
        for name, values in self.changes.items():
            parts += [f"[robot.changes.{name}]", *(f"{key} = {value!r}" for key, value in values.items())]
        return "\n".join(parts) + "\n"


def _one(name: str, *answers: Name, **values: float) -> Hidden:
    return Hidden({name: values}, answers, outside=not answers)


HIDDEN: dict[str, Hidden] = {
    "nothing": Hidden(),
    "seized-wheel": _one("seized_wheel", ("worn_wheel", 11), vertex=11),
    "seized-wheel-in-the-middle": _one("seized_wheel", ("worn_wheel", 4), vertex=4),
    # its neighbour carries the load: 26 % of the weight in place of 10 % (the arena's own wheel loads)
    "lifted-wheel": _one("lifted_wheel", ("load", 11), ("load", 10), vertex=11),
    # less grip sideways, the same resistance to rolling: less load and less anisotropy at once
    "smooth-tyre": _one("smooth_tyre", ("tyre_grip", 11), ("load", 11), ("worn_wheel", 11), vertex=11, factor=0.2),
    # carried by the wheels at both ends of the link and, as links give a little, by the next
    "payload": _one("payload", ("load", 7), ("load", 8), link=7, mass_kg=0.4),
    "slope": _one("slope", ("slope", None), angle_deg=2.0, downhill_deg=60.0),
    "slippery-patch": _one(
        "slippery_patch", ("grip_patch", None), ("friction_patch", None), x_m=0.1, y_m=-0.1, radius_m=0.35, factor=0.4
    ),
    "ratchet": _one("ratchet", ("forward_backward_asymmetry", None), torque=0.004),
    "sideways": _one("sideways", ("left_right_asymmetry", None), factor=0.5),
    "loose-joint": _one("loose_joint", ("loose_joint", 5), joint=5, play_deg=8.0),
    "wrong-zero": _one("wrong_zero", ("zero_offset", 3), joint=3, angle_deg=6.0),
    "short-stroke": _one("short_stroke", ("gain_loss", 8), joint=8, factor=0.6),
    "stuck-joint": _one("stuck_joint", ("stuck_joint", 6), joint=6, angle_deg=10.0),
    # less voltage is less gain and less torque: every servo is later, or slower
    "battery-sag": _one("battery_sag", ("servo_lag", None), ("speed_saturation", None), voltage_V=6.5),
    # its site is on the link ahead of the joint
    "displaced-marker": _one("displaced_marker", ("marker_offset_ahead", 5), vertex=5, along_m=0.01),
    # the same of one servo: back EMF over a softer gain is a longer lag, whatever the load
    "weak-servo": _one("weak_servo", ("lagging_joint", 4), ("slow_joint", 4), joint=4, factor=0.15),
    # outside: one wheel set askew, pulls
    "toe": _one("toe", vertex=11, angle_deg=10.0),
    "magnet": _one("magnet", link=10, x_m=0.25, y_m=0.2, force_N=3.0, reach_m=0.3),
    "tether": _one("tether", link=0, x_m=-0.5, y_m=0.0, stiffness=5.0, length_m=0.4),
    "gust": _one("gust", link=5, force_x_N=0.0, force_y_N=5.0, begin_s=4.0, duration_s=1.0),
}


def by_cause(rows: Sequence[Mapping[str, Any]]) -> dict[str, list[Mapping[str, Any]]]:
    """Judged rows of a table by what is hidden there."""
    return {
        "nothing": [r for r in rows if not r["hidden"]],
        "in the catalogue": [r for r in rows if r.get("answers")],
        "outside": [r for r in rows if r["hidden"] and not r.get("answers")],
    }


def required(rows: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Judged rows that an answer is required of: what hides nothing or what no name says, and of changes in the
    catalogue those of servos and markers, which are many noise levels there, and those of the floor that move paths by
    STRENGTH times what repeats differ by. Where those are not known, neither is the strength."""
    return [r for r in rows if not r.get("answers") or not _of_the_floor(r) or strength(r) >= STRENGTH]


def _of_the_floor(row: Mapping[str, Any]) -> bool:
    return all(find(name).site == "medium" for name, _ in row["answers"])


def strength(row: Mapping[str, Any]) -> float:
    """How far a change moves paths, over what repeats differ by; 0 where a table does not say."""
    return float(row["path_change_m"] / row["path_repeats_m"]) if "path_change_m" in row else 0.0
