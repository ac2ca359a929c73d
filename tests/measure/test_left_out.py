"""Points that a file has beside those of the body: named ones are chosen, unlabelled ones find their place or none."""

import re

import numpy as np
import pytest

from serpenoid.errors import InputError
from serpenoid.measure.film.relabel import label_vertices
from serpenoid.measure.load import load_campaign
from serpenoid.measure.tracks import Tracks
from specimens import animal_campaign
from test_animal_words import crawl

NAMES = tuple(f"b{k}" for k in range(7))


def filmed(hidden: slice, stray: np.ndarray) -> tuple[Tracks, np.ndarray]:
    """Labelled points of a crawling body, `b3` unlabelled in some frames, beside a reflection at `stray`; the truth."""
    time, points = crawl(100)
    floor = np.concatenate([points, np.full((100, 2, 2), np.nan)], axis=1)
    floor[hidden, 7], floor[hidden, 3] = points[hidden, 3], np.nan
    floor[:, 8] = stray
    unlabelled = (*(False,) * 7, True, True)
    return Tracks(time, (*NAMES, "Unlabeled 1", "Unlabeled 2"), floor, "film.csv", unlabelled), points


def test_labels_of_all_points_place_fragments_without_lengths_and_leave_strays_out():
    tracks, points = filmed(slice(20, 40), np.array([3.0, 3.0]))
    found = label_vertices(tracks, NAMES, None, 7, from_head=False)
    np.testing.assert_array_equal(found.vertices, points)
    assert found.relabelled == (("Unlabeled 1", 3),)
    assert found.unused == ("Unlabeled 2",)
    assert found.said == "1 unlabelled marker left out (`Unlabeled 2`): no place on the body fits"


def test_of_a_point_that_a_fragment_may_be_it_is_said_what_to_do():
    tracks, _ = filmed(slice(20, 40), np.array([3.0, 3.0]))
    tracks.floor[20:40, 7] += 1.0  # where no place on the body is
    said = label_vertices(tracks, NAMES, None, 7, from_head=False).said
    assert "`b3` is hidden in 20 frames that show one of them: if it is this, label it where it was recorded" in said


def test_a_point_without_any_label_still_needs_lengths():
    tracks, _ = filmed(slice(0, 100), np.array([3.0, 3.0]))
    with pytest.raises(InputError, match="need `edge_lengths` in .body. .*, where `b3` has no label in it. Or label"):
        label_vertices(tracks, NAMES, None, 7, from_head=False)


def test_the_advice_about_a_point_that_is_never_seen_does_as_it_says(tmp_path):
    time, points = crawl(100)
    missing = points.copy()
    missing[:, 4] = np.nan
    folder = animal_campaign(tmp_path, "a", time, 0.4 * missing, "m")
    with pytest.raises(InputError, match="leave such points out: name the others as `markers`, and count") as told:
        load_campaign(folder)
    never = re.findall("`(vertex_[0-9])`", str(told.value))
    assert never == ["vertex_4"]
    others = [name for name in (f"vertex_{k}" for k in range(7)) if name not in never]
    rewrite(folder, vertices=6, markers=others)
    found = load_campaign(folder).trials[0].motion
    assert found is not None
    (tmp_path / "whole").mkdir()
    whole = load_campaign(animal_campaign(tmp_path / "whole", "a", time, 0.4 * np.delete(points, 4, axis=1), "m"))
    np.testing.assert_allclose(found.markers, whole.trials[0].motion.markers, rtol=1e-12)


def test_markers_of_a_tidy_file_put_its_points_in_order_and_those_that_it_lacks_are_told(tmp_path):
    time, points = crawl(100)
    folder = animal_campaign(tmp_path, "a", time, 0.4 * points, "m")
    assert "moves head first" in " ".join(load_campaign(folder).trials[0].notes)
    rewrite(folder, vertices=7, markers=[f"vertex_{k}" for k in reversed(range(7))])
    assert "moves tail first" in " ".join(load_campaign(folder).trials[0].notes)
    rewrite(folder, vertices=7, markers=[f"m{k}" for k in reversed(range(7))])
    said = " ".join(load_campaign(folder).trials[0].notes)
    assert "`markers` names none of its points, which are called `vertex_0` .. `vertex_6`" in said
    assert "moves head first" in said
    rewrite(folder, vertices=6, markers=[f"m{k}" for k in range(6)])
    with pytest.raises(InputError, match="7 markers for 6 vertices.*`markers` .the file's are `vertex_0`, `vertex_1`"):
        load_campaign(folder)


def rewrite(folder, vertices: int, markers: list[str]) -> None:
    """The campaign file with other `vertices` and `markers`."""
    path = folder / "campaign.toml"
    lines = [line for line in path.read_text().splitlines() if not line.startswith("markers")]
    lines = [f"vertices = {vertices}" if line.startswith("vertices") else line for line in lines]
    lines.insert(lines.index("[motion]") + 1, f"markers = {markers}")
    path.write_text("\n".join(lines) + "\n")
