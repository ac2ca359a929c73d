"""The extended model: what is named, and what is too weak to be named where held-out paths need it."""

from __future__ import annotations

from pathlib import Path

import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write as write_campaign
from serpenoid.diagnose.data.noise.paths import total
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.diagnose import Diagnosis, diagnose
from serpenoid.diagnose.inference.fits.held_out import held_out
from serpenoid.diagnose.inference.search.names import trace
from serpenoid.diagnose.record import record
from serpenoid.diagnose.report.write import PREDICTION, role, write
from serpenoid.diagnose.residuals.gain import scores
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.start import baseline
from serpenoid.effects.active import ActiveEffect
from serpenoid.medium import Medium
from serpenoid.model_file import read_model_file, write_model_file

SLOPE = Effect("slope", None, {"pull_x": 0.004, "pull_y": 0.002})
SMALL_LOAD = Effect("load", 2, {"share": 0.005})


def diagnosed(folder: Path, *effects: Effect, gaits: int = 4) -> Diagnosis:
    write_campaign(make(11, effects, "c", COMBINATIONS[:gaits]), folder)
    file, recordings = read_recordings(folder)
    found = diagnose(recordings, Baseline(baseline(None, file, file.body)), lambda text: None)
    write(folder / "out", file, found)
    return found


def test_a_model_file_says_which_laws_are_named_and_which_only_predict(tmp_path: Path) -> None:
    effects = [ActiveEffect.typical("slope"), ActiveEffect.typical("load", 2), ActiveEffect.typical("load", 3)]
    named = [{"name": "slope", "place": None, "stand_in": True}]
    notes = [role(e, named, {effects[2].key}) for e in effects]
    assert notes == ["named, perhaps a stand-in", PREDICTION, "known before"]
    write_model_file(tmp_path / "m.toml", Medium(anisotropy_ratio=0.1), effects, notes=notes)
    text = (tmp_path / "m.toml").read_text(encoding="utf-8")
    assert f'# {PREDICTION}\n[[effects]]\nname = "load"\nplace = 2' in text
    assert len(read_model_file(tmp_path / "m.toml")["effects"]) == 3


@pytest.mark.slow
def test_a_load_too_weak_to_be_named_is_in_the_extended_model(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, SLOPE, SMALL_LOAD)
    assert [n.effect.name for n in found.named] == ["slope"]
    (load,) = (e for e in found.extension.effects if e.key == ("load", 2))
    assert load.parameters["share"] == pytest.approx(SMALL_LOAD.parameters["share"], rel=0.5)
    (listed,) = record(found)["below_detection"]
    assert (listed["name"], listed["place"], listed["in_extended_model"]) == ("load", 2, True)
    written = read_model_file(tmp_path / "out" / "extended-model.toml")["effects"]
    assert {(e["name"], e.get("place")) for e in written} == {("slope", None), ("load", 2)}
    motion = found.motion.selection.motion
    named_alone = scores(motion, held_out(motion, found.motion.selection.best))
    assert total(list(found.after.path)) < 0.9 * total(list(named_alone.path))


def test_where_nothing_is_named_the_extended_model_is_the_baseline(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, SMALL_LOAD, gaits=1)
    assert found.verdict == "nothing"
    assert found.model.effects == ()
    assert [e["in_extended_model"] for e in record(found)["below_detection"]] == [False]


@pytest.mark.slow
def test_what_paths_are_off_by_from_where_they_were_begun_has_a_name(tmp_path: Path) -> None:
    """An error of heading grows along a path, which start poses fitted anew hide: without it paths stray by more than
    chance makes, so "nothing" would not be true."""
    found = diagnosed(tmp_path, Effect("load", 2, {"share": 0.009}))
    (load,) = found.named
    selection = found.motion.selection
    assert trace(selection.motion, selection.best, selection.bases[0], load.effect) < selection.noise_level_m
    assert load.strength > 1
    low, high = load.intervals["share"]
    assert low is not None
    assert high is not None
    assert low < 0.009 < high
