"""One short campaign with a weak joint and a payload, diagnosed once for all tests of what a reader sees."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write as write_campaign
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.diagnose import Diagnosis, diagnose
from serpenoid.diagnose.report.write import write
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.start import baseline

HIDDEN = (Effect("gain_loss", 3, {"loss": 0.15}), Effect("load", 2, {"share": 0.4}))
SETTINGS = 3  # gaits, two trials each


@pytest.fixture(scope="session")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("campaign")
    write_campaign(make(7, HIDDEN, "two", COMBINATIONS[:SETTINGS]), folder)
    return folder


@pytest.fixture(scope="session")
def diagnosed(campaign: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Diagnosis, dict[str, Any], Path]:
    """The diagnosis, its record, and the folder of results (no figures)."""
    file, recordings = read_recordings(campaign)
    found = diagnose(recordings, Baseline(baseline(None, file, file.body), law_open=True), lambda text: None)
    out = tmp_path_factory.mktemp("out")
    return found, write(out, file, found), out


@pytest.fixture(scope="session")
def healthy(tmp_path_factory: pytest.TempPathFactory) -> tuple[tuple[Recording, ...], Baseline]:
    """Recordings of a healthy robot, and the baseline."""
    folder = tmp_path_factory.mktemp("healthy")
    write_campaign(make(5, (), "null", COMBINATIONS[:2]), folder)
    file, recordings = read_recordings(folder)
    return recordings, Baseline(baseline(None, file, file.body))
