"""What tests have processes of a cluster do."""

import errno
import os
import signal
import time
from pathlib import Path

from lanindex.errors import LanindexError


def killing(item: tuple[str, int], tick) -> tuple[int, int]:
    """Die the first time, and say afterwards by whom this was done."""
    marker, number = item
    if number == 3 and not os.path.exists(marker):
        Path(marker).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number, os.getpid()


def waiting(item: str, tick) -> None:
    """Wait until nobody wants it, and note that."""
    begun = time.monotonic()
    Path(f"{item} begun").touch()
    try:
        while time.monotonic() - begun < 60:
            time.sleep(0.02)
            tick()
    finally:
        Path(item).write_text(f"{time.monotonic() - begun}")


def sleeping(seconds: float, tick) -> float:
    time.sleep(seconds)
    return seconds


def failing(item: int, tick) -> None:
    raise LanindexError(f"number {item}", place="here", remedy="None.")


def measuring(item: bytes, tick) -> int:
    """Return how long an item is."""
    return len(item)


def without_room(item: int, tick) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
