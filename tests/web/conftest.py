"""A browser, and the tools that check and bundle the page's scripts."""

import fcntl
import hashlib
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser

HERE = Path(__file__).parent
WAIT = 240  # seconds for the registry of npm, at most
ARGUMENTS = (
    "--headless",
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-angle=swiftshader",  # the same pictures with and without a graphics card
    "--enable-unsafe-swiftshader",
)


def missing(what: str) -> NoReturn:
    """Skip what this machine cannot try; CI must try all."""
    if os.environ.get("CI") == "true":
        pytest.fail(f"{what}: CI must not skip the tests of the page")
    pytest.skip(what)


@pytest.fixture(scope="session")
def static() -> Path:
    """Return the folder of what the page is made of."""
    return HERE.parent.parent / "lanindex" / "web" / "static"


@pytest.fixture(scope="session")
def node_modules() -> Path:
    """Return a folder with the packages of package.json, which all test processes share."""
    npm = shutil.which("npm")
    if npm is None:
        missing("npm is not installed")
    wanted = (HERE / "package.json").read_bytes()
    name = f"lanindex-npm-{os.getuid()}-{hashlib.sha256(wanted).hexdigest()[:16]}"
    folder = Path(tempfile.gettempdir()) / name
    folder.mkdir(mode=0o700, exist_ok=True)
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "installed").exists():
            (folder / "package.json").write_bytes(wanted)
            command = [npm, "install", "--no-audit", "--no-fund", "--ignore-scripts"]
            try:
                done = subprocess.run(
                    command, cwd=folder, capture_output=True, text=True, check=False, timeout=WAIT
                )
            except subprocess.TimeoutExpired:
                missing(f"npm did not install its packages within {WAIT} s")
            if done.returncode:
                missing(f"npm installs nothing: {done.stderr.strip()[-400:]}")
            (folder / "installed").touch()
    return folder / "node_modules"


@pytest.fixture(scope="session")
def browser() -> "Iterator[Browser]":
    """Return a Chromium without a window, for all tests of a process."""
    path = shutil.which("chromium")
    if path is None:
        missing("Chromium is not installed: apt-get install chromium")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError as error:
        missing(f"{error}: pip install playwright")
    with sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=path, args=list(ARGUMENTS))
        yield found
        found.close()
