"""What a file is, by what stands in it: so that a file in another's place is called by its name, with its verb."""

from __future__ import annotations

from pathlib import Path
from typing import Any

TAKEN_BY = {
    "problem": "`serpenoid solve FILE` takes it",
    "model": "`serpenoid solve PROBLEM --model FILE` takes it",
    "robot": "`serpenoid play RESULTS --robot FILE` takes it",
    "protocol": "`serpenoid arena run FILE` takes it",
    "campaign": "`serpenoid measure FILE` takes it",
}
BY_SUFFIX = {
    ".csv": "a table: recordings are named in a campaign (`serpenoid new campaign`, of an animal with --film), joint "
    "tables are played (`serpenoid play`)",
    ".json": "a record: `serpenoid show` takes the folder it is in",
    ".py": "a Python program: run it with `python`; what a verb takes is a TOML file",
    ".h5": "a recording: name it in a campaign (`serpenoid new campaign`)",
    ".npz": "a recording: name it in a campaign (`serpenoid new campaign`)",
}


def kind_of(data: dict[str, Any]) -> str | None:
    """The kind of a parsed TOML file; None where nothing in it tells."""
    if {"bus", "joint"} & data.keys():
        return "robot"
    if "trial" in data:
        return "campaign"
    if isinstance(data.get("gait"), list) or "trials" in data:
        return "protocol"
    if {"task", "gait"} & data.keys() or ({"body", "medium"} <= data.keys() and "motion" not in data):
        return "problem"
    return "model" if {"medium", "effects"} <= data.keys() else None


def mistaken(path: str | Path, wanted: str, data: dict[str, Any] | None = None) -> str | None:
    """The sentence about a file that is of another kind than `wanted`; None where it is not known to be.

    data: of a TOML file that could be parsed.
    """
    found = kind_of(data) if data is not None else None
    if data is None and (said := BY_SUFFIX.get(Path(path).suffix.lower())):
        return f"{path}: is no {wanted} file but {said}."
    if found is None or found == wanted:
        return None
    return f"{path}: is a {found} file, where a {wanted} file belongs. {TAKEN_BY[found]}."
