"""The steps of both feet as one track."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lanindex.model.score import Track
from lanindex.model.span import Span

FEET = ("r_support", "l_support")
"""The tracks that steps are made of."""

STEP = "step"
"""What the track of both is called."""


def steps(feet: Sequence[Track]) -> Track:
    """Return the track of all steps, whichever foot takes them.

    Parameters
    ----------
    feet : sequence of Track
        Of one foot or of two.

    Returns
    -------
    Track
        In order of time, known where either foot is. Each known stretch has one starting
        position, of those that its feet have there the first.

    Examples
    --------
    >>> import lanindex
    >>> score = lanindex.read_lnd('''
    ... #unit1
    ... support r_support forward mid 0 1
    ... support l_support forward low 1 2
    ... ''')
    >>> for symbol in score.symbols("step"):
    ...     print(symbol)
    step forward mid [0, 8)
    step forward low [8, 16)
    """
    known = _together([span for foot in feet for span in foot.known])
    if len({foot.known for foot in feet}) == 1:
        known = feet[0].known
    rows = np.concatenate([foot.symbols for foot in feet], dtype=feet[0].symbols.dtype)
    rows = rows[np.lexsort((rows["stop"], rows["start"]))]
    starting = rows["start"] == rows["stop"]
    begins = starting & np.isin(rows["start"], [span.start for span in known])
    begins[1:] &= (rows["start"][1:] != rows["start"][:-1]) | ~begins[:-1]
    return Track(STEP, rows[begins | ~starting], known)


def _together(spans: list[Span]) -> tuple[Span, ...]:
    """Return stretches that touch or share frames as one."""
    found: list[Span] = []
    for span in sorted(spans, key=lambda it: it.start):
        if found and span.start <= found[-1].stop:
            found[-1] = Span(found[-1].start, max(found[-1].stop, span.stop))
        else:
            found.append(span)
    return tuple(found)
