"""Every effect of the catalogue, hidden alone and strong in a short campaign, is what its stage scores best.

One call of the scorer each, about no effect at all; the whole diagnosis is tried elsewhere.
"""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import WITHOUT_WHEELS, Effect
from blind.folder import write
from serpenoid.diagnose.data.cameras.columns import all_keys, columns_of
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.paths import path_noise
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.windows.tracks import make_tracks
from serpenoid.diagnose.inference.fits import jumps
from serpenoid.diagnose.inference.fits.jumps import find_jumps
from serpenoid.diagnose.inference.fits.medium import fit_eps
from serpenoid.diagnose.inference.search.ranking import score
from serpenoid.diagnose.inference.search.select import Fit, calibrated
from serpenoid.diagnose.stages.actuation.actuation_by_joint import attempts
from serpenoid.diagnose.stages.actuation.choose_set_points import plays
from serpenoid.diagnose.stages.motion.choose_motion import GUESS
from serpenoid.diagnose.stages.observation.choose_observation import choose_observation
from serpenoid.diagnose.stages.observation.marker_evidence import evidence, sample
from serpenoid.effects import catalogue
from serpenoid.effects.catalogue import of_laws
from serpenoid.medium import Medium
from serpenoid.model import Model

Key = tuple[str, int | None]
SETTINGS = 2  # gaits, each at another duration and heading, two trials of each
SERVOS = (
    Effect("servo_lag", None, {"lag": 0.06}),
    Effect("servo_delay", None, {"delay": 0.05}),
    Effect("servo_inertia", None, {"lag": 0.06, "damping": 0.4}),
    Effect("gain_loss", 3, {"loss": 0.15}),
    Effect("stuck_joint", 7, {"angle": 0.2}),
    Effect("backlash", 5, {"width": 0.06}),
    Effect("servo_play", None, {"width": 0.03}),
    Effect("speed_saturation", None, {"max_speed": 0.6}),
    Effect("lagging_joint", 4, {"lag": 0.08}),
    Effect("slow_joint", 6, {"max_speed": 0.5}),
)
MARKERS = (
    Effect("zero_offset", 6, {"offset": 0.06}),
    Effect("loose_joint", 5, {"width": 0.06}),
    Effect("marker_offset", 4, {"along": 4e-3, "left": -5e-3}),
    Effect("marker_offset_ahead", 4, {"along": 4e-3, "left": -5e-3}),
    Effect("marker_sway", 4, {"sway": 6e-3}),
    Effect("length_scale", None, {"error": 0.015}),
    Effect("camera_stretch", None, {"longer": -0.01, "shear": 0.006}),
)
MOTION = (
    Effect("worn_wheel", 8, {"seizure": 0.6}),
    Effect("rough_skin", 8, {"roughness": 1.0}),
    Effect("load", 2, {"share": 0.2}),
    Effect("tyre_grip", 3, {"change": -0.7}),
    Effect("dry_friction", None, {"crossover_speed": 0.02}),
    Effect("grip_saturation", None, {"saturation_speed": 0.3}),
    Effect("forward_backward_asymmetry", None, {"asymmetry": 0.2}),
    Effect("left_right_asymmetry", None, {"asymmetry": -0.15}),
    Effect("toe", None, {"angle": 0.06}),
    Effect("slope", None, {"pull_x": 2e-3, "pull_y": -1.5e-3}),
    Effect("friction_patch", None, {"strength": 1.5, "x": 0.1, "y": 0.05, "radius": 0.25}),
    Effect("grip_patch", None, {"change": -0.7, "x": 0.1, "y": 0.05, "radius": 0.25}),
    Effect("friction_gradient", None, {"gradient_x": 0.8, "gradient_y": -0.5}),
    Effect("anisotropy_drift", None, {"rate": 0.03}),
    Effect("power_law_drag", None, {"exponent": 0.8}),
    Effect("inertia", None, {"relaxation_time": 0.05}),
    Effect("added_mass", None, {"relaxation_time": 0.1}),
    Effect("contact_offset", None, {"offset": 0.012}),
    Effect("rolling_resistance", None, {"crossover_speed": 0.02}),
    Effect("track_width", None, {"half_track": 0.1}),
    Effect("wheel_mount", None, {"share": 0.4}),
    Effect("frame_drift", None, {"velocity_x": 1e-3, "velocity_y": 1.5e-3}),
)
JUMPS, CLOCK = Effect("position_jumps", None, {"size": 0.012}), Effect("clock_offset", None, {"rate": 0.01})


def recorded(folder: Path, effect: Effect, settings: int = SETTINGS) -> tuple[Recording, ...]:
    write(make(5, [effect], "short", COMBINATIONS[:settings]), folder)
    if effect.name in WITHOUT_WHEELS:
        file = folder / "campaign.toml"
        file.write_text(file.read_text().replace("[body]\n", '[body]\nkind = "crawling robot"\n'))
    return read_recordings(folder)[1]


def calibrated_motion(recordings: tuple[Recording, ...]) -> tuple[Motion, Fit]:
    """Tracks with eps fitted and noise from repeats, and that fit."""
    body = recordings[0].body
    model, labels = Model(body, Medium(anisotropy_ratio=0.2)), tuple(int(r.gait[-2:]) for r in recordings)
    for _ in range(2):
        motion = Motion(make_tracks(recordings, Observation.neutral(body), model), GUESS, labels)
        model = fit_eps(motion, model).model
    return calibrated(motion, fit_eps(motion, model))


def test_every_effect_is_tried() -> None:
    numbers = {e.name for e in of_laws()}  # found with eps: test_diagnose_laws.py
    assert {e.name for e in (*SERVOS, *MARKERS, *MOTION, JUMPS, CLOCK)} == set(catalogue()) - numbers


FOLLOWED = ("backlash",)  # others: test_diagnose_servos.py, test_diagnose_servo_inertia.py, and here


@pytest.mark.parametrize(
    "hidden", [pytest.param(e, id=e.name, marks=[] if e.name in FOLLOWED else pytest.mark.slow) for e in SERVOS]
)
def test_readings_fit_the_hidden_effect_of_the_servos_best(hidden: Effect, tmp_path: Path) -> None:
    data = plays(recorded(tmp_path, hidden, 1))
    price = np.log(data.often.sum())  # of a number: a law may be the limit of another
    best = min(attempts(data, []), key=lambda a: a.chi2.sum() + price * len(a.effect.effect.parameters))
    assert (best.effect.name, best.effect.place) == (hidden.name, hidden.place)


@pytest.mark.parametrize(
    "share", [0.93, pytest.param(0.6, marks=pytest.mark.slow), pytest.param(0.4, marks=pytest.mark.slow)]
)
def test_a_saturation_is_found_wherever_it_lies_below_the_quickest_set_point(share: float, tmp_path: Path) -> None:
    quickest = plays(recorded(tmp_path / "plain", Effect("toe", None, {"angle": 0.01}), 1)).quickest.max()
    hidden = Effect("speed_saturation", None, {"max_speed": share * quickest})
    best = min(attempts(plays(recorded(tmp_path / "hidden", hidden, 1)), []), key=lambda a: a.chi2.sum())
    assert best.effect.name == "speed_saturation"
    assert best.effect.parameters["max_speed"] == pytest.approx(share * quickest, rel=0.01)


SEEN = ("length_scale",)  # others: test_diagnose_observation.py


@pytest.mark.parametrize(
    "hidden", [pytest.param(e, id=e.name, marks=[] if e.name in SEEN else pytest.mark.slow) for e in MARKERS]
)
def test_markers_of_held_out_gaits_are_best_predicted_with_the_hidden_effect(hidden: Effect, tmp_path: Path) -> None:
    data = sample(recorded(tmp_path, hidden))
    sums = evidence(data, Observation.neutral(data.body))
    left: dict[Key, float] = {k: sums.held_out(columns_of(data.body, *k)) for k in all_keys(data.body)}
    assert min(left, key=lambda k: left[k]) == (hidden.name, hidden.place)


ALWAYS = "worn_wheel", "inertia"  # of one vertex, of time; a patch of the floor: test_diagnose_places.py
MOTIONS = [pytest.param(e, id=e.name, marks=[] if e.name in ALWAYS else pytest.mark.slow) for e in MOTION]


@pytest.mark.parametrize("hidden", MOTIONS)
def test_motion_of_held_out_gaits_is_best_predicted_with_the_hidden_effect(hidden: Effect, tmp_path: Path) -> None:
    settings = SETTINGS if hidden.name in ALWAYS else SETTINGS + 1
    ranked = score(*calibrated_motion(recorded(tmp_path, hidden, settings)))
    assert (ranked[0][0].name, ranked[0][0].place) == (hidden.name, hidden.place)


def test_jumps_of_position_are_found_in_gaps(tmp_path: Path) -> None:
    motion, null = calibrated_motion(recorded(tmp_path, JUMPS))
    found = find_jumps(motion, null.predictions, path_noise(motion, null.predictions).level_m)
    assert found is not None
    low, high = found.intervals["size"]
    assert low < JUMPS.parameters["size"] < high
    missed = JUMPS.parameters["size"]  # a law that errs as much in every window does so in gaps as well
    assert find_jumps(motion, null.predictions, path_noise(motion, null.predictions).level_m, missed) is None


def test_a_fast_clock_is_found(tmp_path: Path) -> None:
    recordings = recorded(tmp_path, CLOCK)
    stage, _ = choose_observation(recordings, Observation.neutral(recordings[0].body))
    assert [n.effect.name for n in stage.named] == ["clock_offset"]


def test_jumps_far_above_their_noise_have_a_narrow_interval(monkeypatch: pytest.MonkeyPatch) -> None:
    noises = np.full(16, 1e-5)
    lengths = np.hypot(0.03 + np.random.default_rng(1).normal(0, 1e-5, 16), 1e-5)
    monkeypatch.setattr(jumps, "gap_lengths", lambda motion, predictions, missed_m: (lengths, noises))
    motion = SimpleNamespace(untestable={})
    found = find_jumps(motion, (), 1e-3)  # type: ignore[arg-type]
    assert found is not None
    low, high = found.intervals["size"]
    assert low is not None
    assert high is not None
    assert low < 0.03 < high < low + 2e-5
