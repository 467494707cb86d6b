"""An installed package makes and upgrades libraries: from a wheel, and from a checkout."""

import os
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

pytestmark = pytest.mark.sqlite  # a library in a file

SCRIPT = """
import sys
from importlib import resources
from lanindex.library import migrate
from lanindex.library.connect import altering, connected, target
from lanindex.library.store import Store

link = connected(target("steps.db"), create=True, readonly=False, timeout=1)
with altering(link) as connection:
    migrate.run(connection, "0001", "steps.db")
link.close()
migrate.upgrade("steps.db")
Store.open("once.db", create=True).close()
for name in ("steps.db", "once.db"):
    Store.open(name).close()
    assert migrate.check(name) == []
from lanindex.film.figure import View
from lanindex.film.hits import page  # its page is a file of its own


assert page([], "walk", View(0)).startswith("<!DOCTYPE html>")
assert resources.files("lanindex").joinpath("py.typed").is_file()
print(migrate.scripts())
"""


def run(*command: str, cwd: Path) -> str:
    env = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(command, cwd=cwd, env=env, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.strip()


@pytest.fixture
def environment(tmp_path):
    """Return the Python of a new environment that borrows our libraries, but not lanindex."""
    venv.create(tmp_path / "venv", with_pip=False)
    python = next((tmp_path / "venv").glob("[bS]*/python*"))
    site = run(
        str(python), "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", cwd=tmp_path
    )
    # A folder named by a .pth is searched, but the .pth files inside it (ours) are not read.
    Path(site, "borrowed.pth").write_text(sysconfig.get_path("purelib"))
    return str(python)


def install(python: str, *what: str, cwd: Path) -> None:
    quiet = ("--quiet", "--no-deps", "--no-index", "--no-build-isolation")
    run(sys.executable, "-m", "pip", "--python", python, "install", *quiet, *what, cwd=cwd)


@pytest.mark.slow
def test_from_a_wheel(tmp_path, repository, environment):
    build = ("-m", "build", "--wheel", "--no-isolation", "--outdir", str(tmp_path))
    run(sys.executable, *build, str(repository), cwd=tmp_path)
    (wheel,) = tmp_path.glob("*.whl")
    install(environment, str(wheel), cwd=tmp_path)
    folder = Path(run(environment, "-c", SCRIPT, cwd=tmp_path))
    assert folder.parts[-2:] == ("lanindex", "_migrations")
    assert folder.is_relative_to(tmp_path)


def test_from_a_checkout(tmp_path, repository, environment):
    install(environment, "--editable", str(repository), cwd=tmp_path)
    assert Path(run(environment, "-c", SCRIPT, cwd=tmp_path)) == repository / "migrations"
