"""Fixtures that all tests share."""

import os
import signal
import sys
from pathlib import Path

import pytest
from hypothesis import settings

TESTS = Path(__file__).parent
REPOSITORY = TESTS.parent
sys.path.insert(0, str(TESTS))
settings.register_profile("house", deadline=None)  # a deadline is a timed assertion
settings.load_profile("house")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--bless", action="store_true", help="rewrite golden files, then read the diff"
    )
    parser.addoption("--fuzz", action="store_true", help="run the long fuzzing tests too")


def pytest_configure() -> None:
    """Let the commands that tests start hear Ctrl-C, which a job in the background ignores."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if not config.getoption("--fuzz"):
        skip = pytest.mark.skip(reason="long fuzzing: run with --fuzz")
        for item in items:
            if "fuzz" in item.keywords:
                item.add_marker(skip)


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
