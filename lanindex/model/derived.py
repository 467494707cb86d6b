"""Tracks that follow from others: the steps of both feet, and how far bent limbs are."""

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import BENDS, FEET, SIXTHS
from lanindex.model.score import Track
from lanindex.model.symbol import Span, joined

SUPPORTS = ("r_support", "l_support")
"""The tracks that steps are made of."""

STEP = "step"
"""The name of the track of both."""

_NO_STEPS = [code for code, name in enumerate(FEET) if name in ("spring", "hop", "assemble")]


def with_steps(tracks: dict[str, Track]) -> dict[str, Track]:
    """Return tracks with that of the steps, where any foot has one."""
    if not (feet := [tracks[part] for part in SUPPORTS if part in tracks]):
        return tracks
    return {**tracks, STEP: steps(feet, tracks.get("jump"))}


def steps(feet: Sequence[Track], jump: Track | None = None) -> Track:
    """Return the track of all steps, whichever foot takes them."""
    known = _together([span for foot in feet for span in foot.known])
    if len({foot.known for foot in feet}) == 1:
        known = feet[0].known
    rows = joined(foot.symbols for foot in feet)
    rows = rows[rows["start"] < rows["stop"]]
    _, own, count = np.unique(rows[["start", "stop"]], return_inverse=True, return_counts=True)
    rows = rows[count[own.ravel()] == 1]  # feet that slide apart together take no step
    if jump is not None:
        without = (jump.symbols["amount"][:, None] == _NO_STEPS).any(axis=1)
        landed = np.sort(jump.symbols["stop"][without])
        before, until = (np.searchsorted(landed, rows[end], "right") for end in ("start", "stop"))
        rows = rows[before == until]
    return Track(STEP, rows[np.lexsort((rows["stop"], rows["start"]))], known)


def _together(spans: list[Span]) -> tuple[Span, ...]:
    """Return stretches that touch or share frames as one."""
    found: list[Span] = []
    for span in sorted(spans, key=lambda it: it.start):
        if found and span.start <= found[-1].stop:
            found[-1] = Span(found[-1].start, max(found[-1].stop, span.stop))
        else:
            found.append(span)
    return tuple(found)


Amount = TypeVar("Amount", int, NDArray[Any])

DEGREE = 180 / SIXTHS
"""Degrees of angle of one degree: a sixth of what would lay the lower bone upon the upper one."""

STRETCHES = SIXTHS + 1
"""The amount of stretching until straight: smaller ones are bends."""


def bending(degree: int) -> int:
    """Return the amount of bending to a degree, or of being bent by it."""
    return degree


def stretching(degree: int) -> int:
    """Return the amount of stretching to a degree."""
    return STRETCHES + degree


def degree_of(amount: Amount) -> Amount:
    """Return the degree that a bend arrives at.

    >>> from lanindex.model.derived import bending, degree_of, stretching
    >>> degree_of(bending(3)), degree_of(stretching(1))
    (3, 1)
    """
    return amount % STRETCHES


def with_bends(tracks: dict[str, Track]) -> dict[str, Track]:
    """Return tracks in which gestures of arms and legs have the degree of bend in force."""
    limbs = [limb for limb in BENDS if limb in tracks]
    return {**tracks, **{it: _bent(tracks[it], tracks.get(BENDS[it])) for it in limbs}}


def _bent(limb: Track, bend: Track | None) -> Track:
    """Return a limb's track with its degrees, each in force from the middle of its bend on."""
    rows = limb.symbols.copy()
    rows["amount"] = -1
    if bend is not None and len(bend):
        own = bend.symbols
        halves = own["start"].astype(np.int64) + own["stop"]
        last = np.searchsorted(halves, 2 * rows["stop"].astype(np.int64), "right") - 1
        seen = np.array([one.start for one in bend.known])
        ends = np.array([one.stop for one in bend.known])
        stretch = np.searchsorted(seen, rows["stop"], "right") - 1
        inside = (last >= 0) & (stretch >= 0) & (rows["stop"] <= ends[stretch])
        inside &= own["start"][last] >= seen[stretch]
        rows["amount"][inside] = degree_of(own["amount"][last[inside]])
    return Track(limb.part, rows, limb.known)


def with_derived(tracks: dict[str, Track]) -> dict[str, Track]:
    """Return tracks with those derived from others: steps and degrees of bend."""
    return with_bends(with_steps(tracks))
