"""Options and values that all tests share. Long checks are marked `slow` and run with --run-slow."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

HERE = Path(__file__).parent
PROBLEMS = Path(__file__).parents[1] / "problems"

if (
    signal.getsignal(signal.SIGINT) is signal.SIG_IGN
):  # as shells start what runs in the background; children inherit it
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--run-slow", action="store_true", help="also run the tests marked slow")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    for item in items:
        # an unplugged port's number is free for the next one that is opened: such tests run one after the other
        if item.path.is_relative_to(HERE / "robot") or item.path == HERE / "arena" / "test_bus.py":
            item.add_marker(pytest.mark.xdist_group("serial ports"))
    if config.getoption("--run-slow"):
        return
    skip = pytest.mark.skip(reason="slow: run with --run-slow")
    for item in items:
        if "slow" in item.keywords:
            item.add_marker(skip)


@pytest.fixture(scope="module")
def virtual_machine() -> Iterator[None]:
    """Evaluate in CasADi's virtual machine: tests with many bodies would otherwise compile each of them."""
    from specimens import forget_functions

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SERPENOID_COMPILE", "0")
        forget_functions()
        yield
    forget_functions()
