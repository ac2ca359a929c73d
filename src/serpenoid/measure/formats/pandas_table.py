"""Tables that pandas wrote to HDF5 (`DataFrame.to_hdf`), with columns of several names each, without pandas.

Two layouts: `format="table"`, whose column names are a pickled list in an attribute, and pandas' own default, in which
they are numbers that stand for words.
"""

from __future__ import annotations

import io
import pickle
from pathlib import Path
from typing import Any

import numpy as np

from serpenoid.errors import InputError
from serpenoid.measure.cells import Floats
from serpenoid.measure.formats.hdf5_files import hdf5, texts, whole

Columns = list[tuple[str, ...]]
LEVELS = 8  # of names of a column, at most


def read_pandas(path: Path) -> tuple[Columns, Floats, Floats]:
    """Names of columns, index (F,), values (F, columns) of its first table."""
    with hdf5(path) as file:
        group = next((file[name] for name in file if is_pandas(file[name])), None)
        if group is None:
            raise InputError(f"{path}: holds no table as DeepLabCut writes it. Export it as CSV instead.")
        if "table" not in group:
            return _fixed(group, path)
        table = whole(group["table"], path)
        columns = _plain_pickle(group.attrs["non_index_axes"], path)[0][1]
        values = np.concatenate([table[n] for n in table.dtype.names if n.startswith("values_block")], axis=1)
        return [tuple(map(str, c)) for c in columns], np.asarray(table["index"], float), np.asarray(values, float)


def is_pandas(group: Any) -> bool:
    """Whether a member of an HDF5 file is a table of pandas'."""
    there = set(group) if hasattr(group, "keys") else set()
    return "table" in there or {"axis1", "block0_values"} <= there


def _fixed(group: Any, path: Path) -> tuple[Columns, Floats, Floats]:
    """A table in pandas' own layout: blocks of columns, each with the names of its own."""
    columns: Columns = []
    values = []
    for k in range(int(group.attrs["nblocks"])):
        levels = range(min(LEVELS, int(group.attrs[f"block{k}_items_nlevels"])))
        words = [texts(group[f"block{k}_items_level{level}"], path) for level in levels]
        which = [whole(group[f"block{k}_items_label{level}"], path) for level in levels]
        columns += [tuple(words[level][int(which[level][c])] for level in levels) for c in range(len(which[0]))]
        values.append(np.asarray(whole(group[f"block{k}_values"], path), float))
    return columns, np.asarray(whole(group["axis1"], path), float), np.concatenate(values, axis=1)


class _Plain(pickle.Unpickler):
    """Lists, tuples, strings and numbers; nothing that could run."""

    def find_class(self, module: str, name: str) -> Any:
        raise pickle.UnpicklingError(f"{module}.{name}")


def _plain_pickle(data: Any, path: Path) -> Any:
    try:
        return _Plain(io.BytesIO(bytes(data))).load()
    except (pickle.UnpicklingError, EOFError, ValueError, IndexError, TypeError) as error:
        raise InputError(f"{path}: its column names cannot be read ({error}). Export it as CSV instead.") from None
