"""Files as validated values: every fault names the file, the section, the key, the rule, the value and the remedy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import Field

from serpenoid.body import Body
from serpenoid.errors import InputError
from serpenoid.files import schema
from serpenoid.medium import Medium
from serpenoid.table_file import read_table, write_table


class Inner(schema.Record):
    number: float = Field(gt=0)


class Outer(schema.Record):
    name: str = "x"
    inner: Inner


def written(folder: Path, text: str) -> Path:
    path = folder / "file.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_record_is_read_and_cannot_be_changed(tmp_path: Path) -> None:
    record = schema.load(Outer, written(tmp_path, "[inner]\nnumber = 2\n"))
    assert record.inner.number == 2.0
    with pytest.raises(ValueError, match="frozen"):
        record.inner.number = 3.0  # type: ignore[misc]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[inner]\nnumbr = 2\n", r"file\.toml: \[inner\] numbr: unknown key\. Did you mean `number`\?"),
        ("[inner]\nnumber = 2\nqqqq = 1\n", r"\[inner\] qqqq: unknown key\. Known keys: number\."),
        ("nam = 'y'\n[inner]\nnumber = 2\n", r"file\.toml: nam: unknown key\. Did you mean `name`\?"),
        ("[inner]\n", r"\[inner\] number: is required and not there\."),
        ("name = 'y'\n", r"file\.toml: \[inner\]: is required and not there\."),
        ("[inner]\nnumber = nan\n", r"\[inner\] number: Input should be a finite number, got nan\."),
        ("[inner]\nnumber = inf\n", r"\[inner\] number: Input should be a finite number, got inf\."),
        ("[inner]\nnumber = -1\n", r"\[inner\] number: Input should be greater than 0, got -1\."),
        ("[inner]\nnumber = 'two'\n", r"\[inner\] number: .*valid number.*got 'two'\."),
        ("[inner\nnumber = 2\n", r"file\.toml: not valid TOML: .*line 1"),
        ("[inner]\nnumber = 2,5\n", r"line 2, .*\. Write a point before decimals\."),
        ("name = 'y'\n[inner]\nnumber = \u201c2\u201d\n", r"line 3, .*\. Write straight quotes"),
        ('name = "C:\\Users\\y"\n', r"line 1, .*\. A backslash begins an escape in TOML: write paths with `/`\."),
    ],
)
def test_every_fault_is_located_and_named(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        schema.load(Outer, written(tmp_path, text))


def test_all_faults_are_named_at_once(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        schema.load(Outer, written(tmp_path, "nam = 1\n[inner]\nnumber = -1\n"))
    assert len(str(caught.value).splitlines()) == 2


def test_a_list_whose_entries_are_faulty_is_not_called_empty_as_well(tmp_path: Path) -> None:
    class Listing(schema.Record):
        entry: tuple[Inner, ...] = Field(min_length=1)

    with pytest.raises(InputError) as caught:
        schema.load(Listing, written(tmp_path, "[[entry]]\nnumber = 1\nnumbr = 1\n"))
    assert len(str(caught.value).splitlines()) == 1
    with pytest.raises(InputError, match="needs 1 entry or more"):
        schema.load(Listing, written(tmp_path, "entry = []\n"))


def test_files_that_are_none_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere\.toml: no such file"):
        schema.load(Outer, tmp_path / "nowhere.toml")
    with pytest.raises(InputError, match="is a folder; name a file in it"):
        schema.load(Outer, tmp_path)
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not a text file"):
        schema.load(Outer, tmp_path / "binary.toml")


@pytest.mark.parametrize(
    ("assignment", "expected"),
    [
        ("a.b=2", {"a": {"b": 2, "keep": True}}),
        ("a.b=[1, 2]", {"a": {"b": [1, 2], "keep": True}}),
        ("a.b=word", {"a": {"b": "word", "keep": True}}),
        ('a.b="a word"', {"a": {"b": "a word", "keep": True}}),
        ("a.b=true", {"a": {"b": True, "keep": True}}),
        ("new.section.key=1.5", {"a": {"b": 1, "keep": True}, "new": {"section": {"key": 1.5}}}),
        (" a.b = 1e-3 ", {"a": {"b": 1e-3, "keep": True}}),
    ],
)
def test_assignments_override_a_copy(assignment: str, expected: dict[str, Any]) -> None:
    data = {"a": {"b": 1, "keep": True}}
    assert schema.override(data, [assignment]) == expected
    assert data == {"a": {"b": 1, "keep": True}}


@pytest.mark.parametrize(
    ("assignment", "message"),
    [
        ("a.b", r"--set a\.b: write it as section\.key=value"),
        ("=3", r"--set =3: write it as section\.key=value"),
        ("a.b.c=3", r"--set a\.b\.c=3: `b` is not a section"),
        ("a.b=[.1, .2]", r"--set a\.b=\[\.1, \.2\]: not valid TOML: Invalid value\. Write a 0 before a point that"),
        ("a={b=[0.1, -.2]}", r"not valid TOML: Invalid value\. Write a 0 before a point that begins a number"),
        ("a.b=[1, 2", r"--set a\.b=\[1, 2: not valid TOML: Unclosed array\."),
        ('a.b="word', r"not valid TOML: "),
        ("a.b=1\nx=2", r"holds several assignments\. Give each with a --set of its own"),
    ],
)
def test_assignments_that_are_none_are_refused(assignment: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        schema.override({"a": {"b": 1}}, [assignment])


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ({"vertices": 2}, r"vertices: .*3 are the least, .*got 2"),
        ({"vertices": 4, "edge_lengths": [1, 1]}, r"`edge_lengths` needs 3 numbers for 4 vertices, got 2"),
        ({"vertices": 4, "weights": [1, 1, 1]}, r"`weights` needs 4 numbers for 4 vertices, got 3"),
        ({"vertices": 4, "weights": [1, 1, 1, -1]}, r"weights, entry 4: must be above 0, got -1"),
        ({"vertices": 4, "weights": [1, 1, 1, float("nan")]}, r"weights, entry 4: .*(finite|greater than).*nan"),
        ({"vertices": 4, "edge_lengths": [1, 0, 1]}, r"edge_lengths, entry 2: must be above 0, got 0"),
        ({"vertices": 4, "length_m": 1, "edge_lengths": [1, 1, 1]}, r"give `length_m` .* or `edge_lengths`, not both"),
        ({"vertices": 4, "joints": [2, 1]}, r"`joints` must be increasing vertex numbers between 1 and 2"),
        ({"vertices": 4, "joints": [0, 1]}, r"`joints` must be increasing"),
        ({"vertices": 4, "joints": [1, 1]}, r"`joints` must be increasing"),
        ({"vertices": 4, "joints": []}, r"`joints` must be increasing"),
        ({"vertices": 4, "joint_limit_deg": 190}, r"joint_limit_deg: .*less than or equal to 180, got 190"),
        ({"vertices": 4.5}, r"vertices: .*integer.*4\.5"),
    ],
)
def test_a_body_that_cannot_be_is_refused(section: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        schema.validate(Body, section, "body.toml")


@pytest.mark.parametrize(
    ("ratio", "remedy"),
    [(1.7, r"in \(0, 1\], got 1\.7: it is lengthwise drag"), (0.0, "small positive"), (-0.1, "small positive")],
)
def test_an_anisotropy_ratio_outside_its_range_is_refused_with_a_remedy(ratio: float, remedy: str) -> None:
    with pytest.raises(InputError, match=remedy):
        schema.validate(Medium, {"anisotropy_ratio": ratio}, "medium.toml")
    with pytest.raises(InputError, match="vertex.*edge.*'both'"):
        schema.validate(Medium, {"anisotropy_ratio": 0.5, "dissipation": "both"}, "medium.toml")


def test_a_body_normalises_lengths_and_weights() -> None:
    body = Body(vertices=4, edge_lengths=(1.0, 2.0, 1.0), weights=(1.0, 1.0, 1.0, 5.0))
    np.testing.assert_allclose(body.edges, [0.25, 0.5, 0.25])
    np.testing.assert_allclose(body.vertex_weights, [0.125, 0.125, 0.125, 0.625])
    assert body.joint_vertices == (1, 2)
    assert body.joint_count == 2


def test_a_joint_table_is_read_as_it_was_written(tmp_path: Path) -> None:
    table = np.random.default_rng(50).uniform(-1, 1, size=(7, 3))
    write_table(tmp_path / "gait.csv", table)
    np.testing.assert_array_equal(read_table(tmp_path / "gait.csv", 3), table)
    assert (tmp_path / "gait.csv").read_text().splitlines()[0] == "joint_1,joint_2,joint_3"


HEADER = "joint_1,joint_2\n"
ROWS = "0.1,0.2\n" * 3


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"is empty"),
        ("j1,j2\n" + ROWS, r"header must be joint_1,joint_2"),
        ("joint_1,joint_2,joint_3\n" + "1,2,3\n" * 3, r"header must be .* with 2 joints"),
        (HEADER + "0.1,0.2\n", r"at least 3 rows, got 1"),
        (HEADER + ROWS + "0.1\n", r":5: needs 2 numbers, got 1\. Was the file cut short\?"),
        (HEADER + ROWS + "0.1,x\n", r":5: joint_2 is 'x', not a number"),
        (HEADER + ROWS + "0.1,nan\n", r":5: joint_2 is 'nan', not a number"),
        (HEADER + ROWS + "0.1,45\n", r"got 45\. Are these degrees\?"),
    ],
)
def test_a_joint_table_with_a_fault_is_refused_with_row_and_column(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "gait.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        read_table(path, 2)
    with pytest.raises(InputError, match="no such file"):
        read_table(tmp_path / "none.csv", 2)


def test_a_joint_table_that_was_cut_within_its_last_number_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "gait.csv"
    write_table(path, np.random.default_rng(50).uniform(0.1, 1, size=(7, 3)))
    whole = path.read_text()
    for left in range(1, 10):  # characters of the last number
        path.write_text(whole[: whole.rindex(",") + 1 + left])
        with pytest.raises(InputError, match=r"gait\.csv:8: the last number, [0-9.]+, is shorter than any other"):
            read_table(path, 3)


@pytest.mark.parametrize("text", ["0.1,0.2\n0.3,0.4\n0.5,0", "0.1000,0.2000\n0.3000,0.4000\n0.5000,0.0000"])
def test_a_joint_table_of_another_program_may_have_a_last_line_without_an_end(tmp_path: Path, text: str) -> None:
    path = tmp_path / "gait.csv"
    path.write_text(HEADER + text)
    np.testing.assert_array_equal(read_table(path, 2)[-1], [0.5, 0.0])


class Listed(schema.Record):
    start: ListedStart = Field(default_factory=lambda: ListedStart())


class ListedStart(schema.Record):
    headings: tuple[float, ...] = Field(default=(0.0,), min_length=1)


def test_an_empty_list_inside_a_section_is_named_and_a_faulty_entry_is_one_fault(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"\[start\] headings: .*needs 1 entry or more"):
        schema.load(Listed, written(tmp_path, "[start]\nheadings = []\n"))
    with pytest.raises(InputError) as caught:
        schema.load(Listed, written(tmp_path, "[start]\nheadings = ['north']\n"))
    assert len(str(caught.value).splitlines()) == 1


def test_values_are_equal_by_their_fields_whatever_was_computed_from_them() -> None:
    one, same, other = (Body(vertices=n, edge_lengths=(0.1,) * (n - 1)) for n in (5, 5, 6))
    assert one.edges.sum() == pytest.approx(1)  # kept beside the fields from now on, an array
    assert same.edges.sum() == pytest.approx(1)
    assert (one, hash(one)) == (same, hash(same))
    assert one != other
    assert {one: "found"}[same] == "found"
