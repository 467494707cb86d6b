"""Interrupts processes that fill a library at random moments, and checks what is left.

Run as ``interrupt.py FOLDER kill|interrupt TIMES SEED [PLACE]``; fails if a capture is not whole.
With a place, columns are in files there.
"""

import os
import random
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from sample_library import add_sample, sample_score

from lanindex.errors import LibraryError
from lanindex.library.migrate import check
from lanindex.library.store import Store

CAPTURES = 25


def fill_until(path: Path, how: str, after: float, place: str) -> None:
    """Add what is missing, and be ended after some seconds."""
    if how == "interrupt":
        signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, after)  # unhandled, its signal ends a process at once
    with Store.open(path, create=True) as library:
        if place:
            library.cache.move(place)
        known = library.known()
        for number in range(CAPTURES):
            if os.path.abspath(f"{number}.bvh") not in known:
                add_sample(library, number)
                library.cache.compact()


def left_empty(path: Path) -> bool:
    """Return whether it was broken off while it was made, which is undone."""
    try:
        Store.open(path, readonly=True).close()
    except LibraryError as error:
        return "this file is empty" in str(error)
    return False


def assert_whole(path: Path) -> int:
    """Return the number of captures, all of them whole."""
    if not path.exists() or path.stat().st_size == 0:
        return 0
    if left_empty(path):
        return 0
    assert check(path) == []
    with Store.open(path, readonly=True) as library:
        found = list(library.tracks())
        roster, columns = library.columns(["head"])
        assert library.session.notes == []
    assert roster.number.tolist() == [capture.id for capture, _ in found]
    starts = [one for _, tracks in found for one in tracks["head"].symbols["start"].tolist()]
    assert columns["head"].start.tolist() == starts
    for capture, tracks in found:
        wanted = sample_score(int(Path(capture.path).stem)).tracks
        assert list(tracks) == list(wanted)
        for part, track in wanted.items():
            assert tracks[part].symbols.tolist() == track.symbols.tolist()
    return len(found)


def ended(path: Path, how: str, after: float, place: str) -> bool:
    """Fill in another process; return whether it was broken off."""
    child = os.fork()
    if child:
        return os.waitpid(child, 0)[1] != 0
    try:
        fill_until(path, how, after, place)
        os._exit(0)
    except KeyboardInterrupt:
        os._exit(130)


def main(folder: Path, how: str, times: int, seed: int, place: str = "") -> None:
    """Break off some times, each library until it is full; then fill the last one in peace."""
    choice = random.Random(seed)
    broken = filled = 0
    while broken < times:
        path = folder / f"{filled}.db"
        after = choice.uniform(0.001, 0.3 if place else 0.12)
        interrupted = ended(path, how, after, f"{path.stem}-{place}" if place else "")
        found = assert_whole(path)
        broken += interrupted
        filled += found == CAPTURES
        assert interrupted or found == CAPTURES
    path = folder / f"{filled}.db"
    assert not ended(path, how, 0, f"{path.stem}-{place}" if place else "")
    assert assert_whole(path) == CAPTURES
    print(broken)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]), int(sys.argv[4]), *sys.argv[5:])
