"""A worm by drag alone, continuous and independent of the package: what its points tell whoever asks for K = 12."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from serpenoid.body import Body
from serpenoid.cli.main import main
from serpenoid.compare.calibrate import anisotropy, drag_ratio
from serpenoid.compare.likelihood import fit
from serpenoid.compare.segments import trial_segments
from serpenoid.compare.start import neutral_model
from serpenoid.diagnose.data.noise.memory import Memory
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import window_noise
from serpenoid.diagnose.data.noise.paths import path_noise
from serpenoid.diagnose.data.shapes.shapes_from_points import States
from serpenoid.diagnose.data.tracked import (
    MOST_WINDOWS,
    WINDOWS_PER_PERIOD,
    TrackedRecording,
    _cut,
    _mesh,
    _missed,
    _run,
    tracked_recordings,
    tracker,
)
from serpenoid.diagnose.data.untestable import not_on_offer
from serpenoid.diagnose.data.windows.windows import predictions
from serpenoid.diagnose.inference.fits.finding import Named
from serpenoid.diagnose.stages.motion.stand_ins import amid_points
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.catalogue import catalogue, find
from serpenoid.errors import InputError
from serpenoid.group import accumulate
from serpenoid.measure.campaign import load_campaign_file
from serpenoid.measure.load import load_campaign
from serpenoid.medium import Medium
from serpenoid.model import Model
from specimens import animal_campaign

pytestmark = pytest.mark.usefixtures("virtual_machine")
K = 12.0
NAMES = (("slope", None, 100.0), ("frame_drift", None, 3.0), ("marker_offset", 3, 3.0))
POINTS, FINE = 12, 89  # points seen; 8 pieces of the curve between two of them
RATE, FRAMES_PER_SECOND, NOISE = 0.55, 30.0, 3e-4  # beats a second; body lengths


@dataclass(frozen=True)
class Worm:
    """Resistive force theory on a smooth curve: no net force, no net moment, at every moment."""

    arc = np.linspace(0, 1, FINE)

    def curve(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Points (FINE, 2) about their mean and unit tangents."""
        wave = 0.65 * np.sin(2 * np.pi * (RATE * t - 1.2 * (1 - self.arc)))
        angle = wave + 0.3 * np.sin(0.5 * t) * (2 * self.arc - 1)
        tangent = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        points = np.concatenate([np.zeros((1, 2)), np.cumsum(tangent[1:] + tangent[:-1], axis=0) / 2 / (FINE - 1)])
        return points - np.trapezoid(points, self.arc, axis=0), tangent

    def velocity(self, t: float) -> np.ndarray:
        """(3,): of the body frame, in the body frame."""
        points, tangent = self.curve(t)
        bending = (self.curve(t + 1e-5)[0] - self.curve(t - 1e-5)[0]) / 2e-5
        normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
        drag = np.einsum("ki,kj->kij", tangent, tangent) / K + np.einsum("ki,kj->kij", normal, normal)
        moves = np.zeros((FINE, 2, 3))
        moves[:, 0, 0] = moves[:, 1, 1] = 1
        moves[:, :, 2] = np.stack([-points[:, 1], points[:, 0]], axis=1)
        resist = np.trapezoid(np.einsum("kia,kij,kjb->kab", moves, drag, moves), self.arc, axis=0)
        thrust = np.trapezoid(np.einsum("kia,kij,kj->ka", moves, drag, bending), self.arc, axis=0)
        return -np.linalg.solve(resist, thrust)

    def film(self, seconds: float, count: int = POINTS) -> tuple[np.ndarray, np.ndarray]:
        """Times (F,) and points (F, count, 2) with noise; midpoint rule, four steps a frame."""
        step, pose, points = 1 / FRAMES_PER_SECOND / 4, np.zeros(3), []
        for i in range(int(seconds * FRAMES_PER_SECOND) * 4):
            if i % 4 == 0:
                points.append(self.curve(i * step)[0][:: (FINE - 1) // (count - 1)] @ turning(pose[2]).T + pose[:2])
            moved = self.velocity((i + 0.5) * step) * step
            middle = turning(pose[2] + moved[2] / 2)
            pose = pose + np.concatenate([middle @ moved[:2], moved[2:]])
        seen = np.array(points) + np.random.default_rng(1).normal(0, NOISE, (len(points), count, 2))
        return np.arange(len(seen)) / FRAMES_PER_SECOND, seen


def turning(angle: float) -> np.ndarray:
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def write(folder: Path, time: np.ndarray, points: np.ndarray) -> Path:
    """A campaign of a crawler in micrometres, a millimetre long."""
    folder.mkdir()
    return animal_campaign(folder, "worm", time, 1000 * points, "um")


@pytest.fixture(scope="module")
def film() -> tuple[np.ndarray, np.ndarray]:
    return Worm().film(2.5)


@pytest.fixture(scope="module")
def worm(film: tuple[np.ndarray, np.ndarray], tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("worms") / "worm", *film)


def fitted(worm: Path, dissipation: str) -> tuple[tuple[float, float, float], float]:
    """K with its interval, and what is left over noise."""
    campaign = load_campaign(worm)
    model = neutral_model(campaign, dissipation=dissipation)
    found = anisotropy(campaign, model)
    return drag_ratio(found, model), found.noise_scale


def test_k_is_found_and_where_drag_sits_does_not_matter_to_a_smooth_body(worm: Path) -> None:
    """Of eight seeds K is 11.99 to 12.01, and every interval holds it."""
    (value, low, high), left = fitted(worm, "vertex")
    assert value == pytest.approx(K, rel=0.003)
    assert low < K < high
    assert 0.7 < left < 1.4  # times the points' noise; chains of straight links leave 5 times as much
    assert fitted(worm, "edge")[0][0] == pytest.approx(value, rel=0.01)  # of straight links: K = 11.1 and 15.3


def test_few_points_of_a_body_are_points_of_a_curve_and_no_joints_of_a_chain(tmp_path: Path) -> None:
    """Chords of the 8 edges are up to 3 % shorter than their arcs, and change as the body bends."""
    worm = write(tmp_path / "few", *Worm().film(4.0, count=9))
    trial = load_campaign(worm).trials[0]
    assert trial.metres == pytest.approx(1e-3, rel=5e-4)  # along the body
    assert not any("peristalsis" in note for note in trial.notes)
    (value, low, high), left = fitted(worm, "vertex")
    assert low < K < high
    assert value == pytest.approx(K, rel=0.01)
    assert left < 1.4


@pytest.mark.slow
def test_many_close_points_tell_the_same_k_and_leave_their_noise(tmp_path: Path) -> None:
    """45 points, as trackers of worms give them, with a noise of a seventh of an edge: most of every joint angle. Four
    films: of one of 2.5 s what is left is known to a tenth."""
    time, points = Worm().film(2.5, count=45)
    found = []
    for seed in range(2, 6):
        noisy = points + np.random.default_rng(seed).normal(0, 3e-3, points.shape)
        campaign = load_campaign(write(tmp_path / f"many-{seed}", time, noisy))
        segments = trial_segments(campaign.trials[0])
        found.append(fit(neutral_model(campaign), segments, ("anisotropy_ratio",), np.array([1 / K])))
    assert np.mean([1 / each.values[0] for each in found]) == pytest.approx(K, rel=0.03)  # joints by themselves: -5 %
    assert 0.8 < np.mean([each.noise_scale for each in found]) < 1.25  # unseen directions counted by the size of C: 16


@pytest.mark.parametrize("every", [1, 6])  # of its frames; every sixth makes windows of two frames, twice as long
def test_a_long_recording_is_used_for_so_many_windows(
    film: tuple[np.ndarray, np.ndarray], tmp_path: Path, every: int
) -> None:
    beats = 2 * MOST_WINDOWS // WINDOWS_PER_PERIOD
    time = np.arange(int(beats / RATE * FRAMES_PER_SECOND))[::every] / FRAMES_PER_SECOND
    still = np.stack([Worm().curve(t)[0][:: (FINE - 1) // (POINTS - 1)] for t in time])
    noise = np.random.default_rng(2).normal(0, NOISE, still.shape)
    (kept,) = tracked_recordings(load_campaign(write(tmp_path / "long", time, still + noise)))
    window = max(1 / RATE / WINDOWS_PER_PERIOD, 2 * every / FRAMES_PER_SECOND)
    used = kept.smoothed.states.time[-1]
    assert used == pytest.approx(MOST_WINDOWS * window, rel=0.15)  # a beat's length is estimated
    assert any("the first" in r.words and "`from_s`" in r.words for r in kept.remarks)


@pytest.mark.slow
def test_noise_of_an_animals_paths_is_what_draws_of_its_points_add_up_to(tmp_path: Path) -> None:
    """Two routes: windows with the share of poses that draws tell, strung together, and paths of draws themselves. 24
    draws know an RMS to 15 %; windows taken for independent add up to half as much again."""
    campaign = load_campaign(write(tmp_path / "longer", *Worm().film(6.0)))
    recordings = tracked_recordings(campaign)
    model = Model(campaign.body, Medium(anisotropy_ratio=1 / K))
    tracks = tuple(replace(t, doubt=0.0) for t in tracker(recordings)(model))  # of the curve, which no draw holds
    motion = Motion(tracks, window_noise(tracks, [])[0], tuple(range(len(tracks))))
    expected = predictions(model, tracks)
    level = path_noise(motion, expected).level_m
    apart = path_noise(replace(motion, noise=replace(motion.noise, memory=Memory())), expected).level_m
    drawn = drawn_paths(recordings[0], model, len(tracks))
    assert level == pytest.approx(drawn, rel=0.3)
    assert apart > 1.3 * drawn


def drawn_paths(recording: TrackedRecording, model: Model, parts: int) -> float:
    """RMS [m] of the paths of parts as drawn points have them, about the recording's own."""
    rng = np.random.default_rng(5)
    first, step, count = _mesh(recording.smoothed.states)
    squares = []

    def missed(states: States) -> list[np.ndarray]:
        run = _run(states, first, step, count // parts * parts)
        return [_missed(model, t) for t in _cut(recording, states, run, parts)]

    own = missed(recording.smoothed.states)
    steps = [p.displacement for p in predictions(model, tracker([recording])(model))]
    for _ in range(24):
        for moved, a, b in zip(steps, missed(recording.smoothed.draw(rng)), own, strict=True):
            paths = [accumulate(m, np.zeros(3))[:, :2] for m in (moved, moved + a - b)]
            squares.append(((paths[1] - paths[0]) ** 2).sum(axis=1).mean())
    return float(np.sqrt(np.mean(squares)))


@pytest.mark.parametrize("kind", ["swimmer", "crawler"])
def test_an_animal_is_offered_no_wheels_and_advised_of_no_tyres(kind: str) -> None:
    offered = set(catalogue()) - not_on_offer(Body(kind=kind, vertices=5))
    assert {"inertia", "left_right_asymmetry"} <= offered
    assert ("added_mass" in offered) == (kind == "swimmer")
    said = " ".join(f"{find(n).words(animal=True)}" for n in offered if find(n).site == "medium")
    for part in ("wheel", "tyre", "axle", "servo", "robot", "mat", "pause", "gait"):
        assert part not in said.replace("material", ""), part


def test_a_body_of_no_stated_kind_is_offered_everything_that_goes_with_wheels() -> None:
    assert not_on_offer(Body(vertices=5)) == {"rough_skin"}


def test_what_holds_a_vertex_back_is_a_wheel_or_a_skin_and_of_swimmers_and_animals_neither() -> None:
    for kind, name in (("wheeled robot", "worn_wheel"), ("crawling robot", "rough_skin")):
        offered = {"worn_wheel", "rough_skin"} - not_on_offer(Body(kind=kind, vertices=5))
        assert offered == {name}, kind
        assert Body(kind=kind, vertices=5).other_surface not in find(name).needs
    for kind in ("swimming robot", "swimmer", "crawler"):
        assert {"worn_wheel", "rough_skin"} <= not_on_offer(Body(kind=kind, vertices=5))


def test_a_swimming_robot_has_servos_and_water_and_no_wheels(tmp_path: Path) -> None:
    offered = set(catalogue()) - not_on_offer(Body(kind="swimming robot", vertices=5))
    assert {"servo_lag", "zero_offset", "clock_offset", "added_mass"} <= offered
    assert not {"worn_wheel", "toe", "friction_patch", "slope"} & offered


def test_a_crawling_robot_has_servos_and_ground_and_no_wheels() -> None:
    offered = set(catalogue()) - not_on_offer(Body(kind="crawling robot", vertices=5))
    assert {"servo_lag", "load", "slope", "dry_friction", "grip_saturation"} <= offered
    assert not {"worn_wheel", "toe", "track_width", "wheel_mount", "contact_offset", "added_mass"} & offered


def test_an_animal_with_a_joint_table_is_asked_whether_it_is_a_robot(tmp_path: Path) -> None:
    trial = '[[trial]]\nname = "one"\njoint_table = "t.csv"\ncycle_duration_s = 1.0\n'
    for kind, fine in (("swimmer", False), ("swimming robot", True)):
        (tmp_path / "campaign.toml").write_text(
            f'format = 1\nname = "w"\n[body]\nvertices = 5\nkind = "{kind}"\n{trial}'
        )
        if fine:
            assert not load_campaign_file(tmp_path)[0].uniform
        else:
            with pytest.raises(InputError, match=r'is an animal, and has neither .* "swimming robot"'):
                load_campaign_file(tmp_path)


def test_drag_of_an_animal_has_no_elements_to_choose(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    time, points = Worm().film(1.0)
    folder = write(tmp_path / "worm", time, points)
    assert main(["fit", str(folder), "--dissipation", "edge", "--out", str(tmp_path / "out")]) == 2
    assert "drag acts all along an animal's body" in capsys.readouterr().err


def test_points_that_scatter_about_a_body_of_one_length_are_no_peristalsis(tmp_path: Path) -> None:
    for seed, seconds in ((1, 0.6), (2, 2.0), (3, 4.0)):
        time, points = Worm().film(seconds)
        noisy = points + np.random.default_rng(seed).normal(0, 3e-3, points.shape)
        (trial,) = load_campaign(write(tmp_path / str(seed), time, noisy)).trials
        assert not [note for note in trial.notes if "peristalsis" in note]


def test_a_name_that_does_no_more_than_links_are_off_by_may_be_a_stand_in() -> None:
    """Links are off by 2 % of what effects do, 3.9 % with 95 %: of 100 noise levels 3.9. Marker effects move
    nothing, and where points are all that there is of the body (a robot's joints) nothing is off."""
    strong, weak, seen = (Named(ActiveEffect.neutral(name, place), {}, size) for name, place, size in NAMES)
    for coarse, marked in ((0.02, True), (0.0, False)):
        motion: Any = SimpleNamespace(tracks=[SimpleNamespace(coarse=coarse)] * 2)
        assert [n.stand_in for n in amid_points(motion, [strong, weak, seen])] == [False, marked, False]
    motion = SimpleNamespace(tracks=[SimpleNamespace(coarse=0.02)])
    (alone,) = amid_points(motion, [weak])
    assert not alone.stand_in
