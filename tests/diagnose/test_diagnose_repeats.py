"""What tells chance: trials played again, else cycles of one trial, else nothing, and then errors hide nothing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from blind.campaign import make
from blind.catalogue import Effect
from blind.folder import write
from blind.protocol import COMBINATIONS, usual
from serpenoid.diagnose.data.noise.motion import Motion, Noise
from serpenoid.diagnose.data.noise.noise import over_markers, window_noise
from serpenoid.diagnose.data.noise.repeats import chance_from, none_alike, pairs, repeats
from serpenoid.diagnose.data.noise.shared import repeatable
from serpenoid.diagnose.data.noise.untold import untold
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.used import CHANCE, about_cameras, remarks
from serpenoid.diagnose.diagnose import diagnose
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.start import baseline
from serpenoid.measure.remark import Remark

PHASES, NOISE, SHARED = 8, 1e-3, 4e-3


def track(gait: str, cycles: int, noise: object = None) -> Any:
    """Eight windows a cycle and two of a pause, all of one second; at rest in the modelled world."""
    cycle = np.repeat(np.arange(cycles), PHASES + 2)
    phase = np.tile([*(np.arange(PHASES) + 0.5) / PHASES, 1.0, 1.0], cycles)
    count = len(phase)
    body = SimpleNamespace(total_length_m=0.5)
    recording = SimpleNamespace(name=gait, setting=(gait, 3.0), remarks=(Remark("seen"),), body=body)
    return SimpleNamespace(
        recording=recording, noise=noise, cycle=cycle, phase=phase, playing=phase < 1, least=np.zeros((count, 3)),
        marker_noise=None, doubt=0.0, displacement=np.zeros((count, 3)), duration=np.ones(count),
        boundaries=np.arange(count + 1), usable=np.ones(count, dtype=bool), time=np.arange(count + 1.0),
        on_floor=np.zeros((count + 1, 3)),
    )  # fmt: skip


def test_trials_tell_chance_before_cycles_do_and_what_is_poor_is_remarked() -> None:
    once = [track("a", 1), track("b", 1)]
    assert (chance_from(once), repeats(once)) == ("residuals", [])
    assert remarks(once) == (
        CHANCE["residuals"],
        "a, b: seen",
    )
    (found,) = repeats([track("a", 2), track("b", 1)])
    assert (found.one, found.other, *found.here[[0, -1]], *found.there[[0, -1]]) == (0, 0, 0, 9, 10, 19)
    assert remarks([track("a", 2)]) == (CHANCE["cycles"], "a: seen")
    again = [track("a", 3), track("b", 3), track("a", 2)]
    (found,) = repeats(again)
    assert (found.one, found.other, len(found.here), chance_from(again)) == (0, 2, 20, "trials")
    assert remarks(again) == ("a, b: seen",)
    stretched = "links are longer along one direction"
    for one in again:
        one.recording.remarks = (Remark("seen"), Remark(stretched, "cameras"))
    assert (remarks(again), about_cameras(again)) == (("a, b: seen",), (stretched,))
    again[1].recording.remarks = (Remark("seen"),)
    assert (remarks(again), about_cameras(again)) == (("a, b: seen",), (f"a: {stretched}",))
    assert chance_from([track("a", 3, noise=1.0)]) == "points"  # an animal's windows bring their own


def test_cycles_tell_chance_from_an_error_that_every_cycle_has() -> None:
    rng = np.random.default_rng(0)
    tracks = [track(gait, 5) for gait in "abcdef"]
    shared = [np.tile(rng.normal(0, SHARED, (PHASES + 2, 3)), (5, 1)) for _ in tracks]
    left = [s + rng.normal(0, NOISE, s.shape) for s in shared]
    noise, differences = window_noise(tracks, left)
    assert len(differences) == 6 * 4 * PHASES
    np.testing.assert_allclose(noise.playing, NOISE, rtol=0.2)  # 192 differences, each shared by two: 6 % is one SD
    motion = cast(Motion, SimpleNamespace(tracks=tuple(tracks), noise=noise))
    assert repeatable(motion, left).ratio > 10  # 1 + 2 (4/1)^2 = 33
    assert repeatable(motion, [x - s for x, s in zip(left, shared, strict=True)]).ratio == pytest.approx(1, abs=0.3)


def test_it_is_told_how_much_of_what_repeats_differ_by_is_no_noise_of_the_markers() -> None:
    quiet = [track("a", 3), track("a", 3)]
    seen = [replaced(t, least=np.full((len(t.phase), 3), NOISE)) for t in quiet]
    noise = Noise(np.full(3, 5 * NOISE), np.full(3, NOISE))

    def over(tracks: list[Any]) -> float | None:
        return over_markers(cast(Motion, SimpleNamespace(tracks=tracks, noise=noise)))

    assert over(seen) == pytest.approx(5)  # pauses do not count
    assert over(quiet) is None  # markers without noise
    once = [replaced(seen[0], cycle=0 * seen[0].cycle)]
    assert over(once) == pytest.approx(5)  # nothing was played again: what the model leaves


def replaced(of: Any, **values: object) -> Any:
    return SimpleNamespace(**(vars(of) | values))


@pytest.mark.parametrize(("cycles", "shared"), [(2, 1.3), (12, 0.7)])
def test_something_repeats_no_more_often_than_stated_on_chance_that_neighbours_share(
    cycles: int, shared: float
) -> None:
    """shared: of what repeats, over chance, that a campaign so long tells nearly always."""
    rng = np.random.default_rng(1)
    tracks = [track(gait, cycles) for gait in "aabb"]
    ends = np.arange(len(tracks[0].phase) + 1)
    motion = cast(Motion, SimpleNamespace(tracks=tuple(tracks), noise=Noise(np.ones(3), np.ones(3))))

    def news(size: float) -> bool:
        same = [size * rng.normal(size=(len(ends) - 1, 3)) for _ in "ab"]
        poses = rng.normal(size=(4, len(ends), 3)) / np.sqrt(2)  # of markers: a window has the noise of both its ends
        return repeatable(motion, [np.diff(p, axis=0) + same[i // 2] for i, p in enumerate(poses)]).news

    assert sum(news(0.0) for _ in range(60)) <= 1  # 1 % of 60
    assert sum(news(shared) for _ in range(20)) >= 18


def laid(gait: str, cycles: int, x_m: float, heading: float) -> Any:
    """Of a body of 0.5 m."""
    return replaced(track(gait, cycles), on_floor=np.tile([x_m, 0.0, heading], (cycles * (PHASES + 2) + 1, 1)))


def test_trials_that_were_laid_alike_tell_chance_and_only_where_none_were_those_laid_otherwise() -> None:
    mixed = [laid("a", 2, x, h) for x, h in [(0.0, 0.0), (0.0, 2.0), (0.1, 6.5), (0.3, 0.0), (0.0, 2.2)]]
    assert pairs(mixed) == [(0, 2), (1, 4)]
    assert not none_alike(mixed)
    apart = [laid("a", 2, 0.0, h) for h in (0.0, 2.0, 4.0)]
    assert pairs(apart) == [(0, 1), (1, 2)]
    assert none_alike(apart)
    assert not none_alike([laid("a", 2, 0.0, 0.0), laid("b", 2, 0.0, 0.0)])


def by_chance(rng: np.random.Generator, own: float, cycles: int, headings: tuple[float, float] = (0.0, 2.0)) -> Any:
    """Motion and residuals of six settings, played twice: pushes, and what a trial has alike in every cycle."""
    tracks = [laid(gait, cycles, 0.0, heading) for gait in "abcdef" for heading in headings]
    tracks = [replaced(t, least=np.full((len(t.phase), 3), NOISE / 2)) for t in tracks]
    pushes = [2.0 ** "abcdef".index(t.recording.name) for t in tracks]  # settings differ in noise
    left = []
    for size in pushes:
        alike = np.tile(rng.normal(0, own * size, (PHASES + 2, 3)), (cycles, 1))
        left.append(alike + rng.normal(0, NOISE * size, alike.shape))
    noise, _ = window_noise(tracks, left)
    return cast(Motion, SimpleNamespace(tracks=tuple(tracks), noise=noise, unlike=0.0)), left


@pytest.mark.slow
def test_what_trials_laid_otherwise_differ_by_in_every_cycle_is_no_chance() -> None:
    rng = np.random.default_rng(2)
    assert sum(untold(*by_chance(rng, 0.0, cycles=3)) is not None for _ in range(100)) <= 3  # 1/3 % of 100
    found = [untold(*by_chance(rng, SHARED, cycles=3)) for _ in range(5)]
    size = SHARED * np.sqrt(2 * np.mean(4.0 ** np.arange(6)))  # of both directions
    for f in found:
        assert f is not None
        assert f.by_cycles
        # three quarters of the square are of one setting, of 48 numbers: 10 % is one SD
        assert f.size == pytest.approx(size, rel=0.35)
        assert f.ratio == pytest.approx(np.hypot(SHARED, NOISE) / NOISE, rel=0.25)
    assert untold(*by_chance(rng, SHARED, cycles=3, headings=(0.0, 0.1))) is None  # laid alike: chance, by definition


def test_in_trials_of_one_cycle_pushes_are_forgotten_at_once_and_the_room_is_not() -> None:
    rng = np.random.default_rng(3)
    motion, pushes = by_chance(rng, SHARED, cycles=1)
    assert untold(motion, pushes) is None
    pulled = [rng.normal(0, 1e-3, x.shape) + rng.normal(0, SHARED, 3) for x in pushes]
    noise, _ = window_noise(motion.tracks, pulled)
    found = untold(cast(Motion, replaced(motion, noise=noise)), pulled)
    assert found is not None
    assert not found.by_cycles
    assert found.size == pytest.approx(np.sqrt(2) * SHARED, rel=0.5)  # of six settings: 30 % is one SD


def test_what_repeats_of_a_reference_differed_by_is_no_news() -> None:
    motion, left = by_chance(np.random.default_rng(4), SHARED, cycles=3)
    assert untold(motion, left) is not None
    assert untold(cast(Motion, replaced(motion, unlike=1.0)), left) is None


@pytest.mark.slow  # the search for two effects: test_diagnose_groups.py
def test_two_effects_that_hide_one_another_are_found_though_nothing_was_played_twice(tmp_path: Path) -> None:
    """Noise is what a model leaves: with one of the two it is large, and the one alone would be below detection."""
    settings = tuple(replace(s, plan=replace(s.plan, cycles=1)) for s in usual(3, COMBINATIONS[:4]).settings)
    hidden = [Effect("grip_saturation", None, {"saturation_speed": 0.06}), Effect("load", 2, {"share": 1.0})]
    write(make(3, hidden, protocol=replace(usual(3), settings=settings, plays=1)), tmp_path)
    file, recordings = read_recordings(tmp_path)
    found = diagnose(recordings, Baseline(baseline(None, file, file.body)), lambda text: None)
    assert {(n.effect.name, n.effect.place) for n in found.named} == {("grip_saturation", None), ("load", 2)}
    assert found.verdict == "explained"
