"""A film's scale against stated lengths: said where all links agree on it, never for markers beside their places."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rehearsal import serpenoid_table, snake
from serpenoid.body import Body
from serpenoid.compare.rehearse import Laboratory, write_campaign
from serpenoid.errors import InputError
from serpenoid.measure.consistency.films import Films
from serpenoid.measure.consistency.lengths import Shown, all_longer, beside_film, one_longer, turned, wrong_edge
from serpenoid.measure.load import load_campaign
from serpenoid.measure.shapes.lengths import shown_lengths, usual, without_noise
from serpenoid.measure.trial import build_motion
from serpenoid.simulation import simulate_joint_angles
from specimens import animal_campaign

EDGES = np.array([0.04, 0.08, 0.06, 0.1, 0.08, 0.05, 0.09])


def film(rng: np.random.Generator, scale: float, noise: float, beside: float = 0.0, frames: int = 400) -> np.ndarray:
    """A chain that bends at random: noise of each frame, and markers beside their places for good, along [m]."""
    edges = EDGES + np.diff(rng.normal(scale=beside, size=len(EDGES) + 1))
    turned = np.cumsum(rng.normal(scale=0.3, size=(frames, len(edges))), axis=1)
    steps = edges[None, :, None] * np.stack([np.cos(turned), np.sin(turned)], axis=-1)
    points = np.concatenate([np.zeros((frames, 1, 2)), np.cumsum(steps, axis=1)], axis=1)
    return scale * points + rng.normal(scale=noise, size=points.shape)


@pytest.mark.parametrize("noise", [0.0002, 0.003])
@pytest.mark.parametrize("scale", [0.985, 1.01])
def test_a_scale_that_all_links_share_is_told(scale, noise):
    found = all_longer(Shown.of([film(np.random.default_rng(seed), scale, noise) for seed in range(4)], EDGES))
    assert found == pytest.approx(scale - 1, abs=0.001)


@pytest.mark.parametrize("noise", [0.0002, 0.003, 0.006])
def test_noise_lengthens_no_link(noise):
    rng = np.random.default_rng(7)
    assert [all_longer(Shown.of([film(rng, 1.0, noise)], EDGES)) for _ in range(40)] == [None] * 40


def test_markers_beside_their_places_are_no_scale():
    rng = np.random.default_rng(8)
    said = [all_longer(Shown.of([film(rng, 1.0, 0.0005, beside=0.002)], EDGES)) for _ in range(200)]
    assert sum(one is not None for one in said) <= 2


def test_a_single_link_says_nothing_and_unknown_links_are_left_out():
    points = film(np.random.default_rng(1), 1.02, 0.0002)
    assert all_longer(Shown.of([points[:, :2]], EDGES[:1])) is None
    unknown = np.where(np.arange(len(EDGES)) == 2, np.nan, EDGES)
    assert all_longer(Shown.of([points], unknown)) == pytest.approx(0.02, abs=0.001)


@pytest.mark.parametrize("noise", [0.0002, 0.003])
@pytest.mark.parametrize("scale", [1.0, 0.98])
def test_lengths_that_are_told_from_head_to_tail_are_said_to_be(scale, noise):
    points = film(np.random.default_rng(3), scale, noise)
    assert "turn `edge_lengths` round" in turned(Shown.of([points], EDGES[::-1]), EDGES[::-1], True)
    for told in (EDGES, np.full(len(EDGES), 0.07), np.roll(EDGES, 1)):
        assert turned(Shown.of([points], told), told, True) == ""


def test_markers_beside_their_places_turn_no_lengths_round():
    rng = np.random.default_rng(9)
    told = np.concatenate([EDGES[:3], EDGES[2::-1]])  # the same from either end
    points = [film(rng, 1.0, 0.0005, beside=0.004)[:, :7] for _ in range(50)]
    assert [turned(Shown.of([one], told), told, True) for one in points] == [""] * 50


def test_several_links_that_are_told_wrong_are_said_with_both_lengths():
    points, told = film(np.random.default_rng(4), 1.0, 0.0005), EDGES[[0, 2, 1, 3, 4, 5, 6]]
    said = beside_film(Shown.of([points], told), told, NAMES, True)
    assert re.search(r"`m1` to `m2` 0\.0[78]\d* m, not 0\.06 and `m2` to `m3` 0\.0[56]\d* m, not 0\.08;", said)
    assert "other lengths than `edge_lengths`" in said
    assert (
        beside_film(Shown.of([film(np.random.default_rng(5), 1.0, 0.0005, beside=0.001)], EDGES), EDGES, NAMES, True)
        == ""
    )


@pytest.mark.usefixtures("virtual_machine")
def test_a_campaign_whose_film_is_too_large_says_so_and_what_helps(tmp_path: Path):
    lab = Laboratory(frames_per_second=60.0)
    write_campaign(tmp_path, snake(), {"g": serpenoid_table(60)}, lab, 1, 3, cycles=1, pause_s=1.0)
    right = load_campaign(tmp_path)
    text = (tmp_path / "campaign.toml").read_text()
    stated = re.search(r"edge_lengths = \[(.*?)\]", text, re.S)
    shorter = [float(number) / 1.015 for number in stated[1].split(",") if number.strip()]
    (tmp_path / "campaign.toml").write_text(text.replace(stated[0], f"edge_lengths = {shorter}"))
    told = load_campaign(tmp_path)
    assert not any("all links" in note for trial in right.trials for note in trial.notes)
    assert all(any("all links are 1.5 % longer" in note for note in trial.notes) for trial in told.trials)
    (tmp_path / "campaign.toml").write_text(text.replace(stated[0], ""))
    mended = load_campaign(tmp_path)
    assert mended.trials[0].motion.marker_sd == pytest.approx(right.trials[0].motion.marker_sd, rel=0.02)


NAMES = [f"m{k}" for k in range(len(EDGES) + 1)]


@pytest.mark.parametrize(
    ("edge", "unknown", "certain"), [(3, None, True), (0, None, False), (3, 2, False), (3, 4, False)]
)
def test_an_edge_told_wrong_is_certain_where_its_neighbours_are_as_said(edge, unknown, certain):
    told = EDGES * np.where(np.arange(len(EDGES)) == edge, 1.08, 1.0)
    told[[] if unknown is None else [unknown]] = np.nan
    found = Shown.of([film(np.random.default_rng(4), 1.01, 0.0005)], told)
    assert one_longer(found) is not None
    said = wrong_edge(found, told, NAMES, True)
    assert (said is not None) is certain
    if said is not None:
        assert "`m3` and `m4`" in said[0]
        assert float(re.search(r"them to (.*), or leave", said[1])[1]) == pytest.approx(
            0.1, rel=0.002
        )  # at the others' scale


@pytest.mark.parametrize("ahead", [False, True])
@pytest.mark.parametrize("moved", [(-0.008, 0.0), (0.008, 0.005), (0.0, 0.02)])
def test_a_marker_beside_its_place_is_no_wrong_edge(moved, ahead):
    for seed in range(5):
        points = film(np.random.default_rng(seed), 1.0, 0.0005)
        along = points[:, 5] - points[:, 4] if ahead else points[:, 4] - points[:, 3]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        points[:, 4] += moved[0] * along + moved[1] * np.stack([-along[:, 1], along[:, 0]], axis=1)
        assert wrong_edge(Shown.of([points], EDGES), EDGES, NAMES, True) is None


def test_a_campaign_with_one_edge_told_wrong_is_refused_and_can_be_believed(tmp_path: Path):
    write_campaign(tmp_path, snake(), {"g": serpenoid_table(60)}, Laboratory(), 2, 3, cycles=1, pause_s=1.0)
    text = (tmp_path / "campaign.toml").read_text()
    stated = re.search(r"edge_lengths = \[(.*?)\]", text, re.S)
    lengths = [float(number) for number in stated[1].split(",") if number.strip()]
    lengths[4] *= 1.06
    (tmp_path / "campaign.toml").write_text(wrong := text.replace(stated[0], f"edge_lengths = {lengths}"))
    with pytest.raises(
        InputError, match=r"`.*vertex_4` and `.*vertex_5` 5.7 % closer .* Remedy: set .* to 0\.083\d*, or leave"
    ):
        load_campaign(tmp_path)
    (tmp_path / "campaign.toml").write_text(wrong.replace('gait = "g"', 'gait = "g"\nbelieve = true'))
    for trial in load_campaign(tmp_path).trials:
        assert sum("edge_lengths" in note for note in trial.notes) == 1
        assert any("believed against its data: its film shows" in note for note in trial.notes)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_other_lengths_leave_no_frame_open_that_the_body_told(seed):
    """Two points in five hidden: which frames are told for sure hangs on the lengths, and a fit takes all of a run."""
    rng, model = np.random.default_rng(seed), snake()
    table = serpenoid_table(120)
    moved = simulate_joint_angles(model, np.concatenate([table, table[:1]]), closed=False).vertices
    seen = moved + rng.normal(scale=2e-4, size=moved.shape)
    seen[rng.random(seen.shape[:2]) < 0.4] = np.nan
    time, edges = np.arange(121) / 30, np.array(model.body.edges)
    other = model.body.changed(edge_lengths=tuple((edges * (1 + 0.01 * rng.normal(size=len(edges)))).tolist()))
    own, _, _ = build_motion(model.body, time, seen, None, ((), ()))
    made, _, _ = build_motion(other, time, seen, None, ((), ()), own)
    assert len(own.runs) > 1
    assert all(np.isfinite(made.smooth_angles[run]).all() for run in own.runs)


PIECES, POINTS = 480, 11


def swimmer(frames_a_beat: float, beats: int, noise: float) -> tuple[np.ndarray, np.ndarray]:
    """Times (F,) [s] and points (F, POINTS, 2) of a curve of length 1 with a wave on it, swinging about its middle."""
    time, arc = np.arange(round(frames_a_beat * beats)) / 30, (np.arange(PIECES) + 0.5) / PIECES
    angle = 0.85 * np.sin(2 * np.pi * (30 / frames_a_beat * time[:, None] + 0.95 * arc))
    steps = np.stack([np.cos(angle), np.sin(angle)], axis=2) / PIECES
    ends = np.concatenate([np.zeros((len(time), 1, 2)), np.cumsum(steps, axis=1)], axis=1)
    ends -= ends.mean(axis=1, keepdims=True)
    seen = ends[:, :: PIECES // (POINTS - 1)]
    return time, seen + np.random.default_rng(4).normal(0, noise, seen.shape)


@pytest.mark.parametrize("frames_a_beat", [6.0, 7.5, 10.0])
def test_a_beat_of_few_frames_shortens_no_animal(tmp_path: Path, frames_a_beat: float):
    """Smoothing five frames of a beat of 7.5 would cut 4 % off every swing, and 1.8 % off the body."""
    time, points = swimmer(frames_a_beat, 16, 5e-4)
    body = load_campaign(animal_campaign(tmp_path, "fast", time, points, "m")).body
    assert body.total_length_m == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("frames_a_beat", [6.0, 12.0, 60.0])
@pytest.mark.parametrize("noise", [0.002, 0.005, 0.01])
def test_noise_lengthens_no_animal_however_few_frames_show_a_beat(noise: float, frames_a_beat: float):
    time, points = swimmer(frames_a_beat, round(240 / frames_a_beat), noise)
    body = Body(kind="crawler", vertices=POINTS)
    raw, found = (
        abs(usual(each).sum() - 1) for each in (shown_lengths(body, points), without_noise(body, time, points))
    )
    assert raw > 0.3 * (POINTS - 1) ** 2 * noise**2
    assert found < raw / 4


def test_a_body_that_stretches_is_no_noise_and_keeps_its_length():
    """Waves of stretching along it scatter lengths as a noise of half of them would, which adds 0.6 %."""
    time, points = swimmer(30.0, 6, 1e-3)
    middle = (np.arange(POINTS - 1) + 0.5) / (POINTS - 1)
    longer = 1 + 0.07 * np.sin(2 * np.pi * (time[:, None] - middle))
    steps = np.diff(points, axis=1) * longer[..., None]
    points = np.concatenate([points[:, :1], points[:, :1] + np.cumsum(steps, axis=1)], axis=1)
    body = Body(kind="crawler", vertices=POINTS)
    assert usual(without_noise(body, time, points)).sum() == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("turned", [90.0, 180.0, 37.0])
@pytest.mark.parametrize("mirror", [(1, 1), (-1, 1)])
def test_lengths_are_those_of_the_film_however_it_is_turned_or_mirrored(turned: float, mirror: tuple[int, int]):
    time, points = swimmer(12.0, 5, 0.005)
    body, (c, s) = Body(kind="crawler", vertices=POINTS), (np.cos(np.radians(turned)), np.sin(np.radians(turned)))
    other = without_noise(body, time, points @ np.array([[c, s], [-s, c]]) * mirror + 100)
    assert other == pytest.approx(without_noise(body, time, points), rel=1e-9)


def test_a_marker_whose_other_link_is_bent_all_the_time_or_long_is_no_wrong_edge():
    """By its mean bend a displaced marker may move one of its links by half of what it moves the other, and of a long
    one that is a small share."""
    told = np.array([0.06, 0.08, 0.25, 0.05, 0.07, 0.09, 0.06])
    for moved, bend in (((-0.0035, -0.0065), 0.3), ((-0.003, 0.0), 0.0)):
        rng = np.random.default_rng(5)
        turned = np.cumsum(rng.normal(scale=0.3, size=(400, len(told))) + bend * (np.arange(len(told)) == 3), axis=1)
        steps = told[None, :, None] * np.stack([np.cos(turned), np.sin(turned)], axis=-1)
        points = np.concatenate([np.zeros((400, 1, 2)), np.cumsum(steps, axis=1)], axis=1)
        along = steps[:, 3] / told[3]
        points[:, 3] += moved[0] * along + moved[1] * np.stack([-along[:, 1], along[:, 0]], axis=1)
        points += rng.normal(scale=0.0003, size=points.shape)
        found = Shown.of([points], told)
        assert one_longer(found) is not None  # the short link
        assert wrong_edge(found, told, NAMES, True) is None


def films(scales: list[float], noise: float, beside: float = 0.001) -> Films:
    """Of one robot with markers beside their places, each film with a scale of its own."""
    rng = np.random.default_rng(11)
    points = [film(np.random.default_rng(3), scale, 0.0, beside) for scale in scales]
    seen = [one + rng.normal(scale=noise, size=one.shape) for one in points]
    names = [f"p{k}" for k in range(len(EDGES) + 1)]
    return Films(tuple(f"t{k}" for k in range(len(seen))), (Shown.of(seen, EDGES), EDGES, names, True), tuple(seen))


@pytest.mark.parametrize("noise", [0.0002, 0.003])
def test_films_of_another_scale_than_others_are_told_one_by_one(noise):
    said = films([1.0, 1.03, 1.0, 1.03], noise, beside=0.0).said
    assert list(said) == ["t1", "t3"]
    assert {remark.kind for remark in said.values()} == {"cameras"}
    shown = [float(re.findall(r"all links are ([0-9.]+) % longer in this film", r.words)[0]) for r in said.values()]
    assert shown == pytest.approx([3.0, 3.0], abs=0.5)  # three standard errors of seven medians over 400 noisy frames


@pytest.mark.parametrize("noise", [0.0002, 0.003])
def test_films_of_one_scale_are_told_together_or_not_at_all(noise):
    assert films([1.0] * 4, noise).said == {}
    said = films([1.03] * 4, noise, beside=0.0).said
    assert len(said) == 4
    assert all("in the film than `edge_lengths`" in remark.words for remark in said.values())
    assert {remark.kind for remark in said.values()} == {"scale"}


def test_scales_that_change_within_films_as_much_are_the_cameras():
    """Perspective: links look longer the farther the robot has gone."""
    made = films([1.0, 1.02, 0.98], 0.0002)
    grown = tuple(points * np.linspace(0.98, 1.02, len(points))[:, None, None] for points in made.points)
    assert all("perspective" in remark.words for remark in replace(made, points=grown).said.values())


WAYS = [(np.cos(t), np.sin(t)) for t in (0.0, 0.7, 1.5, 2.3)]


@pytest.mark.parametrize("noise", [0.0002, 0.003])
def test_films_that_differ_by_which_way_links_point_are_a_stretched_cameras(noise):
    """Not told to give each film another scale."""
    made = films([1.0] * 4, noise, beside=0.0)
    turned = [points @ np.array([[c, s], [-s, c]]) for points, (c, s) in zip(made.points, WAYS, strict=True)]
    seen = tuple(points * [1.02, 1.0] for points in turned)
    said = replace(made, points=seen).said
    assert len(said) == 4
    for remark in said.values():
        assert "another along x than along y" in remark.words
        assert float(re.findall(r"up to ([0-9.]+) % longer", remark.words)[0]) == pytest.approx(2.0, abs=0.3)


def stretched(share: float, noise: float, links: int, seed: int = 3) -> Films:
    """Four films that differ in noise alone, of the first links."""
    rng, edges = np.random.default_rng(seed), EDGES[:links]
    every = [film(np.random.default_rng(seed), 1.0, 0.0)[:, : links + 1] * [1 + share, 1.0] for _ in range(4)]
    points = tuple(one + rng.normal(scale=noise, size=one.shape) for one in every)
    names = [f"p{k}" for k in range(links + 1)]
    return Films(tuple(f"t{k}" for k in range(len(points))), (Shown.of(points, edges), edges, names, True), points)


@pytest.mark.parametrize("links", [3, len(EDGES)])
def test_a_stretched_camera_is_told_by_links_that_turn_within_films_which_differ_in_nothing(links):
    """Before, only films that differed in scale were asked for directions."""
    said = stretched(0.022, 0.0002, links).said
    assert len(said) == 4
    for remark in said.values():
        assert remark.kind == "cameras"
        assert "differ by which way" not in remark.words
        share = float(re.findall(r"up to ([0-9.]+) % longer along one direction", remark.words)[0])
        assert share == pytest.approx(2.2, abs=0.15)  # two digits are told, and lengths are in logarithms


@pytest.mark.parametrize("noise", [0.0001, 0.0005, 0.002])
@pytest.mark.parametrize("links", [3, len(EDGES)])
def test_a_camera_that_is_not_stretched_is_told_of_no_direction(links, noise):
    for seed in range(6):
        assert stretched(0.0, noise, links, seed).said == {}


def test_a_marker_beside_its_place_is_no_stretched_camera():
    """Lengths of its two links go with how the joint is bent, and so with where they point, but not alike."""
    made = stretched(0.0, 0.0002, len(EDGES))
    points = [one.copy() for one in made.points]
    for one in points:
        ahead = np.diff(one, axis=1)[:, 3]
        one[:, 3] += 0.01 * np.stack([-ahead[:, 1], ahead[:, 0]], axis=1) / np.linalg.norm(ahead, axis=1)[:, None]
    shown = (Shown.of(points, EDGES), *made.shown[1:])
    said = replace(made, points=tuple(points), shown=shown).said
    assert not any("direction" in remark.words for remark in said.values())


def test_points_too_few_for_the_bends_of_a_body_make_no_end_of_it_longer_than_they_are_apart(tmp_path: Path):
    """The curve through 9 points of a snake that bends to and fro at each ran out into half circles at its ends: they
    came out 1.5 and 2.2 times as long as their points were apart, and a note spoke of lengths that nobody had given."""
    edges = np.array([82, 63, 75, 95, 166, 98, 87, 85]) / 1000
    time, bent = np.arange(300) / 30, np.array([-0.04, 0.48, -0.61, 0.43, -0.38, 0.35, -0.21])
    swing = 0.15 * np.sin(2 * np.pi * (time[:, None] - np.arange(7) / 5))
    way = np.concatenate([np.zeros((300, 1)), np.cumsum(bent + swing, axis=1)], axis=1)
    steps = edges[:, None] * np.stack([np.cos(way), np.sin(way)], axis=2)
    points = np.concatenate([np.zeros((300, 1, 2)), np.cumsum(steps, axis=1)], axis=1) + 0.02 * time[:, None, None]
    seen = points + np.random.default_rng(2).normal(0, 3e-4, points.shape)
    found = load_campaign(animal_campaign(tmp_path, "snake", time, seen, "m"))
    assert found.body.edges_m == pytest.approx(edges, rel=0.1)
    notes = found.trials[0].notes
    assert any("edges a wave" in note for note in notes)
    assert not any("`edge_lengths`" in note for note in notes)
