"""Where signs stand on a page: boxes of its pixels."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING

from lanindex.reader.staff import Image

if TYPE_CHECKING:
    from lanindex.reader.layout import Layout
    from lanindex.reader.signs import Sign
    from lanindex.reader.staff import Staff

Box = tuple[int, int, int, int]
"""Left, top, right and bottom."""

_ROUND = 1.5  # widths of a symbol that are shown round a sign


def box_of(staves: Sequence[Staff], page: Layout, sign: Sign) -> Box:
    """Return the box of a sign on its page; of one on two staves, what stands on the first."""
    x, half = sign.column.x, sign.column.half
    return box_at(staves, page, (x - half, x + half), (sign.start, sign.end))


def box_at(
    staves: Sequence[Staff], page: Layout, xs: tuple[float, float], counts: tuple[float, float]
) -> Box:
    """Return the box of a place: widths of a symbol from the centre line, and counts."""
    number = min(max(bisect_right(page.counts, counts[0]) - 1, 0), len(staves) - 1)
    staff, (low, high) = staves[number], page.counts[number : number + 2]
    rows = (staff.base - staff.top) / (high - low)
    unit = page.unit * staff.inner
    ys = [staff.base - (count - low) * rows for count in (counts[0], min(counts[1], high))]
    corners = [staff.on_page(staff.centre + x * unit, y) for x, y in product(xs, ys)]
    across, down = zip(*corners, strict=True)
    return round(min(across)), round(min(down)), round(max(across)), round(max(down))


def around(image: Image, box: Box) -> Box:
    """Return a box with a little around it, of what an image (H, W) shows there."""
    left, top, right, bottom = box
    edge, (height, width) = round(_ROUND * (right - left)), image.shape
    across = max(left - edge, 0), min(right + edge, width)
    down = max(top - edge, 0), min(bottom + edge, height)
    return across[0], down[0], across[1], down[1]
