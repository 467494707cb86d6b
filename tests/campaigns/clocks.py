"""Let the clock jump back and forth, also in the middle of a verb: nothing comes of it.

The clock of the process is another one than that of the disk, as on a network. Before and while
verbs write, search, move columns into files and join them, it jumps by seconds, hours or years, and
files get times of their own. All answers and all that is stored must be as without that. The clock
is that of libfaketime, where it is installed; else only `time.time` is another.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import chdir, suppress
from functools import partial
from pathlib import Path
from random import Random
from select import select

import common

FAKED = next(Path("/usr/lib").glob("*/faketime/libfaketime.so.1"), None)
CLOCK = "FAKETIME_TIMESTAMP_FILE"
JUMPS = (0, 1, 59, 3601, 86_400, 400 * 86_400, 9_000 * 86_400)
VERBS = ("first_ingest", "later_ingest", "move", "label", "remove", "search", "join", "segments")

_real = time.time
_offset = [0.0]


def jump(choice: Random) -> None:
    """Set the clock forward or back, from what it really is."""
    _offset[0] = choice.choice(JUMPS) * choice.choice((1, -1)) + choice.random()
    if FAKED:
        draft = Path(f"{os.environ[CLOCK]}.{os.getpid()}")
        draft.write_text(f"{_offset[0]:+.3f}\n")
        draft.replace(os.environ[CLOCK])


def with_jumps(work: Callable[[], int], choice: Random) -> int:
    """Do something in a process of its own, while the clock jumps; return how it ended."""
    child = os.fork()
    if not child:
        if not FAKED:
            time.time = lambda: _real() + Random().choice(JUMPS) * Random().choice((1, -1))
        common.end_with(work)
    while not (ended := os.waitpid(child, os.WNOHANG))[0]:
        jump(choice)
        select([], [], [], 0.003)
    return os.waitstatus_to_exitcode(ended[1])


def trial(choice: Random, folder: Path) -> dict[str, int]:
    """Do some verbs one after the other, each at another time."""
    import kills

    os.environ[CLOCK] = str(folder.with_name(f"{folder.name}-clock"))
    try:
        jump(choice)
        scene = kills.Scene(choice, folder)
        for name in choice.sample(VERBS, 2):
            verb = getattr(kills, name)(scene)
            for path in Path("in").iterdir():
                if choice.random() < 0.5:
                    os.utime(path, (choice.choice((0, 1e9, 4e9)),) * 2)
            if choice.random() < 0.2:
                kills.sql(kills.LIBRARY, "PRAGMA journal_mode = WAL")
            with open(os.devnull, "w") as lines:
                code = with_jumps(partial(verb.work, lines=lines.fileno()), choice)
            assert code in verb.ends, (name, code, common.errors_of())
            held, wrong = kills.look()
            want = verb.states[-1]
            assert (held, wrong) == (want, []), (name, wrong, {*held.items()} ^ {*want.items()})
            scene.held = verb.states[-1]
        return {"verbs": 2}
    finally:
        with suppress(OSError):
            os.unlink(os.environ[CLOCK])


def main() -> int:
    """Begin anew with another clock, where there is one, then run the trials."""
    options = common.arguments(__doc__.split("\n")[0], 1000).parse_args()
    if FAKED and CLOCK not in os.environ:
        clock = {CLOCK: os.devnull, "LD_PRELOAD": str(FAKED), "FAKETIME_NO_CACHE": "1"}
        clock |= {"NO_FAKE_STAT": "1", "FAKETIME_DONT_FAKE_MONOTONIC": "1"}
        os.execve(sys.executable, [sys.executable, *sys.argv], {**os.environ, **clock})
    import kills

    with tempfile.TemporaryDirectory() as name:
        with chdir(name):
            kills.prepare(Path(name))
        return common.run(trial, options)


if __name__ == "__main__":
    sys.exit(main())
