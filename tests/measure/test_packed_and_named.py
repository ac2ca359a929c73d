"""Text that is packed, remarked on, or names its points; and what is no text, refused with what to do."""

from __future__ import annotations

import gzip
import re

import numpy as np
import pytest

from serpenoid.errors import InputError
from serpenoid.files import inputs
from serpenoid.measure.formats.points import read_long
from serpenoid.measure.formats.tidy import read_tidy

TIDY = "t_s,x_0,y_0,x_1,y_1\n0,0,0,0.1,0\n0.1,0.01,0,0.11,0\n"
LONG = {"time": "t", "point": "p", "x": "x", "y": "y"}


def test_text_packed_by_gzip_is_read_and_a_cut_or_endless_one_refused(tmp_path, monkeypatch):
    path = tmp_path / "m.csv"
    path.write_bytes(gzip.compress(TIDY.encode()))
    assert read_tidy(path).floor[1, 1, 0] == 0.11
    path.write_bytes(gzip.compress(TIDY.encode())[:-12])
    with pytest.raises(InputError, match=r"m\.csv: packed by gzip, and cannot be unpacked .* cut off"):
        read_tidy(path)
    path.write_bytes(gzip.compress(b"0" * 3_000_000))
    with pytest.raises(InputError, match="at most 2 MB when unpacked"):
        inputs.read_text(path, 2_000_000)
    path.write_bytes(gzip.compress(b"0," * 20_000_000))
    with pytest.raises(InputError, match=r"m\.csv: packed by gzip to less than a part in 100"):
        read_tidy(path)


@pytest.mark.parametrize(("begin", "match"), [
    (b"PK\x03\x04", "but a spreadsheet .* Save the sheet as CSV"),
    (b"\xd0\xcf\x11\xe0", "old spreadsheet"),
    (b"\x89HDF", "HDF5"),
])  # fmt: skip
def test_of_a_file_that_is_no_text_it_is_said_what_it_is(tmp_path, begin, match):
    path = tmp_path / "m.csv"
    path.write_bytes(begin + bytes(range(128, 256)))
    with pytest.raises(InputError, match=match):
        read_tidy(path)


def test_remarks_are_passed_over_unless_they_name_the_columns(tmp_path):
    path = tmp_path / "m.csv"
    path.write_text("# made by hand\n# 10 Hz\n" + TIDY.replace("0.1,0.01", "# a fall\n0.1,0.01"))
    assert read_tidy(path).floor.shape == (2, 2, 2)
    np.savetxt(
        path, np.loadtxt(TIDY.splitlines()[1:], delimiter=","), delimiter=",", header="a\n" + TIDY.split("\n")[0]
    )
    assert read_tidy(path).floor[1, 1, 0] == 0.11
    path.write_text("# only\n# remarks\n")
    with pytest.raises(InputError, match="holds no complete row"):
        read_tidy(path)


def test_points_of_a_long_table_may_have_names(tmp_path):
    path = tmp_path / "m.csv"
    rows = [f"{t},{name},{k},{t}" for t in (0, 1) for k, name in enumerate(("tail", "knee", "head"))]
    path.write_text("\n".join(["t,p,x,y", *rows]) + "\n")
    tracks = read_long(path, LONG, "m")
    assert tracks.names == ("tail", "knee", "head")
    assert tracks.floor[1].tolist() == [[0, 1], [1, 1], [2, 1]]
    path.write_text("\n".join(["t,p,x,y", *rows[:-1], "1,,2,1"]) + "\n")
    with pytest.raises(InputError, match=r"row 7, column B \(`p`\): must not be empty"):
        read_long(path, LONG, "m")
    path.write_text("t,p,x,y\n0,1,0,0\n0,l,1,0\n")
    with pytest.raises(InputError, match=r"row 3, column B \(`p`\): must be a number"):
        read_long(path, LONG, "m")


def test_of_other_names_of_columns_it_is_said_what_to_write(tmp_path):
    path = tmp_path / "m.csv"
    path.write_text(TIDY.replace("x_0,y_0,x_1,y_1", "x_0 [span],y_0 [span],x_1 [span],y_1 [span]"))
    wanted = 'columns = { time = "t_s", x = "x_* [span]", y = "y_* [span]" }'
    with pytest.raises(InputError, match=re.escape(wanted)):
        read_tidy(path)
    path.write_text("t_s,nose x,nose y\n0,0,0\n")
    with pytest.raises(InputError, match=re.escape('columns = { time = "Time (s)"')):
        read_tidy(path)
