"""The page and the notebook for one's own CSV run as they stand, and say what the page says they do."""

from __future__ import annotations

import json
import re
import shlex
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest

from serpenoid.cli.main import main
from serpenoid.measure.campaign import CampaignFile

ROOT = Path(__file__).parents[1]
pytestmark = pytest.mark.usefixtures("virtual_machine")


@pytest.mark.slow
def test_the_page_runs_as_it_stands(tmp_path, capsys):
    page = (ROOT / "docs" / "your-csv.md").read_text(encoding="utf-8")
    toml, *_ = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    commands = re.findall(r"```console\n(.*?)```", page, re.DOTALL)
    (tmp_path / "campaign.toml").write_text(toml)
    shutil.copy(ROOT / "problems" / "recordings" / "lamprey.csv", tmp_path)
    for command in commands:
        assert main([*shlex.split(command)[1:], *(["--no-figures"] if "compare" in command else [])]) == 0
    said = capsys.readouterr().out
    assert "moves head first" in said
    ratio = float(re.search(r"K = 1 / eps +([\d.]+)", said)[1])
    assert ratio == pytest.approx(float(re.search(r"about (\d+): four", page)[1]), abs=0.5)  # the page rounds
    share = float(re.search(r"Resim / Exp = ([\d.]+)", said)[1])
    assert round(100 * share) == int(re.search(r"move (\d+) % of the measured path", page)[1])
    assert (tmp_path / "measured" / "trial-swim-1.png").exists()


ROBOT = """
[about]
question = "How far?"
[body]
vertices = 5
edge_lengths = [0.1, 0.15, 0.15, 0.1]
weights = [1.0, 2.0, 2.0, 2.0, 1.0]
[medium]
anisotropy_ratio = 0.2
dissipation = "vertex"
[gait]
family = "ellipse"
sigma = 0.9
a = 4.0
[task]
steps = 40
cycles = 1
cycle_duration_s = 4.0
c = 0.5
"""


def test_the_robot_of_the_page_is_read_under_its_own_names_and_units(tmp_path, capsys):
    (tmp_path / "robot.toml").write_text(ROBOT)
    assert main(["new", "campaign", str(tmp_path / "made"), "--problem", str(tmp_path / "robot.toml"), "--yes"]) == 0
    _, toml, _ = blocks()
    (tmp_path / "campaign.toml").write_text(toml)
    made = tmp_path / "made" / "example"
    shutil.copy(made / "joint_table.csv", tmp_path / "wave.csv")
    motion = np.loadtxt(made / "motion.csv", delimiter=",", skiprows=1) * 1000  # s, m -> ms, mm
    names = [f"M{k + 1}_{axis}" for k in range(5) for axis in "xy"]
    _write(tmp_path / "wave-1.csv", ["No", "Time (ms)", *names], np.column_stack([np.arange(len(motion)), motion]))
    table, times = np.loadtxt(made / "joint_table.csv", delimiter=",", skiprows=1), np.arange(0.0, 11.0, 0.02)
    into = np.clip((times - 1.0) % 5.0, 0.0, 4.0) * 10  # rows of the table; a pause of a second after each cycle
    angles = np.stack([np.interp(into, np.arange(41), [*joint, joint[0]]) for joint in table.T], axis=1)
    angles[times < 1.0] = table[0]
    log = np.column_stack([1000 * times, np.degrees(angles)])
    _write(tmp_path / "wave-1-servo.csv", ["millis", "angle_1", "angle_2", "angle_3"], log)
    assert main(["measure", str(tmp_path), "--out", str(tmp_path / "out"), "--no-figures"]) == 0
    said = capsys.readouterr().out
    assert "500 mm long" in said or "0.5 m long" in said
    assert float(re.search(r"servo clock .*correlation ([\d.]+)", said)[1]) > 0.999
    assert float(re.search(r"servo scatter +([\d.]+) rad", said)[1]) < 0.02  # noise of 0.2 mm on edges of 100 mm


def blocks() -> list[str]:
    return re.findall(r"```toml\n(.*?)```", (ROOT / "docs" / "your-csv.md").read_text(encoding="utf-8"), re.DOTALL)


def test_wheels_in_the_middles_of_links_fit_the_robot_of_the_page():
    _, robot, middles = map(tomllib.loads, blocks())
    motion = {**robot["motion"], **middles["motion"]}
    file = CampaignFile.model_validate({**robot, "body": middles["body"], "motion": motion})
    whole = CampaignFile.model_validate(robot).body
    assert file.body.edges_m[::2] + file.body.edges_m[1::2] == pytest.approx(whole.edges_m)
    assert list(file.motion.marked(9)) == [0, *file.body.joint_vertices, 8]
    assert file.body.vertex_weights[1::2] == pytest.approx(whole.edges_m / whole.total_length_m, rel=1e-4)


def _write(path: Path, names: list[str], rows: np.ndarray) -> None:
    np.savetxt(path, rows, delimiter=",", header=",".join(names), comments="", fmt="%.4f")


def test_the_notebook_runs_as_it_stands(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    notebook = json.loads((ROOT / "problems" / "your_csv.ipynb").read_text(encoding="utf-8"))
    names: dict[str, object] = {}
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), names)
    assert "drag alone explains 13" in capsys.readouterr().out
