"""What servos were told and did: set-points in every way to take them, shapes about them, names that are earned."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from scipy.stats import norm

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from blind.protocol import Protocol, usual, with_joints
from blind.schedule import lagged, rate_limited
from serpenoid.body import Body
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import UNSURE_CYCLE, Recording
from serpenoid.diagnose.data.shapes.course import Course
from serpenoid.diagnose.data.shapes.shape_in_time import Source, fitted
from serpenoid.diagnose.diagnose import verdict
from serpenoid.diagnose.inference.fits.finding import Named, Stage
from serpenoid.diagnose.inference.fits.prices import Priced, cheapest, earned, outweighed
from serpenoid.diagnose.stages.actuation.actuation_by_joint import fit_everywhere
from serpenoid.diagnose.stages.actuation.actuation_refit import refined
from serpenoid.diagnose.stages.actuation.actuation_search import Played
from serpenoid.diagnose.stages.actuation.choose_actuation import choose_actuation, noise_at_rest, off_by_rounding
from serpenoid.diagnose.stages.actuation.choose_set_points import plays
from serpenoid.diagnose.stages.actuation.expected import carried
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.observation.witness import WrongLog, _said, of_servos, unlike_told
from serpenoid.effects.active import ActiveEffect
from serpenoid.measure.logs import TICK
from serpenoid.measure.shapes.links import chain_vertices
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.simulation.servos import readings_of_each, realise_all

SEED, JOINTS = 71, 6


def protocol(gaits: int) -> Protocol:
    return with_joints(usual(SEED, COMBINATIONS[:gaits]), JOINTS)


def healthy(folder: Path, gaits: int) -> tuple[Recording, ...]:
    write(make(SEED, [], protocol=protocol(gaits)), folder)
    return read_recordings(folder)[1]


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> tuple[Recording, ...]:
    """Two trials of one gait."""
    return healthy(tmp_path_factory.mktemp("servos"), 1)


@pytest.fixture(scope="module")
def four(tmp_path_factory: pytest.TempPathFactory) -> tuple[Recording, ...]:
    """Two trials of each of two gaits."""
    return healthy(tmp_path_factory.mktemp("four"), 2)


def test_shapes_about_what_is_commanded_keep_corners_and_cross_a_hole() -> None:
    rng, time = np.random.default_rng(0), np.arange(0, 8, 1 / 60)
    corners = np.arange(0, 8.01, 0.25)
    course = Course(corners, np.sin(2 * np.pi * corners / 2)[:, None])  # eight rows a cycle of two seconds
    off, noise = 0.05, 0.01
    seen = course.at(time) + off + noise * rng.normal(size=(len(time), 1))
    seen[(time > 3) & (time < 4)] = np.nan
    source = Source.of(time, seen, np.full(1, noise))
    about, plain = (fitted([source], np.empty(0), 0.072, True, c) for c in (course, None))
    wrong = [np.abs(shape.at(time) - off - course.at(time)).max() for shape in (about, plain)]
    assert wrong[0] < noise  # a constant, known from four hundred readings
    assert wrong[1] > 5 * noise  # half a cycle is guessed


def test_what_a_joint_is_told_is_believed_unless_readings_exclude_it() -> None:
    """Of forty joints in noise twelve times their swing each does as it is told; one that stands still while others
    swing by as much as the noise does not."""
    rng, time = np.random.default_rng(5), np.arange(0, 6, 1 / 60)
    wave = np.sin(2 * np.pi * (time[:, None] / 2 + np.arange(40) / 40))
    for swing, dead in ((1 / 12, []), (1.0, [7])):
        course = Course(time, swing * wave)
        done = np.where(np.isin(np.arange(40), dead), 0.0, course.angles)
        source = Source.of(time, done + rng.normal(size=done.shape), np.full(40, 1e-3))
        shape = fitted([source], np.empty(0), 0.072, True, course)
        assert shape.carrier is not None
        np.testing.assert_array_equal(~shape.carrier.angles.any(axis=0), np.isin(np.arange(40), dead))


def test_healthy_servos_carry_their_shapes_and_have_no_names(recordings: tuple[Recording, ...]) -> None:
    data = plays(recordings)
    assert not data.held
    assert not data.told
    stage = choose_actuation(data)
    assert not stage.named
    assert stage.settled
    # rounding and a flicker of 0.4 ticks
    np.testing.assert_allclose(data.noise, TICK * np.sqrt(1 / 12 + 0.4**2), rtol=0.1)
    shapes = [r.shape.carrier for r in carried(recordings, data, [])]
    assert all(c is not None and c.angles.any(axis=0).all() for c in shapes)


def test_an_effect_that_every_joint_has_is_tried_nowhere_else(recordings: tuple[Recording, ...]) -> None:
    data = plays(recordings)
    base = [ActiveEffect.typical("gain_loss", joint + 1) for joint in range(data.readings.shape[1])]
    start = np.zeros(data.readings.shape[1])
    assert fit_everywhere(data, "gain_loss", base, [start]) == []
    assert len(fit_everywhere(data, "gain_loss", base[1:], [start])) == 1


def test_a_joint_that_never_moves_is_stuck_and_has_no_gap_that_it_never_crosses(tmp_path: Path) -> None:
    """A gap wider than all that is commanded leaves a joint where it was, and may be any wider."""
    write(make(SEED, [Effect("stuck_joint", 4, {"angle": 0.1})], protocol=protocol(1)), tmp_path)
    data = plays(read_recordings(tmp_path)[1])
    bare = float(data.chi2(data.realised([])).sum())
    wide = np.full(data.readings.shape[1], 2.0)
    (gap,) = (a for a in fit_everywhere(data, "backlash", [], [wide]) if a.effect.place == 4)
    assert data.chi2(data.realised([gap.effect])).sum() < bare / 1000  # it reads what it read before, as a stuck one
    assert gap.chi2.sum() == pytest.approx(bare)
    (named,) = choose_actuation(data).named
    assert named.effect.key == ("stuck_joint", 4)


def test_commands_that_were_sent_late_are_taken_from_the_log(recordings: tuple[Recording, ...]) -> None:
    rng, late = np.random.default_rng(1), 0.15  # s, at most: every third of a second another delay

    def delayed(r: Recording) -> Recording:
        delay = late * rng.uniform(size=1000)[(r.read_at * 3).astype(int)]
        told = r.schedule.commanded(r.read_at - delay)
        return replace(r, commands=told, position=np.round(told / TICK) * TICK)

    data = plays([delayed(r) for r in recordings])
    assert data.told
    assert choose_actuation(data).settled


@pytest.mark.slow
def test_a_saturation_of_rows_that_jump_is_named_alone(tmp_path: Path) -> None:
    hidden = Effect("speed_saturation", None, {"max_speed": 0.6})
    write(make(SEED, [hidden], protocol=replace(protocol(2), held=True)), tmp_path)
    data = plays(read_recordings(tmp_path)[1])
    assert data.held
    (named,) = choose_actuation(data).named
    assert named.effect.name == hidden.name
    low, high = named.intervals["max_speed"]
    assert low is not None
    assert high is not None
    assert low < 0.6 < high


def test_servos_that_lag_by_less_than_a_reading_where_rows_jump_are_no_noise(tmp_path: Path) -> None:
    """A reading after each jump is off by a row: a scatter of four ticks, within which all joints were followed."""
    hidden = Effect("servo_lag", None, {"lag": 0.005})
    write(make(SEED, [hidden], protocol=replace(protocol(1), held=True)), tmp_path)
    data = plays(read_recordings(tmp_path)[1])
    assert data.held
    np.testing.assert_array_less(data.noise, TICK)
    (named,) = choose_actuation(data).named
    assert named.effect.key == (hidden.name, None)
    low, high = named.intervals["lag"]
    assert low is not None
    assert high is not None
    assert low < 0.005 < high


@pytest.mark.parametrize(
    ("name", "place", "late"),
    [pytest.param("servo_lag", None, 0.12, marks=pytest.mark.slow), ("lagging_joint", 4, 0.02)],
)
def test_a_lag_is_told_from_a_late_start_where_nothing_says_when_a_trial_began(
    recordings: tuple[Recording, ...], name: str, place: int | None, late: float
) -> None:
    rng, lag, noise = np.random.default_rng(2), 0.15, 0.01
    lags = slice(None) if place is None else [place - 1]

    def filmed(r: Recording) -> Recording:
        true = r.schedule.commanded(r.read_at + late)  # laid over the table where it looks most alike: later
        true[:, lags] = lagged(r.read_at, true[:, lags], np.full(len(true) - 1, lag))
        unsure = UNSURE_CYCLE * r.schedule.cycle_duration_s
        return replace(r, position=true + noise * rng.normal(size=true.shape), by_servos=False, t0_spread=unsure)

    stage = choose_actuation(plays([filmed(r) for r in recordings]))
    assert stage.settled
    (named,) = stage.named
    assert named.effect.key == (name, place)
    low, high = named.intervals["lag"]
    assert low is not None
    assert high is not None
    assert low < lag < high
    assert high - low < 0.2 * lag


def filmed(r: Recording, change: Callable[[np.ndarray, np.ndarray], np.ndarray], noise: float) -> Recording:
    """Without a log: what joints do of what they are told (time, angles), as markers show it, with a noise [rad]."""
    rng = np.random.default_rng(9)
    true = change(r.read_at, r.schedule.commanded(r.read_at + 0.02))
    unsure = UNSURE_CYCLE * r.schedule.cycle_duration_s
    return replace(r, position=true + noise * rng.normal(size=true.shape), by_servos=False, t0_spread=unsure)


@pytest.mark.slow
def test_a_zero_that_is_off_hides_no_other_fault_of_what_markers_show(four: tuple[Recording, ...]) -> None:
    def change(time: np.ndarray, told: np.ndarray) -> np.ndarray:
        return told * [1, 1, 1, 1, 0.8, 1] + [0, 0.15, 0, 0, 0, -0.1]

    stage = choose_actuation(plays([filmed(r, change, 0.01) for r in four]))
    (named,) = stage.named
    assert named.effect.key == ("gain_loss", 5)
    assert named.effect.parameters["loss"] == pytest.approx(0.2, abs=0.01)
    assert [re.findall(r"joint (\d).*?([-+][\d.]+) degrees", w) for w in stage.words] == [
        [("2", "+8.6")], [("6", "-5.7")]
    ]  # fmt: skip
    assert stage.left > 5


@pytest.mark.slow
def test_a_lag_that_hides_in_the_noise_of_markers_is_played_all_the_same(four: tuple[Recording, ...]) -> None:
    """It moves paths by far more than their noise: shapes are splines about what servos are expected to do."""
    lag = 0.05

    def change(time: np.ndarray, told: np.ndarray) -> np.ndarray:
        return lagged(time, told, np.full(len(time) - 1, lag))

    stage = choose_actuation(plays([filmed(r, change, 0.03) for r in four]))
    assert stage.settled
    assert not stage.named
    (found,) = stage.undetected
    assert found.effect.key == ("servo_lag", None)
    low, high = found.intervals["lag"]
    assert low is not None
    assert high is not None
    assert 0.02 < low < lag < high


@pytest.mark.slow
def test_a_candidate_that_does_nothing_alone_ends_no_search(four: tuple[Recording, ...]) -> None:
    """Beside the beginnings that all joints' fits together make, the quickest joint seems to be explained."""
    lags = np.array([0.25, 0.1, 0.25, 0.03, 0.2, 0.15])

    def change(time: np.ndarray, told: np.ndarray) -> np.ndarray:
        columns = [lagged(time, told[:, [j]], np.full(len(time) - 1, lag)) for j, lag in enumerate(lags)]
        return np.concatenate(columns, axis=1)

    stage = choose_actuation(plays([filmed(r, change, 0.003) for r in four]))
    assert [n.effect.key for n in sorted(stage.named, key=lambda n: n.effect.place or 0)] == [
        ("lagging_joint", joint + 1) for joint in range(len(lags))
    ]
    for n in stage.named:
        assert n.effect.parameters["lag"] == pytest.approx(lags[(n.effect.place or 0) - 1], abs=0.003)


def test_a_film_of_another_scale_bends_no_joint_where_there_is_no_log(tmp_path: Path) -> None:
    write(make(SEED, [], protocol=protocol(1)), tmp_path)
    campaign = tmp_path / "campaign.toml"
    text = re.sub(r"(?m)^servo_log = .*\n", "", campaign.read_text())
    said = re.search(r"edge_lengths = \[(.*?)\]", text, re.DOTALL)
    assert said is not None
    edges = 0.98 * np.array([float(x) for x in said[1].split(",") if x.strip()])
    campaign.write_text(text.replace(said[0], f"edge_lengths = {edges.tolist()}"))
    file, read = read_recordings(campaign)
    for r in read:
        links = np.linalg.norm(np.diff(r.markers, axis=1), axis=2)
        np.testing.assert_allclose(np.nanmedian(links, axis=0), file.body.edges_m, rtol=3e-3)
        (words,) = (remark.words for remark in r.remarks if "links" in remark.words)
        assert "2 % longer in the film" in words
        assert "Taken for the film's scale" in words
    stage = choose_actuation(plays(read))
    assert stage.settled
    assert not stage.named


def test_films_of_different_scales_are_each_taken_in_their_own_where_there_is_no_log(tmp_path: Path) -> None:
    """A camera that was moved between two trials: later films are 2.5 % larger."""
    write(make(SEED, [], protocol=protocol(2)), tmp_path)
    campaign = tmp_path / "campaign.toml"
    text = re.sub(r"(?m)^servo_log = .*\n", "", campaign.read_text())
    campaign.write_text(text)
    before = read_recordings(campaign)[1]
    later = [r.name for r in before][len(before) // 2 :]
    for name, motion in re.findall(r'name = "(.*)"\n(?:(?!\[\[)[^\n]*\n)*?motion = "(.*)"', text):
        if name in later:
            film = tmp_path / motion
            head, *rows = film.read_text().splitlines()
            cells = [row.split(",") for row in rows]
            larger = [[t, *(f"{1.025 * float(x):.6f}" if x else "" for x in xs)] for t, *xs in cells]
            film.write_text("\n".join([head, *map(",".join, larger)]) + "\n")
    read = read_recordings(campaign)[1]
    said = {r.name: [remark.words for remark in r.remarks if "camera moved" in remark.words] for r in read}
    assert [name for name, words in said.items() if words] == later
    factors = [re.search(r"Taken here times ([0-9.]+), ", words) for name in later for words in said[name]]
    assert [float(f[1]) for f in factors if f] == pytest.approx([1 / 1.025] * len(later), rel=1e-3)
    for one, other in zip(before, read, strict=True):
        np.testing.assert_allclose(other.markers, one.markers, rtol=1e-3, atol=1e-4)
    assert choose_actuation(plays(read)).settled


def test_a_start_that_labels_leave_open_moves_corners_and_is_no_lag(four: tuple[Recording, ...]) -> None:
    """Rows of 60 ms on straight lines, a log of 25 Hz whose labels say when they were due to 5 ms: moved to first
    order, every corner is missed by as much, which passed for noise, or a lag took a part of it away."""
    rng, late = np.random.default_rng(6), [0.0048, -0.0042, 0.003, -0.001]

    def read(r: Recording, late: float) -> Recording:
        table = 0.6 * rng.uniform(-1, 1, size=(24, r.body.joint_count))
        schedule = replace(r.schedule, table=table, cycle_duration_s=1.44, cycles=2, pause_s=0.5)
        time = np.arange(-0.5, schedule.whole_s, 0.04)
        position = np.round(schedule.commanded(time - late) / TICK) * TICK
        return replace(
            r, schedule=schedule, log_time=time, position=position, commands=None, told=None, t0_spread=0.005
        )

    data = plays([read(r, t) for r, t in zip(four, late, strict=True)])
    assert not any(r.begins_known for r in data.recordings)
    stage = choose_actuation(data)
    assert not stage.named
    assert stage.settled
    np.testing.assert_array_less(data.noise, TICK)  # rounding alone; by slopes thirty times as much
    assert data.channels(data.realised([])).max() < 1.3


def test_servos_that_are_far_too_slow_begin_where_they_are_told_to(recordings: tuple[Recording, ...]) -> None:
    """A triangle instead of a sine looks late by up to a quarter of a cycle; the film is laid where it looks alike."""
    rng, slow, noise = np.random.default_rng(3), 0.5, 0.01

    def filmed(r: Recording) -> Recording:
        late = 0.18 * r.schedule.cycle_duration_s
        time = np.arange(r.read_at[0], r.read_at[-1] + 1e-3, 1e-3)
        true = Course(time, rate_limited(time, r.schedule.commanded(time + late), slow)).at(r.read_at)
        unsure = UNSURE_CYCLE * r.schedule.cycle_duration_s
        return replace(r, position=true + noise * rng.normal(size=true.shape), by_servos=False, t0_spread=unsure)

    stage = choose_actuation(plays([filmed(r) for r in recordings]))
    assert stage.settled
    (named,) = stage.named
    assert named.effect.name == "speed_saturation"
    low, high = named.intervals["max_speed"]
    assert low is not None
    assert high is not None
    assert low < slow < high
    assert high - low < 0.02 * slow


def test_what_servos_do_after_a_trial_without_a_pause_is_no_lag(recordings: tuple[Recording, ...]) -> None:
    """Late by a lag, they stop after the promised end, and nothing says when that is."""
    rng, lag = np.random.default_rng(8), 0.05

    def read(r: Recording) -> Recording:
        schedule = replace(r.schedule, pause_s=0.0)
        time = np.arange(r.read_at[0], r.read_at[-1] + 1e-3, 1e-3)
        true = Course(time, lagged(time, schedule.commanded(time + lag), np.full(len(time) - 1, lag))).at(r.read_at)
        position = TICK * np.round((true + 0.4 * TICK * rng.normal(size=true.shape)) / TICK)
        return replace(r, schedule=schedule, position=position, t0_spread=UNSURE_CYCLE * schedule.cycle_duration_s)

    stage = choose_actuation(plays([read(r) for r in recordings]))
    assert stage.settled
    (named,) = stage.named
    assert named.effect.key == ("servo_lag", None)
    low, high = named.intervals["lag"]
    assert low is not None
    assert high is not None
    assert low < lag < high


def test_a_law_of_all_servos_that_is_only_the_nearest_is_a_stand_in(recordings: tuple[Recording, ...]) -> None:
    """Servos that do everything late by as much are nearest to inertia, and corners tell that they have none."""
    rng, late = np.random.default_rng(9), 0.2

    def read(r: Recording) -> Recording:
        noise = 0.4 * TICK * rng.normal(size=r.position.shape)
        return replace(r, position=TICK * np.round((r.schedule.commanded(r.read_at - late) + noise) / TICK))

    stage = choose_actuation(replace(plays([read(r) for r in recordings]), without=frozenset({"servo_delay"})))
    assert "servo_inertia" in {n.effect.name for n in stage.named}
    assert sum(n.effect.parameters["lag"] for n in stage.named) == pytest.approx(late, rel=0.05)
    assert all(n.stand_in and n.effect.place is None for n in stage.named)
    assert not stage.settled


def test_where_a_servo_that_is_late_stops_after_the_end_does_not_bend_its_shape_before(
    recordings: tuple[Recording, ...],
) -> None:
    once, lag = replace(recordings[0].schedule, cycles=1, pause_s=0.0), 0.4
    r = replace(recordings[0], schedule=once, commands=None)
    time, end = np.sort([*r.read_at, *r.time, once.period_s]), once.period_s
    true = once.commanded(time)
    true[:, [3]] = lagged(time, true[:, [3]], np.full(len(time) - 1, lag))
    true[time > end] = true[time == end][0]  # it is let go
    read, shown = (true[np.searchsorted(time, t)] for t in (r.read_at, r.time))
    effect = ActiveEffect.typical("lagging_joint", 4).with_coordinates([lag])
    stopped = replace(r, position=np.round(read / TICK) * TICK)
    (found,) = carried([stopped], plays([stopped]), [effect])
    inside = (r.time > 0) & (r.time < end)
    np.testing.assert_allclose(found.angles[inside], shown[inside], atol=2 * TICK)  # corners of rows and rounding


def reading(r: Recording, joint: int, law: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Recording:
    """The trial, one joint's readings being what a law (time, set-point) makes of its command."""
    position, told = r.position.copy(), r.schedule.commanded(r.read_at)
    position[:, joint - 1] = np.round(law(r.read_at, told[:, joint - 1]) / TICK) * TICK
    return replace(r, position=position)


def clipped(time: np.ndarray, told: np.ndarray) -> np.ndarray:
    return np.clip(told, told.mean() - 0.5 * told.std(), told.mean() + 0.5 * told.std())


def dead_from_half_time(time: np.ndarray, told: np.ndarray) -> np.ndarray:
    return np.where(time < time.mean(), told, told[len(told) // 2])


@pytest.mark.parametrize("law", [pytest.param(clipped, marks=pytest.mark.slow), dead_from_half_time])
def test_a_fault_of_one_servo_that_is_no_law_of_the_catalogue_gets_no_name(
    recordings: tuple[Recording, ...], law: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> None:
    stage = choose_actuation(plays([reading(recordings[0], 4, law)]))  # a law that is wrong in one trial is none
    assert not stage.named
    assert stage.words[0].startswith("joint 4 misses its command by")


@pytest.mark.parametrize(
    ("by_servos", "noise", "is_off"),
    [
        (True, "the reading's noise", "reads"),
        pytest.param(False, "the noise of the bend that markers show", "is bent", marks=pytest.mark.slow),
    ],
)
def test_what_a_joint_is_always_off_by_is_told_in_degrees(
    recordings: tuple[Recording, ...], by_servos: bool, noise: str, is_off: str
) -> None:
    rng, off = np.random.default_rng(3), np.where(np.arange(recordings[0].position.shape[1]) == 4, 0.06, 0.0)

    def zeroed(r: Recording) -> Recording:
        told = r.schedule.commanded(r.read_at) + off
        return replace(r, position=told + 0.02 * rng.normal(size=told.shape), by_servos=by_servos)

    said = choose_actuation(plays([zeroed(r) for r in recordings])).words[0]
    off_by = rf"it {is_off} \+3\.[345] degrees beyond its command"
    assert re.fullmatch(rf"joint 5 misses its command by \S+ times {noise}: {off_by}", said)
    elsewhere = choose_actuation(plays([reading(recordings[0], 4, clipped)])).words[0]
    assert elsewhere.endswith("the reading's noise")  # not by a constant


@pytest.mark.slow
def test_a_log_that_is_late_at_one_joint_is_told_and_is_no_servo_that_lags(recordings: tuple[Recording, ...]) -> None:
    late = 0.15

    def delayed(r: Recording) -> Recording:
        position = r.position.copy()
        position[:, 3] = np.interp(r.read_at - late, r.read_at, r.position[:, 3])
        return replace(r, position=position)

    baseline = Baseline(Model(recordings[0].body, Medium(anisotropy_ratio=0.2)))
    read, _, stage = of_servos([delayed(recordings[0])], baseline)
    assert not stage.named
    (words,) = stage.words
    said = re.fullmatch(r"the log of joint 4 is (\S+) s late: markers show that it does as it is told", words)
    assert said
    assert float(said[1]) == pytest.approx(late, abs=0.01)  # two figures are said
    # later stages have the joint as it was, but for rounding, flicker and when the trial began
    np.testing.assert_allclose(read[0].position, recordings[0].position, atol=8 * TICK)


def test_a_log_that_is_wrong_in_one_trial_is_told_with_that_trial(recordings: tuple[Recording, ...]) -> None:
    position = recordings[1].position.copy()
    position[:, 3] *= -1  # as one who wrote this log with another sign
    some = [recordings[0], replace(recordings[1], position=position), *recordings[2:]]
    stage = of_servos(some, Baseline(Model(recordings[0].body, Medium(anisotropy_ratio=0.2))))[2]
    told = f"the log of joint 4 is wrong in `{recordings[1].name}` alone: markers show that it does as it is told"
    assert told in stage.words


def test_markers_that_are_finer_than_readings_accuse_no_log_of_its_noise(recordings: tuple[Recording, ...]) -> None:
    first = recordings[0]
    told = first.schedule.commanded(first.time.clip(0.0, first.end))
    shape = first.body.total_length_m * chain_vertices(first.body, np.zeros((len(told), 3)), told)
    fine = 5e-6 * np.random.default_rng(0).normal(size=shape.shape)  # m: 0.1 mrad, a fifth of what readings scatter by
    stage = of_servos(
        [replace(first, markers=shape + fine)], Baseline(Model(first.body, Medium(anisotropy_ratio=0.2)))
    )[2]
    assert stage.words == ()


def test_a_log_that_is_wrong_at_every_joint_is_told_once(recordings: tuple[Recording, ...]) -> None:
    every = tuple(WrongLog(joint, None) for joint in range(1, recordings[0].body.joint_count + 1))
    servos = plays(recordings[:1])
    (said,) = _said(every, servos)
    assert "every joint" in said
    assert len(_said(every[1:], servos)) == len(every) - 1


def test_names_that_stand_for_another_law_explain_nothing(recordings: tuple[Recording, ...]) -> None:
    lag = Named(ActiveEffect.of("servo_lag", None, lag=0.05), {}, 3.0)
    assert verdict([Stage("actuation", (lag,))]) == "explained"
    assert verdict([Stage("actuation", (replace(lag, stand_in=True),))]) == "partly explained"


def test_what_is_nearest_to_a_fault_that_is_no_law_is_told(recordings: tuple[Recording, ...]) -> None:
    (told,) = choose_actuation(plays([reading(recordings[0], 4, clipped)])).words[1:]
    assert re.fullmatch(r"gain_loss at joint 4 would leave \d+% of what it does: not its law", told)


def test_a_servo_that_is_dead_in_one_of_two_repeats_is_no_stuck_joint(recordings: tuple[Recording, ...]) -> None:
    settings: dict[tuple[str, float], int] = {}
    trials = []
    for r in recordings:
        settings[r.setting] = settings.get(r.setting, 0) + 1
        dead = settings[r.setting] == 1
        trials.append(reading(r, 2, lambda time, told: np.full_like(told, told[0])) if dead else r)
    data = plays(trials)
    assert len(data.recordings) == len(trials)
    stage = choose_actuation(data)
    assert not stage.named
    assert not stage.settled


@pytest.mark.parametrize("said", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_a_trial_in_which_servos_are_weak_is_seen_beside_its_repeat_and_named(
    recordings: tuple[Recording, ...], said: bool
) -> None:
    def known(r: Recording) -> Recording:
        return r if said else replace(r, t0_spread=UNSURE_CYCLE * r.schedule.cycle_duration_s, told=None, commands=None)

    weak, *others = map(known, recordings)
    stage = choose_actuation(plays([replace(weak, position=0.75 * weak.position), *others]))
    assert not stage.named
    assert f"all joints stray in `{weak.name}` alone, 0.75 times as far as told" in stage.words


@pytest.mark.slow
def test_two_joints_that_are_exchanged_in_one_trial_are_told(recordings: tuple[Recording, ...]) -> None:
    wired, *others = recordings
    order = np.arange(wired.position.shape[1])
    order[[2, 5]] = order[[5, 2]]
    stage = choose_actuation(plays([replace(wired, position=wired.position[:, order]), *others]))
    said = f"joints 3 and 6 do what the other is told in `{wired.name}` alone: wires or numbers exchanged?"
    assert said in stage.words


@pytest.mark.slow
def test_servos_that_tire_from_trial_to_trial_are_told(four: tuple[Recording, ...]) -> None:
    tired = [replace(r, position=(1 - 0.05 * (n + 1)) * r.position) for n, r in enumerate(four)]
    words = choose_actuation(plays(tired)).words
    first, last = tired[0].name, tired[-1].name
    said = f"all joints move less from trial to trial: 0.95 times as far as told in `{first}`, 0.80 times in `{last}`"
    assert said in words


@pytest.mark.slow
def test_a_joint_that_lags_makes_no_other_one_unlike_what_it_is_told(recordings: tuple[Recording, ...]) -> None:
    def lags(r: Recording) -> Recording:
        position = r.position.copy()
        position[:, 3] = np.interp(r.read_at - 0.08, r.read_at, r.position[:, 3])
        return replace(r, position=position)

    data = plays([lags(r) for r in recordings])
    lag = next(n.effect for n in choose_actuation(data).named)
    assert data.missed(data.realised([]))[:3].min() > 1  # with one clock for all the others seem to be early
    for found in ([lag], []):  # whether or not its law is known
        assert unlike_told(data, found, []).nonzero()[0].tolist() == [3]


@dataclass(frozen=True)
class Worth:
    """Effects that take away so much each of what there is, and nothing of one another's."""

    gains: tuple[float, ...]
    there: float = 1000.0

    @property
    def size(self) -> int:
        return len(self.gains)

    @property
    def priced(self) -> Priced:
        return Priced(self.there - sum(self.gains), self.size, 100.0)


def test_effects_that_gain_no_more_than_the_null_are_dropped() -> None:
    fitted = []

    def each_without(found: Worth, some: Sequence[int]) -> list[Worth]:
        fitted.extend(found.gains[i] for i in some)
        return [replace(found, gains=found.gains[:i] + found.gains[i + 1 :]) for i in some]

    best = earned(Worth((500.0, 30.0, 20.0, 200.0, 10.0)), Worth(()), each_without, lambda found: 40.0)
    assert best.gains == (500.0, 200.0)
    assert fitted == [500.0, 30.0, 20.0, 200.0, 10.0, 20.0, 30.0, 200.0, 500.0]  # who gained least is asked first


LEFT = {"abc": 180.0, "bc": 210.0, "ac": 200.0, "ab": 680.0, "a": 700.0, "b": 710.0, "c": 500.0, "": 1000.0}


@dataclass(frozen=True)
class Alike:
    """Effects of which a and b do nearly the same."""

    names: str

    @property
    def size(self) -> int:
        return len(self.names)

    @property
    def priced(self) -> Priced:
        return Priced(LEFT[self.names], self.size, 100.0)


def test_of_two_that_do_the_same_the_lesser_is_dropped_and_the_other_is_asked_anew() -> None:
    asked = []

    def without(found: Alike, some: Sequence[int]) -> list[Alike]:
        asked.append("".join(found.names[i] for i in some))
        return [Alike(found.names[:i] + found.names[i + 1 :]) for i in some]

    assert earned(Alike("abc"), Alike(""), without, lambda found: 40.0).names == "ac"
    assert asked == ["abc", "a", "c"]  # 30, 20 and 500 beside all; 300 and 500 without b


def test_effects_that_together_take_away_less_than_they_leave_are_no_causes() -> None:
    bare, best = Worth(()).priced, Worth((200.0, 150.0)).priced
    assert outweighed(bare, best)
    more = Worth((200.0, 350.0)).priced
    assert not outweighed(bare, more)


def test_a_fit_must_pay_for_its_parameters_and_its_rivals() -> None:
    base, toll = Priced(100.0, 1, 100.0), float(np.log(100))
    dear = 2 * np.log(50)  # for fifty candidates
    assert cheapest(base, [Priced(100 - toll - dear + 0.1, 2, 100.0)], 50) is None
    assert cheapest(base, [Priced(90.0, 2, 100.0), Priced(100 - toll - dear - 0.1, 2, 100.0)], 50) == 1
    assert cheapest(base, [], 50) is None


def test_of_sets_of_as_many_numbers_that_of_fewer_names_is_the_likelier_one() -> None:
    one_law, name = Priced(100.0, 2, 100.0), 2 * np.log(24)  # one of 24 candidates
    two_laws = Priced(100.0 - name + 0.1, 2, 100.0)
    assert cheapest(one_law, [two_laws], 1) == 0
    assert cheapest(one_law, [two_laws], 1, [name]) is None
    assert cheapest(two_laws, [one_law], 1) is None
    assert cheapest(two_laws, [one_law], 1, [-name]) == 0


def test_noise_blurs_what_rounding_does_to_the_mean_of_readings_at_rest() -> None:
    ticks, at = np.arange(-8, 9), np.linspace(-0.5, 0.5, 40, endpoint=False)
    for noise in (0.2, 0.4, 0.6):  # of a tick
        below = norm.cdf((ticks + 0.5 - at[:, None]) / noise)
        mean = (ticks[1:] * np.diff(below, axis=1)).sum(axis=1)
        expected = np.sqrt(np.mean((mean - at) ** 2)) * TICK
        # the second harmonic is half as large where nothing is blurred, and below a fifth of the first from here on
        assert off_by_rounding(noise * TICK) == pytest.approx(expected, rel=0.03)


def test_noise_that_is_larger_than_it_was_taken_for_is_no_structure_of_readings() -> None:
    rng, time = np.random.default_rng(0), np.arange(400)
    left = np.column_stack([2 * rng.normal(size=400), rng.normal(size=400) + 2 * np.sqrt(2) * np.sin(0.1 * time)])
    one = np.ones(2)
    data = cast(
        Plays,
        SimpleNamespace(noise=one, held_against=one, trials=np.zeros(400), read=left < np.inf),
    )
    white, slow = Plays.structure_of(data, left)
    assert white == 0.0
    assert slow == pytest.approx(4, rel=0.15)  # of chance 1 / sqrt(400) of their product with noise


@pytest.mark.slow
def test_a_joint_with_play_that_rested_anywhere_in_its_gap_is_named_and_followed(tmp_path: Path) -> None:
    """Trials begin where the joint came to rest, not in the middle of its gap; to the markers that is no news."""
    width = 0.1
    write(make(104, [Effect("backlash", 4, {"width": width})], combinations=COMBINATIONS[:2]), tmp_path)
    recordings = read_recordings(tmp_path)[1]
    rests = [float(r.position[r.read_at < 0][:, 3].mean() - r.schedule.table[0, 3]) for r in recordings]
    assert max(map(abs, rests)) > width / 4  # the generator lets it rest anywhere
    data = plays(recordings)
    stage = choose_actuation(data)
    (named,) = stage.named
    assert named.effect.key == ("backlash", 4)
    assert not named.stand_in
    assert stage.settled
    low, high = named.intervals["width"]
    assert low is not None
    assert high is not None
    assert low < width < high
    assert data.channels(data.realised([named.effect])).max() < 1.1


def test_a_gap_remembers_where_a_trial_came_to_rest_from_and_what_follows_does_not() -> None:
    model = Model(Body(vertices=5, edge_lengths=(0.1,) * 4), Medium(anisotropy_ratio=0.2), (
        ActiveEffect.of("servo_lag", lag=0.3), ActiveEffect.of("backlash", 2, width=0.1)
    ))  # fmt: skip
    times = np.linspace(0, 2, 50)
    told = np.tile(0.03 * np.sin(3 * times)[:, None], 3)  # within the gap
    (plain,) = realise_all(model, [told], [times])
    (rested,) = realise_all(model, [told], [times], came_from=[np.array([0.2, 0.04, -0.3])])
    np.testing.assert_allclose(rested.angles[:, [0, 2]], plain.angles[:, [0, 2]], atol=1e-9)
    np.testing.assert_allclose(rested.angles[:, 1], 0.04, atol=0.02)
    assert rested.angles[0, 1] == pytest.approx(0.04)
    np.testing.assert_allclose(plain.angles[:, 1], 0.0, atol=1e-12)


def test_laws_side_by_side_play_as_each_alone() -> None:
    body, medium = Body(vertices=5, edge_lengths=(0.1,) * 4), Medium(anisotropy_ratio=0.2)
    gap = ActiveEffect.of("backlash", 2, width=0.1)
    lags = [ActiveEffect.of("servo_lag", lag=lag) for lag in (0.05, 0.1)]
    sets = [(), (gap,), (gap, lags[0]), (gap, lags[1]), (lags[1], ActiveEffect.of("servo_delay", delay=0.03))]
    models = [Model(body, medium, effects) for effects in sets]
    times = [np.linspace(0, 2, 50), np.linspace(0, 3, 2500)]
    told = [np.sin(3 * time[:, None] + np.arange(3)) for time in times]
    came_from = [np.array([0.2, 0.4, -0.3]), np.zeros(3)]
    every = readings_of_each(models, told, times, came_from)
    for model, found in zip(models, every, strict=True):
        for mine, alone in zip(found, realise_all(model, told, times, came_from), strict=True):
            np.testing.assert_array_equal(mine, alone.readings)


def test_what_a_law_is_worth_to_first_order_is_what_a_fit_without_it_loses(four: tuple[Recording, ...]) -> None:
    data = plays([reading(reading(r, 3, lambda t, told: 0.9 * told), 5, lambda t, told: 0.8 * told) for r in four])
    laws = [ActiveEffect.of("gain_loss", joint, loss=0.05) for joint in (3, 5)]
    best = Played(data, refined(data, laws))
    for index, worth in enumerate(best.worth(range(2))):
        lost = Played(data, refined(data, [laws[1 - index]])).priced.chi2 - best.priced.chi2
        assert lost > 1000
        assert worth == pytest.approx(lost, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("loss", [0.15, 0.2])
def test_rows_that_run_do_so_for_servos_that_are_all_weak(loss: float, tmp_path: Path) -> None:
    """Rows that are held beside a lag come nearer to a smaller swing than rows that run."""
    weak = [Effect("gain_loss", joint, {"loss": loss}) for joint in range(1, 11)]
    write(make(SEED, weak, combinations=COMBINATIONS[:2]), tmp_path)
    recordings = [replace(r, commands=None, told=None, t0_spread=0.05) for r in read_recordings(tmp_path)[1]]
    data = plays(recordings)
    assert not data.held
    stage = choose_actuation(data)
    assert {n.effect.name for n in stage.named} == {"gain_loss"}
    for named in stage.named:
        assert named.effect.parameters["loss"] == pytest.approx(loss, abs=0.002)


def test_who_reads_the_same_tick_again_and_again_has_no_noise_that_blurs_it() -> None:
    rng, ticks = np.random.default_rng(8), np.repeat([0, 1], 400)
    assert off_by_rounding(0.0) == pytest.approx(TICK / np.sqrt(12), rel=0.01)
    assert noise_at_rest(np.where(ticks == 0, 0.3, -0.2) * TICK, ticks, TICK) == pytest.approx(0.0, abs=1e-9 * TICK)
    assert noise_at_rest(0.5 * TICK * rng.normal(size=800), ticks, TICK) == pytest.approx(0.5 * TICK, rel=0.1)
    assert noise_at_rest(3 * TICK * rng.normal(size=800), ticks, TICK) == TICK
    assert noise_at_rest(np.array([0.4 * TICK]), np.zeros(1, int), TICK) == TICK  # one reading does not tell


def test_the_value_of_a_joint_that_stands_still_holds_half_a_tick_and_no_more(
    recordings: tuple[Recording, ...],
) -> None:
    """Readings that never leave a tick; between ticks nobody knows where the joint is."""
    angle = 0.1 + 0.4 * TICK
    stuck = []
    for r in recordings:
        position = r.position.copy()
        position[:, 3] = np.round(angle / TICK) * TICK
        stuck.append(replace(r, position=position))
    (named,) = choose_actuation(plays(stuck)).named
    assert named.effect.key == ("stuck_joint", 4)
    low, high = named.intervals["angle"]
    assert low is not None
    assert high is not None
    assert low < angle < high
    assert high - low < 1.5 * TICK
