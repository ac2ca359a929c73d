"""Campaign folders: complete, repeatable, and silent about what is hidden."""

from __future__ import annotations

import csv
import tomllib
from pathlib import Path

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, Campaign, make, with_experiment
from blind.catalogue import CATALOGUE, ON_WHEELS, Effect, draw
from blind.folder import write
from blind.gaits import progress
from blind.outside import OUTSIDE
from blind.snake import EDGES, JOINT_LIMIT, MASSES, SNAKE10, SPEED_LIMIT, TICK

SEED = 11
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def null() -> Campaign:
    return make(SEED, 0)


def _read(path: Path) -> dict[str, np.ndarray]:
    with path.open() as f:
        rows = list(csv.DictReader(f))
    return {k: np.array([row[k] for row in rows]) for k in rows[0]}


def test_folder_follows_the_format(tmp_path: Path) -> None:
    c = make(SEED, 0, "abc")
    write(c, tmp_path / "abc")
    campaign = tomllib.loads((tmp_path / "abc" / "campaign.toml").read_text())
    trials = campaign["trial"]
    assert len({t["gait"] for t in trials}) >= 6
    assert len({t["cycle_duration_s"] for t in trials}) == 3
    assert len({round(t.setting.heading, 3) for t in c.trials}) == 3
    for t in trials:
        table = np.loadtxt(tmp_path / "abc" / t["joint_table"], delimiter=",", skiprows=1)
        assert table.shape == (50, 10)
        assert np.abs(table).max() <= JOINT_LIMIT
        speed = np.abs(np.diff(table, axis=0, append=table[:1])).max() * 50 / t["cycle_duration_s"]
        assert speed < SPEED_LIMIT
        servo = _read(tmp_path / "abc" / t["servo_log"])
        position = servo["position_3"].astype(float)
        np.testing.assert_allclose(position / TICK, np.round(position / TICK), atol=1e-3)
        assert set(servo["phase"]) == {"approach", "play", "pause", "end"}
        motion = _read(tmp_path / "abc" / t["motion"])
        assert np.median(np.diff(motion["t_s"].astype(float))) == pytest.approx(1 / 120, abs=2e-5)
        empty = np.array([[cell == "" for cell in motion[f"x_{k}"]] for k in range(12)])
        assert empty.all(axis=0).any()
        assert 0.005 < empty.mean() < 0.2


def test_the_robot_is_the_one_of_the_problem_file() -> None:
    body = tomllib.loads((ROOT / "problems" / "snake10.toml").read_text())["body"]
    np.testing.assert_allclose(body["weights"], MASSES)
    np.testing.assert_allclose(body["edge_lengths"], EDGES, atol=1e-6)


def test_first_gait_moves_tail_first_and_the_others_head_first(null: Campaign) -> None:
    tables = {t.setting.gait: t.setting.plan.table for t in null.trials}
    directions = [progress(table) for _, table in sorted(tables.items())]
    assert directions[0] < -0.09
    assert min(directions[1:]) > 0.09


def test_an_effect_is_the_only_difference_to_the_null(null: Campaign) -> None:
    zero = make(SEED, [Effect("slope", None, {"pull_x": 0.0, "pull_y": 0.0})])
    for a, b in zip(null.trials, zero.trials, strict=True):
        np.testing.assert_allclose(a.film.markers, b.film.markers, atol=1e-8)
        np.testing.assert_array_equal(a.log.position, b.log.position)


def test_repeated_trials_differ_as_in_a_laboratory(null: Campaign) -> None:
    trials = null.trials
    a, b = (t.path[:, :2] - t.path[0, :2] for t in trials[:2])
    ends = [p[-1] @ [np.cos(t.path[0, 2]), np.sin(t.path[0, 2])] for p, t in zip((a, b), trials, strict=False)]
    assert 1e-5 < abs(ends[0] - ends[1]) < 0.03


# one of each kind always: of servos, of what is seen, of one vertex, of directions, of the floor, of the law, of time
ALWAYS = ("servo_lag", "servo_inertia", "speed_saturation", "backlash", "stuck_joint", "zero_offset", "marker_sway",
          "camera_stretch", "clock_offset", "position_jumps", "worn_wheel", "left_right_asymmetry", "slope",
          "friction_patch", "rolling_resistance", "inertia")  # fmt: skip


@pytest.mark.parametrize("name", [pytest.param(n, marks=[] if n in ALWAYS else pytest.mark.slow) for n in CATALOGUE])
def test_every_effect_leaves_a_trace_in_the_files(name: str, null: Campaign) -> None:
    kind = CATALOGUE[name]
    rng = np.random.default_rng(3)
    place = kind.places()[len(kind.places()) // 2]
    strongest = max((kind.draw(rng, place, SNAKE10) for _ in range(20)), key=lambda p: abs(next(iter(p.values()))))
    if name in ("speed_saturation", "slow_joint"):
        strongest = {"max_speed": 0.3}
    c = make(SEED, [Effect(name, place, strongest)], combinations=COMBINATIONS[:3])
    marker = max(
        np.nanmax(np.abs(a.film.markers - b.film.markers)) for a, b in zip(c.trials, null.trials, strict=False)
    )
    clock = max(np.abs(a.log.time - b.log.time).max() for a, b in zip(c.trials, null.trials, strict=False))
    assert marker > 1e-3 or clock > 1e-3


@pytest.mark.parametrize("name", OUTSIDE)
def test_every_outside_cause_changes_the_motion(name: str, null: Campaign) -> None:
    c = make(SEED, name, combinations=COMBINATIONS[:3])
    assert max(np.abs(a.path - b.path).max() for a, b in zip(c.trials, null.trials, strict=False)) > 2e-3


def test_names_and_places_are_drawn_uniformly() -> None:
    rng = np.random.default_rng(0)
    drawn = [draw(rng, 1)[0] for _ in range(100 * len(ON_WHEELS))]
    counts = np.array([sum(e.name == n for e in drawn) for n in ON_WHEELS])
    assert counts.min() > 60  # expected 100, standard deviation 10
    assert {e.place for e in drawn if e.name == "load"} == set(range(12))
    assert {e.name for e in drawn} == set(ON_WHEELS)


def test_an_experiment_is_played_in_the_same_world() -> None:
    c = make(SEED, [Effect("toe", None, {"angle": 0.1})], combinations=COMBINATIONS[:3])
    longer = with_experiment(c, c.trials[4].setting.plan.table, 4.0)
    assert len(longer.trials) == len(c.trials) + 2
    assert longer.world is c.world
    assert longer.trials[: len(c.trials)] == c.trials


def test_nothing_in_the_folder_tells(tmp_path: Path) -> None:
    """Same files, same lines, same metadata, whatever is hidden."""
    folders = []
    for i, hide in enumerate((0, [Effect("slope", None, {"pull_x": 0.004, "pull_y": 0.0})])):
        folder = tmp_path / str(i) / "id"
        write(make(SEED, hide, "id", COMBINATIONS[:3]), folder)
        folders.append(folder)
    a, b = (sorted(p.relative_to(f) for p in f.rglob("*")) for f in folders)
    assert a == b
    assert (folders[0] / "campaign.toml").read_text() == (folders[1] / "campaign.toml").read_text()
    for path in a:
        if path.suffix == ".csv":
            lines = [(f / path).read_text().splitlines() for f in folders]
            assert lines[0][0] == lines[1][0]
            assert len(lines[0]) == len(lines[1])
