"""A marker that peels off, and a horn that slips a little in each trial, are told with their own values and from each
other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.folder import write
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.markers_by_trial import put_back
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.geometry import register, shapes, turn
from serpenoid.diagnose.stages.by_trial import two_values
from serpenoid.diagnose.stages.observation.looked import Looked
from serpenoid.diagnose.stages.observation.marker_evidence import sample
from serpenoid.diagnose.stages.observation.seen_by_trial import seen_by_trial, slipping

FITS = 6


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> tuple[Recording, ...]:
    folder = tmp_path_factory.mktemp("films")
    write(make(72, [], combinations=COMBINATIONS[:2]), folder)
    return read_recordings(folder)[1]


def looked(recordings: tuple[Recording, ...]) -> Looked:
    neutral = Observation.neutral(recordings[0].body)
    return Looked(sample(recordings), neutral, neutral)


def peeling(r: Recording, along: float, left: float) -> Recording:
    """The marker at vertex 5 beside its place on the link behind it."""
    link = r.markers[:, 5] - r.markers[:, 4]
    unit = link / np.linalg.norm(link, axis=1, keepdims=True)
    moved = r.markers.copy()
    moved[:, 5] += along * unit + left * np.stack([-unit[:, 1], unit[:, 0]], axis=1)
    return replace(r, markers=moved)


def slipped(r: Recording, angle: float) -> Recording:
    """Joint 5 bent beyond its reading."""
    pose = register(shapes(r.body, r.angles), r.markers)[0]
    bent = r.angles + angle * (np.arange(r.angles.shape[1]) == 4)
    return replace(r, markers=r.markers + turn(pose[:, None, 2], shapes(r.body, bent) - shapes(r.body, r.angles)))


def test_a_marker_that_peels_off_is_told_with_its_way(recordings: tuple[Recording, ...]) -> None:
    shares = np.linspace(0, 1, len(recordings))
    found = tuple(peeling(r, 0.004 * x, -0.012 * x) for r, x in zip(recordings, shares, strict=True))
    by_trial = seen_by_trial(found, looked(found), FITS)
    assert by_trial is not None
    told, alone = by_trial.told, by_trial.models
    assert told.steady
    assert told.called == ("marker_offset at vertex 5",)
    first, last = recordings[0].name, recordings[-1].name
    assert told.words.startswith("marker_offset at vertex 5 changes steadily from trial to trial: along ")
    ends = [float(part.split()[0]) for part in told.words.split(f" mm in `{first}`, ")[1:]]
    assert ends == pytest.approx([4, -12], abs=0.3)
    assert told.words.endswith(f" mm in `{last}`")
    mended = put_back(found, Observation.neutral(found[0].body), alone)
    off = [np.nanmax(np.abs(m.markers - r.markers)) for m, r in zip(mended, recordings, strict=True)]
    assert max(off) < 5e-4  # of 13 mm, as well as some hundred frames tell it


def test_a_horn_that_slips_is_no_marker(recordings: tuple[Recording, ...]) -> None:
    shares = np.linspace(0, 1, len(recordings))
    found = tuple(slipped(r, 0.15 * x) for r, x in zip(recordings, shares, strict=True))
    by_trial = seen_by_trial(found, looked(found), FITS)
    assert by_trial is not None
    told, alone = by_trial.told, by_trial.models
    assert put_back(found, Observation.neutral(found[0].body), alone) == found  # joints are bent: no matter of markers
    assert told.called == ("zero_offset at joint 5",)
    assert f"0.15 rad in `{recordings[-1].name}`" in told.words


def test_a_step_is_no_steady_change_and_what_all_trials_share_or_none_shows_is_not_told(
    recordings: tuple[Recording, ...],
) -> None:
    half = tuple(peeling(r, 0.0, 0.01 * (i > 1)) for i, r in enumerate(recordings))
    stepped = seen_by_trial(half, looked(half), FITS)
    assert stepped is not None
    assert not stepped.told.steady
    assert "marker_offset at vertex 5 differs from trial to trial" in stepped.told.words
    names = tuple(r.name for r in recordings)
    assert (stepped.divided.changed, stepped.divided.others) == (names[2:], names[:2])
    where = f"marker_offset at vertex 5 is another in `{names[2]}` and `{names[3]}`: along "
    assert stepped.divided.words.startswith(where)
    assert float(stepped.divided.words.split(" mm there, ")[1].split()[-1]) == pytest.approx(10, abs=0.3)
    assert seen_by_trial(recordings, looked(recordings), FITS) is None
    assert seen_by_trial(recordings[:3], looked(recordings[:3]), FITS) is None


def test_values_on_a_line_are_no_two_and_of_two_the_larger_ones_act() -> None:
    line = np.linspace(0, 1, 12)[:, None] * [[3.0, -4.0]]
    assert two_values(line) is None
    scattered = np.random.default_rng(3).normal(size=(12, 2))
    assert two_values(scattered) is None
    some = np.array([0, 0, 1, 1, 0, 1], dtype=bool)
    both = 0.05 * np.random.default_rng(4).normal(size=(6, 2)) + np.where(some[:, None], [-4.0, 1.0], 0.0)
    assert two_values(both) == some.tolist()
    assert two_values(both - [-4.0, 1.0]) == (~some).tolist()
    assert two_values(np.array([[0.0], [0.1], [5.0], [-0.1]])) == [False, False, True, False]


def test_what_only_mends_a_marker_that_slips_is_taken_out_at_its_place(recordings: tuple[Recording, ...]) -> None:
    """Both offsets of one marker in all trials, which nothing but its way from trial to trial tells apart."""
    shares = np.linspace(0, 1, len(recordings))
    found = tuple(peeling(r, -0.004 * x, 0.01 * x) for r, x in zip(recordings, shares, strict=True))
    bare = looked(found)
    both = bare.beside(("marker_offset", 5)).beside(("marker_offset_ahead", 5))
    best, told = slipping(found, both, FITS)
    assert told is not None
    assert best.keys == ()
    assert told.key == ("marker_offset", 5)
    elsewhere = bare.beside(("marker_offset", 2))
    assert slipping(found, elsewhere, FITS)[0] is elsewhere
