"""Markers at some vertices only: wheels in the middles of links have a vertex of their own, and no marker."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from rehearsal import of_links
from serpenoid.body import Body
from serpenoid.cli.main import main
from serpenoid.errors import InputError
from serpenoid.measure.consistency.claims import contradictions
from serpenoid.measure.consistency.geometry import Plane, marker_faults
from serpenoid.measure.consistency.layout import layout
from serpenoid.measure.consistency.lengths import Shown, one_longer
from serpenoid.measure.consistency.reach import reach
from serpenoid.measure.consistency.rivals import ODDS
from serpenoid.measure.load import load_campaign
from serpenoid.measure.shapes.links import chain_vertices

ENDS = [0, 2, 4, 6, 8]  # tail, three joints, head
SHOWN = 0.2e-3 * 2**0.5 / 0.05  # rad: noise of two markers on a link of 50 mm


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of a robot with wheels in the middles of its links, which shows every vertex."""
    folder = tmp_path_factory.mktemp("middles")
    robot = ["--joints", "3", "--edges", "0.05,0.1,0.08,0.06", "--wheels", "middles"]
    assert main(["new", "problem", str(folder / "mine.toml"), "--yes", *robot]) == 0
    words = ["--problem", str(folder / "mine.toml"), "--format", "tidy", "--yes"]
    with pytest.MonkeyPatch.context() as patch:  # a new campaign has markers at joints and ends
        patch.setattr(import_module("serpenoid.scaffold.campaign"), "_marked", lambda body: list(range(body.vertices)))
        assert main(["new", "campaign", str(folder / "campaign.toml"), *words]) == 0
    return folder


def marked(whole: Path, to: Path, key: str, shown: list[int] = ENDS) -> Path:
    """The same where joints and ends alone have markers, or others."""
    rows = [line.split(",") for line in (whole / "example" / "motion.csv").read_text().split()]
    kept = [[row[0], *(cell for k in shown for cell in row[1 + 2 * k : 3 + 2 * k])] for row in rows]
    kept[0] = ["t_s", *(f"{axis}_{k}" for k in range(len(shown)) for axis in "xy")]
    to.mkdir(parents=True)
    (to / "motion.csv").write_text("\n".join(",".join(row) for row in kept))
    text = (whole / "campaign.toml").read_text().replace("[motion] ", f"[motion]\n{key}\n#", 1)
    text = text.replace('"example/motion.csv"', f'"{to / "motion.csv"}"')
    path = whole / f"{to.name}.toml"
    path.write_text(text)
    return path


def test_shapes_are_those_that_all_vertices_show(whole: Path, tmp_path: Path) -> None:
    full = load_campaign(whole).trials[0].motion
    some = load_campaign(marked(whole, tmp_path / "some", f"vertices = {ENDS}")).trials[0].motion
    assert full is not None
    assert some is not None
    assert not len(some.jumps)
    assert not len(some.gaps)
    apart = some.joint_angles - full.joint_angles
    assert np.sqrt(np.nanmean(apart**2)) < SHOWN
    assert some.marker_sd == pytest.approx(full.marker_sd, rel=0.2)


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("vertices = [0, 2, 4, 8, 6]", "increasing"),
        ("vertices = [0, 2, 4, 6, 9]", "from 0 to 8"),
        ("vertices = [0, 2]", "5 markers for 2 vertices"),
        (f'vertices = {ENDS}\nmarkers = ["a", "b"]', "needs 5 names, got 2"),
        ("", "5 markers for 9 vertices"),
    ],
)
def test_what_does_not_fit_is_refused_in_words(whole: Path, tmp_path: Path, key: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        load_campaign(marked(whole, tmp_path / "wrong", key))


def edited(whole: Path, to: Path, old: str, new: str) -> Path:
    path = marked(whole, to, f"vertices = {ENDS}\nmarkers = {NAMES}".replace("'", '"'))
    assert old in (text := path.read_text())
    path.write_text(text.replace(old, new))
    return path


NAMES = ["tail", "a", "b", "c", "head"]


@pytest.mark.parametrize(
    ("old", "new", "kind", "words"),
    [
        ("vertices", "vertices", "", ""),
        ('length_unit = "m"', 'length_unit = "cm"', "scale", "0.01 times as far apart"),
        ('length_unit = "m"', 'length_unit = "mm"', "scale", "0.001 times as far apart"),
    ],
    ids=["healthy", "a hundredth", "a thousandth"],
)
def test_a_wrong_unit_is_refused_whatever_lies_between_markers(whole, tmp_path, old, new, kind, words):
    found = contradictions(edited(whole, tmp_path / "some", old, new))
    assert [one.kind for one in found] == [kind] * bool(kind)
    assert all(words in one.said for one in found)


def chain(vertices: int, joints: tuple[int, ...], edges: list[float], frames: int = 60) -> tuple[Body, np.ndarray]:
    """A body that undulates, and its vertices (F, N, 2) with noise of a hundredth of an edge."""
    body = Body(vertices=vertices, joints=joints, edge_lengths=tuple(edges))
    phase = np.linspace(0, 12, frames)[:, None] + 1.3 * np.arange(len(joints))
    poses = np.stack([np.linspace(0, 0.5, frames), np.zeros(frames), np.linspace(0, 1, frames)], axis=1)
    points = body.edges_m.sum() * chain_vertices(body, poses, 0.7 * np.sin(phase))
    return body, points + np.random.default_rng(3).normal(scale=0.01 * min(edges), size=points.shape)


def faults(body: Body, points: np.ndarray, shown: list[int]) -> list[tuple[str, str]]:
    plan = layout(points[:, shown], reach(body, body.edges_m, points, shown))
    return [(f.kind, f.words) for f in marker_faults(plan, [f"m{k}" for k in shown], None) if f.gain > ODDS]


LINKS = [0.06, 0.05, 0.1, 0.07, 0.09, 0.08]
WHERE = {"at the ends of links": range(0, 25, 4), "in their middles": range(2, 25, 4), "anywhere": [0, 3, 5, 9, 14, 24]}


@pytest.mark.parametrize("shown", WHERE.values(), ids=WHERE)
def test_markers_anywhere_are_checked(shown):
    shown = list(shown)
    body, points = chain(25, tuple(range(4, 24, 4)), [link / 4 for link in LINKS for _ in range(4)])
    assert faults(body, points, shown) == []
    ((kind, words), *_) = faults(body, 10 * points, shown)
    assert (kind, "times as far apart" in words) == ("scale", True)
    wrong = points.copy()
    wrong[:, [shown[1], shown[4]]] = points[:, [shown[4], shown[1]]]
    ((kind, words), *_) = faults(body, wrong, shown)
    assert kind == "markers"
    assert f"`m{shown[1]}` and `m{shown[4]}`" in words


def test_one_marker_in_another_unit_is_told_by_its_name():
    body, points = chain(25, tuple(range(4, 24, 4)), [link / 4 for link in LINKS for _ in range(4)])
    points[:, 8] *= 1000
    assert "`m8` where it cannot be" in faults(body, points, list(range(0, 25, 4)))[0][1]


def test_what_a_body_allows_between_two_markers():
    body = Body(vertices=6, joints=(1, 3), edge_lengths=(0.1, 0.2, 0.3, 0.4, 0.5))
    found = reach(body, body.edges_m, np.zeros((1, 6, 2)), [0, 1, 3, 4, 5])
    np.testing.assert_allclose(found.high, [0.1, 0.5, 0.4, 0.5])
    assert found.rigid.all()
    across = reach(body, body.edges_m, np.zeros((1, 6, 2)), [0, 2, 5])
    np.testing.assert_allclose(across.low, [0.1, 0.6])  # 0.1 | 0.2; 0.3 | 0.9
    np.testing.assert_allclose(across.high, [0.3, 1.2])


def test_the_upward_axis_of_a_short_chain_is_the_one_along_which_nothing_moves():
    body, points = chain(7, (2, 4), [0.055, 0.055, 0.095, 0.095, 0.07, 0.07])
    points = points @ np.array([[np.cos(1), np.sin(1)], [-np.sin(1), np.cos(1)]])
    shown = [0, 2, 4, 6]
    height = 0.02 + 1e-4 * np.random.default_rng(5).normal(size=points[:, shown, :1].shape)
    space = np.concatenate([points[:, shown], height], axis=2)
    lengths = of_links(np.array([0.11, 0.19, 0.14]))
    for axis, floor in {"z": [0, 1], "y": [2, 0], "x": [1, 2]}.items():
        plan = layout(space[..., floor], lengths)
        found = marker_faults(plan, ["t", "a", "b", "h"], Plane(space, axis, lambda floor: floor))
        certain = [f.cure for f in found[:1] if f.gain > ODDS]
        assert certain == ([] if axis == "z" else ['set `up_axis = "z"` in [motion]'])


def test_one_length_that_is_wrong_is_told_and_markers_beside_their_places_are_not():
    body, points = chain(7, (2, 4), [0.055, 0.055, 0.095, 0.095, 0.07, 0.07], 400)
    seen = points[:, [0, 2, 4, 6]]
    assert one_longer(Shown.of([seen], np.array([0.11, 0.19, 0.14]))) is None
    edge, share = one_longer(Shown.of([seen], np.array([0.11, 0.22, 0.14])))
    assert edge == 1
    assert share == pytest.approx(0.19 / 0.22 - 1, abs=0.01)
    assert one_longer(Shown.of([seen], np.array([0.11, 0.22, 0.13]))) is None  # two are off: a marker between them
    rng = np.random.default_rng(2)
    beside = [
        one_longer(Shown.of([seen], np.array([0.11, 0.19, 0.14]) * (1 + 0.05 * rng.normal(size=3)))) for _ in range(200)
    ]
    assert sum(one is not None for one in beside) <= 6


def test_times_in_milliseconds_are_told_where_markers_show_no_joint(whole: Path, tmp_path: Path) -> None:
    middles = [0, 1, 3, 5, 7, 8]
    path = marked(whole, tmp_path / "middles", f"vertices = {middles}", middles)
    assert contradictions(path) == ()
    film = tmp_path / "middles" / "motion.csv"
    header, *rows = film.read_text().split()
    seconds, cells = zip(*(row.split(",", 1) for row in rows), strict=True)
    film.write_text("\n".join([header, *(f"{1000 * float(s)},{c}" for s, c in zip(seconds, cells, strict=True))]))
    (found,) = contradictions(path)
    assert "run 1000 times as long as the schedule" in found.words
    assert "are its times milliseconds?" in found.cure


@pytest.mark.parametrize("shown", WHERE.values(), ids=WHERE)
@pytest.mark.parametrize("place", [0, 2, -1])
def test_a_marker_whose_x_and_y_are_exchanged_is_told_with_that_cure(shown, place):
    shown = list(shown)
    body, points = chain(25, tuple(range(4, 24, 4)), [link / 4 for link in LINKS for _ in range(4)])
    points[:, shown[place]] = points[:, shown[place], ::-1]
    kind, words = faults(body, points, shown)[0]
    assert (kind, words) == ("transposed", f"have x and y of `m{shown[place]}` exchanged")


@pytest.mark.parametrize(
    ("columns", "across", "said"),
    [(None, "x_{}", ["vertex_3", "vertex_5"]), ("M*", "M{}_x", ["M3 (vertex 3)", "M4 (vertex 5)"])],
)
def test_markers_are_called_what_the_file_calls_them(whole: Path, tmp_path: Path, columns, across, said) -> None:
    shown = [0, 1, 3, 5, 7, 8]
    keys = f"vertices = {shown}"
    if columns:
        keys += f'\ncolumns = {{ time = "t_s", x = "{columns}_x", y = "{columns}_y" }}'
    path = marked(whole, tmp_path / f"called{len(said[0])}", keys, shown)
    film = path.parent / tmp_path / path.stem / "motion.csv"
    rows = [row.split(",") for row in film.read_text().split()]
    swapped = [[*row[:5], *row[7:9], *row[5:7], *row[9:]] for row in rows]
    names = [[across.format(k + bool(columns)), across.format(k + bool(columns)).replace("x", "y")] for k in range(6)]
    swapped[0] = ["t_s", *(name for pair in names for name in pair)]
    film.write_text("\n".join(",".join(row) for row in swapped))
    (found,) = contradictions(path)
    assert f"`{said[0]}` and `{said[1]}` exchanged" in found.words
