"""One robot on its floor, moving: goals in, markers and servo readings out; the clock advances by the time step."""

from __future__ import annotations

import math

import numpy as np

from serpenoid.arena import mujoco_module
from serpenoid.arena.assembly import Assembly
from serpenoid.arena.floor import Mats, force, patch_factor
from serpenoid.arena.robot import GRAVITY, TICK
from serpenoid.arena.scene import compile_scene
from serpenoid.body import Floats
from serpenoid.errors import InputError

REFRESH_S = 1 / 120  # how often grip and rolling resistance follow place and load
LOAD_MEMORY_S = 0.05  # foam creeps: rolling resistance follows the load this late
SLIP_SPEED = 1e-3  # m/s, over which a direction of slip or roll counts as such
SETTLE_S = 0.5


class World:
    """The running simulation. Angles are servo angles [rad] unless called true; vertex 0 is the tail."""

    def __init__(self, assembly: Assembly, mats: Mats | None = None) -> None:
        self.assembly = assembly
        self.robot = assembly.robot
        self.mats = mats or Mats.even()
        self._mujoco = mujoco_module()
        self.model = compile_scene(assembly)
        self.data = self._mujoco.MjData(self.model)
        self._find_places()
        self.goal = np.zeros(self.robot.servos)
        self._start, self._target, self._since = np.zeros(self.robot.servos), np.zeros(self.robot.servos), 0.0
        self._tilt_floor()

    @property
    def time_s(self) -> float:
        return float(self.data.time)

    def place(self, angles: Floats, x_m: float = 0.0, y_m: float = 0.0, heading_rad: float = 0.0) -> None:
        """Set the robot down: marker centroid at (x, y), chord from tail to head at `heading`; let it settle."""
        self._mujoco.mj_resetData(self.model, self.data)
        self.command(angles)
        self._start, self.goal = self._target.copy(), self._target.copy()
        self.data.qpos[self._servo_q] = self.goal
        self._turn_root(x_m, y_m, heading_rad)
        self._loads = np.full(2 * self.robot.wheels, self.robot.mass_kg * GRAVITY / (2 * self.robot.wheels))
        self._places = self.data.geom_xpos[self._tyres].copy()
        self._refresh(0.0)
        for _ in range(round(SETTLE_S / self.robot.timestep_s)):
            self.step()
        self.data.time = 0.0
        self._since = -math.inf

    def command(self, angles: Floats) -> None:
        """Send goals, shape (m,) [rad]; they are rounded to ticks, as on the bus."""
        goals = np.round(self.assembly.scale * np.asarray(angles) / TICK) * TICK
        stuck = self.assembly.stuck
        self._start = self.goal.copy()
        self._target = np.where(np.isnan(stuck), goals, stuck)
        self._since = self.time_s

    def step(self) -> None:
        """Advance by one time step."""
        self._profile()
        self.data.ctrl[:] = self.goal
        if self.assembly.pulls:
            self._pull()
        self._mujoco.mj_step(self.model, self.data)
        if self.time_s >= self._next_refresh:
            self._refresh(REFRESH_S)
            self._check()

    def markers(self) -> Floats:
        """Marker positions, shape (N, 3) [m], z up."""
        return self.data.site_xpos.copy()

    def angles(self) -> Floats:
        """What the servos read, shape (m,) [rad], in whole ticks."""
        return np.round(self.data.qpos[self._servo_q] / TICK) * TICK

    def speeds(self) -> Floats:
        """Of the servos' shafts, shape (m,) [rad/s]."""
        return self.data.qvel[self._servo_v].copy()

    def duty(self) -> Floats:
        """Share of the supply voltage the servos apply, shape (m,), -1..1: what they call load."""
        return self.data.actuator_force / self.model.actuator_forcerange[:, 1] * self.assembly.torque

    def voltage(self) -> float:
        """At the servos' terminals [V], under the present current."""
        source = self.source_voltage()
        current = self.power() / source
        return source - self.robot.battery_resistance * current

    def source_voltage(self) -> float:
        return max(6.0, self.assembly.voltage_V - self.assembly.voltage_drop * self.time_s)

    def power(self) -> float:
        """Drawn from the battery [W]: motors (copper loss and torque times speed; no recovery), standby, board."""
        robot = self.robot
        volts = self.data.actuator_force * robot.resistance / robot.torque_constant
        amperes = (volts - robot.back_emf_constant * self.data.qvel[self._servo_v]) / robot.resistance
        motors = float(np.maximum(0.0, volts * amperes).sum())
        return motors + robot.servos * robot.standby_current_A * self.source_voltage() + robot.controller_power_W

    def wheel_loads(self) -> Floats:
        """Normal force under each wheel pair, shape (N,) [N], smoothed as the foam does."""
        return self._loads.reshape(self.robot.wheels, 2).sum(axis=1)

    def _find_places(self) -> None:
        model = self.model
        servos = [model.joint(f"servo_{j}") for j in range(self.robot.servos)]
        self._servo_q = np.array([joint.qposadr[0] for joint in servos])
        self._servo_v = np.array([joint.dofadr[0] for joint in servos])
        self._tyres = np.array([model.geom(f"tyre_{k}{side}").id for k in range(self.robot.wheels) for side in "lr"])
        axles = model.body_jntadr[model.geom_bodyid[self._tyres]]
        self._axle_v = model.jnt_dofadr[axles]  # of each tyre; the two tyres of a common axle name the same one
        self._links = np.array([model.body(f"link_{number}").id for number in range(self.robot.servos + 1)])
        self._tyre_of = np.full(model.ngeom, -1)
        self._tyre_of[self._tyres] = np.arange(2 * self.robot.wheels)
        self._grip = model.geom_friction[self._tyres, 0].copy()
        self._places = np.zeros((2 * self.robot.wheels, 3))
        self._loads = np.zeros(2 * self.robot.wheels)
        self._next_refresh = 0.0

    def _check(self) -> None:
        """MuJoCo restarts the clock after a number that is not finite; nothing after that is a measurement."""
        if self.data.warning.number.any():
            raise InputError(
                f"the arena's simulation lost its balance at {self.time_s:.2f} s. "
                f"`timestep_s` is {self.robot.timestep_s:.5f}: halve it, or take back an extreme `[robot]` value."
            )

    def _tilt_floor(self) -> None:
        slope, downhill = self.assembly.slope_rad, self.assembly.downhill_rad
        pull = math.sin(slope)
        self.model.opt.gravity[:] = -GRAVITY * np.array(
            [-pull * math.cos(downhill), -pull * math.sin(downhill), math.cos(slope)]
        )

    def _turn_root(self, x_m: float, y_m: float, heading_rad: float) -> None:
        """Pose the tail link so that markers' centroid and chord come to lie as asked."""
        self._mujoco.mj_kinematics(self.model, self.data)
        chord = self.data.site_xpos[-1] - self.data.site_xpos[0]
        turn = heading_rad - math.atan2(chord[1], chord[0])
        self.data.qpos[3:7] = [math.cos(turn / 2), 0, 0, math.sin(turn / 2)]
        self._mujoco.mj_kinematics(self.model, self.data)
        self.data.qpos[:2] += np.array([x_m, y_m]) - self.data.site_xpos[:, :2].mean(axis=0)
        self._mujoco.mj_forward(self.model, self.data)

    def _profile(self) -> None:
        duration = self.robot.profile_s
        share = 1.0 if not duration else min(1.0, (self.time_s - self._since) / duration)
        self.goal = self._start + share * (self._target - self._start)

    def _pull(self) -> None:
        self.data.xfrc_applied[:] = 0.0
        for pull in self.assembly.pulls:
            body = self._links[pull.link]
            self.data.xfrc_applied[body, :2] += force(pull, self.data.xipos[body, :2], self.time_s)

    def _refresh(self, interval: float) -> None:
        """Let grip follow the place, rolling resistance the load, and the servos the voltage."""
        self._next_refresh = self.time_s + REFRESH_S - 1e-9
        places = self.data.geom_xpos[self._tyres]
        self._follow_load(interval)
        grip = self._grip * self.mats.factor(places[:, :2]) * patch_factor(self.assembly, places[:, :2])
        if interval > 0 and (self.assembly.grip_against != 1).any():
            grip = grip * self._against((places - self._places) / interval)
        self.model.geom_friction[self._tyres, 0] = grip
        self._places = places.copy()
        if self.assembly.voltage_drop:
            self._follow_voltage()

    def _follow_load(self, interval: float) -> None:
        contact = self.data.contact
        normal = np.zeros(2 * self.robot.wheels)
        if interval > 0 and self.data.ncon:
            tyre = self._tyre_of[contact.geom].max(axis=1)
            normal[tyre] = self.data.efc_force[contact.efc_address]
            self._loads += (normal - self._loads) * min(1.0, interval / LOAD_MEMORY_S)
        radius = self.robot.wheel_diameter_m / 2
        resistance = self.robot.rolling_resistance * radius * self._loads
        own = self.data.qvel[self._axle_v] * radius
        back = np.repeat(self.assembly.backward, 2) / 2 * 0.5 * (1 - np.tanh(own / SLIP_SPEED))
        torque = np.zeros(self.model.nv)
        np.add.at(torque, self._axle_v, resistance + back + np.repeat(self.assembly.bearing, 2) / 2)
        self.model.dof_frictionloss[self._axle_v] = torque[self._axle_v]
        drag = np.zeros(self.model.nv)
        np.add.at(drag, self._axle_v, self.robot.rolling_damping * radius**2 * self._loads)
        self.model.dof_damping[self._axle_v] = drag[self._axle_v]

    def _against(self, velocity: Floats) -> Floats:
        """Factor on the grip by the side a wheel slips to; `velocity`: (2 N, 3) of the wheels' centres."""
        leftward = self.data.geom_xmat[self._tyres].reshape(-1, 3, 3)[:, :, 1]
        slip = (velocity * leftward).sum(axis=1)
        left, right = self.assembly.grip_against
        share = 0.5 * (1 + np.tanh(slip / SLIP_SPEED))
        return right + (left - right) * share

    def _follow_voltage(self) -> None:
        share = self.source_voltage() / 11.1
        stiffness = self.robot.servo_stiffness * self.assembly.gain * share
        limit = self.robot.stall_torque * self.assembly.torque * share
        self.model.actuator_gainprm[:, 0] = stiffness
        self.model.actuator_biasprm[:, 1] = -stiffness
        self.model.actuator_forcerange[:] = np.column_stack([-limit, limit])
