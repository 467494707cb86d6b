"""How far elbows and knees are bent, and when they bend and stretch.

Source: ``encode/BODY.md``, "Bends".
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from lanindex.alphabet import BENDS, PARTS, SIXTHS
from lanindex.encode.arithmetic import Floats, bend, runs
from lanindex.encode.joints import Body
from lanindex.encode.limbs import smooth, window
from lanindex.encode.places import Stretch, stretches
from lanindex.encode.profile import Profile
from lanindex.encode.steps import Event
from lanindex.encode.ways import swings
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
    calm = smooth(angle[None, :, None], window(CALM, profile.rate))[0, :, 0]
    pace = np.gradient(calm) * float(profile.rate) if len(calm) > 1 else np.zeros(len(calm))
    degree = min(round(calm[0] / DEGREE), SIXTHS)
    found = [_event(0, 0, bending(degree), float(calm[0]), degree)]
    least = round(LULL * profile.rate)
    for first, last in swings(calm, SWING):
        if abs(calm[last] - calm[first]) < SWING:
            continue
        way = 1 if calm[last] > calm[first] else -1
        onward = way * pace[first : last + 1]
        for start, stop in _pieces(onward, least):
            arrived = float(angle[first + stop])
            if way * (arrived - DEGREE * degree) <= SWING:
                continue
            degree = min(round(arrived / DEGREE), SIXTHS)
            amount = bending(degree) if way > 0 else stretching(degree)
            begin, end = _seen(onward[start : stop + 1])
            begin, end = first + start + begin, first + start + end
            found.append(_event(begin, end, amount, arrived, degree))
    return found


def _event(start: int, stop: int, amount: int, angle: float, degree: int) -> Event:
    off = abs(angle / DEGREE - degree)
    return Event(start, stop, -1, -1, max(1 - 2 * off, 0.0), amount=amount)


def _pieces(pace: Floats, least: int) -> list[tuple[int, int]]:
    """Part a swing where it rests or gives way: what moves, and what may go on slowly between."""
    last = len(pace) - 1
    rests = [(a, min(b, last)) for a, b in runs(pace < IDLES) if b - a >= least]
    edges = [0, *(edge for rest in rests for edge in rest), last]
    return [(a, b) for a, b in pairwise(edges) if b > a]


def _seen(pace: Floats) -> tuple[int, int]:
    """Return from which frame to which a bend is seen."""
    fastest = pace.max()
    fast = np.flatnonzero(pace >= min(fastest / 4, fastest))
    slow = np.flatnonzero(pace <= IDLES)
    before, behind = slow[slow < fast[0]], slow[slow > fast[-1]]
    first = int(before[-1]) if len(before) else 0
    return first, int(behind[0]) if len(behind) else len(pace) - 1
