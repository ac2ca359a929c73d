"""What a diagnosis is made from: finished work found again, contradictions refused, every stretch of a film used."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from blind.ground import Ground
from blind.swimmers import Swimmer, write
from serpenoid.cli.main import main
from serpenoid.diagnose.campaign import diagnose_campaign
from serpenoid.diagnose.data.tracked import PARTS, tracked_recordings, tracker
from serpenoid.diagnose.data.used import remarks, used
from serpenoid.diagnose.diagnose import Diagnosis
from serpenoid.diagnose.record import record
from serpenoid.errors import InputError
from serpenoid.files import store
from serpenoid.measure.load import load_campaign
from serpenoid.medium import Medium
from serpenoid.model import Model

Diagnosed = tuple[Diagnosis, dict[str, Any], Path]


def test_begun_again_no_fit_is_made_twice_and_the_answer_is_the_same(campaign: Path, diagnosed: Diagnosed) -> None:
    before = _kept()
    again = diagnose_campaign(campaign)[1]
    after = _kept()
    assert before
    assert all(after.get(path, number) == number for path, number in before.items())  # others add and clear away theirs
    assert record(again) == record(diagnosed[0])


def _kept() -> dict[Path, int]:
    return {path: path.stat().st_ino for path in store.folder().glob("[!.]*.work")}


def test_the_answer_without_an_effect_does_not_take_the_place_of_the_whole_one(
    campaign: Path, diagnosed: Diagnosed, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["diagnose", str(campaign), "--out", str(tmp_path / "out"), "--no-figures", "--quiet"]
    assert main(words) == 0  # from fits that are kept
    assert main([*words, "--without", "worn_wheel"]) == 2
    assert "holds the answer of another `diagnose`" in capsys.readouterr().err


def test_every_second_of_whole_windows_is_used_and_said(diagnosed: Diagnosed) -> None:
    tracks = diagnosed[0].motion.selection.motion.tracks
    promised = sum(track.recording.promised_s for track in tracks)
    assert used(tracks).used_s + used(tracks).dropped_s == pytest.approx(promised)
    assert used(tracks).used_s > 0.9 * promised  # a few windows have markers hidden at their ends
    assert diagnosed[1]["used_s"] == used(tracks).used_s


def test_a_campaign_that_contradicts_itself_is_not_diagnosed(campaign: Path, tmp_path: Path) -> None:
    folder = tmp_path / "campaign"
    shutil.copytree(campaign, folder)
    text = (folder / "campaign.toml").read_text()
    first, second = sorted({line for line in text.splitlines() if line.startswith("joint_table")})[:2]
    (folder / "campaign.toml").write_text(text.replace(first, second, 1))
    with pytest.raises(InputError, match="trial `gait01-a-1`.*follow.*not.*Remedy: name"):
        diagnose_campaign(folder)


@pytest.fixture(scope="module")
def holed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A swimmer filmed with a hole of a second in the middle."""
    folder = write(Swimmer(Ground(0.6), 63), tmp_path_factory.mktemp("swim"))
    header, *rows = (folder / "motion.csv").read_text().splitlines()
    middle = len(rows) // 2
    time = np.array([float(row.split(",")[0]) for row in rows])
    hidden = np.abs(time - time[middle]) < 0.5
    kept = [row.split(",")[0] + "," * row.count(",") if h else row for row, h in zip(rows, hidden, strict=True)]
    (folder / "motion.csv").write_text("\n".join([header, *kept]) + "\n")
    return folder


def test_a_hole_cuts_a_film_in_two_and_both_sides_are_used(holed: Path) -> None:
    (trial,) = load_campaign(holed).trials
    pieces = tracked_recordings(load_campaign(holed))
    assert [piece.name.partition(",")[0] for piece in pieces] == ["swim", "swim"]
    assert len({piece.name for piece in pieces}) == 2
    assert trial.motion is not None
    whole = trial.motion.time_s[-1] - trial.motion.time_s[0]
    assert sum(piece.promised_s for piece in pieces) == pytest.approx(whole)
    tracks = tracker(pieces)(Model(pieces[0].body, Medium(anisotropy_ratio=0.6, dissipation="vertex")))
    assert len(tracks) >= PARTS
    assert used(tracks).used_s > whole - 1.0 - 0.3 * whole  # the hole, and what is left over of whole windows
    assert 1.0 <= used(tracks).dropped_s < 1.0 + 0.3 * whole
    assert all(text.startswith("swim") for text in remarks(tracks))
