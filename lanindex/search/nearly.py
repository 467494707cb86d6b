"""What it costs to lie off the middle of a cell, or across its border.

A margin tells how far a symbol is from the nearest border of its cell, 1 in the middle. Where a
search is told to be generous, the border lies so much further out that a symbol of the cell across
may match as well; how clearly something matched is then measured from there.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import THOUSANDTHS

NEAR = 250
"""How far out the border lies for ``--near``, in thousandths of a margin."""

Number = TypeVar("Number", int, NDArray[np.int64])


def own(margin: Number, near: int) -> Number:
    """Return what is missing to a fit of 1 for a symbol of a cell that is asked for.

    All are thousandths; `near` is how far out the border lies.
    """
    return THOUSANDTHS - (near + margin) * THOUSANDTHS // (near + THOUSANDTHS)


def across(margin: Number, near: int) -> Number:
    """Return the same for a symbol of the cell across the border, whose margin is below `near`."""
    return THOUSANDTHS - (near - margin) * THOUSANDTHS // (near + THOUSANDTHS)
