"""How arms and legs bend, stretch by stretch.

Source: ``encoding/BODY.md``, "Bends".
"""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from lanindex.alphabet import BENDS, PARTS, SIXTHS
from lanindex.encoding.arithmetic import bend, slopes, smooth, window
from lanindex.encoding.curves import Event, Floats, lulls, seen, swings, table, turning_points
from lanindex.encoding.joints import Body
from lanindex.encoding.places import Stretch, together
from lanindex.encoding.profile import Profile
from lanindex.encoding.twists import Told
from lanindex.model.derived import DEGREE, bending, stretching

SWING = 20.0
"""Degrees of angle: a smaller swing of the joint is no bend, nor is one that ends no farther than
this from the middle of the degree that the joint had before."""

CALM = 0.15
"""Seconds that an angle is averaged over where its pace is looked at."""

IDLES = 20.0
"""Degrees of angle a second: slower, for as long as `LULL`, parts two bends."""

LULL = 0.25
"""Seconds that a joint is slow for where it rests."""

_CHAINS = {part: PARTS[limb].chain for limb, part in BENDS.items()}


def bends_of(body: Body) -> Iterator[Told]:
    """Yield how each arm and leg bends, stretch by stretch."""
    for stretch, parts in together(body, _CHAINS):
        found = bends(_angles(stretch, parts), body.profile, body.fast)
        for part, those in zip(parts, found, strict=True):
            yield part, stretch.known, stretch.frames.start, those


def _angles(stretch: Stretch, parts: Sequence[str]) -> Floats:
    """Return by how many degrees lower bones are turned from upper ones, (P, N)."""
    angles = np.empty((len(parts), len(stretch.frames)))
    chains = list(zip(*(_CHAINS[part] for part in parts), strict=True))
    for block, places in stretch.blocks():
        upper, middle, lower = (
            np.array([places[joint].T for joint in joints]).swapaxes(0, 1) for joints in chains
        )
        angles[:, block.inner] = bend(middle - upper, lower - middle)
    return angles


def bends(angles: Floats, profile: Profile, fast: bool = False) -> list[Floats]:
    """Return the first degree and the bends of angles (P, N), degrees, as from `table`."""
    rate, width, least = float(profile.rate), window(CALM, profile.rate), round(LULL * profile.rate)
    first = smooth(angles[:, : width // 2 + 1], width)[:, 0].tolist()
    degrees = [min(round(angle / DEGREE), SIXTHS) for angle in first]
    if fast:
        from lanindex.encoding import curves_fast

        parts = [
            curves_fast.bend_frames(angle, degree, width, rate, least)
            for angle, degree in zip(angles, degrees, strict=True)
        ]
    else:
        calm = smooth(angles, width)
        each = zip(angles, calm, slopes(calm) * rate, degrees, strict=True)
        parts = [bend_parts(*it, rate, least) for it in each]
    return [table(_bends(*it)) for it in zip(angles, first, degrees, parts, strict=True)]


def _bends(
    angle: Floats, first: float, degree: int, parts: Iterable[tuple[int, int, int, int, int]]
) -> list[Event]:
    """Return the degree at the beginning, and the bends: see `bend_parts`."""
    bends = [_bend(0, 0, bending(degree), first, degree)]
    for way, arrived, last, start, stop in parts:
        amount = bending(arrived) if way > 0 else stretching(arrived)
        bends.append(_bend(start, stop, amount, float(angle[last]), arrived))
    return bends


def _bend(start: int, stop: int, amount: int, angle: float, degree: int) -> Event:
    off = abs(angle / DEGREE - degree)
    return Event(start, stop, -1, -1, max(1 - 2 * off, 0.0), amount=amount)


def bend_parts(
    angle: Floats, calm: Floats, pace: Floats, degree: int, rate: float, least: int
) -> list[tuple[int, int, int, int, int]]:
    """Return pieces of swings, cut at rests, that bend or stretch farther than `degree`.

    Direction (1, -1), the degree that is new then, last frame, visible begin and end. A moving
    piece may begin in the rest before it, and end in the rest behind it.
    """
    found, fast = [], np.abs(pace)
    for first, last in swings(calm, turning_points(calm), SWING):
        if abs(calm[last] - calm[first]) < SWING:
            continue
        way = 1 if calm[last] > calm[first] else -1
        edges = [first, first]
        for start, stop in lulls(way * pace[first : last + 1], IDLES, least):
            edges.append(first + start)
            edges.append(min(first + stop, last))
        edges.append(last)
        edges.append(last)
        for number in range(len(edges) - 3):
            low, start, stop, high = edges[number : number + 4]
            if start < stop and way * (angle[stop] - DEGREE * degree) > SWING:
                degree = min(round(angle[stop] / DEGREE), SIXTHS)
                within = (start, stop) if number % 2 else (low, high)
                begin, end = seen(angle, fast, (start, stop), within, IDLES / rate)
                found.append((way, degree, stop, begin, end))
    return found
