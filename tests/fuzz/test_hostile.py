"""Whole commands against what hurts: pipes, devices, endless nesting, sizes beyond reason, names that climb out."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import serpenoid as sp
from fuzz.specimens import CAMPAIGN
from serpenoid.cli.main import main
from serpenoid.errors import InputError
from serpenoid.measure.campaign import load_campaign_file

REFERENCE = str(Path(__file__).parents[2] / "problems" / "reference.toml")


def refused(words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("device", ["/dev/zero", "/dev/random", "pipe"])
def test_only_regular_files_are_read(device: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = Path(device)
    if device == "pipe":
        path = tmp_path / device
        os.mkfifo(path)
    refused(["simulate", str(path)], f"{path}: is a pipe or a device, not a file", capsys)


@pytest.mark.parametrize("text", ["a = " + "[" * 5000 + "]" * 5000, "[a" + ".a" * 3000 + "]", "a = " + "9" * 9000])
def test_nesting_and_endless_numbers_are_refused(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "deep.toml").write_text(text)
    refused(["simulate", str(tmp_path / "deep.toml")], "deep.toml: ", capsys)


@pytest.mark.parametrize(
    ("assignment", "key"),
    [
        ("task.cycles=1000000000", "[task] cycles"),
        ("task.cycles=100000", "task.steps * task.cycles * body.vertices must be at most"),
        ("body.vertices=2000", "[body] vertices"),
        ('body.vertices="5"', "[body] vertices: Input should be a valid integer"),
        ("body.vertices=true", "[body] vertices: Input should be a valid integer"),
        ("body.length_m=1e308", "[body] length_m"),
        ("task.constraints.spatial_frequency=9", "spatial_frequency 9 is outside task.bounds.xi"),
    ],
)
def test_every_size_has_a_bound_with_its_name(assignment: str, key: str, capsys: pytest.CaptureFixture[str]) -> None:
    refused(["simulate", REFERENCE, "--set", assignment], key, capsys)


def test_a_sweep_of_a_thousand_million_points_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    refused(["sweep", REFERENCE, "--c", "0:2.5:1000000000"], "must be at most 10000 values", capsys)


@pytest.mark.parametrize("key", ["name", "gait"])
@pytest.mark.parametrize(
    "name", ["x/../../../PWNED", "..", ".hidden", "a\\\\b", "a\\u0000b", "a\\nb", "<b>", "$x$", "@TABLE@", "", "x" * 61]
)
def test_no_name_that_becomes_a_path_is_anything_but_a_name(key: str, name: str, tmp_path: Path) -> None:
    old = 'name = "one-1"' if key == "name" else 'gait = "one"'
    path = tmp_path / "campaign.toml"
    path.write_text(CAMPAIGN.replace(old, f'{key} = "{name}"', 1))
    with pytest.raises(InputError, match=rf"{key}: must be letters, digits, spaces and"):
        load_campaign_file(path)


def test_a_byte_order_mark_is_no_matter(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "marked.toml"
    path.write_bytes(b"\xef\xbb\xbf" + Path(REFERENCE).read_bytes())
    assert main(["simulate", str(path), "--no-figures", "--quiet", "--out", str(tmp_path / "out")]) == 0


@pytest.mark.parametrize("shell", [">&-", "> /dev/full"])
def test_output_that_cannot_be_printed_is_said_in_a_sentence(shell: str, tmp_path: Path) -> None:
    command = f"{sys.executable} -m serpenoid simulate {REFERENCE} --no-figures --out {tmp_path / 'out'} {shell}"
    ended = subprocess.run(command, shell=True, stderr=subprocess.PIPE, text=True, timeout=90, check=False)
    assert ended.returncode in (1, 2)
    *before, said = ended.stderr.splitlines()
    assert said.startswith("serpenoid: standard output")
    assert all(line.startswith("simulating") for line in before)  # the bar of progress


@pytest.mark.parametrize("family", ["nan", "[]", "{}"])
def test_a_family_that_is_no_word_is_refused_and_not_passed_over(
    family: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = Path(REFERENCE).read_text().replace("[gait]", f"[gait]\nfamily = {family}", 1)
    text = "\n".join(line for line in text.split("\n") if not line.startswith('family = "'))
    (tmp_path / "odd.toml").write_text(text)
    refused(["simulate", str(tmp_path / "odd.toml")], "odd.toml: [gait] family: must be one of", capsys)


def test_a_value_that_ends_options_is_no_value(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["sweep", REFERENCE, "--c=--"])
    assert ended.value.code == 2
    assert "argument --c: expected one argument" in capsys.readouterr().err


def test_a_file_without_a_name_is_none(tmp_path: Path) -> None:
    path = tmp_path / "campaign.toml"
    path.write_text(CAMPAIGN.replace('motion = "motion.csv"', 'motion = ""', 1))
    with pytest.raises(InputError, match=r"campaign\.toml: \[\[trial\]\] 1 motion: must name a file"):
        load_campaign_file(path)


def test_trials_of_a_record_that_are_no_list_are_a_line_of_the_table(tmp_path: Path) -> None:
    (tmp_path / "campaign.json").write_text('{"trials": null}')
    assert main(["table", str(tmp_path), "--out", str(tmp_path / "runs.csv"), "--quiet"]) == 1
    assert "campaign.json: `trials` must be a list" in (tmp_path / "runs.csv").read_text()


@pytest.mark.parametrize("line", ["cycle_duration_s = 1e-308", "speed_limit_rpm = 1e-308"])
def test_speeds_beyond_all_numbers_are_refused(line: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot = Path(REFERENCE).parent / "robots" / "snake10-robot.toml"
    key = line.split(" ", 1)[0]
    path = tmp_path / "robot.toml"
    path.write_text(re.sub(rf"{key} = [0-9.]+", line, robot.read_text(), count=1))
    refused(["robot", "check", str(tmp_path), "--robot", str(path)], f"{key}: Input should be greater than", capsys)


@pytest.mark.parametrize(
    ("reference", "said"),
    [("worm", "has tracked points alone: no robot can be compared with it"), ("", "'': no such file or folder")],
)
def test_what_is_no_reference_is_refused_before_anything_is_diagnosed(
    reference: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "campaign.toml").write_text(CAMPAIGN)
    worm = str(Path(REFERENCE).parent / "campaigns" / "worm.toml")
    given = worm if reference else ""
    refused(["diagnose", str(tmp_path), "--reference", given, "--out", str(tmp_path / "out")], said, capsys)


@pytest.mark.parametrize("reference", ["worm", "robot"])
def test_an_animal_has_no_reference_and_is_refused_before_anything_is_diagnosed(
    reference: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "campaign.toml").write_text(CAMPAIGN)
    worm = str(Path(REFERENCE).parent / "campaigns" / "worm.toml")
    given = worm if reference == "worm" else str(tmp_path)
    said = "no other campaign repeats its shapes. Leave --reference out"
    refused(["diagnose", worm, "--reference", given, "--out", str(tmp_path / "out")], said, capsys)
    with pytest.raises(InputError, match=r"repeats its shapes\. Leave reference out"):
        sp.diagnose(worm, reference=given)
