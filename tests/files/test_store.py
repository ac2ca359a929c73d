"""Finished work is kept: found again by content, never believed when damaged, never done twice after a kill."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from rehearsal import ROOT, serpenoid_table, snake
from serpenoid.compare.calibrate import calibrate
from serpenoid.compare.rehearse import Laboratory, write_campaign
from serpenoid.errors import InputError
from serpenoid.files import store
from serpenoid.measure.load import load_campaign

LAMPREY = ROOT / "problems" / "campaigns" / "lamprey.toml"


@pytest.fixture
def cache(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv("SERPENOID_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache" / "work"


def entries(cache: Path) -> dict[str, int]:
    """Name -> inode: an entry that was made again has another one."""
    return {path.name: path.stat().st_ino for path in cache.glob("[!.]*.work")} if cache.exists() else {}


def test_what_is_found_again_is_what_was_kept(cache, folder, virtual_machine):
    first = load_campaign(folder)
    fitted = calibrate(first, snake(), ("anisotropy_ratio",))
    kept = entries(cache)
    second = load_campaign(folder)
    again = calibrate(second, snake(), ("anisotropy_ratio",))
    assert entries(cache) == kept
    assert len(kept) >= 4  # campaign, trial, estimates, profile
    assert store.key(second.trials, again.together) == store.key(first.trials, fitted.together)  # to the last bit
    np.testing.assert_array_equal(again.profile, fitted.profile)


def test_values_of_every_kind_come_back(cache):
    value = {
        "a": (1, 2.5, None, True),
        "b": [np.arange(6.0).reshape(2, 3), float("nan"), -float("inf")],
        3: slice(1, 5),
    }
    for _ in range(2):
        found = store.remember(lambda: value, "all kinds")
        assert found["a"] == value["a"]
        np.testing.assert_array_equal(found["b"][0], value["b"][0])
        assert np.isnan(found["b"][1])
        assert found[3] == slice(1, 5)


@pytest.mark.parametrize("damage", ["cut", "flipped", "empty", "another's"])
def test_a_damaged_entry_is_made_again(cache, damage):
    assert store.remember(lambda: 1.0, "x") == 1.0
    store.remember(lambda: 3.0, "y")
    (path,) = (p for p in cache.iterdir() if p.stem == store.key("x"))
    data = path.read_bytes()
    middle = len(data) // 2
    other = (cache / f"{store.key('y')}.work").read_bytes()[: store.DIGEST] + data[store.DIGEST :]
    changed = {
        "cut": data[:middle], "flipped": data[:middle] + bytes([data[middle] ^ 1]) + data[middle + 1 :], "empty": b"",
        "another's": other,
    }  # fmt: skip
    path.write_bytes(changed[damage])
    assert store.remember(lambda: 2.0, "x") == 2.0
    assert store.remember(lambda: 4.0, "x") == 2.0


def test_a_changed_input_option_or_code_is_other_work(cache, monkeypatch):
    one = store.key("fit", np.arange(3.0), {"option": 1})
    assert store.key("fit", np.arange(3.0), {"option": 2}) != one
    assert store.key("fit", np.array([0.0, 1.0, np.nextafter(2.0, 3)]), {"option": 1}) != one
    monkeypatch.setattr(store, "source_digest", lambda: "another version")
    assert store.key("fit", np.arange(3.0), {"option": 1}) != one


def test_the_folder_stays_bounded_and_the_longest_unused_leaves(cache, monkeypatch):
    monkeypatch.setattr(store, "MOST_BYTES", 30_000)
    for k in range(6):
        store.remember(lambda: np.zeros(1000), k)  # 8 kB each
        os.utime(cache / f"{store.key(k)}.work", (k, k))
    left = {path.stem for path in cache.iterdir()}
    assert left == {store.key(k) for k in (3, 4, 5)}


def test_what_is_larger_than_the_folder_may_be_drives_nothing_out(cache, monkeypatch):
    monkeypatch.setattr(store, "MOST_BYTES", 30_000)
    store.remember(lambda: np.zeros(1000), "small")
    assert len(store.remember(lambda: np.zeros(10_000), "large")) == 10_000
    assert [path.stem for path in cache.iterdir()] == [store.key("small")]


def test_a_cache_that_cannot_be_written_loses_nothing(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("not a folder")
    monkeypatch.setenv("SERPENOID_CACHE", str(tmp_path / "file"))
    assert store.remember(lambda: 5.0, "x") == 5.0


def test_a_changed_recording_is_read_again(cache, tmp_path):
    shutil.copytree(ROOT / "problems" / "recordings", tmp_path / "recordings")
    (tmp_path / "campaigns").mkdir()
    copied = shutil.copy(LAMPREY, tmp_path / "campaigns")
    load_campaign(copied)
    path = tmp_path / "recordings" / "lamprey.csv"
    path.write_text(path.read_text().replace("0.06,3,1,415.07", "0.06,3,1,4x5.07"))
    with pytest.raises(InputError, match="must be a number"):
        load_campaign(copied)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("lab")
    tables = {"wide": serpenoid_table(30), "low": serpenoid_table(30, a=4.0)}
    write_campaign(path, snake(), tables, Laboratory(frames_per_second=30.0), 1, 0, 2.0, 1, 1.0)
    return path


def run(verb: str, folder: Path, out: Path, cache: Path, seconds: float | None = None) -> float:
    """One command in a process of its own, killed after `seconds`; returns how long it ran."""
    command = [sys.executable, "-m", "serpenoid", verb, str(folder), "--out", str(out), "--quiet", "--no-figures"]
    environment = {**os.environ, "SERPENOID_CACHE": str(cache), "SERPENOID_COMPILE": "0"}
    began = time.monotonic()
    process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL)
    try:
        process.wait(seconds)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    return time.monotonic() - began


def answer(out: Path, verb: str) -> dict:
    record = json.loads((out / f"{verb}.json").read_text())
    record.pop("provenance")
    return record


@pytest.mark.parametrize(
    ("verb", "kills"), [("compare", 1), *(pytest.param(v, 20, marks=pytest.mark.slow) for v in ("compare", "fit"))]
)
def test_killed_at_random_moments_the_answer_is_the_same_and_nothing_is_done_twice(folder, tmp_path, verb, kills):
    whole = run(verb, folder, tmp_path / "undisturbed", tmp_path / "other cache")
    rng, cache = np.random.default_rng(kills), tmp_path / "cache"
    done: dict[str, int] = {}
    for k in range(kills):
        run(verb, folder, tmp_path / f"killed-{k}", cache, rng.uniform(0.3, 1.0) * whole)
        now = entries(cache / "work")
        assert done.items() <= now.items()  # finished work was not done again
        done = now
    run(verb, folder, tmp_path / "again", cache)
    assert answer(tmp_path / "again", verb) == answer(tmp_path / "undisturbed", verb)
    after = entries(cache / "work")
    assert done.items() <= after.items()
    assert set(after) == set(entries(tmp_path / "other cache" / "work"))
