"""Groups: what the data cannot exclude is reported beside the choice, what they can is not."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from serpenoid.cli.main import main
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.noise.paths import path_error, path_noise, strength
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import Recording, held_out_labels
from serpenoid.diagnose.design.experiment import Laboratory, next_experiment
from serpenoid.diagnose.inference.doubt.groups import band
from serpenoid.diagnose.inference.fits.finding import Stage, excludable
from serpenoid.diagnose.inference.fits.medium import fit
from serpenoid.diagnose.inference.search.names import kept, trace, visible
from serpenoid.diagnose.stages.actuation.choose_actuation import choose_actuation
from serpenoid.diagnose.stages.actuation.choose_set_points import plays
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.motion.choose_motion import MotionFinding, choose_motion
from serpenoid.diagnose.stages.motion.values_of_motion import named_of
from serpenoid.diagnose.stages.observation.choose_observation import choose_observation
from serpenoid.diagnose.start import baseline
from serpenoid.effects.active import ActiveEffect
from serpenoid.table_file import read_table

GRADIENT = Effect("friction_gradient", None, {"gradient_x": 0.35, "gradient_y": 0.21})
TOE = Effect("toe", None, {"angle": 0.05})
SLOPE = Effect("slope", None, {"pull_x": 0.002, "pull_y": 0.0008})


def recorded(folder: Path, seed: int, *effects: Effect, gaits: int = 1) -> tuple[Recording, ...]:
    write(make(seed, effects, combinations=COMBINATIONS[:gaits]), folder)
    return read_recordings(folder)[1]


def motion(folder: Path, seed: int, *effects: Effect, gaits: int = 2) -> MotionFinding:
    recordings = recorded(folder, seed, *effects, gaits=gaits)
    _, seen = choose_observation(recordings, Observation.neutral(recordings[0].body))
    file, _ = read_recordings(folder)
    return choose_motion(recordings, seen, Baseline(baseline(None, file, file.body)), lambda text: None)


def observed(recordings: tuple[Recording, ...]) -> Stage:
    return choose_observation(recordings, Observation.neutral(recordings[0].body))[0]


def members(stage: Stage) -> set[tuple[str, int | None]]:
    chosen = {(n.effect.name, n.effect.place) for n in stage.named}
    return chosen | {(r.effect.name, r.effect.place) for r in stage.rivals}


def test_a_joint_without_gain_and_one_stuck_at_zero_are_one_group(tmp_path: Path) -> None:
    stage = choose_actuation(plays(recorded(tmp_path, 31, Effect("gain_loss", 4, {"loss": 1.0}))))
    assert members(stage) == {("gain_loss", 4), ("stuck_joint", 4)}
    assert all(r.separation < 0.1 for r in stage.rivals)


def test_a_stuck_joint_off_zero_has_no_rival(tmp_path: Path) -> None:
    stage = choose_actuation(plays(recorded(tmp_path, 32, Effect("stuck_joint", 7, {"angle": 0.1}))))
    assert members(stage) == {("stuck_joint", 7)}


def test_the_first_joints_zero_and_the_tail_markers_side_are_one_group(tmp_path: Path) -> None:
    stage = observed(recorded(tmp_path, 33, Effect("zero_offset", 1, {"offset": 0.02})))
    assert members(stage) == {("zero_offset", 1), ("marker_offset", 0)}


def test_a_zero_in_mid_body_has_no_rival(tmp_path: Path) -> None:
    stage = observed(recorded(tmp_path, 34, Effect("zero_offset", 6, {"offset": 0.02})))
    assert members(stage) == {("zero_offset", 6)}


@pytest.fixture(scope="module")
def undecided(tmp_path_factory: pytest.TempPathFactory) -> MotionFinding:
    """Where friction varies over the floor."""
    return motion(tmp_path_factory.mktemp("gradient"), 972, GRADIENT)


@pytest.mark.slow
def test_gradient_and_wide_patch_are_one_group(undecided: MotionFinding) -> None:
    assert {("friction_gradient", None), ("friction_patch", None)} <= members(undecided.stage)
    assert all(s.rival.separation < 3 for s in undecided.swaps)
    assert [s.fit.chi2 for s in undecided.swaps] == sorted(s.fit.chi2 for s in undecided.swaps)


@pytest.mark.slow
def test_the_report_says_which_experiment_tells_the_group_apart(tmp_path: Path) -> None:
    write(make(972, [GRADIENT], combinations=COMBINATIONS[:2]), tmp_path / "campaign")
    out = tmp_path / "out"
    assert main(["diagnose", str(tmp_path / "campaign"), "--out", str(out), "--quiet"]) == 0
    proposed = json.loads((out / "diagnosis.json").read_text())["next_experiment"]
    page = (out / "report.html").read_text(encoding="utf-8")
    assert len(read_table(out / proposed["joint_table"])) > 1
    assert f"<code>{proposed['joint_table']}</code>, {proposed['cycle_duration_s']:.3g} s per cycle" in page
    assert all(f"{rival['name']}: {rival['expected_chi2']:.0f}" in page for rival in proposed["tells_apart"])


def test_an_experiment_for_the_group_stays_near_what_the_campaign_did(undecided: MotionFinding) -> None:
    found = undecided.selection
    laboratory = Laboratory.of(found.best, [s.fit for s in undecided.swaps], found.motion)
    experiment = next_experiment(laboratory)
    assert experiment is not None
    assert len(experiment.chi2) == len(undecided.swaps)
    assert (experiment.chi2 > 0).all()
    used = [t.recording.schedule for t in found.motion.tracks]
    durations = [s.cycle_duration_s for s in used]
    assert 0.7 * min(durations) <= experiment.plan.schedule.cycle_duration_s <= 1.5 * max(durations)
    assert experiment.plan.schedule.pause_s == used[0].pause_s
    visited = np.concatenate([t.poses[:, :2] for t in found.motion.tracks])
    assert (experiment.plan.start[:2] >= visited.min(axis=0)).all()
    assert (experiment.plan.start[:2] <= visited.max(axis=0)).all()


@pytest.fixture(scope="module")
def slope_and_toe(tmp_path_factory: pytest.TempPathFactory) -> MotionFinding:
    return motion(tmp_path_factory.mktemp("two"), 950, SLOPE, TOE)


@pytest.mark.slow
def test_each_of_two_separable_effects_is_named_alone_and_missed_when_left_out(slope_and_toe: MotionFinding) -> None:
    found = slope_and_toe
    assert members(found.stage) == {("slope", None), ("toe", None)}
    best = found.selection.best
    for effect, left in zip(best.effects, found.selection.bases, strict=True):
        assert {e.name for e in left.effects} == {e.name for e in best.effects} - {effect.name}
        assert excludable(left.chi2, best.chi2, float(best.evidence.count.sum()), band(best))


def test_what_is_too_weak_to_be_named_stays_beside_what_is(slope_and_toe: MotionFinding) -> None:
    found = slope_and_toe.selection
    toe = next(i for i, e in enumerate(found.best.effects) if e.name == "toe")
    faint = trace(found.motion, found.best, found.bases[toe], found.best.effects[toe])
    without = found.bases[toe].predictions
    off = path_error(found.motion, without) / path_noise(found.motion, without).farthest
    loud = 1.05 * max(faint, off)
    louder = replace(found, **vars(kept(found.motion, found.null, found.best, loud, [("toe", None)])))
    assert [e.name for e in louder.best.effects] == ["slope"]
    assert [t.added.name for t in louder.undetected] == ["toe"]
    assert louder.best.coordinates[1:] != pytest.approx(found.best.coordinates[1:3], rel=1e-3)  # it is bent alone
    told = [named_of(s, b, s.best.effects[i]) for s, b, i in
            ((found, found.bases[1 - toe], 1 - toe), (louder, louder.bases[0], 0))]  # fmt: skip
    assert told[0].effect == told[1].effect
    assert told[0].intervals == told[1].intervals


def test_an_effect_whose_trace_others_took_over_is_listed_as_faint(tmp_path: Path) -> None:
    found = motion(tmp_path, 951, SLOPE, gaits=1).selection
    assert [e.name for e in found.best.effects] == ["slope"]
    slope, toe = found.best.effects[0], ActiveEffect.of("toe", angle=1e-4)
    both = fit(found.motion, found.best.model, [slope, toe], np.array([*found.best.coordinates, 1e-4]))
    best, bases, lost = visible(found.motion, found.null, both, found.noise_level_m)
    assert [e.name for e in best.effects] == ["slope"]
    assert [(f.added.name, f.strength_m < found.noise_level_m) for f in lost] == [("toe", True)]
    assert [b.effects for b in bases] == [()]


def test_where_eps_is_known_it_does_not_take_the_place_of_an_effect(tmp_path: Path) -> None:
    found = motion(tmp_path, 952, Effect("worn_wheel", 5, {"seizure": 0.7}), gaits=1).selection
    (wheel,) = found.best.effects
    true = found.best.model.medium.anisotropy_ratio
    assert found.null.model.medium.anisotropy_ratio > 1.1 * true
    usual = trace(found.motion, found.best, found.null, wheel)
    assert usual == strength(found.motion, found.best.predictions, found.null.predictions)
    assert trace(replace(found.motion, ratio=true), found.best, found.null, wheel) > 1.5 * usual
    assert trace(replace(found.motion, ratio=2 * true), found.best, found.null, wheel) == usual


@pytest.mark.parametrize(("left_per_residual", "excluded"), [(0.5, True), (1.0, True), (4.0, False)])
def test_where_the_best_fit_leaves_more_than_chance_a_difference_counts_for_less(
    left_per_residual: float, excluded: bool
) -> None:
    least = 100 * left_per_residual
    assert excludable(least + 50, least, 100, 25) is excluded
    assert not excludable(np.nextafter(least, 0), least, 100, 25)


def _repeat(gait: str, duration: float) -> Recording:
    return cast(Recording, SimpleNamespace(gait=gait, setting=(gait, duration)))


def test_gaits_are_held_out_together_and_without_a_second_gait_settings_or_trials() -> None:
    a, slow, b = _repeat("a", 2.0), _repeat("a", 4.0), _repeat("b", 2.0)
    assert held_out_labels([a, slow, b, a]) == (0, 0, 1, 0)
    assert held_out_labels([a, a, slow]) == (0, 0, 1)
    assert held_out_labels([a, a]) == (0, 1)
