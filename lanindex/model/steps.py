"""The steps of both feet as one track."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lanindex.alphabet import FEET
from lanindex.model.score import Track
from lanindex.model.span import Span
from lanindex.model.symbol import joined

SUPPORTS = ("r_support", "l_support")
"""The tracks that steps are made of."""

STEP = "step"
"""What the track of both is called."""

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
    if jump is not None:
        landed = np.sort(
            jump.symbols["stop"][(jump.symbols["amount"][:, None] == _NO_STEPS).any(axis=1)]
        )
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
