"""What can be hidden: names, places, how strengths are drawn, and what each does to the world. Laws: EFFECTS.md."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial

import numpy as np

from blind.cameras import Cameras
from blind.ground import SHAPES, WAYS, Dry, ExternalForce, Ground, Patch
from blind.motion import Drive, paths
from blind.schedule import Servos
from blind.snake import SNAKE10, Floats, Robot

ACTUATION, MEDIUM, OBSERVATION = "actuation", "medium", "observation"
Parameters = dict[str, float]
# Trial number, time (n,) [s], joint angles and what the servos read (n, m) [rad] -> angles and readings with the fault.
ServoFault = Callable[[int, Floats, Floats, Floats], tuple[Floats, Floats]]


@dataclass(frozen=True)
class Effect:
    """A hidden effect: name, place (joint 1 .. m, vertex 0 .. N - 1, or None), parameters in SI units."""

    name: str
    place: int | None = None
    parameters: Parameters = field(default_factory=dict)

    def as_dict(self) -> dict[str, object]:
        return asdict(self)


@dataclass(frozen=True)
class World:
    """Everything that decides what a campaign's data look like, apart from chance."""

    ground: Ground
    servos: Servos = Servos()
    cameras: Cameras = Cameras()
    gust: Callable[[int], ExternalForce] | None = None
    fault: ServoFault | None = None
    weather: Callable[[Ground, int], Ground] | None = None

    def paths(self, drives: Sequence[Drive], trials: Sequence[int] | None = None) -> list[Floats]:
        """Poses of each trial; gusts and weather need to know which trials they are (default 0, 1, ...)."""
        if self.gust is None and self.weather is None:
            return paths(self.ground, list(drives))
        numbers = trials if trials is not None else range(len(drives))
        return [paths(self._ground(i), [d])[0] for i, d in zip(numbers, drives, strict=True)]

    def _ground(self, trial: int) -> Ground:
        ground = self.ground if self.weather is None else self.weather(self.ground, trial)
        return ground if self.gust is None else replace(ground, external=(self.gust(trial),))


Draw = Callable[[np.random.Generator, int | None, Robot], Parameters]
Apply = Callable[[World, int, Parameters], World]


@dataclass(frozen=True)
class Kind:
    """One entry of the catalogue. where: GLOBAL, AT_JOINT or AT_VERTEX."""

    site: str
    where: str
    draw: Draw
    apply: Apply

    def places(self, robot: Robot = SNAKE10) -> tuple[int | None, ...]:
        """The possible ones, (None,) for a global effect."""
        if self.where == GLOBAL:
            return (None,)
        return tuple(range(1, robot.joints + 1) if self.where == AT_JOINT else range(robot.vertices))


GLOBAL, AT_JOINT, AT_VERTEX = "global", "joint", "vertex"


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _one(name: str, low: float, high: float) -> Draw:
    return lambda rng, place, robot: {name: _log(rng, low, high)}


def _either(name: str, low: float, high: float) -> Draw:
    return lambda rng, place, robot: {name: float(rng.choice([-1, 1])) * _log(rng, low, high)}


def _arrow(x: str, y: str, low: float, high: float) -> Draw:
    def draw(rng: np.random.Generator, place: int | None, robot: Robot) -> Parameters:
        size, angle = _log(rng, low, high), rng.uniform(0, 2 * np.pi)
        return {x: float(size * np.cos(angle)), y: float(size * np.sin(angle))}

    return draw


def _load(rng: np.random.Generator, place: int | None, robot: Robot) -> Parameters:
    lighter = rng.uniform() < 0.3
    carried = float(robot.weights[place or 0])
    return {"share": -carried * _log(rng, 0.1, 1.0) if lighter else _log(rng, 0.01, 0.4)}


def _rough(rng: np.random.Generator, place: int | None, robot: Robot) -> Parameters:
    return {"roughness": _log(rng, 0.2, 4.0) if rng.uniform() < 0.5 else -_log(rng, 0.2, 0.9)}


def _patch(rng: np.random.Generator, place: int | None, robot: Robot) -> Parameters:
    strength = _log(rng, 0.2, 4.0) if rng.uniform() < 0.5 else -_log(rng, 0.2, 0.9)
    x, y = rng.uniform(-0.35, 0.35, 2)
    return {"strength": strength, "x": float(x), "y": float(y), "radius": _log(rng, 0.12, 0.35)}


def _grip_patch(rng: np.random.Generator, place: int | None, robot: Robot) -> Parameters:
    strength, *where = _patch(rng, place, robot).values()
    return dict(zip(("change", "x", "y", "radius"), (strength, *where), strict=True))


def _tyre(rng: np.random.Generator, place: int | None, robot: Robot) -> Parameters:
    return {"change": _log(rng, 0.2, 4.0) if rng.uniform() < 0.3 else -_log(rng, 0.2, 0.95)}


def _swing(rng: np.random.Generator, place: int | None, robot: Robot) -> Parameters:
    return {"lag": _log(rng, 0.01, 0.15), "damping": float(rng.uniform(0.3, 1.2))}


def _exponent(rng: np.random.Generator, place: int | None, robot: Robot) -> Parameters:
    return {"exponent": float(np.exp(rng.choice([-1, 1]) * _log(rng, 0.03, 0.6)))}


def _change(part: str, **values: Callable[[int, Parameters], object]) -> Apply:
    """Change values of a part of the world; add to those that are kept by place."""

    def apply(world: World, place: int, p: Parameters) -> World:
        old = getattr(world, part)
        new = {k: f(place, p) for k, f in values.items()}
        merged = {k: {**getattr(old, k), **v} if isinstance(v, dict) else v for k, v in new.items()}
        return replace(world, **{part: replace(old, **merged)})

    return apply


def _gaps(world: World, place: int, p: Parameters) -> World:
    """A gap in one joint, or in all; gaps behind each other add up."""
    joints = range(1, world.ground.robot.joints + 1) if place < 0 else (place,)
    width = world.servos.width | {j: world.servos.width.get(j, 0.0) + p["width"] for j in joints}
    return replace(world, servos=replace(world.servos, width=width))


_ground, _servos, _cameras = (partial(_change, part) for part in ("ground", "servos", "cameras"))


CATALOGUE: dict[str, Kind] = {
    "servo_lag": Kind(ACTUATION, GLOBAL, _one("lag", 0.005, 0.15), _servos(lag=lambda k, p: p["lag"])),
    "servo_inertia": Kind(ACTUATION, GLOBAL, _swing, _servos(swing=lambda k, p: (p["lag"], p["damping"]))),
    "servo_delay": Kind(ACTUATION, GLOBAL, _one("delay", 0.01, 0.15), _servos(delay=lambda k, p: p["delay"])),
    "gain_loss": Kind(ACTUATION, AT_JOINT, _one("loss", 0.005, 0.6), _servos(loss=lambda k, p: {k: p["loss"]})),
    "zero_offset": Kind(
        ACTUATION, AT_JOINT, _either("offset", 0.002, 0.2), _servos(offset=lambda k, p: {k: p["offset"]})
    ),
    "stuck_joint": Kind(ACTUATION, AT_JOINT, _either("angle", 0.01, 0.35), _servos(stuck=lambda k, p: {k: p["angle"]})),
    "backlash": Kind(ACTUATION, AT_JOINT, _one("width", 0.003, 0.2), _gaps),
    "servo_play": Kind(ACTUATION, GLOBAL, _one("width", 0.003, 0.1), _gaps),
    "loose_joint": Kind(ACTUATION, AT_JOINT, _one("width", 0.003, 0.2), _servos(loose=lambda k, p: {k: p["width"]})),
    "speed_saturation": Kind(
        ACTUATION, GLOBAL, _one("max_speed", 0.4, 2.0), _servos(max_speed=lambda k, p: p["max_speed"])
    ),
    "lagging_joint": Kind(ACTUATION, AT_JOINT, _one("lag", 0.01, 0.4), _servos(lags=lambda k, p: {k: p["lag"]})),
    "slow_joint": Kind(
        ACTUATION, AT_JOINT, _one("max_speed", 0.2, 2.0), _servos(speeds=lambda k, p: {k: p["max_speed"]})
    ),
    "worn_wheel": Kind(MEDIUM, AT_VERTEX, _one("seizure", 0.15, 1.0), _ground(seizure=lambda k, p: {k: p["seizure"]})),
    "rough_skin": Kind(MEDIUM, AT_VERTEX, _rough, _ground(roughness=lambda k, p: {k: p["roughness"]})),
    "load": Kind(MEDIUM, AT_VERTEX, _load, _ground(share=lambda k, p: {k: p["share"]})),
    "tyre_grip": Kind(MEDIUM, AT_VERTEX, _tyre, _ground(tyres=lambda k, p: {k: p["change"]})),
    "dry_friction": Kind(
        MEDIUM, GLOBAL, _one("crossover_speed", 0.003, 0.5), _ground(crossover_speed=lambda k, p: p["crossover_speed"])
    ),
    "rolling_resistance": Kind(
        MEDIUM,
        GLOBAL,
        _one("crossover_speed", 0.003, 0.5),
        _ground(rolling_crossover=lambda k, p: p["crossover_speed"]),
    ),
    "grip_saturation": Kind(
        MEDIUM,
        GLOBAL,
        _one("saturation_speed", 0.02, 1.0),
        _ground(saturation_speed=lambda k, p: p["saturation_speed"]),
    ),
    "forward_backward_asymmetry": Kind(
        MEDIUM, GLOBAL, _either("asymmetry", 0.004, 0.6), _ground(forward_backward=lambda k, p: p["asymmetry"])
    ),
    "left_right_asymmetry": Kind(
        MEDIUM, GLOBAL, _either("asymmetry", 0.01, 0.5), _ground(left_right=lambda k, p: p["asymmetry"])
    ),
    "track_width": Kind(
        MEDIUM, GLOBAL, _one("half_track", 0.02, 0.2), _ground(half_track=lambda k, p: p["half_track"])
    ),
    "wheel_mount": Kind(MEDIUM, GLOBAL, _either("share", 0.1, 1.0), _ground(mount=lambda k, p: p["share"])),
    "toe": Kind(MEDIUM, GLOBAL, _either("angle", 0.004, 0.2), _ground(toe=lambda k, p: p["angle"])),
    "slope": Kind(
        MEDIUM, GLOBAL, _arrow("pull_x", "pull_y", 2e-4, 0.015), _ground(pull=lambda k, p: (p["pull_x"], p["pull_y"]))
    ),
    "friction_patch": Kind(MEDIUM, GLOBAL, _patch, _ground(patches=lambda k, p: (Patch(**p),))),
    "grip_patch": Kind(
        MEDIUM,
        GLOBAL,
        _grip_patch,
        _ground(grip_patches=lambda k, p: (Patch(p["change"], p["x"], p["y"], p["radius"]),)),
    ),
    "friction_gradient": Kind(
        MEDIUM,
        GLOBAL,
        _arrow("gradient_x", "gradient_y", 0.15, 2.5),
        _ground(gradient=lambda k, p: (p["gradient_x"], p["gradient_y"])),
    ),
    "anisotropy_drift": Kind(MEDIUM, GLOBAL, _either("rate", 0.003, 0.08), _ground(drift_rate=lambda k, p: p["rate"])),
    "power_law_drag": Kind(MEDIUM, GLOBAL, _exponent, _ground(exponent=lambda k, p: p["exponent"])),
    "inertia": Kind(
        MEDIUM, GLOBAL, _one("relaxation_time", 0.005, 1.0), _ground(inertia=lambda k, p: p["relaxation_time"])
    ),
    "added_mass": Kind(
        MEDIUM, GLOBAL, _one("relaxation_time", 0.02, 2.0), _ground(added_mass=lambda k, p: p["relaxation_time"])
    ),
    "contact_offset": Kind(
        MEDIUM, GLOBAL, _either("offset", 0.004, 0.035), _ground(contact_offset=lambda k, p: p["offset"])
    ),
    "marker_offset": Kind(
        OBSERVATION,
        AT_VERTEX,
        _arrow("along", "left", 0.3e-3, 15e-3),
        _cameras(moved_marker=lambda k, p: {k: (p["along"], p["left"])}),
    ),
    "marker_offset_ahead": Kind(
        OBSERVATION,
        AT_JOINT,  # whose number is that of its vertex
        _arrow("along", "left", 0.3e-3, 15e-3),
        _cameras(moved_ahead=lambda k, p: {k: (p["along"], p["left"])}),
    ),
    "marker_sway": Kind(
        OBSERVATION, AT_VERTEX, _either("sway", 0.5e-3, 15e-3), _cameras(swaying=lambda k, p: {k: p["sway"]})
    ),
    "length_scale": Kind(
        OBSERVATION, GLOBAL, _either("error", 0.001, 0.04), _cameras(scale_error=lambda k, p: p["error"])
    ),
    "camera_stretch": Kind(
        OBSERVATION,
        GLOBAL,
        _arrow("longer", "shear", 0.001, 0.03),
        _cameras(stretch=lambda k, p: (p["longer"], p["shear"])),
    ),
    "clock_offset": Kind(OBSERVATION, GLOBAL, _either("rate", 5e-4, 0.03), _cameras(clock_rate=lambda k, p: p["rate"])),
    "position_jumps": Kind(OBSERVATION, GLOBAL, _one("size", 1e-3, 40e-3), _cameras(jump=lambda k, p: p["size"])),
    "frame_drift": Kind(
        OBSERVATION,
        GLOBAL,
        _arrow("velocity_x", "velocity_y", 1e-4, 5e-3),
        _cameras(drift=lambda k, p: (p["velocity_x"], p["velocity_y"])),
    ),
}


def _dry(ways: str) -> Kind:
    """A floor of dry friction."""
    return Kind(
        MEDIUM,
        GLOBAL,
        lambda rng, place, robot: {"shape": float(rng.integers(len(SHAPES))), "speed": _log(rng, 0.003, 0.03)},
        _ground(dry=lambda k, p: Dry(ways, int(p["shape"]), p["speed"])),
    )


# What no effect of the catalogue is: whole laws of the floor.
FLOORS = {f"dry_{ways}": _dry(ways) for ways in WAYS}
KNOWN = CATALOGUE | FLOORS
# Of bodies without wheels: the robots of the studies have some, on which a worn one does the same.
WITHOUT_WHEELS = ("rough_skin",)
ON_WHEELS = tuple(n for n in CATALOGUE if n not in WITHOUT_WHEELS)
# Added when keys were in use, one time after the other: a campaign of an earlier key has one of these in few cases, and
# else what it had.
NEWER = (
    ("lagging_joint", "slow_joint", "marker_offset_ahead"),
    ("marker_sway",),
    ("servo_inertia",),
    ("servo_delay",),
    ("camera_stretch",),
    ("servo_play",),
    ("tyre_grip", "grip_patch"),
)
# Powers of a length that a parameter has: drawn for the ten-servo snake, they grow with the robot.
LENGTHS: dict[str, dict[str, int]] = {
    "dry_friction": {"crossover_speed": 1},
    "rolling_resistance": {"crossover_speed": 1},
    "grip_saturation": {"saturation_speed": 1},
    "track_width": {"half_track": 1},
    "slope": {"pull_x": 1, "pull_y": 1},
    "friction_patch": {"x": 1, "y": 1, "radius": 1},
    "grip_patch": {"x": 1, "y": 1, "radius": 1},
    "friction_gradient": {"gradient_x": -1, "gradient_y": -1},
    "contact_offset": {"offset": 1},
    "marker_offset": {"along": 1, "left": 1},
    "marker_offset_ahead": {"along": 1, "left": 1},
    "marker_sway": {"sway": 1},
    "position_jumps": {"size": 1},
    "frame_drift": {"velocity_x": 1, "velocity_y": 1},
}


def drawn(rng: np.random.Generator, name: str, place: int | None, robot: Robot = SNAKE10) -> Effect:
    """One effect at a place, its strength at random."""
    parameters = KNOWN[name].draw(rng, place, robot)
    powers = LENGTHS.get(name, {})
    return Effect(name, place, {p: v * robot.size ** powers.get(p, 0) for p, v in parameters.items()})


def draw(
    rng: np.random.Generator, count: int, robot: Robot = SNAKE10, among: Sequence[str] | None = None
) -> list[Effect]:
    """`count` effects with different names, uniform over those of wheels (or some), places uniform over the robot."""
    pool = sorted(among or ON_WHEELS)
    known = [n for n in pool if not any(n in added for added in NEWER)]
    names = list(rng.choice(known, size=count, replace=False))
    for added in NEWER:
        known = sorted([*known, *(n for n in pool if n in added)])
        today = rng.spawn(1)[0].choice(known, size=count, replace=False)  # does not move what rng draws next
        names = [t if t in added else e for t, e in zip(today, names, strict=True)]
    found = []
    for name in names:
        places = CATALOGUE[str(name)].places(robot)
        found.append(drawn(rng, str(name), places[int(rng.integers(len(places)))], robot))
    return found


def world(eps: float, effects: Sequence[Effect], robot: Robot = SNAKE10) -> World:
    """The world with these effects in it."""
    w = World(Ground(eps, robot))
    for e in effects:
        w = KNOWN[e.name].apply(w, e.place if e.place is not None else -1, e.parameters)
    return w
