"""Compiled evaluation: the same numbers as CasADi's virtual machine, safe among processes, and dispensable."""

from __future__ import annotations

import hashlib
import logging
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from serpenoid.errors import InputError
from serpenoid.files import store
from serpenoid.mechanics import compile as compilation
from serpenoid.mechanics import functions, roots, servo
from serpenoid.mechanics.compile import compiled, find_compiler, generate_c
from serpenoid.mechanics.extended import held_for
from serpenoid.mechanics.tables import joint_table
from serpenoid.model import Structure
from serpenoid.simulation import simulate_batch, simulate_joint_angles
from specimens import forget_functions, nlp_of, phases_of_rows, problem, reference, serpenoid_table

SAME = 1e-12  # the project's bound between compiled and interpreted evaluation
needs_compiler = pytest.mark.skipif(not find_compiler(), reason="no C compiler here")
SMALL = Structure(4, (1, 2), "vertex")
LARGER = Structure(5, (1, 2, 3), "vertex")


@pytest.fixture
def fresh() -> Iterator[None]:
    """Functions are prepared anew inside the test, and again after it."""
    forget_functions()
    yield
    forget_functions()


def evaluate() -> list[np.ndarray]:
    """Motion of a gait, of a batch, and all functions of the gait NLP with limits, at a point that is no optimum."""
    asked = problem("reference-optimum")
    model = asked.model
    motion = simulate_joint_angles(model, serpenoid_table(model, 20))
    batch = simulate_batch(model, np.array([serpenoid_table(model, 20, a=a) for a in (3.0, 5.0)]))
    nlp = nlp_of(model, 10, 2)
    rng = np.random.default_rng(40)
    x = np.concatenate([0.1 * rng.normal(size=30), [0.6, 0.5, -0.5, 0.3, 5.0, 1.1]])
    p = np.concatenate([[0.7], phases_of_rows([0.0, 0.4], 10), model.parameters])
    multipliers = rng.normal(size=sum(nlp.constraint_counts))
    found = [motion.poses, motion.vertices, motion.step_energy, batch.poses, batch.dissipation]
    for name, function in nlp.functions().items():
        more = (1.3, multipliers) if name == "hess_lag" else ()
        values = function(x, p, *more)
        found += [ca.densify(v).full() for v in (values if isinstance(values, tuple) else (values,))]
    return found


@needs_compiler
def test_compiled_evaluation_is_the_virtual_machines(fresh: None, monkeypatch: pytest.MonkeyPatch) -> None:
    machine_code = evaluate()
    monkeypatch.setenv("SERPENOID_COMPILE", "0")
    forget_functions()
    interpreted = evaluate()
    for a, b in zip(machine_code, interpreted, strict=True):
        scale = max(1.0, float(np.abs(b).max()))
        assert np.abs(a - b).max() <= SAME * scale


def test_switching_compilation_off_leaves_the_functions_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SERPENOID_COMPILE", "0")
    function = functions.shape(SMALL)
    assert compiled([function])[0] is function


@needs_compiler
def test_what_was_prepared_without_a_compiler_is_not_kept_for_later_tests(fresh: None) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SERPENOID_COMPILE", "0")
        forget_functions()
        assert servo._in_lanes() is None
        assert roots.roots("viscous", held_for(frozenset())) is None
    forget_functions()
    assert servo._in_lanes() is not None
    assert roots.roots("viscous", held_for(frozenset())) is not None


def test_where_the_machine_has_no_compiler_that_of_a_package_serves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(compilation.importlib.util, "find_spec", lambda name: None)
    compilation._note_once.cache_clear()
    function = functions.shape(SMALL)
    with caplog.at_level(logging.WARNING):
        assert compiled([function])[0] is function
    assert "pip install ziglang" in caplog.text
    compilation._note_once.cache_clear()
    caplog.clear()
    with caplog.at_level(logging.WARNING):
        assert compilation.loaded("play", "", str) is None
        assert compilation.loaded("roots", "", str) is None
    assert caplog.text.count("pip install ziglang") == 1  # what a diagnosis asks for first
    monkeypatch.setattr(compilation.importlib.util, "find_spec", lambda name: name == "ziglang")
    assert find_compiler()[:4] == (sys.executable, "-m", "ziglang", "cc")


@needs_compiler
def test_the_cache_is_used_again_and_keyed_by_content(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SERPENOID_CACHE", str(tmp_path))
    compiled([functions.shape(SMALL)])
    (library,) = tmp_path.glob("*.so")
    written = library.stat().st_mtime_ns
    compiled([functions.shape(SMALL)])
    assert [p.stat().st_mtime_ns for p in tmp_path.glob("*.so")] == [written]
    compiled([functions.step_energy(SMALL)])
    assert len(list(tmp_path.glob("*.so"))) == 2
    assert not list(tmp_path.glob("*.lock"))
    assert not list(tmp_path.glob(".*"))  # no half-written library left behind


@needs_compiler
def test_a_compiler_that_fails_is_a_warning_and_the_virtual_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    broken = tmp_path / "cc"
    broken.write_text("#!/bin/sh\necho no such processor >&2\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setenv("CC", str(broken))
    monkeypatch.setenv("SERPENOID_CACHE", str(tmp_path / "cache"))
    function = functions.shape(SMALL)
    with caplog.at_level(logging.WARNING):
        assert compiled([function])[0] is function
    assert "no such processor" in caplog.text
    assert not list((tmp_path / "cache").glob("*.so"))


@needs_compiler
@pytest.mark.parametrize("kept", [0, 100, 4096, 8192, -1])
def test_a_library_that_was_cut_short_is_built_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kept: int
) -> None:
    monkeypatch.setenv("SERPENOID_CACHE", str(tmp_path))
    function = functions.shape(SMALL)
    compiled([function])
    (library,) = tmp_path.glob("*.so")
    whole = library.read_bytes()
    library.unlink()  # an open library must not be overwritten in place
    library.write_bytes(whole[:kept])
    assert compiled([function])[0].class_name() == "External"
    assert library.read_bytes() == whole


@needs_compiler
def test_a_library_without_its_checksum_or_with_another_is_not_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SERPENOID_CACHE", str(tmp_path))
    function = functions.shape(SMALL)
    compiled([function])
    (library,), (receipt,) = tmp_path.glob("*.so"), tmp_path.glob("*.sha256")
    for said in ("", "0" * 64):
        receipt.write_text(said)
        built = library.stat().st_ino
        assert compiled([function])[0].class_name() == "External"
        assert library.stat().st_ino != built


@needs_compiler
def test_a_library_that_cannot_be_loaded_is_a_warning_and_the_virtual_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("SERPENOID_CACHE", str(tmp_path))
    function = functions.shape(SMALL)
    compiled([function])
    (library,) = tmp_path.glob("*.so")
    library.unlink()
    library.write_bytes(b"built for another machine")
    library.with_suffix(".sha256").write_text(hashlib.sha256(library.read_bytes()).hexdigest())
    with caplog.at_level(logging.WARNING):
        again = compiled([function])[0]
    assert again is function
    assert "virtual machine" in caplog.text
    assert compiled([function])[0].class_name() == "External"  # the next one compiles it afresh


@pytest.mark.parametrize("mode", [0o777, 0o775, 0o702])
def test_a_cache_that_others_may_write_is_refused(tmp_path: Path, mode: int) -> None:
    tmp_path.chmod(mode)
    with pytest.raises(InputError, match=r"may be written to by other users.*chmod go-w .*SERPENOID_COMPILE=0"):
        compilation.refuse_shared(tmp_path)
    below = tmp_path / "below"
    below.mkdir(mode=0o700)
    if mode & 0o002:  # who may rename the folder above can put another in its place
        with pytest.raises(InputError, match="may be written to by other users"):
            compilation.refuse_shared(below)
    tmp_path.chmod(0o1777)  # like /tmp: nobody can rename what belongs to another
    compilation.refuse_shared(below)


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root can give a folder away")
def test_a_cache_of_another_user_is_refused_before_anything_is_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SERPENOID_CACHE", str(tmp_path))
    monkeypatch.setattr(compilation, "find_compiler", lambda: ("cc",))
    os.chown(tmp_path, 4321, 4321)
    with pytest.raises(InputError, match=r"belongs to another user \(uid 4321\).*Set SERPENOID_CACHE"):
        compiled([functions.shape(SMALL)])
    assert not list(tmp_path.iterdir())


def test_a_cache_that_cannot_be_written_is_a_warning_and_the_virtual_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("SERPENOID_CACHE", str(tmp_path / "file"))
    monkeypatch.setattr(compilation, "find_compiler", lambda: ("cc",))
    function = functions.shape(SMALL)
    with caplog.at_level(logging.WARNING):
        assert compiled([function])[0] is function
        assert compiled([functions.shape(LARGER)])[0].class_name() != "External"
        assert store.remember(lambda: 1.0, "not kept") == 1.0
    (warning,) = caplog.messages  # said once, whatever cannot be kept
    assert f"SERPENOID_CACHE = {tmp_path / 'file'} cannot be written to" in warning
    assert "virtual machine" in warning


CHILD = """
import sys
import numpy as np
from serpenoid.mechanics import functions, roots, servo
from serpenoid.mechanics.compile import compiled
from serpenoid.model import Structure
structure = Structure(4, (1, 2), "vertex")
shape, energy = compiled([functions.shape(structure), functions.step_energy(structure)])
assert shape.class_name() == "External", shape.class_name()
parameters = [1 / 3] * 3 + [1 / 4] * 4 + [0.2]
sys.stdout.write(repr(shape([0.3, -0.4], parameters)[0].full().tolist()))
"""


@needs_compiler
def test_processes_that_compile_at_once_into_an_empty_cache_all_get_the_library(tmp_path: Path) -> None:
    source = str(Path(compilation.__file__).parents[2])
    environment = os.environ | {"SERPENOID_CACHE": str(tmp_path), "PYTHONPATH": source}
    environment.pop("SERPENOID_COMPILE", None)
    command = [sys.executable, "-c", CHILD]
    children = [
        subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for _ in range(3)
    ]
    results = [child.communicate(timeout=120) for child in children]
    assert [child.returncode for child in children] == [0, 0, 0], results
    assert len({output for output, _ in results}) == 1
    assert len(list(tmp_path.glob("*.so"))) == 1


@needs_compiler
def test_generated_c_of_a_public_function_compiles_by_itself(tmp_path: Path) -> None:
    source = tmp_path / "momentum.c"
    source.write_text(generate_c([functions.step_momentum(SMALL)]))
    library = tmp_path / "momentum.so"
    subprocess.run([*find_compiler(), "-shared", "-fPIC", str(source), "-o", str(library), "-lm"], check=True)
    external, rng = ca.external("step_momentum", str(library)), np.random.default_rng(41)
    inputs = [rng.normal(size=external.size_in(i)) for i in range(external.n_in())]
    expected = functions.step_momentum(SMALL)(*inputs).full()
    np.testing.assert_allclose(external(*inputs).full(), expected, rtol=SAME)


def test_joint_tables_need_no_compiler() -> None:
    model = reference()
    q = np.array([0.6, 1.0, -1.5, 0.4, 6.0, 0.9])
    np.testing.assert_allclose(joint_table(model, q, 20), serpenoid_table(model), atol=1e-13)
