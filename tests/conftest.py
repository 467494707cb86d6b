"""Fixtures that all tests share."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from postgres_server import Server

TESTS = Path(__file__).parent
REPOSITORY = TESTS.parent
sys.path.insert(0, str(TESTS))


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--bless", action="store_true", help="rewrite golden files, then read the diff"
    )
    parser.addoption(
        "--slow", action="store_true", help="try all seeds and examples, and what takes long"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Choose how much is tried, and let commands hear Ctrl-C, which background jobs ignore."""
    # Tests start hundreds of processes: without bytecode each compiles the whole package
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    sys.dont_write_bytecode = False
    for name in ("LANINDEX_DB", "LANINDEX_WORDS"):  # the user's own, which tests leave alone
        os.environ.pop(name, None)
    import effort  # registers the profiles

    from lanindex import compiled

    # Only tests of compiled loops load or compile them, however much all of a process read together
    compiled._again.update(dict.fromkeys(compiled.LOOPS, sys.maxsize))
    taken = threading.Lock()
    taken.acquire()
    compiled.take_turns(taken)
    effort.settings.load_profile("slow" if config.getoption("--slow") else "quick")
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if not config.getoption("--slow"):
        skip = pytest.mark.skip(reason="run with --slow")
        for item in items:
            if "slow" in item.keywords:
                item.add_marker(skip)


@pytest.fixture(scope="session")
def server() -> Iterator[Server]:
    """Return a running PostgreSQL server."""
    from postgres_server import serving

    with serving() as running:
        yield running


@pytest.fixture(scope="session")
def captures() -> Path:
    """Return the folder of real captures; skip where there is none."""
    named = os.environ.get("LANINDEX_CAPTURES")
    folder = Path(named) if named else REPOSITORY.parent / "shared" / "captures"
    if folder.is_dir():
        return folder
    if named:
        pytest.fail(f"LANINDEX_CAPTURES names {named}, which is no folder")
    pytest.skip("no real captures: set LANINDEX_CAPTURES to their folder")


@pytest.fixture
def repository() -> Path:
    """Return the top folder of the checkout."""
    return REPOSITORY
