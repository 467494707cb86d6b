"""A PostgreSQL server for tests: in a temporary folder, on a socket, gone at the end."""

import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

PLACES = "/usr/lib/postgresql"  # Debian keeps the server's commands off the path
FAST = "-c fsync=off -c synchronous_commit=off -c full_page_writes=off"


def folder_of_commands() -> Path | None:
    """Return where ``initdb`` and ``pg_ctl`` are; None: nowhere."""
    found = shutil.which("initdb", path=f"{os.environ['PATH']}:{_installed()}")
    return Path(found).parent if found else None


def _installed() -> str:
    versions = Path(PLACES).glob("*/bin") if Path(PLACES).is_dir() else ()
    return ":".join(map(str, sorted(versions, reverse=True)))


class Server:
    """A running server."""

    def __init__(self, commands: Path, folder: Path, options: str = FAST) -> None:
        self.commands, self.folder, self.data = commands, folder, folder / "data"
        # The server refuses to be root's
        self.user = "postgres" if os.geteuid() == 0 else None
        if self.user:
            shutil.chown(folder, self.user)
        self.options = f"-k {folder} -c listen_addresses='' -c max_connections=200 {options}"
        how = ["--auth=trust", "--username=owner", "--no-sync", "--encoding=UTF8", "--locale=C"]
        self.run("initdb", *how)

    def run(self, command: str, *words: str) -> None:
        """Run one of the server's commands on its data, as its user."""
        words = (str(self.commands / command), "-D", str(self.data), *words)
        done = subprocess.run(
            words, user=self.user, cwd=self.folder, capture_output=True, text=True, timeout=60
        )
        assert done.returncode == 0, done.stdout + done.stderr

    def start(self) -> None:
        """Start the server, and wait for it."""
        self.run("pg_ctl", "-w", "-l", str(self.folder / "log"), "-o", self.options, "start")

    def stop(self, mode: str = "fast") -> None:
        """Stop the server; ``immediate`` is a crash."""
        self.run("pg_ctl", "-w", "-m", mode, "stop")

    def url(self, schema: str, user: str = "owner") -> str:
        """Return the address of a library in a schema."""
        place = f"host={self.folder}&options=-csearch_path%3D{schema}"
        return f"postgresql+psycopg://{user}@/postgres?{place}"

    def address(self, database: str) -> str:
        """Return the address of a library that has a database to itself."""
        return f"postgresql+psycopg://owner@/{database}?host={self.folder}"

    def connect(self, **options: object):
        """Return a connection of psycopg."""
        import psycopg

        how = {"host": str(self.folder), "user": "owner", "dbname": "postgres", **options}
        return psycopg.connect(**how)


@contextmanager
def serving(options: str = FAST) -> Iterator[Server]:
    """Start a server; skip the test where PostgreSQL is not installed, in CI fail."""
    commands = folder_of_commands()
    if commands is None:
        (pytest.fail if os.environ.get("CI") == "true" else pytest.skip)(
            "no PostgreSQL server is installed: Debian's package postgresql"
        )
    with TemporaryDirectory(prefix="lanindex") as name:
        os.chmod(name, 0o755)
        server = Server(commands, Path(name), options)
        server.start()
        try:
            yield server
        finally:
            server.stop("immediate")
