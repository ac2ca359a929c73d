"""Options and values that all tests share.

Long checks, and further variants of what others ask, are marked `slow` and run with --run-slow.
"""

from __future__ import annotations

import os
import signal
import tempfile
from collections.abc import Generator, Iterator
from contextlib import nullcontext
from pathlib import Path

import pytest
from filelock import FileLock

from serpenoid.__main__ import calm

calm()  # before NumPy is imported
PROBLEMS = Path(__file__).parents[1] / "problems"

# as shells start what runs in the background; children inherit it
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--run-slow", action="store_true", help="also run the tests marked slow")


def shared(item: pytest.Item) -> str | None:
    """The name of what a test shares with others: a fixture of the session, or those of its module."""
    made = getattr(item, "_fixtureinfo", None)
    if made and "serial_ports" in made.name2fixturedefs:  # they wait for one another and for the clock
        return "serial_ports"
    found = [f[-1] for name, f in made.name2fixturedefs.items() if f and name != "virtual_machine"] if made else []
    ours = [f for f in found if f.baseid.startswith("tests")]
    session = sorted(f.argname for f in ours if f.scope == "session")
    if session:
        return session[0]
    return item.nodeid.partition("::")[0] if any(f.scope == "module" for f in ours) else None


@pytest.hookimpl(tryfirst=True)  # the runner reads groups in the same hook
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    for item in items:
        if (name := shared(item)) is not None:
            item.add_marker(pytest.mark.xdist_group(name))
    if config.getoption("--run-slow"):
        return
    skip = pytest.mark.skip(reason="slow: run with --run-slow")
    for item in items:
        if "slow" in item.keywords:
            item.add_marker(skip)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """As many pieces of a task at once as this process has cores for itself: where others test as well, pieces that are
    forked wait for one another, which takes a seventh of the processor time. Who tests that, and commands, fork."""
    from serpenoid.parallel import limited

    cores = (os.cpu_count() or 1) // int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    with nullcontext() if item.path.parent.name == "parallel" else limited(max(1, cores)):
        return (yield)


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each test starts in a folder of its own: what is named by a hash of its content is also the other process's."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def serial_ports() -> Iterator[None]:
    """One test at a time on this machine: the number of a port that a test unplugs goes to the next one opened."""
    with FileLock(Path(tempfile.gettempdir()) / "serpenoid-tests-serial-ports.lock", timeout=600, mode=0o666):
        yield


@pytest.fixture(scope="module")
def virtual_machine() -> Iterator[None]:
    """Evaluate in CasADi's virtual machine: tests with many bodies would otherwise compile each of them."""
    from specimens import forget_functions

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SERPENOID_COMPILE", "0")
        forget_functions()
        yield
    forget_functions()
