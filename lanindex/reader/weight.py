"""What carries the body: feet that stand by circles, feet that jump by the signs around."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from lanindex.alphabet import FEET, kind_of

if TYPE_CHECKING:
    from lanindex.reader.score import Record

CIRCLES = ("hold", "?")
"""Signs that tell what carries: a foot or both, or that it is not known."""

_STANCES = ("r_stance", "l_stance")
_FLIGHTS = {(2, 2, True): "spring", (1, 1, True): "hop", (1, 1, False): "leap"} | {
    **{(1, 2, it): "assemble" for it in (True, False)},
    **{(2, 1, it): "sissonne" for it in (True, False)},
}
"""What a flight is by how many feet it leaves and lands on, and whether one is the same."""


def stances(
    circles: Sequence[Record], records: Sequence[Record], spots: Sequence[float], last: float
) -> Iterator[Record]:
    """Yield the feet that stand, each until the next sign of support, or circle.

    Parameters
    ----------
    circles : sequence of Record
        On the column of a foot, or on the centre line for both; a question says that it is not
        known which foot stands.
    records : sequence of Record
        What else was read, in order: the level of a foot is that of its step before.
    spots : sequence of float
        Where the body begins to turn on the spot.
    last : float
        Where the page ends.

    Yields
    ------
    Record
    """
    ends = [last, *spots, *(it.start for it in circles)]
    ends += [it.start for it in records if kind_of(it.part) in ("support", "jump", "carrier")]
    ends += [it.end for it in records if kind_of(it.part) == "carrier"]
    ends.sort()
    standing: dict[str, Record] = {}
    for circle in sorted(circles, key=lambda it: it.start):
        if circle.start >= last:
            continue
        end = ends[bisect_right(ends, circle.start)]
        both = not circle.part.endswith("support")
        for part in _STANCES if circle.kind == "hold" else ():
            if not both and circle.part[0] != part[0]:
                continue
            before = standing.get(part)
            if before and before.end == circle.start:  # it stands again on each staff
                standing[part] = replace(before, end=end)
                continue
            if before:
                yield before
            steps = [it for it in records if it.part == f"{part[:2]}support"]
            levels = [it.level for it in steps if it.end <= circle.start]
            level = levels[-1] if levels else "mid"
            standing[part] = replace(circle, part=part, kind="stance", level=level, end=end)
    yield from standing.values()


def jumped(jump: Record, records: Sequence[Record]) -> Record:
    """Return a jump with its direction and its feet, by the signs before and behind it."""
    steps = [it for it in records if it.part in ("r_support", "l_support")]
    landings = [it for it in steps if jump.start < it.end <= jump.end]
    stood = [it for it in records if it.part in _STANCES and it.end == jump.start]
    if not stood:  # the foot, or both, that stepped last
        steps = [it for it in steps if it.end <= jump.start]
        stood = [it for it in steps if it.end == max(it.end for it in steps)]
    left, landed = ({it.part[0] for it in own} for own in (stood, landings))
    feet = _FLIGHTS.get((len(left), len(landed), left == landed), "unseen")
    ways = {it.direction for it in landings}
    way = ways.pop() if len(ways) == 1 else "place"
    return replace(jump, direction=way, amount=FEET.index(feet))
