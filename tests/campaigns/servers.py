"""Let a PostgreSQL server crash, cut its connections, or have a full disk, while a verb goes on.

Each process of the campaign has a server of its own, its data on a small disk. In the middle of a
verb the server is killed and started again, now or a little later; or it cuts all connections; or
its disk is full. The verb ends with 2 and a sentence, or does all that it does. What is left is
whole, and the same command ends well once the server runs and has room.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack, chdir, suppress
from pathlib import Path
from random import Random

import common
import kills
import schemas
from common import errors_of
from postgres_server import Server, serving

DISK = 160 << 20
SAYS = ("server", "No space left", "schema")
CUT = "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE application_name = 'lanindex'"

OWN = ExitStack()
"""The server of this process and its disk."""

SERVER: list[Server] = []


def begin() -> Server:
    """Start a server on a small disk, where one can be mounted."""
    if not SERVER:
        folder = tempfile.mkdtemp(prefix="server-")
        OWN.callback(os.rmdir, folder)
        size = f"size={DISK},mode=0755"
        command = ["mount", "-t", "tmpfs", "-o", size, "none", folder]
        if subprocess.run(command, capture_output=True, check=False).returncode == 0:
            OWN.callback(subprocess.run, ["umount", "--lazy", folder], check=True)
        os.chmod(folder, 0o755)
        kept, tempfile.tempdir = tempfile.tempdir, folder
        options = "-c max_wal_size=32MB -c restart_after_crash=on"
        SERVER.append(OWN.enter_context(serving(options)))
        tempfile.tempdir = kept
        kills.SCHEMAS = schemas.Schemas(SERVER[0])
    return SERVER[0]


def crash(server: Server, choice: Random) -> None:
    """Kill the server, and start it again, mostly at once."""
    server.stop("immediate")
    time.sleep(choice.choice((0, 0, 0.3)))
    server.start()


def cut(server: Server, choice: Random) -> None:
    """Cut all connections, also those that are made anew."""
    for _ in range(choice.choice((1, 1, 5))):
        with server.connect(autocommit=True) as link:
            link.execute(CUT)


def fill(server: Server, choice: Random) -> None:
    """Fill the disk of the server for a while."""
    filler = server.folder / "filler"
    room = choice.choice((0, 0, 1 << 16, 1 << 19))
    held = os.statvfs(server.folder)
    with open(filler, "wb", buffering=0) as file, suppress(OSError):
        left = held.f_bavail * held.f_frsize - room
        while left > 0:
            left -= file.write(bytes(min(left, 1 << 20)))
    time.sleep(0.5)
    filler.unlink()


def runs(server: Server) -> None:
    """Start the server again if a full disk has ended it."""
    for _ in range(100):
        with suppress(Exception), server.connect() as link:
            link.execute("SELECT 1")
            return
        if not (server.data / "postmaster.pid").exists():
            with suppress(AssertionError):
                server.start()
        time.sleep(0.1)
    raise TimeoutError("the server does not start")


def trial(choice: Random, folder: Path) -> dict[str, int]:
    """Break a server off in the middle of a verb."""
    server = begin()
    verbs = [one for one in kills.VERBS if one not in kills.OF_FILES]
    make = choice.choice(verbs)
    verb = make(kills.Scene(choice, folder))
    before = kills.look()[1]
    ways = [crash, crash, cut, cut, *[fill] * (2 * os.path.ismount(server.folder.parent))]
    way = choice.choice(ways)
    after = choice.random() * choice.choice((0.05, 0.3))

    def work() -> int:
        with open(os.devnull, "w") as lines:
            return verb.work(lines=lines.fileno())

    def meanwhile() -> None:
        time.sleep(after)
        way(server, choice)

    code = common.forked(work, meanwhile)
    runs(server)
    said, (held, wrong) = errors_of(), kills.look()
    about = make.__name__, way.__name__, code, said
    assert {*wrong} <= {*before}, (about, wrong)
    assert held in verb.states, (about, held, verb.states)
    if code == 2:
        lines = [it for it in said.splitlines() if it.startswith("lanindex: ")]
        assert len(lines) == 1, about
        assert any(word in lines[0] for word in SAYS), about
    else:
        assert code in verb.ends, about
        assert held == verb.states[-1], about
    assert common.forked(work) in verb.ends, (about, errors_of())
    assert kills.look() == (verb.states[-1], []), about
    assert kills.SCHEMAS is not None
    kills.SCHEMAS.drop(kills.LIBRARY)
    return {way.__name__: 1, "done": code != 2, "refused": code == 2}


def main() -> int:
    """Prepare what is compared with, in files, and run the trials."""
    options = common.arguments(__doc__.split("\n")[0], 300).parse_args()
    with tempfile.TemporaryDirectory() as name:
        with chdir(name):
            kills.prepare(Path(name))
        return common.run(trial, options, OWN.close)


if __name__ == "__main__":
    sys.exit(main())
