"""What campaigns share: their options, trials in processes of their own, and the line of figures.

A campaign is many trials. Each has a seed of its own, so that one alone can be done again with
``--only``, and a folder of its own, which goes with it: in ``TMPDIR``, which is fastest in memory
(``/dev/shm``).
"""

from __future__ import annotations

import argparse
import ctypes
import faulthandler
import os
import pickle
import signal
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from random import Random
from select import select
from time import monotonic, sleep
from typing import Any

TESTS = Path(__file__).parents[1]
sys.path[:0] = [str(TESTS), str(TESTS.parent)]  # modules of the tests, and the package beside them

os.environ["NO_COLOR"] = "1"

Trial = Callable[[Random, Path], Mapping[str, int]]
"""Does something in an empty folder and returns what came of it, counted; raises where that must
not be."""


def arguments(about: str, count: int) -> argparse.ArgumentParser:
    """Return the options that all campaigns have."""
    parser = argparse.ArgumentParser(description=about)
    parser.set_defaults(about=Path(sys.argv[0]).stem)
    parser.add_argument("--count", type=int, default=count, help="how many trials")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, metavar="NUMBER", help="do this trial alone")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--minutes", type=float, help="begin no trial after so long")
    return parser


def run(trial: Trial, options: argparse.Namespace, close: Callable[[], None] = lambda: None) -> int:
    """Do all trials, print what failed and a line of figures, and return the exit code.

    Each process calls `close` at its end.
    """
    begun, became, failed, done = monotonic(), Counter[str](), list[int](), 0
    end = begun + 60 * options.minutes if options.minutes else None
    numbers = range(options.count) if options.only is None else [options.only]
    readers = dict[int, int]()
    for first in range(options.processes):
        reader, writer = os.pipe()
        sys.stdout.flush()
        if not os.fork():
            os.close(reader)
            try:
                _work(trial, options.seed, numbers[first :: options.processes], end, writer)
            except BaseException:
                traceback.print_exc()
            finally:
                close()
                os._exit(1)
        os.close(writer)
        readers[reader] = first
    said = {reader: b"" for reader in readers}
    while readers:
        for reader in select(list(readers), [], [])[0]:
            piece = os.read(reader, 1 << 16)
            said[reader] += piece
            *lines, said[reader] = said[reader].split(b"\n")
            for number, outcome, why in (pickle.loads(bytes.fromhex(it.decode())) for it in lines):
                became.update(outcome)
                done += 1
                if why:
                    failed.append(number)
                    print(f"trial {number} of seed {options.seed} failed:\n{why}", flush=True)
            if not piece:
                del readers[reader]
                os.close(reader)
                os.wait()
    seconds = monotonic() - begun
    counts = "".join(f", {count:,} {outcome}" for outcome, count in became.most_common())
    print(
        f"{options.about}: {done:,} trials, {len(failed)} failed{counts}; "
        f"seed {options.seed}, {seconds:.0f} s, {done / seconds:.1f} a second"
    )
    missing = len(numbers) - done if end is None else 0
    if missing:  # a process that did them has died
        print(f"{missing} trials never ended")
    return bool(failed or missing)


LONGEST = 300
"""Seconds that a trial may take."""


def _too_long(*_: object) -> None:
    raise TimeoutError(f"a trial takes more than {LONGEST} s")


def _work(trial: Trial, seed: int, numbers: Any, end: float | None, writer: int) -> None:
    """Do some trials, and tell of each."""
    for number in numbers:
        if end is not None and monotonic() > end:
            break
        outcome: Mapping[str, int] = {}
        why = ""
        with tempfile.TemporaryDirectory(prefix="campaign-") as name:
            os.chdir(name)
            signal.signal(signal.SIGALRM, _too_long)
            signal.alarm(LONGEST)
            try:
                outcome = trial(Random(f"{seed} {number}"), Path(name))
            except BaseException as error:
                if isinstance(error, KeyboardInterrupt):
                    raise
                why = "".join(traceback.format_exception(error)[-99:])
            signal.alarm(0)
            os.chdir("/")
        os.write(writer, pickle.dumps((number, outcome, why)).hex().encode() + b"\n")


# Small captures and scores that differ, the same each time.

DIRECTIONS = ("forward", "r_forward", "right", "back", "left", "l_forward")


def texts(count: int) -> list[str]:
    """Return scores of two units as LND, each with other movements of both arms."""
    return [_text(Random(f"clip {number}")) for number in range(count)]


def _text(choice: Random) -> str:
    lines = ["#speed=60", "#rhythm 4/4", "#unit_total 2", "#unit0"]
    lines += [f"direction {part} place low 0 0" for part in ("r_arm", "l_arm")]
    for unit in (1, 2):
        lines.append(f"#unit{unit}")
        for part in ("r_arm", "l_arm"):
            for start in range(0, 4, choice.choice((1, 2))):
                stop, where = start + choice.choice((0.5, 0.75, 1)), choice.choice(DIRECTIONS)
                level = choice.choice(("low", "mid", "high"))
                lines.append(f"direction {part} {where} {level} {start} {stop}")
    return "\n".join(lines) + "\n"


def files(scores: int, captures: int) -> list[tuple[str, bytes]]:
    """Return scores and performed ones: of each the ending and the content."""
    from dances import dance_bytes

    every = texts(scores + captures)
    return [(".lnd", text.encode()) for text in every[:scores]] + [
        (".bvh", dance_bytes(text)) for text in every[scores:]
    ]


SAID = [Path()]
"""The folder of ``stdout`` and ``stderr``."""


def called(*words: str | Path, lines: int | None = None) -> int:
    """Call the command in this process, and return its exit code.

    What it prints goes to the files ``stdout`` and ``stderr``, or line by line to a descriptor.
    """
    from lanindex.app import cli, output

    with (
        open(SAID[0] / "stdout" if lines is None else lines, "w", 1, closefd=lines is None) as out,
        open(SAID[0] / "stderr", "w", 1) as errors,
    ):
        kept = sys.stdout, sys.stderr
        sys.stdout, sys.stderr = out, errors
        try:
            return cli.run([str(word) for word in words])
        finally:
            output.end_progress()
            sys.stdout, sys.stderr = kept


def errors_of() -> str:
    """Return what `called` has printed on standard error, if it is no traceback."""
    said = (SAID[0] / "stderr").read_text(errors="replace")
    assert "Traceback" not in said, said
    return said


def forked(work: Callable[[], int], meanwhile: Callable[[], None] = lambda: None) -> int:
    """Do something in a process of its own, something here meanwhile, and return how it ended.

    Of one that takes too long is told where it stands.
    """
    sys.stdout.flush()
    with tempfile.TemporaryFile() as stacks:
        child = os.fork()
        if not child:
            faulthandler.register(signal.SIGUSR1, stacks)
            end_with(work)
        try:
            meanwhile()
            status = os.waitpid(child, 0)[1]
        except BaseException as error:
            os.kill(child, signal.SIGUSR1)
            sleep(1)
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            stacks.seek(0)
            error.add_note(f"the process stood at\n{stacks.read().decode()}")
            raise
    return os.waitstatus_to_exitcode(status)


def end_with(work: Callable[[], int]) -> None:
    """Do something, and end this process with what it returns; an error is told as a verb does."""
    from lanindex.errors import LanindexError

    try:
        code = work()
    except LanindexError as error:
        (SAID[0] / "stderr").write_text(f"lanindex: {error}\n")
        code = 2
    except BaseException:
        with open(SAID[0] / "stderr", "a") as errors:
            traceback.print_exc(file=errors)
        code = 99
    os._exit(code)


# A process that is killed as it makes its n-th system call: the moments between two calls are all
# the same to the disk. Linux alone traces calls so.

_TRACEME, _SYSCALL, _SETOPTIONS, _SYSCALL_INFO = 0, 24, 0x4200, 0x420E
_SYSGOOD, _EXITKILL = 1, 1 << 20
_WRITES = {1, 18, 20, 44, 74, 75, 76, 77, 82, 83, 87, 263, 264, 285, 316}
"""Numbers of the calls that change what is on a disk, or send to a server, on x86-64: write, fsync,
unlink, sendto …"""


def _ptrace(request: int, child: int, size: Any, data: Any) -> None:
    trace = ctypes.CDLL(None, use_errno=True).ptrace
    trace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
    if trace(request, child, size, data) < 0:
        raise OSError(ctypes.get_errno(), "ptrace")


def stopped(work: Callable[[], int], last: int = 0, *, writes: bool) -> tuple[int, int]:
    """Do something in a process that is killed before its `last` system call; 0: not at all.

    If only `writes` count, it is one of those that change what is on a disk. Return how it ended
    (-9: killed), and how many calls there were.
    """
    sys.stdout.flush()
    child = os.fork()
    if not child:
        _ptrace(_TRACEME, 0, None, None)
        os.kill(os.getpid(), signal.SIGSTOP)
        end_with(work)
    os.waitpid(child, 0)
    _ptrace(_SETOPTIONS, child, None, _SYSGOOD | _EXITKILL)
    info = (ctypes.c_uint64 * 11)()  # its first byte is 1 before a call, then the fourth is which
    calls = passed_on = 0
    while True:
        _ptrace(_SYSCALL, child, None, passed_on)
        status = os.waitpid(child, 0)[1]
        if not os.WIFSTOPPED(status):
            return os.waitstatus_to_exitcode(status), calls
        passed_on = os.WSTOPSIG(status)
        if passed_on == signal.SIGTRAP | 0x80:
            passed_on = 0
            _ptrace(_SYSCALL_INFO, child, ctypes.sizeof(info), ctypes.byref(info))
            calls += info[0] & 0xFF == 1 and (not writes or info[3] in _WRITES)
            if last and calls == last:
                os.kill(child, signal.SIGKILL)
                return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), calls
