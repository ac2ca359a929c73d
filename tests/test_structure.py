"""The way of the data is one way: no cycles among modules, and heavy imports only where they belong."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import serpenoid
from serpenoid.effects.catalogue import SITES, catalogue
from serpenoid.media import LAWS

SOURCE = Path(serpenoid.__file__).parent
FILES = sorted(SOURCE.rglob("*.py"))

# rooms that may import each heavy package; a name ending in / is a folder
ALLOWED = {
    "casadi": (
        *("gaits/", "objectives/", "mechanics/", "effects/"),
        *("simulation/", "optimise/", "compare/", "diagnose/"),
    ),
    "matplotlib": ("plot/",),
    "dynamixel_sdk": ("robot/bus/",),
    "mujoco": ("arena/",),
}
# what each of these rooms may know of the others; rooms that are not listed stand to the right of them all
LEFT_OF_MODELS = {
    "errors", "wording", "files", "table_file", "status", "shown", "body", "body_curve", "medium", "group", "gaits",
    "objectives", "interrupts", "joint_range",
}  # fmt: skip
MAY_IMPORT = {
    "files": {"errors"},
    "body": {"errors", "files", "joint_range"},
    "joint_range": set(),
    "body_curve": {"body"},
    "medium": {"files", "media"},
    "group": {"body"},
    "gaits": {"body", "files", "errors", "wording"},
    "objectives": {"body", "files", "errors", "wording"},
    "self_contact": {"body", "wording"},
    "table_file": {"body", "errors", "files", "wording"},
    "errors": set(),
    "wording": set(),
    "status": set(),
    "media": {"errors"},
    "effects": {"body", "files", "errors", "wording", "media"},
    "model": LEFT_OF_MODELS | {"effects", "media"},
    "trajectory": LEFT_OF_MODELS,
    "lifting": LEFT_OF_MODELS | {"model"},
    "problem": LEFT_OF_MODELS | {"model", "effects", "media", "model_file", "lifting"},
    "model_file": LEFT_OF_MODELS | {"effects"},
    "cases": LEFT_OF_MODELS | {"model", "effects", "model_file", "problem"},
    "mechanics": LEFT_OF_MODELS | {"model", "effects", "media"},
    "simulation": LEFT_OF_MODELS | {"model", "effects", "media", "trajectory", "problem", "mechanics", "joint_limits"},
    "optimise": LEFT_OF_MODELS
    | {"model", "media", "effects", "trajectory", "problem", "cases", "self_contact", "mechanics", "simulation"},
}


# rooms within a package, in the order in which they may import each other
ROOMS = {
    "measure": ("formats", "film", "shapes", "consistency", "animals"),
    "diagnose/data": ("shapes", "cameras", "recordings", "windows", "noise"),
    "diagnose/inference": ("fits", "search", "doubt"),
    "diagnose/stages": ("actuation", "observation", "motion"),
    "diagnose": ("data", "inference", "residuals", "stages", "design", "report"),
    "optimise": ("step", "clear", "program"),
}


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def imports(path: Path) -> set[str]:
    """Modules that a file imports when it runs: everything but what stands under `if TYPE_CHECKING`."""
    found: set[str] = set()

    def visit(node: ast.AST) -> None:
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            return
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            found.add(node.module)
            found.update(f"{node.module}.{alias.name}" for alias in node.names)
        for child in ast.iter_child_nodes(node):
            visit(child)

    visit(parsed(path))
    return found


def module(path: Path) -> str:
    """`serpenoid.a.b` of a file."""
    parts = path.relative_to(SOURCE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def room(name: str) -> str:
    """Top-level part below `serpenoid`."""
    return (name.split(".") + [""])[1]


@pytest.mark.parametrize("package", ALLOWED)
def test_heavy_packages_are_imported_in_their_rooms_alone(package: str) -> None:
    users = {
        path.relative_to(SOURCE).as_posix() for path in FILES if package in {m.split(".")[0] for m in imports(path)}
    }
    strangers = {user for user in users if not user.startswith(ALLOWED[package])}
    assert not strangers


@pytest.mark.parametrize("name", MAY_IMPORT)
def test_imports_point_one_way(name: str) -> None:
    for path in FILES:
        if room(module(path)) == name:
            known = {room(m) for m in imports(path) if m.startswith("serpenoid.")} - {name}
            assert known <= MAY_IMPORT[name], f"{path.relative_to(SOURCE)} reaches to the right"


@pytest.mark.parametrize("package", ROOMS)
def test_rooms_of_a_package_import_what_stands_before_them(package: str) -> None:
    order, dotted = ROOMS[package], f"serpenoid.{package.replace('/', '.')}."
    for number, name in enumerate(order):
        for path in (SOURCE / package / name).rglob("*.py"):
            used = {m.removeprefix(dotted).split(".")[0] for m in imports(path) if m.startswith(dotted)}
            assert not used & set(order[number + 1 :]), f"{path.relative_to(SOURCE)} reaches to a later room"
    assert {p.name for p in (SOURCE / package).iterdir() if (p / "__init__.py").exists()} == set(order)


def test_no_module_imports_itself_through_others() -> None:
    names = {module(path): path for path in FILES}
    graph = {name: {m for m in imports(path) if m in names and m != name} for name, path in names.items()}
    done: set[str] = set()

    def walk(name: str, trail: tuple[str, ...]) -> None:
        assert name not in trail, " -> ".join([*trail[trail.index(name) :], name])
        if name not in done:
            for other in graph[name] - {"serpenoid"}:  # the package itself only forwards names, lazily
                walk(other, (*trail, name))
            done.add(name)

    for name in names:
        walk(name, ())


def test_the_diagnosis_knows_no_effect_by_name() -> None:
    """What it must know of an effect stands in the effect's own file, so that one more file is one more candidate."""
    names, rooms = set(catalogue()), tuple(f"serpenoid.effects.{site}" for site in SITES)
    for path in (SOURCE / "diagnose").rglob("*.py"):
        texts = {n.value for n in ast.walk(parsed(path)) if isinstance(n, ast.Constant)}
        assert not texts & names, f"{path.relative_to(SOURCE)} names an effect"
        assert not {m for m in imports(path) if m.startswith(rooms)}, f"{path.relative_to(SOURCE)} imports an effect"


def test_no_law_is_asked_for_by_name() -> None:
    """What others must know of a law stands in its own file, so that one more file is one more law."""
    for path in FILES:
        if room(module(path)) != "media":
            texts = {
                n.value for n in ast.walk(parsed(path)) if isinstance(n, ast.Constant) and isinstance(n.value, str)
            }
            assert not texts & set(LAWS), f"{path.relative_to(SOURCE)} names a law"
            assert not {m for m in imports(path) if m.startswith(tuple(f"serpenoid.media.{name}" for name in LAWS))}


def test_nothing_but_the_command_line_imports_the_command_line() -> None:
    for path in FILES:
        if room(module(path)) not in ("cli", "__main__"):
            assert not {m for m in imports(path) if m.startswith("serpenoid.cli")}, path


def loaded_after(code: str) -> set[str]:
    """Top-level modules in a fresh interpreter after `code`."""
    script = f"{code}\nimport sys\nprint(*sorted({{m.split('.')[0] for m in sys.modules}}), file=sys.stderr)"
    environment = os.environ | {"PYTHONPATH": str(SOURCE.parent)}
    command = [sys.executable, "-c", script]
    child = subprocess.run(command, capture_output=True, text=True, env=environment, check=True, timeout=60)
    return set(child.stderr.split())


HELP = """
import contextlib
from serpenoid.cli.main import main
with contextlib.suppress(SystemExit):
    main("{} --help".split())
"""
HEAVY = {"casadi", "matplotlib", "scipy", "mujoco", "dynamixel_sdk", "joblib"}


def test_importing_the_package_loads_nothing_heavy() -> None:
    assert not loaded_after("import serpenoid") & (HEAVY | {"numpy", "pydantic"})


def test_help_loads_nothing_heavy() -> None:
    code = (
        "import contextlib\nfrom serpenoid.cli.main import main\nwith contextlib.suppress(SystemExit): main(['--help'])"
    )
    assert not loaded_after(code) & (HEAVY | {"numpy", "pydantic"})


def test_reading_loads_nothing_heavy() -> None:
    """A diagnosis reads its files while what judges them is imported."""
    assert not loaded_after("import serpenoid.cli.diagnose_one, serpenoid.measure.trial_files") & HEAVY


READER = """
from contextlib import suppress
from unittest.mock import patch
from serpenoid.cli.diagnose_one import run_one
with patch("serpenoid.measure.campaign.load_campaign_file") as load, suppress(SystemExit):
    load.return_value[0].tracked_only = False
    with patch("serpenoid.parallel.Beside.begin", side_effect=SystemExit):
        run_one(None, "campaign")
"""


def test_what_a_diagnosis_and_the_process_that_reads_for_it_both_need_is_imported_before_there_are_two() -> None:
    assert "scipy" in loaded_after(READER)


@pytest.mark.parametrize("verb", ["simulate", "solve", "sweep", "show", "schema"])
def test_help_of_a_verb_loads_nothing_heavy(verb: str) -> None:
    assert not loaded_after(HELP.format(verb)) & HEAVY


def test_every_public_name_can_be_imported_and_the_list_is_complete() -> None:
    for name in serpenoid.__all__:
        assert getattr(serpenoid, name) is not None
    assert set(serpenoid.__all__) == set(serpenoid._PUBLIC)
    with pytest.raises(AttributeError, match="no attribute 'simulat'"):
        _ = serpenoid.simulat


def test_source_raises_no_bare_exceptions_asserts_nothing_and_never_prints() -> None:
    for path in FILES:
        for node in ast.walk(parsed(path)):
            if not isinstance(node, ast.Assert | ast.Raise | ast.Call):
                continue
            where = f"{path.relative_to(SOURCE)}:{node.lineno}"
            assert not isinstance(node, ast.Assert), where
            if isinstance(node, ast.Raise) and node.exc is not None:
                raised = node.exc.func if isinstance(node.exc, ast.Call) else node.exc
                assert not (isinstance(raised, ast.Name) and raised.id in ("Exception", "BaseException")), where
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                assert node.func.id != "print", where


def test_every_module_says_what_it_is() -> None:
    for path in FILES:
        assert ast.get_docstring(parsed(path)), path


def test_no_name_of_a_module_is_given_twice() -> None:
    """The second would stand where the first is meant, and say something else."""
    for path in FILES:
        names: list[str] = []
        for node in parsed(path).body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                names += [] if isinstance(node, ast.FunctionDef) and node.decorator_list else [node.name]
            elif isinstance(node, ast.Assign | ast.AnnAssign):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                names += [n.id for t in targets for n in ast.walk(t) if isinstance(n, ast.Name)]
        assert len(names) == len(set(names)), (path, sorted({n for n in names if names.count(n) > 1}))


@pytest.fixture(scope="module")
def dear() -> object:
    return object()


@pytest.mark.parametrize("number", [1, 2])
def test_tests_that_share_what_is_dear_run_in_one_process(
    dear: object, number: int, request: pytest.FixtureRequest
) -> None:
    if "PYTEST_XDIST_WORKER" in os.environ:  # pytest 9.2 takes no group from pytest-xdist 3.8, and does not say so
        assert request.node.nodeid.endswith("@tests/test_structure.py")
