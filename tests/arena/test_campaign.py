"""The campaign folder: the documented files, the same from the same seed, resumed after a kill, refused when wrong."""

import csv
import os
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import numpy as np
import pytest

from arena.support import LENGTH, serpenoid_table
from serpenoid.arena.campaign import another, run_campaign
from serpenoid.arena.protocol import Protocol, load_protocol
from serpenoid.arena.trial import plans, schedule
from serpenoid.cli.claim import move_aside
from serpenoid.cli.main import main
from serpenoid.errors import InputError

PROTOCOL = """
seed = 5
trials = {trials}
cycles = 1
cycle_duration_s = 2.0
pause_s = 0.5
[start]
headings_deg = [0, 90]
[cameras]
dropout = 0.05
unlabelled = 0.5
[[gait]]
name = "wave"
joint_table = "wave.csv"
"""


@pytest.fixture
def protocol_file(tmp_path):
    def write(trials=1, extra=""):
        header = ",".join(f"joint_{number}" for number in range(1, 11))
        np.savetxt(tmp_path / "wave.csv", serpenoid_table(), delimiter=",", header=header, comments="")
        path = tmp_path / "protocol.toml"
        path.write_text(PROTOCOL.format(trials=trials) + extra)
        return path

    return write


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    folder = tmp_path_factory.mktemp("arena")
    protocol = Protocol.model_validate(
        {
            **tomllib.loads(PROTOCOL.format(trials=1)),
            "robot": {"changes": {"payload": {"link": 3}}},
        }
    )
    run_campaign(protocol, {"wave": serpenoid_table()}, folder / "out", truth=folder / "truth")
    return folder


def rows(path):
    with path.open(newline="", encoding="utf-8") as stream:
        return list(csv.reader(stream))


def test_campaign_toml_describes_what_is_there(campaign):
    described = tomllib.loads((campaign / "out/campaign.toml").read_text())
    assert described["format"] == 1
    assert sum(described["body"]["edge_lengths"]) == pytest.approx(LENGTH, rel=1e-5)
    assert len(described["body"]["weights"]) == described["body"]["vertices"] == 12
    (trial,) = described["trial"]
    for key in ("joint_table", "motion", "servo_log", "power_log"):
        assert (campaign / "out" / trial[key]).is_file()


def test_what_is_hidden_stays_hidden(campaign):
    for path in (campaign / "out").rglob("*"):
        assert "payload" not in path.name
        assert not path.is_file() or "payload" not in path.read_text()


def test_motion_is_a_motive_1_25_export(campaign):
    lines = rows(campaign / "out/wave-1/motion.csv")
    head = dict(zip(lines[0][::2], lines[0][1::2], strict=True))
    assert (head["Format Version"], head["Length Units"]) == ("1.25", "Meters")
    assert [line[1] for line in lines[2:6]] == ["Type", "Name", "ID", "Parent"]
    assert lines[6][2:] == ["Position"] * (len(lines[6]) - 2)
    assert lines[7][:5] == ["Frame", "Time (Seconds)", "X", "Y", "Z"]
    assert {line for line in lines[3][2:38:3]} == {
        f"Snake:{n}" for n in ("tail", "head", *map("joint_{}".format, range(1, 11)))
    }
    assert any(name.startswith("Unlabeled") for name in lines[3])
    assert int(head["Total Exported Frames"]) == len(lines) - 8
    assert {len(line) for line in lines[2:]} == {len(lines[3])}


def test_markers_are_the_truth_with_the_asked_for_noise(campaign):
    lines = rows(campaign / "out/wave-1/motion.csv")[8:]
    cells = np.array([[float(cell or "nan") for cell in line[2:38]] for line in lines]).reshape(-1, 12, 3)
    truth = np.load(campaign / "truth/wave-1.npz")["markers"]
    off = cells[..., [2, 0, 1]] - truth  # file z is floor x, file x is floor y, file y is up
    assert np.nanstd(off) == pytest.approx(0.0002, rel=0.05)  # thousands of values: 5 % is more than 5 sigma
    assert 0.01 < np.isnan(cells).mean() < 0.12  # bursts: few and long, so the share of one trial scatters
    edges = np.linalg.norm(np.diff(truth[..., :2], axis=1), axis=2)
    assert edges.sum(axis=1) == pytest.approx(LENGTH, rel=1e-3)


def test_servo_log_has_the_columns_and_whole_ticks(campaign):
    header, *body = rows(campaign / "out/wave-1/servo.csv")
    groups = ("command", "position", "voltage", "load", "temperature", "error")
    assert header == ["t_s", "phase", "cycle", "step", *(f"{g}_{n}" for g in groups for n in range(1, 11))]
    assert list(dict.fromkeys(row[1] for row in body)) == ["approach", "play", "pause", "end"]
    steps = [int(row[3]) for row in body if row[1] == "play"]
    assert (steps[0], steps[-1]) == (0, 49)
    assert {row[3] for row in body if row[1] == "pause"} == {"50"}
    ticks = np.array([[float(cell) for cell in row[4:24]] for row in body]) / (2 * np.pi / 4096)
    assert np.abs(ticks - np.round(ticks)).max() < 1e-2  # six decimals of a radian


def test_power_log_is_near_standby_at_rest_and_above_it_in_motion(campaign):
    header, *body = rows(campaign / "out/wave-1/power.csv")
    assert header == ["t_s", "voltage_V", "current_A", "power_W"]
    power = np.array([float(row[3]) for row in body])
    assert power[:20].mean() == pytest.approx(6.4, abs=0.2)
    assert power.max() > 8


def test_rows_are_commanded_when_the_format_says():
    commands = schedule(50, 5.0, 2, 2.0)
    assert [c.time_s for c in commands if (c.cycle, c.step, c.phase) == (1, 10, "play")] == [pytest.approx(8.0)]
    assert [(c.time_s, c.row) for c in commands if c.phase == "pause"] == [(5.0, 0), (12.0, 0)]


def test_durations_and_repeats_become_trials():
    gait = {"name": "g", "joint_table": "g.csv", "cycle_durations_s": [4.0, 8.0]}
    protocol = Protocol.model_validate({"gait": [gait], "trials": 2, "start": {"headings_deg": [0, 120, 240]}})
    assert [(p.name, p.cycle_duration_s, p.heading_deg) for p in plans(protocol)] == [
        ("g-a-1", 4.0, 0),
        ("g-b-1", 8.0, 0),
        ("g-a-2", 4.0, 120),
        ("g-b-2", 8.0, 120),
    ]


def test_the_same_seed_gives_the_same_files(protocol_file, tmp_path):
    protocol, tables = load_protocol(protocol_file())
    for name in ("one", "two"):
        run_campaign(protocol, tables, tmp_path / name)
    for file in ("motion", "servo", "power"):
        first, second = ((tmp_path / name / f"wave-1/{file}.csv").read_bytes() for name in ("one", "two"))
        assert first == second


def test_interrupted_it_keeps_whole_trials_and_goes_on(protocol_file, tmp_path):
    source = Path(__file__).parents[2] / "src"
    command = [
        sys.executable,
        "-m",
        "serpenoid",
        "arena",
        "run",
        str(protocol_file(trials=5)),
        "--out",
        str(tmp_path / "out"),
    ]
    process = subprocess.Popen(
        [*command, "-j", "2"],
        env={**os.environ, "PYTHONPATH": str(source)},
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    while not list((tmp_path / "out").glob("wave-*")) and process.poll() is None:
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the workers, too
    error = process.communicate(timeout=30)[1]
    assert process.returncode == 130, error
    assert "run the same command to continue" in error
    assert "Traceback" not in error
    kept = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "out").glob("wave-*")}
    assert 1 <= len(kept) < 5
    assert main([*command[3:], "-j", "1"]) == 0
    assert len(tomllib.loads((tmp_path / "out/campaign.toml").read_text())["trial"]) == 5
    assert all((tmp_path / "out" / name).stat().st_mtime_ns == stamp for name, stamp in kept.items())


def test_workers_end_with_a_parent_that_was_killed(protocol_file, tmp_path):
    source = Path(__file__).parents[2] / "src"
    words = ("arena", "run", str(protocol_file(trials=8)), "--out", str(tmp_path / "out"), "-j", "2")
    process = subprocess.Popen(
        [sys.executable, "-m", "serpenoid", *words],
        env={**os.environ, "PYTHONPATH": str(source)},
        stderr=subprocess.PIPE,
        text=True,
    )
    while not list((tmp_path / "out").glob("wave-*")) and process.poll() is None:
        time.sleep(0.02)
    process.kill()
    process.communicate(timeout=20)  # returns when the last of the workers has let go of the pipe
    assert len(list((tmp_path / "out").glob("wave-*"))) < 8


def test_a_killed_run_leaves_nothing_half_written(protocol_file, tmp_path):
    protocol, tables = load_protocol(protocol_file())
    folder = run_campaign(protocol, tables, tmp_path / "out")
    (folder / ".unfinished-wave-9").mkdir()
    run_campaign(protocol, tables, folder)
    assert not list(folder.glob(".unfinished*"))


def test_another_protocol_is_not_mixed_into_a_folder(protocol_file, tmp_path):
    protocol, tables = load_protocol(protocol_file())
    folder = run_campaign(protocol, tables, tmp_path / "out")
    with pytest.raises(InputError, match="another protocol"):
        run_campaign(protocol.model_copy(update={"seed": 6}), tables, folder)
    with pytest.raises(InputError, match="not empty"):
        run_campaign(protocol, tables, tmp_path)
    (folder / ".arena.json").write_text("{")
    assert "damaged" in str(another(protocol, tables, folder))
    move_aside(folder)  # as --force does
    assert another(protocol.model_copy(update={"seed": 6}), tables, folder) is None


@pytest.mark.parametrize(
    ("extra", "message"),
    [
        ("[robot.changes.seized_weel]\nvertex = 3\n", "Did you mean `seized_wheel`"),
        ("[robot.changes.seized_wheel]\nvertex = 12\n", "vertex"),
        ("[robot]\nmass_kg = 0.5\n", "the parts weigh"),
        ('[[gait]]\nname = "wave"\njoint_table = "wave.csv"\n', "is there twice"),
        ('[[gait]]\nname = "other"\njoint_table = "none.csv"\n', "no such file"),
    ],
)
def test_a_wrong_protocol_is_refused_by_name(protocol_file, extra, message, capsys):
    assert main(["arena", "run", str(protocol_file(extra=extra))]) == 2
    assert message in capsys.readouterr().err


def test_a_table_in_degrees_is_refused_with_its_place(protocol_file, tmp_path):
    path = protocol_file()
    lines = (tmp_path / "wave.csv").read_text().splitlines()
    lines[3] = lines[3].replace(lines[3].split(",")[1], "31.5")
    (tmp_path / "wave.csv").write_text("\n".join(lines))
    with pytest.raises(InputError, match="joint_2 must be within"):
        load_protocol(path)


def test_without_mujoco_the_error_names_the_remedy(monkeypatch):
    from serpenoid.arena import mujoco_module

    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(InputError, match="pip install mujoco"):
        mujoco_module()


def test_a_spread_of_minus_zero_is_none() -> None:
    table = {"seed": 1, "gait": [{"name": "wave", "joint_table": "wave.csv"}]}
    floor, start = {"trial_variation": -0.0, "variation": -0.0}, {"heading_sd_deg": -0.0, "position_sd_m": -0.0}
    protocol = Protocol.model_validate(table | {"floor": floor, "start": start})
    spreads = (protocol.floor.trial_variation, protocol.floor.variation, protocol.start.heading_sd_deg)
    assert np.copysign(1, spreads).tolist() == [1, 1, 1]
