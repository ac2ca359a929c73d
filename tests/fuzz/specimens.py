"""One small valid file of every kind that the package reads, and a function that reads it as its verb does.

What a reader gives back is compared: a file whose number was replaced by what is none must not give another answer.
"""

from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rehearsal import serpenoid_table, write_c3d
from serpenoid.arena.protocol import load_protocol
from serpenoid.cli.main import main
from serpenoid.errors import InputError
from serpenoid.files.inputs import read_json
from serpenoid.files.schema import load as load_record
from serpenoid.measure.campaign import load_campaign_file
from serpenoid.measure.formats.motive import read_motive
from serpenoid.measure.formats.points import read_c3d, read_long, read_sleap
from serpenoid.measure.formats.tidy import read_tidy
from serpenoid.measure.logs import read_power_log, read_servo_log
from serpenoid.measure.write import write_motive, write_power_log, write_servo_log
from serpenoid.model_file import read_model_file
from serpenoid.optimise.chain_store import ChainStore
from serpenoid.optimise.solver import GaitSolver
from serpenoid.problem import load
from serpenoid.results import write_simulation
from serpenoid.robot.description import Robot
from serpenoid.robot.table import read_table as read_results
from serpenoid.simulation.problem import simulate
from serpenoid.table_file import read_table, write_table

PROBLEMS = Path(__file__).parents[2] / "problems"
SMALL = """\
[about]
question = "How far?"

[body]
vertices = 5
edge_lengths = [0.2, 0.3, 0.3, 0.2]
weights = [1.0, 2.0, 2.0, 2.0, 1.0]
joint_limit_deg = 70.0

[medium]
anisotropy_ratio = 0.2
dissipation = "vertex"

[gait]
family = "ellipse"
sigma = 0.9
a = 4.0

[task]
steps = 8
cycles = 1
cycle_duration_s = 2.5
c = 0.5

[task.bounds]
a = [0.0, 10.0]

[task.constraints]
joint_limits = true

[[effects]]
name = "worn_wheel"
place = 2
seizure = 0.5
"""
MODEL = SMALL[SMALL.index("[medium]") : SMALL.index("[gait]")] + SMALL[SMALL.index("[[effects]]") :]
CAMPAIGN = """\
format = 1
name = "two trials"
description = "a rehearsal"

[body]
vertices = 4
edge_lengths = [0.1, 0.2, 0.1]

[motion]
format = "tidy"
length_unit = "m"

[[trial]]
name = "one-1"
gait = "one"
joint_table = "table.csv"
cycle_duration_s = 2.0
cycles = 2
pause_s = 0.5
motion = "motion.csv"

[[trial]]
name = "one-2"
gait = "one"
motion = "motion.csv"
from_s = 0.5
"""
COLUMNS = {"time": "t", "point": "point", "x": "x", "y": "y"}


@dataclass(frozen=True)
class Specimen:
    """name of the file in its folder, its valid content (folder -> nothing), and its reader (path -> an answer)."""

    file: str
    write: Callable[[Path], None]
    read: Callable[[Path], Any]
    table: bool = False  # every number in it is data


def _text(text: str) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        path.write_text(text, encoding="utf-8")
        write_table(path.parent / "head-first.csv", serpenoid_table(8))
        write_table(path.parent / "tail-first.csv", serpenoid_table(8))

    return write


def _copy(path: Path) -> Callable[[Path], None]:
    return _text(path.read_text(encoding="utf-8"))


def _motive(path: Path) -> None:
    rng = np.random.default_rng(1)
    write_motive(path, np.arange(6) / 120, rng.normal(size=(6, 3, 2)), ["S:a", "S:b", "Unlabeled 12"])


def _servo(path: Path) -> None:
    angle = np.linspace(-1, 1, 12).reshape(6, 2)
    schedule = [("approach", 0, 0), *(("play", 0, k) for k in range(4)), ("end", 0, 4)]
    write_servo_log(path, np.arange(6) / 50, angle, angle + 0.1, schedule)


def _power(path: Path) -> None:
    write_power_log(path, np.arange(20) / 50, 5 + np.sin(np.arange(20)))


def _tidy(path: Path) -> None:
    path.write_text("t_s,x_0,y_0,x_1,y_1\n" + "".join(f"{k / 10},{k / 7:.4f},2,{k},4.5\n" for k in range(6)))


def _long(path: Path) -> None:
    path.write_text("t,point,x,y\n" + "".join(f"{k / 10},{j},{k + j},{k * j}\n" for k in range(4) for j in range(3)))


def _sleap(path: Path) -> None:
    rows = "".join(f"track_0,{k},0.9,{10 + k}.5,20.25,0.8,{30 + k},40,0.7\n" for k in range(5))
    path.write_text("track,frame_idx,instance.score,a.x,a.y,a.score,b.x,b.y,b.score\n" + rows)


def _result(path: Path) -> None:
    problem = path.parent / "small.toml"
    problem.write_text(SMALL)
    write_simulation(path.parent, simulate(load(problem)), figures=False)


def _diagnosis(path: Path) -> None:
    gain = {key: {"before": 0.05, "after": 0.02, "before_interval": [0.04, 0.06], "after_interval": [0.01, 0.03]}
            for key in ("path_rms_m", "displacement_error_m", "heading_error_rad", "s", "log_likelihood")}  # fmt: skip
    seizure = {"value": 0.5, "interval": [0.4, 0.6], "unit": "1", "at_bound": False}
    effect = {
        "name": "worn_wheel",
        "place": 2,
        "strength_over_noise": 3.0,
        "stand_in": False,
        "parameters": {"seizure": seizure},
    }
    step = {"stage": "motion", "compares": "shape against motion", "before": 0.05, "after": 0.02, "noise_level": 0.01,
            "unit": "m", "share_above_noise_before": 0.96, "share_above_noise_after": 0.75}  # fmt: skip
    record = {"campaign": "two", "verdict": "explained", "effects": [effect], "gain": gain,
              "noise_level_m": 0.001, "left_open_m": 0.002, "left_open_by_gait_m": {"a": 0.002},
              "length_unit": "m", "noise_from": "trials",
              "anisotropy_ratio": {"before": 0.2, "after": 0.21, "interval": [0.2, 0.22], "at_bound": False},
              "drag_ratio": None, "law": {"name": "viscous", "rivals": {"coulomb": "misses less"}, "drag_at": ""},
              "ladder": [step], "discrepancy_m": 0.003, "provenance": {"written": "today"},
              "reference": None, "alternatives": [effect | {"separation_over_noise": 2.0}], "below_detection": [],
              "untestable": {"slope": "one heading alone"}, "skipped": {}, "next_experiment": None,
              "residual_pattern": ["motion: repeats"], "used_s": 11.5, "dropped_s": 0.5, "remarks": []}  # fmt: skip
    path.write_text(json.dumps(record, indent=1))


def _motion(tracks: Any) -> list[Any]:
    return [tracks.time_s.tolist(), np.nan_to_num(tracks.floor, nan=-99.0).tolist()]


def _shown(path: Path) -> str:
    """What is said of it, or the error's text as an InputError."""
    said, why = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(why):
        code = main(["show", str(path.parent)])
    if code == 2:
        raise InputError(why.getvalue())
    assert code == 0
    return said.getvalue()


def _problem(path: Path) -> Any:
    problem = load(path)
    assert np.isfinite(problem.model.parameters).all()
    return problem.model_dump(mode="json", exclude={"about"})


def _power_values(path: Path) -> Any:
    log = read_power_log(path)
    return [log.time_s.tolist(), log.power_W.tolist()]


def _servo_values(path: Path) -> Any:
    log = read_servo_log(path)
    return [log.time_s.tolist(), log.position.tolist(), None if log.command is None else log.command.tolist()]


def _chain(path: Path) -> None:
    problem = path.parent / "small.toml"
    problem.write_text(SMALL)
    solver = GaitSolver(load(problem))
    ChainStore(path.parent, "up").save(0.5, _solved(solver))


def _solved(solver: GaitSolver) -> Any:
    return solver.solve(solver.problem.gait.parameters, 0.5)


def _stored(path: Path) -> Any:
    answer = ChainStore(path.parent, "up").load(0.5, _solver(path.parent / "small.toml"))
    return None if answer is None else answer.outcome.point.x.tolist()


SOLVERS: dict[str, GaitSolver] = {}


def _solver(path: Path) -> GaitSolver:
    return SOLVERS.setdefault(str(path), GaitSolver(load(path)))


SPECIMENS = {
    "problem": Specimen("small.toml", _text(SMALL), _problem),
    "model": Specimen("model.toml", _text(MODEL), read_model_file),
    "campaign": Specimen("campaign.toml", _text(CAMPAIGN), lambda p: load_campaign_file(p)[0].model_dump(mode="json")),
    "robot": Specimen("robot.toml", _copy(PROBLEMS / "robots" / "snake10-robot.toml"),
                      lambda p: load_record(Robot, p).model_dump(mode="json")),
    "protocol": Specimen("protocol.toml", _copy(PROBLEMS / "protocols" / "two-gaits.toml"),
                         lambda p: load_protocol(p)[0].model_dump(mode="json")),
    "joint table": Specimen("table.csv", lambda p: write_table(p, serpenoid_table(8)), lambda p: read_table(p).tolist(),
                            True),
    "motive": Specimen("motive.csv", _motive, lambda p: _motion(read_motive(p)), True),
    "tidy": Specimen("tidy.csv", _tidy, lambda p: _motion(read_tidy(p)), True),
    "long": Specimen("long.csv", _long, lambda p: _motion(read_long(p, COLUMNS, "m")), True),
    "sleap": Specimen("sleap.csv", _sleap, lambda p: _motion(read_sleap(p, 60.0)), True),
    "c3d": Specimen("points.c3d", write_c3d, lambda p: _motion(read_c3d(p))),
    "servo log": Specimen("servo.csv", _servo, _servo_values, True),
    "power log": Specimen("power.csv", _power, _power_values, True),
    "played solution": Specimen("solution.json", _result, lambda p: read_results(p.parent).stated.cycle_duration_s),
    "shown solution": Specimen("solution.json", _result, _shown),
    "diagnosis": Specimen("diagnosis.json", _diagnosis, _shown),
    "receipt": Specimen(".arena.json", lambda p: p.write_text('{"protocol": "01234567"}'), read_json),
    "chain point": Specimen("up-0.5.npz", _chain, _stored),
}  # fmt: skip
