"""The assembly as a MuJoCo model: links hinged by servos, each on its own wheels, on one soft floor.

Every link's frame stands at axle height on its tail-side joint (the tail link: on the tail marker), x towards the
head, z up. Joints: `servo_j` about the vertical, `bend_j` across (the connectors give a little under weight), and
`play_j` after a loose servo. Names: `wheel_k`, marker sites `marker_k`.
"""

from __future__ import annotations

import math
from typing import Any

from serpenoid.arena import mujoco_module
from serpenoid.arena.assembly import Assembly
from serpenoid.arena.chain import Chain
from serpenoid.arena.robot import Robot

MARKER_HEIGHT = 0.034  # above the axles: on top of the servos
SIDES = (1, -1)  # left, right

HEADER = """<mujoco model="arena">
<compiler angle="radian" autolimits="true" inertiafromgeom="true"/>
<option timestep="{timestep}" integrator="implicitfast" cone="elliptic" solver="Newton" jacobian="sparse"
  iterations="30" ls_iterations="30" tolerance="1e-6" impratio="5" gravity="0 0 -9.81"/>
<size memory="4M"/>
<default><geom contype="0" conaffinity="0"/></default>
<worldbody>
<geom name="floor" type="plane" size="5 5 0.1" contype="1" conaffinity="2" condim="3" solref="{soft} 1"/>
"""


def compile_scene(assembly: Assembly) -> Any:
    """The compiled `MjModel`."""
    return mujoco_module().MjModel.from_xml_string(scene_xml(assembly))


def scene_xml(assembly: Assembly) -> str:
    robot = assembly.robot
    header = HEADER.format(timestep=robot.timestep_s, soft=robot.contact_time_s)
    links = "".join(_link(assembly, number) for number in range(robot.servos + 1))
    bodies = links + "</body>" * (robot.servos + 1 + _loose(assembly))
    servos = "".join(_servo(assembly, joint) for joint in range(robot.servos))
    return f"{header}{bodies}</worldbody><actuator>{servos}</actuator></mujoco>"


def _loose(assembly: Assembly) -> int:
    return int((assembly.backlash > 0).sum())


def _link(assembly: Assembly, number: int) -> str:
    """One link, its body left open so that the next one hangs in it."""
    robot = assembly.robot
    return "".join(
        [
            _tail(robot) if number == 0 else _hinge(assembly, number - 1),
            _masses(assembly, number),
            *(_wheel(assembly, wheel) for wheel in range(robot.wheels) if robot.links.before(wheel) == number),
            *(_marker(assembly, vertex) for vertex in range(robot.wheels) if robot.links.after(vertex) == number),
        ]
    )


def _tail(robot: Robot) -> str:
    return f'<body name="link_0" pos="0 0 {robot.wheel_diameter_m / 2}"><freejoint name="root"/>'


def _hinge(assembly: Assembly, joint: int) -> str:
    """Servo joint number `joint` (0 next to the tail), the link's bending, and its play if it is loose."""
    robot = assembly.robot
    reach = robot.links.length_m(joint)
    play = assembly.backlash[joint]
    zero = f'<body name="link_{joint + 1}" pos="{reach} 0 0" euler="0 0 {assembly.zero[joint]}">'
    servo = (
        f'<joint name="servo_{joint}" axis="0 0 1" damping="{robot.servo_damping}" '
        f'frictionloss="{robot.gear_friction}" armature="{robot.rotor_inertia}"/>'
    )
    damping = 0.02 * robot.bend_stiffness
    bend = f'<joint name="bend_{joint}" axis="0 1 0" stiffness="{robot.bend_stiffness}" damping="{damping}"/>'
    if play == 0:
        return zero + servo + bend
    horn = zero.replace(f"link_{joint + 1}", f"horn_{joint}") + servo + _box(0.002, 0.01, 0.01, 0.01, 0.0)
    loose = f'<joint name="play_{joint}" axis="0 0 1" range="{-play / 2} {play / 2}" damping="0.003" armature="1e-4"/>'
    return f'{horn}<body name="link_{joint + 1}">{loose}{bend}'


def _masses(assembly: Assembly, number: int) -> str:
    robot = assembly.robot
    parts = _paper_parts(robot, number) if robot.chain is None else _parts(robot, robot.chain, number)
    if assembly.payload[number] > 0:
        middle = robot.spacing_m / 2 if robot.chain is None else robot.chain.length_m(number) / 2
        middle = 0.0 if robot.chain is None and number == 0 else middle
        parts.append(_box(float(assembly.payload[number]), 0.02, 0.02, 0.01, middle, 0.04))
    return "".join(parts)


def _parts(robot: Robot, chain: Chain, number: int) -> list[str]:
    """What each vertex carries beside its wheels, as one box where the vertex is: servos behind their joints."""
    s, parts = robot.size, []
    for vertex, mass in enumerate(chain.masses_kg):
        if chain.before(vertex) == number:
            behind = 0.012 * s if vertex in chain.joints else 0.0
            rest = mass - robot.wheel_pair_mass_kg
            place = chain.place_m(vertex, number) - behind
            parts.append(_box(rest, 0.0233 * s, 0.0143 * s, 0.017 * s, place, 0.015 * s))
    return parts


def _paper_parts(robot: Robot, number: int) -> list[str]:
    """Connector, then a servo behind the link's head-side joint, batteries and board in the end links."""
    spacing, last = robot.spacing_m, robot.servos
    middle = 0.0 if number == 0 else spacing / 2
    end = spacing / 2 if number == 0 else spacing
    parts = [_box(robot.connector_mass_kg, 0.02, 0.015, 0.01, middle)]
    if number < last:
        parts.append(_box(robot.servo_mass_kg, 0.0233, 0.0143, 0.017, end - 0.012, 0.015))
    if number in (0, last):
        parts.append(_box(robot.battery_mass_kg, 0.035, 0.0175, 0.015, middle, 0.01))
    if number == 0:  # the tail link holds two wheel sets and so two connectors
        parts.append(_box(robot.connector_mass_kg, 0.01, 0.015, 0.01, end - robot.wheel_offset_m))
    if number == last and robot.board_mass_kg > 0:
        parts.append(_box(robot.board_mass_kg, 0.025, 0.0175, 0.008, middle, 0.03))
    return parts


def _box(mass: float, half_x: float, half_y: float, half_z: float, x: float, z: float = 0.0) -> str:
    return f'<geom type="box" size="{half_x} {half_y} {half_z}" pos="{x} 0 {z}" mass="{mass}"/>'


def _wheel(assembly: Assembly, wheel: int) -> str:
    """A wheel pair: one body on a common axle, or one body per wheel. The tyre touches the floor in one point."""
    robot = assembly.robot
    if robot.axle == "common":
        tyres = "".join(_tyre(assembly, wheel, side, robot.track_m / 2 * side) for side in SIDES)
        return (
            _axle(assembly, wheel, f"wheel_{wheel}", 0.0, robot.wheel_pair_mass_kg, robot.track_m / 2)
            + tyres
            + "</body>"
        )
    return "".join(
        _axle(assembly, wheel, f"wheel_{wheel}{'lr'[n]}", robot.track_m / 2 * side, robot.wheel_pair_mass_kg / 2, 0.006)
        + _tyre(assembly, wheel, side, 0.0)
        + "</body>"
        for n, side in enumerate(SIDES)
    )


def _axle(assembly: Assembly, wheel: int, name: str, across: float, mass: float, half_width: float) -> str:
    robot = assembly.robot
    radius, toe = robot.wheel_diameter_m / 2, float(assembly.toe[wheel])
    x, y = _wheel_place(robot, wheel) - across * math.sin(toe), across * math.cos(toe)
    spin = 0.6 * mass * radius**2  # most of a wheel's mass is its tyre
    tilt = max(mass * (half_width**2 + radius**2 / 4), 0.51 * spin)
    return (
        f'<body name="{name}" pos="{x} {y} {assembly.lift[wheel]}" euler="0 0 {toe}">'
        f'<joint name="{name}" axis="0 1 0" damping="1e-5" frictionloss="0" solimpfriction="0.999 0.999 0.001"/>'
        f'<inertial pos="0 0 0" mass="{mass}" diaginertia="{tilt} {spin} {tilt}"/>'
    )


def _tyre(assembly: Assembly, wheel: int, side: int, across: float) -> str:
    radius = assembly.robot.wheel_diameter_m / 2
    grip = assembly.robot.grip * assembly.grip[wheel, SIDES.index(side)]
    return (
        f'<geom name="tyre_{wheel}{"lr"[SIDES.index(side)]}" type="sphere" size="{radius}" pos="0 {across} 0" '
        f'contype="2" conaffinity="1" priority="1" condim="3" friction="{grip} 0 0" mass="0" '
        f'solref="{assembly.robot.contact_time_s} 1"/>'
    )


def _wheel_place(robot: Robot, wheel: int) -> float:
    """x of the axle in its link's frame: behind a joint, under any other vertex."""
    chain = robot.links
    place = chain.place_m(wheel, chain.before(wheel))
    return place - robot.wheel_offset_m if wheel in chain.joints else place


def _marker(assembly: Assembly, vertex: int) -> str:
    robot = assembly.robot
    x = robot.links.place_m(vertex, robot.links.after(vertex))
    along, across = assembly.marker[vertex]
    return f'<site name="marker_{vertex}" pos="{x + along} {across} {MARKER_HEIGHT * robot.size}"/>'


def _servo(assembly: Assembly, joint: int) -> str:
    """A DC motor under proportional control; back EMF is the joint's damping, full voltage the torque limit."""
    robot = assembly.robot
    share = assembly.voltage_V / 11.1
    stiffness = robot.servo_stiffness * assembly.gain[joint] * share
    limit = robot.stall_torque * assembly.torque[joint] * share
    return (
        f'<general name="servo_{joint}" joint="servo_{joint}" gainprm="{stiffness}" biastype="affine" '
        f'biasprm="0 {-stiffness} 0" forcerange="{-limit} {limit}"/>'
    )
