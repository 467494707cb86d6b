"""How two lines must lie to each other: ``with``, ``during``, ``after`` and the others.

Each other line is compared with the first, its first start to its last end. "A starting position
alone comes neither after nor before anything"; beside others it is only where the first line is
still no more than one itself.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from lanindex.search.plan import Companion
from plain_matcher.candidates import Recording


class Stretch(NamedTuple):
    """A line, as it is compared with others.

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


def _shared(it: Stretch, other: Stretch) -> int:
    return min(it.until, other.until) - max(it.start, other.start)


_AGREE: dict[str, Callable[[Stretch, Stretch, int], bool]] = {
    "with": lambda it, other, slack: it.start < other.until and other.start < it.until,
    "overlapping": lambda it, other, slack: (
        it.start < other.until
        and other.start < it.until
        and (other.alone or 2 * _shared(it, other) >= other.until - other.start)
    ),
    "during": lambda it, other, slack: other.start <= it.start and it.until <= other.until,
    "starting with": lambda it, other, slack: abs(other.start - it.start) <= slack,
    "ending with": lambda it, other, slack: abs(other.until - it.until) <= slack,
    "exactly with": lambda it, other, slack: (
        abs(other.start - it.start) <= slack and abs(other.until - it.until) <= slack
    ),
    "without": lambda it, other, slack: it.start < other.until and other.start < it.until,
    "never": lambda it, other, slack: True,
}
"""Whether they lie as a relation says that has no limit; slack in frames."""

_BETWEEN: dict[str, Callable[[Stretch, Stretch], int]] = {
    "with": lambda it, other: max(0, other.start - it.until, it.start - other.until),
    "without": lambda it, other: max(0, other.start - it.until, it.start - other.until),
    "after": lambda it, other: it.start - other.until,
    "before": lambda it, other: other.start - it.until,
}
"""How many frames lie between; less than none: it is the other one that comes first."""


def stands(
    companion: Companion, line: Stretch, other: Stretch, recording: Recording, slack: int
) -> bool:
    """Return whether another line stands to a line as a companion of it must, or must not.

    Parameters
    ----------
    companion : Companion
        The relation, and how many frames may lie between.
    line : Stretch
        The leading line, or the hit.
    other : Stretch
        The other line.
    recording : Recording
        Whose clock tells how long that is.
    slack : int
        Frames by which edges may differ that should agree.
    """
    relation, within = companion.relation, companion.within
    if relation in ("after", "before"):
        between = _BETWEEN[relation](line, other)
        if other.alone or line.alone or between < 0:
            return False
        return recording.meets(between, within)
    if other.alone and not line.alone:
        return False
    if within:
        return recording.meets(_BETWEEN[relation](line, other), within)
    return _AGREE[relation](line, other, slack)
