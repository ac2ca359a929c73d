"""The study of robots drawn at random asks for what the arena can play."""

import numpy as np
import pytest

from arena.any_robot import JOINTS, changes, draw, hidden_of, protocol_text, write_robot
from arena.hidden import Hidden
from serpenoid.arena.protocol import load_protocol
from serpenoid.arena.robot import too_weak
from serpenoid.files.writing import write_text


@pytest.mark.parametrize("number", [1, 2, 3])
def test_whatever_is_drawn_is_a_protocol_with_any_of_the_changes(number, tmp_path):
    drawn = draw("a key of this test", number)
    write_robot(drawn, tmp_path)
    joints, masses = drawn.protocol.robot.joints, drawn.protocol.robot.masses
    assert JOINTS[0] <= joints <= JOINTS[1]
    assert too_weak(drawn.built) == ""
    (tmp_path / "a").mkdir()
    kinds = {kind: change(np.random.default_rng(number)) for kind, change in changes(drawn).items()}
    for kind, hidden in {"nothing": Hidden(), **kinds}.items():
        write_text(tmp_path / "a" / "protocol.toml", protocol_text(drawn, kind, 1, hidden))
        protocol, tables = load_protocol(tmp_path / "a" / "protocol.toml")
        assert protocol.robot.changes.model_dump(exclude_none=True).keys() == hidden.changes.keys()
        assert {table.shape[1] for table in tables.values()} == {joints}
        np.testing.assert_allclose(protocol.robot.loads, drawn.built.loads, rtol=1e-3)
        np.testing.assert_allclose(protocol.robot.vertex_masses_kg / protocol.robot.mass_kg, masses / masses.sum())


def test_a_key_draws_the_same_robots_and_changes_again():
    first, again = draw("k", 1), draw("k", 1)
    assert hidden_of(first) == hidden_of(again)
    assert hidden_of(draw("k", 2)) != hidden_of(first)
