"""A film from which frames are missing though its clock says otherwise, beside a servo log that goes on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rehearsal import serpenoid_table, snake
from serpenoid.compare.rehearse import Laboratory, write_campaign
from serpenoid.measure.campaign import load_campaign_file
from serpenoid.measure.consistency.check import check
from serpenoid.measure.consistency.claim import Claim
from serpenoid.measure.consistency.claims import believe
from serpenoid.measure.consistency.lost_frames import lost_frames
from serpenoid.measure.consistency.signals import Signal
from serpenoid.measure.load import align_trial
from serpenoid.measure.trial_files import Files, read_files

RATE, LAG = 50.0, 0.04


def angles(time: np.ndarray) -> np.ndarray:
    """Two cycles of 3 s with pauses of 1 s, of four joints (F, 4); at rest before and after."""
    phase = np.clip(np.stack([time - 1.0, time - 5.0]), 0.0, 3.0).sum(axis=0) / 3.0
    return 0.6 * np.sin(2 * np.pi * (phase[:, None] + np.arange(4) / 5))


def witnesses(lost: slice | list[int] | None, rate: float = 0.0, seed: int = 0) -> tuple[Signal, Signal]:
    """Film and log, each with noise, on clocks of their own; frames lost without a word."""
    rng, true = np.random.default_rng(seed), np.arange(0, 10, 1 / RATE)
    kept = np.ones(len(true), dtype=bool)
    if lost is not None:
        kept[lost] = False
    seen = angles(true[kept] - LAG) + rng.normal(scale=4e-3, size=(kept.sum(), 4))
    log_s = np.arange(0, 10, 0.02)
    read = np.round(angles(log_s) / 1.5e-3) * 1.5e-3
    return Signal(1e9 + (1 + rate) * np.arange(kept.sum()) / RATE, seen), Signal(log_s + 4.63, read)


@pytest.mark.parametrize(("first", "count"), [(100, 25), (130, 10), (300, 40)])
def test_frames_that_were_lost_without_a_word_are_told_with_place_and_time(first, count):
    (found,) = lost_frames(*witnesses(slice(first, first + count)))
    assert found.at_s - 1e9 == pytest.approx(first / RATE, abs=0.1)
    assert found.seconds == pytest.approx(count / RATE, abs=0.003)  # angles' noise 4e-3 rad, at 1 rad/s, of 100 rows


@pytest.mark.parametrize("rate", [0.0, 0.01, -0.02])
def test_clocks_that_run_at_different_rates_have_lost_nothing(rate):
    assert all(not lost_frames(*witnesses(None, rate, seed)) for seed in range(5))


def test_places_are_looked_for_only_where_some_could_be_evidence_enough(monkeypatch):
    monkeypatch.setattr("serpenoid.measure.consistency.lost_frames._stepped", lambda costs, most: pytest.fail("asked"))
    assert not lost_frames(*witnesses(None))


def test_a_trial_with_lost_frames_is_remarked_on_and_no_other():
    films = {"whole": None, "torn": slice(130, 150)}
    claims = [Claim(name, "table", None, *witnesses(lost)) for name, lost in films.items()]
    ((trial, said),) = check(claims, {}).remarks
    assert trial == "torn"
    assert "0.4 s are missing from the film near 1000000002.6 s" in said


def test_every_place_of_several_is_told():
    lost = [*range(90, 110), *range(150, 170), *range(330, 350)]
    found = lost_frames(*witnesses(lost))
    assert [one.at_s - 1e9 for one in found] == pytest.approx([90 / RATE, 130 / RATE, 290 / RATE], abs=0.06)
    assert [one.seconds for one in found] == pytest.approx([0.4] * 3, abs=0.005)


def torn(files: Files, first: int, count: int) -> Files:
    """Frames taken out without a word."""
    assert files.tracks is not None
    assert files.labelled is not None
    kept = np.delete(np.arange(len(files.tracks.time_s)), slice(first, first + count))
    tracks = replace(files.tracks, time_s=files.tracks.time_s[: len(kept)], floor=files.tracks.floor[kept], space=None)
    return replace(files, tracks=tracks, labelled=replace(files.labelled, vertices=files.labelled.vertices[kept]))


@pytest.mark.usefixtures("virtual_machine")
def test_a_torn_film_goes_on_where_the_log_does_unless_it_is_believed(tmp_path):
    lab = Laboratory(frames_per_second=50.0, lag_s=0.05)
    times = {"cycle_duration_s": 3.0, "cycles": 2, "pause_s": 1.0}
    write_campaign(tmp_path, snake(), {"g": serpenoid_table(40)}, lab, 1, 0, **times)
    file, folder = load_campaign_file(tmp_path)
    body, (whole,) = read_files(file, folder)
    part = torn(whole, 150, 20)
    ((mended,), said) = believe(file, folder, body, [part])
    assert "0.4 s are missing" in said[whole.entry.name][0].words
    assert np.allclose(mended.tracks.time_s[160:], whole.tracks.time_s[180 : 20 + len(mended.tracks.time_s)], atol=3e-3)
    aligned, plain = align_trial(file, mended, body), align_trial(file, whole, body)
    assert aligned.servo.offset.offset_s == pytest.approx(plain.servo.offset.offset_s, abs=2e-3)
    assert [len(trial.passages) for trial in (aligned, plain)] == [2, 2]
    believed = replace(part, entry=part.entry.model_copy(update={"believe": True}))
    ((same,), said) = believe(file, folder, body, [believed])
    assert same is believed
    assert "0.4 s are missing" in said[whole.entry.name][0].words
