"""The arena for any chain: four, six and sixteen joints, unequal links, rigid vertices between joints."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from serpenoid.arena.assembly import Assembly
from serpenoid.arena.protocol import PlayedRobot, load_protocol
from serpenoid.arena.robot import Robot, robot_of, too_weak
from serpenoid.arena.world import World
from serpenoid.body import Body
from serpenoid.cli.main import main
from serpenoid.errors import InputError
from serpenoid.gaits import EllipseGait
from serpenoid.measure.load import load_campaign
from serpenoid.mechanics.tables import joint_table
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.problem import load
from serpenoid.table_file import write_table
from specimens import PROBLEMS

SIX = {"vertices": 8, "edge_lengths": (0.05, 0.10, 0.12, 0.10, 0.08, 0.10, 0.05), "mass_kg": 0.95}
BODIES = {
    "4 joints": Body(vertices=6, length_m=0.5, mass_kg=0.7),
    "6 joints, unequal links": Body(**SIX),
    "16 joints": Body(vertices=18, length_m=1.4, mass_kg=2.0),
    "3 joints, rigid vertices between": Body(vertices=9, joints=(2, 4, 6), length_m=0.6, mass_kg=0.8),
    "small": Body(vertices=8, length_m=0.2, mass_kg=0.25),
}
EPS = 0.1865  # the ratio to which the arena's tyres and bearings were calibrated (docs/arena.md)


def robot(name: str) -> Robot:
    return Robot.model_validate(robot_of(BODIES[name]))


def table(body: Body, a: float = 5.0) -> np.ndarray:
    model = Model(body, Medium(anisotropy_ratio=EPS))
    return joint_table(model, EllipseGait(a=a).parameters, 40)


def test_the_papers_body_is_the_papers_robot_to_the_last_number():
    assert Robot.model_validate(robot_of(load(PROBLEMS / "snake10.toml").body)) == Robot()


@pytest.mark.parametrize("name", BODIES)
def test_a_chain_weighs_and_measures_what_its_body_says(name):
    body, world = BODIES[name], World(Assembly.healthy(robot(name)))
    assert world.model.body_mass.sum() == pytest.approx(body.mass_kg, rel=1e-9)
    world.place(np.zeros(body.joint_count))
    places = world.markers()[:, :2]
    # wheels carry joints that give a little: a tenth of a millimetre over a link
    np.testing.assert_allclose(np.linalg.norm(np.diff(places, axis=0), axis=1), body.edges_m, atol=1e-4)


@pytest.mark.parametrize("name", BODIES)
def test_wheels_carry_the_chain_and_sink_no_more_than_the_papers(name):
    body, world = BODIES[name], World(Assembly.healthy(robot(name)))
    world.place(table(body)[0])
    # the smallest body rests on wheels closest together: 1 % is the last of the settling, as for the paper's
    assert world.wheel_loads().sum() == pytest.approx(body.mass_kg * 9.81, rel=0.02)
    assert world.wheel_loads().min() > 0
    sink = world.robot.wheel_diameter_m / 2 - world.data.geom_xpos[world._tyres, 2]
    assert 0 < sink.mean() < 0.001


@pytest.mark.parametrize("name", BODIES)
def test_a_curved_chain_at_rest_stays_at_rest(name):
    world = World(Assembly.healthy(robot(name)))
    world.place(table(BODIES[name])[0])
    before = world.markers()
    for _ in range(round(1 / world.robot.timestep_s)):
        world.step()
    assert np.abs(world.markers() - before).max() < 5e-5  # a quarter of the cameras' noise


def moved(name: str, played: np.ndarray) -> float:
    """Body lengths per cycle along the first chord, in the second of two cycles of 5 s."""
    body, world = BODIES[name], World(Assembly.healthy(robot(name)))
    world.place(played[0])
    chord = world.markers()[-1] - world.markers()[0]
    centres = [world.markers()[:, :2].mean(axis=0)]
    for count in range(2 * len(played)):
        world.command(played[count % len(played)])
        while world.time_s < (count + 1) * 5.0 / len(played) - 1e-9:
            world.step()
        centres.append(world.markers()[:, :2].mean(axis=0))
    way = centres[-1] - centres[len(played)]
    return float(way @ chord[:2] / np.linalg.norm(chord[:2]) / body.total_length_m)


@pytest.mark.parametrize("name", ["6 joints, unequal links", pytest.param("16 joints", marks=pytest.mark.slow)])
def test_a_travelling_wave_moves_a_chain_head_first_and_its_reverse_tail_first(name):
    played = table(BODIES[name])
    forward, backward = moved(name, played), moved(name, played[-np.arange(len(played))])
    assert forward > 0.15
    assert backward < -0.15


def test_what_a_robot_section_gives_is_not_scaled():
    own = robot_of(BODIES["small"], {"wheel_diameter_m": 0.03, "changes": {"payload": {"link": 6}}})
    played = PlayedRobot.model_validate(own)
    assert played.wheel_diameter_m == 0.03
    assert played.track_m < Robot().track_m
    assert played.assembled().payload[6] == 0.3


def test_a_change_that_names_a_part_the_chain_does_not_have_is_refused():
    with pytest.raises(ValueError, match="`payload` names a vertex, joint or link that this robot does not have"):
        PlayedRobot.model_validate(robot_of(BODIES["small"], {"changes": {"payload": {"link": 9}}}))


def protocol(folder: Path) -> Path:
    numbers = {key: list(value) if isinstance(value, tuple) else value for key, value in SIX.items()}
    body = "\n".join(f"{key} = {value}" for key, value in numbers.items())
    (folder / "six.toml").write_text(f"[body]\n{body}\n[medium]\nanisotropy_ratio = {EPS}\n")
    write_table(folder / "wave.csv", table(Body(**SIX)))
    text = 'name = "six"\nproblem = "six.toml"\ntrials = 1\ncycles = 1\npause_s = 1.0\n'
    (folder / "protocol.toml").write_text(text + '[[gait]]\nname = "wave"\njoint_table = "wave.csv"\n')
    return folder / "protocol.toml"


def test_a_six_joint_robot_goes_from_arena_through_measure_to_compare(tmp_path, capsys):
    campaign = tmp_path / "campaign"
    assert main(["arena", "run", str(protocol(tmp_path)), "--out", str(campaign), "-j", "1", "--quiet"]) == 0
    body = load_campaign(campaign).body
    np.testing.assert_allclose(body.edges_m, SIX["edge_lengths"], rtol=1e-5)
    assert body.mass_kg == pytest.approx(SIX["mass_kg"])
    words = ["--no-figures", "--json", "--out"]
    assert main(["measure", str(campaign), *words, str(tmp_path / "measured")]) == 0
    capsys.readouterr()
    assert main(["compare", str(campaign), *words, str(tmp_path / "compared")]) == 0
    (cycle,) = json.loads(capsys.readouterr().out)["comparisons"]
    # the ratio was fitted to this cycle alone: the drag model goes where the robot went, nearly
    assert cycle["resim"] == pytest.approx(cycle["exp"], rel=0.1)


def test_a_body_without_mass_and_a_table_of_another_robot_are_refused(tmp_path):
    path = protocol(tmp_path)
    write_table(tmp_path / "wave.csv", np.zeros((10, 10)))
    with pytest.raises(InputError, match="with 6 joints"):
        load_protocol(path)
    (tmp_path / "six.toml").write_text("[body]\nvertices = 8\n[medium]\nanisotropy_ratio = 0.2\n")
    with pytest.raises(InputError, match=r"\[body\] mass_kg: the arena needs"):
        load_protocol(path)


def test_the_load_of_a_joint_is_the_moment_of_friction_of_its_lighter_side():
    """Two links of 0.3 m between masses of 1, 2 and 3 kg: the tail's 1 kg at 0.3 m, over the stall torque."""
    heavy = Body(vertices=3, edge_lengths=(0.3, 0.3), weights=(1.0, 2.0, 3.0), mass_kg=6.0)
    built = Robot.model_validate(robot_of(heavy, {"grip": 0.4, "stall_torque": 1.4}))
    np.testing.assert_allclose(built.loads, [0.4 * 9.81 * 1.0 * 0.3 / 1.4])
    assert too_weak(built) == ""
    assert (Robot().loads < 1).all()  # the paper's


def test_servos_that_cannot_turn_the_body_are_told_before_it_is_played(tmp_path, caplog):
    write_table(tmp_path / "still.csv", np.zeros((10, 4)))
    (tmp_path / "heavy.toml").write_text(
        "[body]\nvertices = 6\nlength_m = 1.4\nmass_kg = 8.0\n[medium]\nanisotropy_ratio = 0.2\n"
    )
    (tmp_path / "protocol.toml").write_text(
        'format = 1\nname = "heavy"\nproblem = "heavy.toml"\ntrials = 1\ncycles = 1\n'
        '[[gait]]\nname = "still"\njoint_table = "still.csv"\ncycle_durations_s = [1.0]\nheadings_deg = [0.0]\n'
    )
    assert main(["arena", "run", str(tmp_path / "protocol.toml"), "--out", str(tmp_path / "out"), "--quiet"]) == 0
    (said,) = [r.getMessage() for r in caplog.records if "stalls at" in r.getMessage()]
    assert said.startswith("joint ")
    assert "N m to turn the lighter side of the body over the floor" in said
