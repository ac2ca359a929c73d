"""Files that show several animals: one is named, or all are listed."""

import json

import numpy as np
import pytest
from test_trackers import DOWN, NAMES, RATE, swimmer

from serpenoid.errors import InputError
from serpenoid.measure.formats.points import read_long, read_sleap
from serpenoid.measure.formats.trackers import Timing, read_deeplabcut, read_sleap_analysis, read_tierpsy
from serpenoid.measure.formats.wcon import read_wcon
from serpenoid.measure.load import load_campaign

OTHER = np.array([3.0, -7.0])  # where the second one is, from the first


def deeplabcut(path, time, both):
    heads = [["scorer", *["net"] * 36], ["individuals", *["one"] * 18, *["two"] * 18],
             ["bodyparts", *[n for n in NAMES for _ in range(3)] * 2],
             ["coords", *["x", "y", "likelihood"] * 12]]  # fmt: skip
    cells = np.concatenate([np.dstack([p * DOWN, np.full(p.shape[:2], 0.99)]).reshape(len(time), -1) for p in both], 1)
    rows = [[str(f), *map(repr, row.tolist())] for f, row in enumerate(cells)]
    path.write_text("\n".join(",".join(row) for row in heads + rows) + "\n")
    return lambda who: read_deeplabcut(path, Timing(RATE, "px", individual=who))


def sleap_csv(path, time, both):
    lines = [",".join(["track", "frame_idx", *(f"{n}.{part}" for n in NAMES for part in ("x", "y", "score"))])]
    for f in range(len(time)):
        for who, points in zip(("one", "two"), both, strict=True):
            cells = np.column_stack([points[f] * DOWN, np.ones(6)]).ravel().tolist()
            lines.append(",".join([who, str(f), *map(repr, cells)]))
    path.write_text("\n".join(lines) + "\n")
    return lambda who: read_sleap(path, RATE, "px", 0.0, who)


def sleap_hdf5(path, time, both):
    import h5py

    with h5py.File(path, "w") as file:
        file["tracks"] = np.stack([(points * DOWN).transpose(2, 1, 0) for points in both])
        file["node_names"] = np.array(NAMES, dtype="S")
        file["track_names"] = np.array(["one", "two"], dtype="S")
    return lambda who: read_sleap_analysis(path, Timing(RATE, "px", individual=who))


def tierpsy(path, time, both):
    import h5py

    table = np.zeros(2 * len(time), dtype=[("worm_index", "<i4"), ("timestamp", "<i4")])
    table["worm_index"], table["timestamp"] = np.repeat([1, 2], len(time)), np.tile(np.arange(len(time)), 2)
    with h5py.File(path, "w") as file:
        file["coordinates/skeletons"] = np.concatenate([points * DOWN for points in both])
        file["timeseries_data"] = table
        file["timeseries_data"].attrs["fps"] = RATE
    number = {None: None, "one": "1", "two": "2"}
    return lambda who: read_tierpsy(path, Timing(length_unit="px", individual=number.get(who, who)))


def wcon(path, time, both):
    data = [
        {"id": who, "t": time.tolist(), "x": points[..., 0].tolist(), "y": points[..., 1].tolist()}
        for who, points in zip(("one", "two"), both, strict=True)
    ]
    path.write_text(json.dumps({"units": {"t": "s", "x": "px", "y": "px"}, "data": data}))
    return lambda who: read_wcon(path, Timing(individual=who))


def long(path, time, both):
    lines = ["who,t,id,x,y"]
    for f, t in enumerate(time.tolist()):
        for who, points in zip(("one", "two"), both, strict=True):
            lines += [f"{who},{t!r},{k},{x!r},{y!r}" for k, (x, y) in enumerate(points[f].tolist())]
    path.write_text("\n".join(lines) + "\n")
    columns = {"time": "t", "point": "id", "x": "x", "y": "y", "individual": "who"}
    return lambda who: read_long(path, columns, "bl", individual=who)


@pytest.mark.parametrize("write", [deeplabcut, sleap_csv, sleap_hdf5, tierpsy, wcon, long])
def test_the_individual_that_is_named_is_read(tmp_path, write):
    if write in (sleap_hdf5, tierpsy):
        pytest.importorskip("h5py")
    time, points = swimmer()
    suffix = {sleap_hdf5: "h5", tierpsy: "hdf5", wcon: "wcon"}.get(write, "csv")
    read = write(tmp_path / f"m.{suffix}", time, (points, points + OTHER))
    for who, there in (("one", points), ("two", points + OTHER)):
        found = read(who)
        np.testing.assert_allclose(found.floor, there, atol=1e-9)
        np.testing.assert_allclose(np.diff(found.time_s), 1 / RATE, atol=1e-6)
    with pytest.raises(InputError, match="shows 2 individuals: .* Name one in the trial: `individual"):
        read(None)
    with pytest.raises(InputError, match='`individual = "three"`: the file has'):
        read("three")


def test_two_animals_of_one_file_are_two_trials(tmp_path):
    time, points = swimmer()
    sleap_csv(tmp_path / "m.csv", time, (points, points + OTHER))
    names = ", ".join(f'"{n}"' for n in NAMES)
    trials = "".join(f'[[trial]]\nname = "{w}"\nmotion = "m.csv"\nindividual = "{w}"\n' for w in ("one", "two"))
    (tmp_path / "campaign.toml").write_text(
        'format = 1\nname = "w"\n[body]\nvertices = 6\nkind = "crawler"\n[motion]\nformat = "sleap"\n'
        f'length_unit = "px"\nframes_per_second = {RATE}\nmarkers = [{names}]\n{trials}'
    )
    one, two = (trial.motion for trial in load_campaign(tmp_path).trials)
    assert one is not None
    assert two is not None
    scale = np.linalg.norm(np.diff(points, axis=1), axis=2).sum(axis=1).mean()
    np.testing.assert_allclose((two.markers - one.markers).mean(axis=(0, 1)), OTHER / scale, rtol=0.02)


def test_a_table_that_does_not_say_whose_points_it_has_says_what_to_name(tmp_path):
    time, points = swimmer()
    long(tmp_path / "m.csv", time, (points, points + OTHER))
    with pytest.raises(InputError, match="row 8, .*twice in one frame. Of several animals.*`individual`"):
        read_long(tmp_path / "m.csv", {"time": "t", "point": "id", "x": "x", "y": "y"}, "px")


def test_a_fault_of_one_of_several_is_said_with_its_row_of_the_file(tmp_path):
    time, points = swimmer()
    read = sleap_csv(tmp_path / "m.csv", time, (points, points + OTHER))
    lines = (tmp_path / "m.csv").read_text().splitlines()
    lines[8] = lines[8].replace("two,3,", "two,1,")  # row 9 of the file, the fourth of its own
    (tmp_path / "m.csv").write_text("\n".join(lines) + "\n")
    with pytest.raises(InputError, match="row 9, .*times must increase"):
        read("two")
    assert len(read("one").time_s) == len(time)
