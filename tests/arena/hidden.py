"""What is hidden in the arena's robot for a diagnosis with a healthy campaign as reference, and what may be said of it.

An answer names effect and place; place None: the effect has none. The outside ones have no name: all that is asked is
that nothing is given as the explanation.
"""

from __future__ import annotations

from dataclasses import dataclass

Name = tuple[str, int | None]


@dataclass(frozen=True)
class Hidden:
    """A change (`[robot.changes.kind]`), the answers that name it, and whether the catalogue can name it at all."""

    kind: str
    values: dict[str, float | str]
    answers: tuple[Name, ...] = ()

    @property
    def outside(self) -> bool:
        """No effect of the catalogue is this."""
        return not self.answers

    @property
    def toml(self) -> str:
        """The protocol's section."""
        rows = [f"{k} = {v!r}".replace("'", '"') for k, v in self.values.items()]
        return "\n".join([f"[robot.changes.{self.kind}]", *rows]) + "\n"


HIDDEN: dict[str, Hidden] = {
    "seized-wheel": Hidden("seized_wheel", {"vertex": 4}, (("worn_wheel", 4),)),
    "slope": Hidden("slope", {"angle_deg": 2.0, "downhill_deg": 60.0}, (("slope", None),)),
    # carried by the wheels at both ends of the link and, links giving a little, by the next
    "payload": Hidden("payload", {"link": 7, "mass_kg": 0.4}, (("load", 7), ("load", 8))),
    "loose-joint": Hidden("loose_joint", {"joint": 5, "play_deg": 8.0}, (("backlash", 5),)),
    "wrong-zero": Hidden("wrong_zero", {"joint": 3, "angle_deg": 6.0}, (("zero_offset", 3),)),
    "slippery-patch": Hidden(
        "slippery_patch", {"x_m": 0.2, "y_m": 0.1, "radius_m": 0.25, "factor": 0.3}, (("friction_patch", None),)
    ),
    # less voltage is less gain and less torque: every servo is later, or slower
    "battery-sag": Hidden("battery_sag", {"voltage_V": 7.5}, (("servo_lag", None), ("speed_saturation", None))),
    "stuck-joint": Hidden("stuck_joint", {"joint": 6, "angle_deg": 10.0}, (("stuck_joint", 6),)),
    "short-stroke": Hidden("short_stroke", {"joint": 8, "factor": 0.6}, (("gain_loss", 8),)),
    "displaced-marker": Hidden("displaced_marker", {"vertex": 5, "along_m": 0.01}, (("marker_offset", 5),)),
    "lifted-wheel": Hidden("lifted_wheel", {"vertex": 6}, (("load", 6),)),
    # less grip sideways, the same resistance to rolling: less load and less anisotropy at once
    "smooth-tyre": Hidden("smooth_tyre", {"vertex": 0, "factor": 0.3}, (("load", 0), ("worn_wheel", 0))),
    "ratchet": Hidden("ratchet", {"torque": 0.003}, (("forward_backward_asymmetry", None),)),
    "sideways": Hidden("sideways", {"factor": 0.5}, (("left_right_asymmetry", None),)),
    # outside: one servo that is soft (lag and dead band at one joint), one wheel set askew, pulls
    "weak-servo": Hidden("weak_servo", {"joint": 4, "factor": 0.15}),
    "toe": Hidden("toe", {"vertex": 11, "angle_deg": 10.0}),
    "magnet": Hidden("magnet", {"x_m": 0.25, "y_m": 0.2, "force_N": 3.0, "reach_m": 0.3}),
    "tether": Hidden("tether", {}),
    "gust": Hidden("gust", {"force_y_N": 5.0}),
    "none": Hidden("none", {}),
}
