"""How two lines must lie to each other: ``with``, ``during``, ``after`` and the others.

Each other line is compared with the first, its first start to its last end. "A starting position
alone comes neither after nor before anything"; beside others it is only where the first line is
still no more than one itself.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from lanindex.search.automaton import Companion
from lanindex.search.plain.candidates import Recording
from lanindex.search.plain.paths import Path


class Stretch(NamedTuple):
    """What another line is compared with.

    Attributes
    ----------
    start, until : int
        Frames, half-open.
    alone : bool
        Whether it is no more than a starting position.
    """

    start: int
    until: int
    alone: bool


FORBIDDEN = ("without", "never")
"""Relations of what must not happen."""

NO_FRAMES = ("during", "after", "before")
"""Relations of lines that add no frames to the hit."""

_AGREE: dict[str, Callable[[Stretch, Path, int], bool]] = {
    "with": lambda it, path, slack: it.start < path.until and path.start < it.until,
    "during": lambda it, path, slack: path.start <= it.start and it.until <= path.until,
    "starting with": lambda it, path, slack: abs(path.start - it.start) <= slack,
    "ending with": lambda it, path, slack: abs(path.until - it.until) <= slack,
    "exactly with": lambda it, path, slack: (
        abs(path.start - it.start) <= slack and abs(path.until - it.until) <= slack
    ),
    "without": lambda it, path, slack: it.start < path.until and path.start < it.until,
    "never": lambda it, path, slack: True,
}
"""Whether they lie as a relation says that has no limit; slack in frames."""

_BETWEEN: dict[str, Callable[[Stretch, Path], int]] = {
    "with": lambda it, path: max(0, path.start - it.until, it.start - path.until),
    "without": lambda it, path: max(0, path.start - it.until, it.start - path.until),
    "after": lambda it, path: it.start - path.until,
    "before": lambda it, path: path.start - it.until,
}
"""How many frames lie between; less than none: it is the other one that comes first."""


def stands(
    companion: Companion, stretch: Stretch, path: Path, recording: Recording, slack: int
) -> bool:
    """Tell whether a path stands to a stretch as a companion of it must, or must not.

    Parameters
    ----------
    companion : Companion
        The relation, and how many frames may lie between.
    stretch : Stretch
        The leading line, or the hit.
    path : Path
        The other line.
    recording : Recording
        Whose clock tells how long that is.
    slack : int
        Frames by which edges may differ that should agree.
    """
    relation, within = companion.relation, companion.within
    if relation in ("after", "before"):
        between = _BETWEEN[relation](stretch, path)
        if path.alone or stretch.alone or between < 0:
            return False
        return recording.meets(between, within)
    if path.alone and not stretch.alone:
        return False
    if within:
        return recording.meets(_BETWEEN[relation](stretch, path), within)
    return _AGREE[relation](stretch, path, slack)
