"""Points whose names a tracker exchanges for a while: named with the time, and nothing said of others."""

import numpy as np
import pytest

from serpenoid.errors import InputError
from serpenoid.measure.consistency.exchanged import exchanges, named_as_in_most, told
from serpenoid.measure.load import load_campaign

LABELS = [f"p{k}" for k in range(7)]


def crawling(frames=240, noise=0.001, hidden=0.0, seed=0):
    """A wave that runs down seven points of a body of one metre, on its way at half a metre a second."""
    rng = np.random.default_rng(seed)
    time, place = np.arange(frames) / 30, np.linspace(0, 1, 7)
    points = np.stack(
        [0.5 * time[:, None] + place, 0.12 * np.sin(2 * np.pi * (1.3 * place - time[:, None] / 2))], axis=2
    )
    points += noise * rng.normal(size=points.shape)
    points[rng.random(points.shape[:2]) < hidden] = np.nan
    return time, points


@pytest.mark.parametrize("hidden", [0.0, 0.05])
@pytest.mark.parametrize(
    "order", [[0, 1, 4, 3, 2, 5, 6], [0, 2, 1, 3, 4, 5, 6], [0, 2, 3, 1, 4, 5, 6], [6, 5, 4, 3, 2, 1, 0]]
)
def test_points_exchanged_for_a_while_are_told_with_the_time(order, hidden):
    time, points = crawling(hidden=hidden)
    points[100:130] = points[100:130, order]
    (found,) = exchanges(points, time)
    assert found.first == pytest.approx(100, abs=2)  # a point may be hidden just there
    assert found.last == pytest.approx(129, abs=2)
    assert sorted(k for k, name in enumerate(found.names) if name != k) == [k for k in range(7) if order[k] != k]


@pytest.mark.parametrize("share", [0.1, 0.2, 0.45])
@pytest.mark.parametrize("hidden", [0.0, 0.05])
def test_ends_that_are_confused_in_many_frames_are_told_and_put_back(share, hidden):
    """A worm digitised by hand, from the other end in every second frame, passed for one in which nothing moved."""
    time, points = crawling(hidden=hidden)
    turned = np.random.default_rng(0).random(len(time)) < share
    film = np.where(turned[:, None, None], points[:, ::-1], points)
    put, found = named_as_in_most(film, time)
    assert sum(one.last + 1 - one.first for one in found) == turned.sum()
    assert np.array_equal(put, points, equal_nan=True)
    assert told(found, LABELS, time).startswith("all points, head for tail, exchanged ")


def test_a_body_that_curls_up_or_shakes_confuses_no_ends():
    time, points = crawling(noise=0.2)
    assert exchanges(points, time) == ()
    angle = np.cumsum(np.full((240, 6), 0.9) + 0.5 * np.sin(3 * time[:, None] + np.arange(6)), axis=1)
    steps = np.stack([np.cos(angle), np.sin(angle)], axis=2)
    ring = np.concatenate([np.zeros((240, 1, 2)), np.cumsum(steps, axis=1)], axis=1)
    assert exchanges(ring + 0.01 * np.random.default_rng(1).normal(size=ring.shape), time) == ()


@pytest.mark.parametrize("seed", range(6))
def test_points_that_stray_to_a_reflection_in_turn_are_no_exchange_and_a_true_one_beside_them_is_told(seed):
    time, points = crawling(seed=seed)
    rng = np.random.default_rng(seed)
    true = points.copy()
    true[200:220, [1, 4]] = true[200:220, [4, 1]]
    for film in (points, true):
        for frame in (60, 120, 170):
            one, two = rng.choice(7, 2, replace=False)
            film[frame : frame + 2, one] = [1.0, 0.5] + rng.normal(0, 0.002, (2, 2))
            film[frame + 2 : frame + 4, two] = [1.0, 0.5] + rng.normal(0, 0.002, (2, 2))
    assert exchanges(points, time) == ()
    (found,) = exchanges(true, time)
    assert found.said(LABELS, time) == "`p1` and `p4` exchanged between 6.667 and 7.3 s"


def test_points_exchanged_to_the_end_are_told_and_most_of_the_recording_is_right():
    time, points = crawling()
    points[:60, [1, 4]] = points[:60, [4, 1]]
    (found,) = exchanges(points, time)
    assert found.said(LABELS, time) == "`p1` and `p4` exchanged between 0 and 1.967 s"


@pytest.mark.parametrize("order", [[0, 2, 3, 1, 4, 5, 6], [6, 5, 4, 3, 2, 1, 0]])
def test_points_get_back_the_names_of_most_of_the_recording(order):
    time, points = crawling()
    wrong = points.copy()
    wrong[100:130] = points[100:130, order]
    put, found = named_as_in_most(wrong, time)
    assert len(found) == 1
    np.testing.assert_array_equal(put, points)


@pytest.mark.parametrize("turn", [4.5, 5.5, 6.5])
def test_the_ends_of_a_body_that_is_curled_up_are_confused_as_ends(turn):
    time, place = np.arange(60) / 16, np.linspace(-0.5, 0.5, 12)
    bend = turn * np.sin(np.pi * np.minimum(time / time[-1], 1.0))[:, None] * place
    along = np.cumsum(np.stack([np.cos(bend), np.sin(bend)], axis=2), axis=1) / 12
    points = along + np.random.default_rng(3).normal(0, 0.02, along.shape)
    points[28:32] = points[28:32, ::-1]  # where its ends are side by side
    (found,) = exchanges(points, time)
    assert found.said([str(k) for k in range(12)], time).startswith("all points, head for tail, exchanged")
    assert (found.first, found.last) == (28, 31)


@pytest.mark.parametrize("seed", range(20))
def test_noise_hidden_points_outliers_and_a_pushed_camera_are_no_exchange(seed):
    time, points = crawling(hidden=0.2, noise=0.005, seed=seed)
    rng = np.random.default_rng(100 + seed)
    points[rng.integers(0, 240, 10), rng.integers(0, 7, 10)] += rng.normal(size=(10, 2))
    points[150:] += [1 / 6, 0.0]  # as far as one point is from the next
    assert exchanges(points, time) == ()


@pytest.mark.parametrize("count", [6, 12, 22])
def test_a_body_that_jumps_along_itself_by_a_vertex_is_no_exchange(count):
    """Rows that are held: a wave moves on by a vertex in one frame, and every vertex is where its neighbour was."""
    frames = np.arange(200)
    place = np.arange(count)[None, :] + (0.01 * frames + (frames >= 120))[:, None]
    points = np.stack([place, 4.0 * np.sin(2 * np.pi * place / 15)], axis=2) / count
    points += np.random.default_rng(4).normal(0, 0.02 / count, points.shape)
    assert exchanges(points, np.arange(len(points)) / 30) == ()


def written(folder, recordings):
    """A campaign of animals of unknown length."""
    header = ",".join(["t_s", *(f"{axis}_{k}" for k in range(7) for axis in "xy")])
    trials = ""
    for name, (time, points) in recordings.items():
        rows = np.column_stack([time, points.reshape(len(time), -1)])
        np.savetxt(folder / f"{name}.csv", rows, delimiter=",", header=header, comments="")
        trials += f'[[trial]]\nname = "{name}"\nmotion = "{name}.csv"\n'
    (folder / "campaign.toml").write_text(
        'format = 1\nname = "a"\n[body]\nkind = "crawler"\nvertices = 7\n[motion]\nformat = "tidy"\n'
        f'length_unit = "m"\n{trials}'
    )
    return folder


def test_a_campaign_with_exchanged_points_is_refused_in_words(tmp_path):
    time, points = crawling()
    points[100:130, [2, 4]] = points[100:130, [4, 2]]
    with pytest.raises(InputError, match=r"`one`: its markers have `vertex_2` and `vertex_4` exchanged between 3.333"):
        load_campaign(written(tmp_path, {"one": (time, points)}))


def test_exchanged_points_are_put_back_on_demand_and_it_is_said(tmp_path):
    time, points = crawling()
    wrong = points.copy()
    wrong[100:130] = points[100:130, ::-1]
    folder = written(tmp_path, {"one": (time, wrong)})
    with pytest.raises(InputError, match="set `undo_exchanges = true`"):
        load_campaign(folder)
    path = folder / "campaign.toml"
    path.write_text(path.read_text().replace("[motion]", "[motion]\nundo_exchanges = true"))
    (trial,) = load_campaign(folder).trials
    assert any("all points, head for tail, exchanged between 3.333 and 4.3 s" in note for note in trial.notes)
    assert trial.motion is not None
    np.testing.assert_allclose(trial.motion.markers * trial.metres, points, atol=0.01)


def test_two_animals_in_one_campaign_without_lengths_are_refused(tmp_path):
    recordings = {name: crawling(seed=seed) for seed, name in enumerate(["a", "b", "c"])}
    recordings["b"] = recordings["b"][0], 1.3 * recordings["b"][1]
    with pytest.raises(InputError, match=r"trial `b`: its body is 1\.(29|3) times as long as in trial `[ac]`"):
        load_campaign(written(tmp_path, recordings))


def test_one_animal_whose_camera_is_calibrated_to_a_few_per_cent_is_taken(tmp_path):
    recordings = {name: crawling(seed=seed) for seed, name in enumerate(["a", "b"])}
    recordings["b"] = recordings["b"][0], 1.03 * recordings["b"][1]
    assert len(load_campaign(written(tmp_path, recordings)).trials) == 2


def test_a_point_that_no_frame_shows_is_named_alone(tmp_path):
    time, points = crawling()
    points[:, 2] = np.nan
    with pytest.raises(InputError, match="no lengths, and `vertex_2` is never seen, in no frame of any recording"):
        load_campaign(written(tmp_path, {"one": (time, points), "two": (time, points + 1)}))


def test_neighbours_that_are_never_seen_together_are_named(tmp_path):
    time, points = crawling()
    points[::2, 2], points[1::2, 3] = np.nan, np.nan
    with pytest.raises(InputError, match="never seen together: `vertex_2` and `vertex_3`"):
        load_campaign(written(tmp_path, {"one": (time, points)}))


def test_a_recording_in_utf_16_is_the_same_and_one_that_does_not_say_so_is_told(tmp_path):
    folder = written(tmp_path, {"one": crawling()})
    text = (folder / "one.csv").read_text()
    first = load_campaign(folder)
    (folder / "one.csv").write_text(text, encoding="utf-16")
    assert np.array_equal(load_campaign(folder).trials[0].motion.markers, first.trials[0].motion.markers)
    (folder / "one.csv").write_text(text, encoding="utf-16-le")  # no byte-order mark
    with pytest.raises(InputError, match="one.csv: not a text file"):
        load_campaign(folder)
