"""Drag of edges sits in their middles: told of where vertices are assumed, followed where the model says so."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from serpenoid.body import Body
from serpenoid.cli.main import main
from serpenoid.diagnose.report.write import about_links
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.model_file import write_model_file
from serpenoid.problem import load
from serpenoid.simulation.rollout import simulate_joint_angles

EPS = 0.4


def test_drag_at_the_middles_is_drag_of_the_edges() -> None:
    edges = (0.05, 0.1, 0.08, 0.12, 0.07, 0.06, 0.1)
    joints = len(edges) - 1
    body = Body(vertices=len(edges) + 1, edge_lengths=edges, weights=(3.0, 1.0, 2.0, 2.0, 1.0, 2.0, 2.0, 4.0))
    table = np.sin(2 * np.pi * (np.arange(30)[:, None] / 30 - np.arange(joints) / joints))
    at_edges, at_vertices = (Medium(anisotropy_ratio=EPS, dissipation=where) for where in ("edge", "vertex"))
    plain = simulate_joint_angles(Model(body, at_edges), table)
    amid = simulate_joint_angles(Model(body.with_middles(), at_vertices), table)
    assert amid.displacement == pytest.approx(plain.displacement, rel=1e-4)
    assert amid.dissipation == pytest.approx(plain.dissipation, rel=1e-4)


def test_drag_amid_pieces_of_edges_is_drag_of_the_edges_of_a_body_that_is_cut_into_them() -> None:
    edges, pieces = np.array([0.1, 0.06, 0.12, 0.08]), 3
    table = 0.8 * np.sin(2 * np.pi * (np.arange(30)[:, None] / 30 - np.arange(3) / 3))
    whole = Body(vertices=5, edge_lengths=tuple(edges))
    cut = Body(vertices=13, joints=(3, 6, 9), edge_lengths=tuple(np.repeat(edges / pieces, pieces)))
    at_edges, at_vertices = (Medium(anisotropy_ratio=EPS, dissipation=where) for where in ("edge", "vertex"))
    amid = whole.with_middles(pieces)
    assert amid.edges_m[[0, 1, 2, 3]] == pytest.approx(edges[0] / pieces * np.array([0.5, 1.0, 1.0, 0.5]))
    plain, other = (
        simulate_joint_angles(Model(body, medium), table) for body, medium in ((cut, at_edges), (amid, at_vertices))
    )
    assert other.displacement == pytest.approx(plain.displacement, rel=1e-4)
    assert other.dissipation == pytest.approx(plain.dissipation, rel=1e-4)


@pytest.fixture(scope="module")
def smooth(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A problem file for each place of the drag, and one trial of a body with drag along its edges."""
    folder = tmp_path_factory.mktemp("smooth")
    robot = ["--joints", "4", "--length", "0.6", "--anisotropy", str(EPS), "--yes"]
    assert main(["new", "problem", str(folder / "vertex.toml"), *robot]) == 0
    text = (folder / "vertex.toml").read_text().replace('dissipation = "vertex"', 'dissipation = "edge"')
    (folder / "edge.toml").write_text(text)
    words = ["--problem", str(folder / "edge.toml"), "--yes"]
    assert main(["new", "campaign", str(folder / "campaign.toml"), *words]) == 0
    return folder


def diagnosed(folder: Path, model: str, out: Path) -> dict[str, Any]:
    words = ["diagnose", str(folder), "--model", model, "--out", str(out), "--no-figures", "--quiet"]
    assert main(words) == 0
    return json.loads((out / "diagnosis.json").read_text())


@pytest.mark.slow
def test_where_vertices_are_assumed_the_middles_are_told_of(smooth: Path, tmp_path: Path) -> None:
    said = diagnosed(smooth, str(smooth / "vertex.toml"), tmp_path / "out")
    assert said["law"]["drag_at"].startswith("drag in the middles of edges misses windows by")
    assert said["verdict"] != "nothing"


def test_what_is_diagnosed_with_drag_at_edges_can_be_simulated_and_diagnosed_again(
    smooth: Path, tmp_path: Path
) -> None:
    said = diagnosed(smooth, str(smooth / "edge.toml"), tmp_path / "out")
    low, high = said["anisotropy_ratio"]["interval"]
    assert low < EPS < high
    assert said["verdict"] == "nothing"
    assert not said["law"]["drag_at"]
    extended = tmp_path / "out" / "extended-model.toml"
    assert tomllib.loads(extended.read_text())["body"]["vertices"] == 11
    one, other = (load(smooth / "edge.toml", model=model) for model in (None, str(extended)))
    assert other.body.joint_count == one.body.joint_count
    assert diagnosed(smooth, str(extended), tmp_path / "again")["verdict"] == "nothing"


def test_a_model_of_another_body_with_as_many_vertices_is_refused(
    smooth: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = Body(vertices=3, edge_lengths=(0.3, 0.3)).with_middles(4)  # 11 vertices, as the recorded one with middles
    write_model_file(tmp_path / "other.toml", Medium(anisotropy_ratio=EPS), (), other)
    assert main(["diagnose", str(smooth), "--model", str(tmp_path / "other.toml"), "--no-figures"]) == 2
    assert "a body of 11 vertices, but the campaign" in capsys.readouterr().err


@pytest.mark.slow
def test_dry_friction_all_along_the_links_is_told_of_where_drag_at_vertices_is_assumed(tmp_path: Path) -> None:
    edges, pieces = [0.12, 0.16, 0.1, 0.14, 0.12], 6
    fine = [round(e / pieces, 6) for e in edges for _ in range(pieces)]
    joints = [pieces * (j + 1) for j in range(len(edges) - 1)]
    robot = ["--joints", str(len(joints)), "--length", "0.64", "--anisotropy", str(EPS), "--yes"]
    assert main(["new", "problem", str(tmp_path / "robot.toml"), *robot]) == 0
    plain = (tmp_path / "robot.toml").read_text()
    _, _, rest = re.split(r"(?m)^(?=\[body\])|^(?=\[medium\])", plain)
    head = plain[: plain.index("[body]")]
    truth = f"[body]\nvertices = {len(fine) + 1}\njoints = {joints}\nedge_lengths = {fine}\n\n"
    law = rest.replace('"vertex"', '"edge"').replace('"viscous"', '"coulomb"')
    (tmp_path / "truth.toml").write_text(head + truth + law)
    words = ["--problem", str(tmp_path / "truth.toml"), "--yes"]
    assert main(["new", "campaign", str(tmp_path / "campaign.toml"), *words]) == 0
    text = (tmp_path / "campaign.toml").read_text()
    said = f"[body]\nvertices = {len(edges) + 1}\nedge_lengths = {edges}\n\n"
    text = re.sub(r"(?ms)^\[body\].*?(?=^\[)", said, text)
    text = re.sub(r"(?ms)^\[medium\].*?(?=^\[)", "", text)
    (tmp_path / "campaign.toml").write_text(re.sub(r"(?m)^vertices = \[.*\n", "", text))
    assert main(["diagnose", str(tmp_path), "--out", str(tmp_path / "out"), "--no-figures", "--quiet"]) == 0
    law = json.loads((tmp_path / "out" / "diagnosis.json").read_text())["law"]
    assert law["drag_at"].startswith("dry friction, all along the links, misses windows by")
    assert law["drag_at_model"] == "drag-elsewhere.toml"
    assert not law["rivals"]  # at vertices none does as well
    model = str(tmp_path / "out" / "drag-elsewhere.toml")
    said = diagnosed(tmp_path, model, tmp_path / "again")
    assert said["verdict"] == "nothing"
    low, high = said["anisotropy_ratio"]["interval"]
    assert low - 0.01 < EPS < high + 0.01  # four pieces for six: 1 / 16 of what a link resists turning by, not 1 / 36


def test_where_something_is_left_links_of_one_edge_are_to_be_cut() -> None:
    links = Body(kind="swimming robot", vertices=18, length_m=1.0)
    assert about_links(links, settled=True) == []
    (said,) = about_links(links, settled=False)
    assert "0.3% of what the straight body resists" in said
    assert "Cut links into more edges" in said
    cut = Body(kind="swimming robot", vertices=35, length_m=1.0, joints=tuple(range(2, 34, 2)))
    wheeled = links.changed(kind="wheeled robot")
    assert about_links(cut, settled=False) == about_links(wheeled, settled=False) == []
    assert "lacks 25.0%" in about_links(Body(vertices=3, length_m=1.0), settled=True)[0]
