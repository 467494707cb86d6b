"""How far elbows and knees are bent, and when they bend and stretch.

Source: ``encode/BODY.md``, "Bends".
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, pairwise

import numpy as np

from lanindex.alphabet import BENDS, PARTS, SIXTHS
from lanindex.encode import compiled
from lanindex.encode.arithmetic import Floats, bend
from lanindex.encode.joints import Body
from lanindex.encode.limbs import window
from lanindex.encode.places import Stretch, stretches
from lanindex.encode.profile import Profile
from lanindex.encode.steps import Event
from lanindex.model import Span
from lanindex.model.bends import DEGREE, bending, stretching

SWING = 20.0
"""Degrees of angle: less is no bend, and no farther from the middle of a degree is still that."""

CALM = 0.15
"""Seconds that an angle is averaged over where its pace is looked at."""

IDLES = 20.0
"""Degrees of angle a second: slower, for as long as `LULL`, parts two bends."""

LULL = 0.25
"""Seconds that a joint is slow for where it rests."""

Ends = tuple[int, int]


def bends(body: Body) -> Iterator[tuple[str, Span, int, list[Event]]]:
    """Yield how each arm and leg bends, stretch by stretch.

    Parameters
    ----------
    body : Body
        The capture; a limb without its middle joint has no bends.

    Yields
    ------
    tuple of str, Span, int and list of Event
        The track, the frames of the source over which it is known, the first resampled frame, and
        the symbols: first the degree at the beginning, then the bends.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.encode.bends import bends
    >>> from lanindex.encode.joints import Body
    >>> body = Body(lanindex.read("corpus/compass.bvh"), lanindex.load_profile())
    >>> for part, known, begin, found in bends(body):
    ...     print(part, known, [one.amount for one in found])
    r_arm_bend Span(start=0, stop=840) [0, 6, 7]
    l_arm_bend Span(start=0, stop=840) [0]
    r_leg_bend Span(start=0, stop=840) [0]
    l_leg_bend Span(start=0, stop=840) [0]
    """
    for limb, part in BENDS.items():
        chain = PARTS[limb].chain
        for stretch in stretches(body, chain):
            found = _found(_angle(stretch, chain), body.profile)
            yield part, stretch.known, stretch.frames.start, found


def _angle(stretch: Stretch, chain: Sequence[str]) -> Floats:
    """Return by how many degrees the lower bone is turned from the upper one, (N,)."""
    angle = np.empty(len(stretch.frames))
    for block, places in stretch.blocks():
        upper, middle, lower = (places[joint] for joint in chain)
        angle[block.inner] = bend(middle - upper, lower - middle)
    return angle


def _found(angle: Floats, profile: Profile) -> list[Event]:
    """Return the degree at the beginning, and the bends."""
    stages = compiled.chosen(0)
    calm = stages.mean(angle, window(CALM, profile.rate))
    pace = np.gradient(calm) * float(profile.rate) if len(calm) > 1 else np.zeros(len(calm))
    degree = min(round(calm[0] / DEGREE), SIXTHS)
    found = [_event(0, 0, bending(degree), float(calm[0]), degree)]
    fast = np.abs(pace)
    least = round(LULL * profile.rate)
    for first, last in stages.swings(calm, SWING):
        if abs(calm[last] - calm[first]) < SWING:
            continue
        way = 1 if calm[last] > calm[first] else -1
        for part, within in _pieces(way * pace[first : last + 1], first, least):
            arrived = float(angle[part[1]])
            if way * (arrived - DEGREE * degree) <= SWING:
                continue
            degree = min(round(arrived / DEGREE), SIXTHS)
            amount = bending(degree) if way > 0 else stretching(degree)
            begin, end = stages.seen(angle, fast, part, within, IDLES / float(profile.rate))
            found.append(_event(begin, end, amount, arrived, degree))
    return found


def _event(start: int, stop: int, amount: int, angle: float, degree: int) -> Event:
    off = abs(angle / DEGREE - degree)
    return Event(start, stop, -1, -1, max(1 - 2 * off, 0.0), amount=amount)


def _pieces(pace: Floats, first: int, least: int) -> Iterator[tuple[Ends, Ends]]:
    """Part a swing where it rests or gives way: what moves, and what may go on slowly between.

    Beside the first and the last frame of each are those that its borders lie between: what moves
    may have begun in the rest before, and end in the one behind.
    """
    last = first + len(pace) - 1
    slow = compiled.chosen(0).lulls(pace, IDLES, least)
    rests = ((first + start, min(first + stop, last)) for start, stop in slow)
    edges = [first, first, *chain(*rests), last, last]
    for number, part in enumerate(pairwise(edges[1:-1])):
        if part[0] < part[1]:
            yield part, part if number % 2 else (edges[number], edges[number + 3])
