"""Robots and protocols drawn at random, played in the arena with a hidden change, and diagnosed beside the healthy one.

    python -m arena.any_robot --key KEY --out results/blind/KEY --work FOLDER [COUNT]

The arena's contact law, motors and sagging links are no law of the package, and here neither the robot nor the protocol
is one that anything was developed on: joints, links, masses, grip, bearings, gaits, cameras and logs follow from the
key. Of each robot a healthy campaign, the same healthy robot again, and two changes. One row of any-robot.csv a
campaign, a summary in README.md; a row that is there is not made again.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from arena.hidden import STRENGTH, Hidden, by_cause, required
from arena.study import KEPT, diagnosed, judged, moved_by
from blind import table
from blind.protocol import Protocol
from blind.random_protocols import draw_protocol
from blind.study import commit
from serpenoid.arena.campaign import run_campaign
from serpenoid.arena.protocol import load_protocol
from serpenoid.arena.robot import Robot, robot_of, too_weak
from serpenoid.body import Body
from serpenoid.diagnose.reference import reference_of
from serpenoid.errors import InputError
from serpenoid.files.writing import write_text
from serpenoid.table_file import write_table

TABLE = "any-robot.csv"
JOINTS, LENGTH_M = (4, 14), (0.5, 1.5)  # of those drawn; smaller ones weigh less than their servos' gears are stiff
FASTEST, MOST_FRAMES = 0.6, 240.0  # of the servos' free speed; the arena's cameras
SLOWEST_LOG = 10.0
CHANGES = 2


@dataclass(frozen=True)
class Drawn:
    """A robot and its protocol: draws, and the numbers of `[robot]` and `[floor]` that differ from the arena's own."""

    protocol: Protocol
    robot: dict[str, float | str]
    seed: int

    @property
    def size(self) -> float:
        """Mean edge over the paper's spacing, which scales wheels."""
        return float(self.protocol.robot.edges.mean()) / (0.92 / 11)

    @property
    def built(self) -> Robot:
        """As the arena builds it."""
        own = self.protocol.robot
        body = Body(
            vertices=own.vertices, edge_lengths=tuple(map(float, own.edges)), weights=tuple(map(float, own.masses)),
            mass_kg=own.mass_kg,
        )  # fmt: skip
        return Robot.model_validate(robot_of(body, self.robot))

    @property
    def wheel_load_N(self) -> float:
        return 9.81 * self.protocol.robot.mass_kg / self.protocol.robot.vertices


def draw(key: str, number: int) -> Drawn:
    """The robot of a number: the first of its draws whose gaits the arena's servos are fast and strong enough for."""
    for attempt in range(1000):
        seed = int(hashlib.sha256(f"{key}:{number}:{attempt}".encode()).hexdigest()[:8], 16)
        found = draw_protocol(seed)
        robot = found.robot
        fast = max(_speed(s.plan.table, s.plan.cycle_s) for s in found.settings) > FASTEST * robot.speed_limit
        fits = JOINTS[0] <= robot.joints <= JOINTS[1] and LENGTH_M[0] <= robot.length <= LENGTH_M[1]
        if fits and not fast and found.plays * len(found.settings) >= 3:
            drawn = Drawn(found, _parts(np.random.default_rng([seed, 20])), seed)
            if not too_weak(drawn.built):
                return drawn
    raise ArithmeticError(f"{key}: no robot in 1000 draws")


def _speed(rows: np.ndarray, cycle_s: float) -> float:
    return float(np.abs(np.diff(rows, axis=0, append=rows[:1])).max() * len(rows) / cycle_s)


def _parts(rng: np.random.Generator) -> dict[str, float | str]:
    """Tyres, bearings and axles of another workshop."""
    return {
        "grip": float(rng.uniform(0.35, 0.9)),
        "rolling_resistance": float(np.exp(rng.uniform(*np.log((0.02, 0.1))))),
        "rolling_damping": float(rng.uniform(0.2, 1.5)),
        "axle": str(rng.choice(["common", "independent"])),
    }


def write_robot(drawn: Drawn, folder: Path) -> None:
    """robot.toml, which is also the model, and a joint table for each gait."""
    p, robot = drawn.protocol, drawn.protocol.robot
    write_text(
        folder / "robot.toml",
        f"[body]\nvertices = {robot.vertices}\nedge_lengths = {[round(float(e), 4) for e in robot.edges]}\n"
        f"weights = {[float(w) for w in robot.masses]}\nmass_kg = {robot.mass_kg:.4f}\n\n"
        '[medium]\nanisotropy_ratio = 0.2\ndissipation = "vertex"\n',
    )
    for setting in p.settings:
        write_table(folder / f"{setting.label}.csv", setting.plan.table)


def protocol_text(drawn: Drawn, name: str, seed: int, hidden: Hidden) -> str:
    """The arena's protocol file, `robot.toml` and the tables beside its folder."""
    p, tools, plan = drawn.protocol, drawn.protocol.instruments, drawn.protocol.settings[0].plan
    head = [
        f'format = 1\nname = "{name}"\nseed = {seed}\nproblem = "../robot.toml"',
        f"trials = {p.plays}\ncycles = {plan.cycles}\npause_s = {plan.pause_s}",
        f"[floor]\nseed = {drawn.seed % 1000}",
        f"[cameras]\nframes_per_second = {min(tools.frames_per_second, MOST_FRAMES)}\nnoise_m = {tools.marker_noise}",
        f"[logs]\nservo_hz = {max(tools.log_hertz, SLOWEST_LOG)}",
        "[robot]",
        *(f'{k} = "{v}"' if isinstance(v, str) else f"{k} = {v!r}" for k, v in drawn.robot.items()),
    ]
    gaits = [
        f'[[gait]]\nname = "{s.label}"\njoint_table = "../{s.label}.csv"\ncycle_durations_s = [{s.plan.cycle_s}]\n'
        f"headings_deg = [{np.rad2deg(s.heading):.1f}]"
        for s in p.settings
    ]
    top, rest = head[:2], head[2:]
    return "\n".join([*top, *gaits, *rest, hidden.toml])


def changes(drawn: Drawn) -> dict[str, Callable[[np.random.Generator], Hidden]]:
    """What may be hidden, in sizes of this robot; see `arena.hidden` for what may be said of it."""
    robot, size = drawn.protocol.robot, drawn.size
    last, length = robot.vertices - 1, robot.length

    def one(name: str, *answers: tuple[str, int | None], **values: float) -> Hidden:
        return Hidden({name: values}, answers, outside=not answers)

    def vertex(rng: np.random.Generator) -> int:
        return int(rng.integers(robot.vertices))

    def joint(rng: np.random.Generator) -> int:
        return int(rng.integers(1, robot.joints + 1))

    def sign(rng: np.random.Generator) -> float:
        return float(rng.choice([-1.0, 1.0]))

    def seized(rng: np.random.Generator) -> Hidden:
        v = vertex(rng)
        return one("seized_wheel", ("worn_wheel", v), vertex=v)

    def smooth(rng: np.random.Generator) -> Hidden:
        v = vertex(rng)
        return one(
            "smooth_tyre",
            ("tyre_grip", v),
            ("load", v),
            ("worn_wheel", v),
            vertex=v,
            factor=float(rng.uniform(0.1, 0.4)),
        )

    def payload(rng: np.random.Generator) -> Hidden:
        link, mass = int(rng.integers(robot.joints + 1)), float(rng.uniform(0.1, 0.4)) * robot.mass_kg
        return one("payload", ("load", link), ("load", link + 1), link=link, mass_kg=mass)

    def slope(rng: np.random.Generator) -> Hidden:
        angle, way = float(rng.uniform(1.0, 3.0)), float(rng.uniform(0, 360))
        return one("slope", ("slope", None), angle_deg=angle, downhill_deg=way)

    def patch(rng: np.random.Generator) -> Hidden:
        x, y, radius = *(0.15 * length * rng.normal(size=2)), float(rng.uniform(0.3, 0.5)) * length
        factor = float(rng.uniform(0.2, 0.5))
        return one(
            "slippery_patch",
            ("grip_patch", None),
            ("friction_patch", None),
            x_m=float(x),
            y_m=float(y),
            radius_m=radius,
            factor=factor,
        )

    def ratchet(rng: np.random.Generator) -> Hidden:
        torque = float(rng.uniform(0.06, 0.15)) * drawn.wheel_load_N * 0.028 * size
        return one("ratchet", ("forward_backward_asymmetry", None), torque=torque)

    def sideways(rng: np.random.Generator) -> Hidden:
        return one("sideways", ("left_right_asymmetry", None), factor=float(rng.uniform(0.3, 0.7)))

    def loose(rng: np.random.Generator) -> Hidden:
        j = joint(rng)
        return one("loose_joint", ("loose_joint", j), joint=j, play_deg=float(rng.uniform(4, 10)))

    def zero(rng: np.random.Generator) -> Hidden:
        j = joint(rng)
        return one("wrong_zero", ("zero_offset", j), joint=j, angle_deg=sign(rng) * float(rng.uniform(2, 8)))

    def stroke(rng: np.random.Generator) -> Hidden:
        j = joint(rng)
        return one("short_stroke", ("gain_loss", j), joint=j, factor=float(rng.uniform(0.4, 0.85)))

    def stuck(rng: np.random.Generator) -> Hidden:
        j = joint(rng)
        return one("stuck_joint", ("stuck_joint", j), joint=j, angle_deg=sign(rng) * float(rng.uniform(0, 20)))

    def marker(rng: np.random.Generator) -> Hidden:
        v = int(rng.integers(1, last))
        along = sign(rng) * float(rng.uniform(0.005, 0.015)) * size
        # its site is on the link ahead of the joint; one name for each link it may be on
        return one("displaced_marker", ("marker_offset_ahead", v), ("marker_offset", v), vertex=v, along_m=along)

    def weak(rng: np.random.Generator) -> Hidden:
        j = joint(rng)
        return one("weak_servo", ("lagging_joint", j), ("slow_joint", j), joint=j, factor=0.15)

    def toe(rng: np.random.Generator) -> Hidden:
        return one("toe", vertex=vertex(rng), angle_deg=sign(rng) * float(rng.uniform(6, 15)))

    def tether(rng: np.random.Generator) -> Hidden:
        pull = float(rng.uniform(2, 5)) * robot.mass_kg
        return one("tether", link=0, x_m=-0.5 * length, y_m=0.0, stiffness=pull, length_m=0.4 * length)

    drawn_by = (
        seized, smooth, payload, slope, patch, ratchet, sideways, loose, zero, stroke, stuck, marker, weak, toe, tether,
    )  # fmt: skip
    return {each.__name__: each for each in drawn_by}


def hidden_of(drawn: Drawn) -> dict[str, Hidden]:
    """What is hidden in the campaigns of a robot: nothing, and some changes."""
    rng = np.random.default_rng([drawn.seed, 21])
    kinds = changes(drawn)
    some = rng.choice(sorted(kinds), CHANGES, replace=False)
    return {"nothing": Hidden()} | {str(kind): kinds[str(kind)](rng) for kind in some}


def play(work: Path, drawn: Drawn, name: str, key: str, hidden: Hidden) -> Path:
    """A campaign's folder, in a folder whose name tells nothing; the noise-free motion elsewhere."""
    digest = hashlib.sha256(f"{key}:{drawn.seed}:{name}".encode()).hexdigest()
    folder = work / str(drawn.seed) / digest[:12]
    folder.mkdir(parents=True, exist_ok=True)
    write_robot(drawn, folder.parent)
    write_text(folder / "protocol.toml", protocol_text(drawn, digest[:6], int(digest[12:18], 16), hidden))
    protocol, tables = load_protocol(folder / "protocol.toml")
    run_campaign(protocol, tables, folder / "campaign", truth=folder / "truth")
    return folder


def run_robot(key: str, number: int, work: Path, out: Path) -> None:
    """All campaigns of one robot, as far as they are not in the table."""
    drawn = draw(key, number)
    hidden = hidden_of(drawn)
    done = {(r["robot"], r["name"]) for r in table.read(out / TABLE)[1]}
    if all((number, name) in done for name in ("healthy", *hidden)):
        return
    model = work / str(drawn.seed) / "robot.toml"
    base = {"robot": number, "joints": drawn.protocol.robot.joints, "trials": drawn.protocol.plays * _gaits(drawn)}
    then = play(work, drawn, "healthy", key, Hidden())
    began = time.process_time()
    healthy, said = diagnosed(then / "campaign", None, then / "diagnosis", model)
    row = base | {"name": "healthy", "seconds": time.process_time() - began, **{k: said[k] for k in KEPT}}
    if (number, "healthy") not in done:
        kept(key, out, row)
    known, again = reference_of(healthy), play(work, drawn, "nothing", key, Hidden())
    for name, change in hidden.items():
        if (number, name) in done:
            continue
        folder, began = play(work, drawn, name, key, change), time.process_time()
        row = base | {"name": name, "hidden": change.changes}
        try:
            _, said = diagnosed(folder / "campaign", known, folder / "diagnosis", model)
        except InputError as error:
            kept(key, out, row | {"outcome": "refused", "verdict": str(error)})
            continue
        row |= {**judged(said, change), **{k: said[k] for k in KEPT}, "seconds": time.process_time() - began}
        row["path_change_m"], row["path_repeats_m"] = moved_by(folder, then, again)
        kept(key, out, row)
        sys.stderr.write(f"robot {number}, {name}: {row['outcome']} ({row['verdict']})\n")


def _gaits(drawn: Drawn) -> int:
    return len(drawn.protocol.settings)


def kept(key: str, out: Path, row: dict[str, Any]) -> None:
    """One more row of the table."""
    rows = table.read(out / TABLE)[1]
    above = {"command": f"python -m arena.any_robot --key {key}", "commit": commit(), "key": key}
    table.write(out / TABLE, above, [*rows, row])
    write_text(out / "README.md", _summary(above, [*rows, row]))


def _summary(above: dict[str, str], rows: Sequence[dict[str, Any]]) -> str:
    head = (
        "# Hidden changes of robots drawn at random, played in the arena\n\n"
        f"`{above['command']}` (commit {above['commit']}); each robot's own healthy campaign is the reference.\n\n"
        "| robot | joints, trials | hidden | path change, repeats [mm] | said | verdict | outcome |\n"
        "| --- | --- | --- | --- | --- | --- | --- |\n"
    )
    judged_rows = [r for r in rows if "outcome" in r]
    kinds = by_cause(judged_rows)
    kinds[f"in the catalogue, of servos, of markers, or moving paths by {STRENGTH:g} times what repeats differ by"] = [
        r for r in required(judged_rows) if r.get("answers")
    ]
    counts = "; ".join(
        f"{kind}: {sum(r['outcome'] == 'right' for r in some)} of {len(some)} right"
        for kind, some in kinds.items()
        if some
    )
    return head + "\n".join(_line(r) for r in rows) + f"\n\n{counts}.\n"


def _line(r: dict[str, Any]) -> str:
    said = [
        f"`{e['name']}`"
        + ("" if e["place"] is None else f" at {e['place']}")
        + (" (stand-in)" if e["stand_in"] else "")
        for e in r.get("effects", [])
    ]
    if others := len(r.get("alternatives", [])):
        said.append(f"or {others} other{'s' * (others > 1)}")
    moved = f"{1e3 * r['path_change_m']:.1f}, {1e3 * r['path_repeats_m']:.1f}" if "path_change_m" in r else "-"
    return (
        f"| {r['robot']} | {r['joints']}, {r['trials']} | {r['name']} | {moved} | {', '.join(said) or '-'} "
        f"| {r['verdict']} | {r.get('outcome', '-')} |"
    )


def main() -> None:
    p = argparse.ArgumentParser(description="Robots drawn at random in the arena, changed, beside the healthy ones.")
    p.add_argument("count", nargs="?", type=int, default=10, help="robots (default 10)")
    p.add_argument("--out", type=Path, required=True)
    p.add_argument("--work", type=Path, required=True)
    p.add_argument("--key", required=True)
    a = p.parse_args()
    for number in range(1, a.count + 1):
        run_robot(a.key, number, a.work, a.out)


if __name__ == "__main__":
    main()
