"""Files that are written are UTF-8, whatever they speak of."""

from __future__ import annotations

import os
from pathlib import Path

from serpenoid.files.writing import write_csv, write_text


def test_a_folder_whose_name_is_in_no_encoding_is_named_by_escapes(tmp_path: Path) -> None:
    name = os.fsdecode(b"caf\xe9")
    write_text(tmp_path / "a.txt", f"written to {name}\n")
    write_csv(tmp_path / "a.csv", ["folder"], [[name]])
    assert (tmp_path / "a.txt").read_text(encoding="utf-8") == "written to caf\\udce9\n"
    assert (tmp_path / "a.csv").read_text(encoding="utf-8") == "folder\ncaf\\udce9\n"
