"""Staves of a page, found by their lines, cut out, and made straight.

A page is made flat first: its lines become upright and level. Then its staves are of one kind:
equally wide, equally far apart, on one base, and with beats of one height.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.draw.picture import C
from lanindex.draw.staff import BEAT, DOUBLE, MARGIN, START
from lanindex.errors import CaptureError, extra

with extra("reader", error_type=CaptureError):
    import cv2

LONGEST = 30_000
"""Pixels of a page's longer side that are looked at; OpenCV maps 32,767 at most."""

_MOST = 4_000_000  # pixels of a page that are looked at; a larger one is made smaller
_LEAST = 60  # pixels of a staff's height, at least
_TURNED = 0.2  # slope of lines, at most: a page turned by 6 degrees and seen from the side
_COARSE = 500  # pixels of a page's longer side where its lines' slopes are looked for first
_NARROW = 150  # pixels of its shorter side there, at least
_COVERED = 0.85  # share of a line that shows ink, at least

Image = NDArray[np.uint8]
Ink = NDArray[Any]  # of floats: 0 paper, 1 ink; also what OpenCV makes of it
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Staff:
    """A staff cut out of a page and made straight: time runs up, its lines are vertical."""

    image: Image  # (h, w) grey, evenly lit: 255 paper, 0 ink; as far as the staves beside it
    centre: float  # x of the centre line, pixels of `image`
    inner: float  # From the centre to the outer lines, pixels
    stroke: float  # Thickness of the staff's lines, pixels
    base: float  # y where time begins: the upper of a lower double line, or the lowest line
    top: float  # y where time ends on this staff
    foot: float  # y of the lower end of its lines: below `base` if it has a starting position
    bars: tuple[float, ...]  # y of bar lines between, rising in time
    ticks: tuple[float, ...]  # y of ticks of beats on the centre line, rising in time
    first: bool  # Whether it has a lower double line: a score begins here
    last: bool  # Whether it ends in a double line
    to_page: NDArray[np.float32]  # (h, w, 2) where pixels of `image` lie on the page, x and y

    def on_page(self, x: float, y: float) -> tuple[float, float]:
        """Return where a point of the image lies on the page."""
        height, width = self.image.shape
        column, row = min(max(int(x), 0), width - 2), min(max(int(y), 0), height - 2)
        right, down = x - column, y - row
        near = self.to_page[row : row + 2, column : column + 2].astype(float)
        across = near[:, 0] * (1 - right) + near[:, 1] * right
        place = across[0] * (1 - down) + across[1] * down
        return float(place[0]), float(place[1])


@dataclass(frozen=True, slots=True)
class _Trio:
    """The lines of a staff on a flat page."""

    centre: float
    inner: float
    roof: float  # Row of their upper end
    foot: float  # Row of their lower end
    cover: float  # Share of them that shows ink


def staves(page: Image) -> list[Staff]:
    """Return the staves of a page, from left to right.

    Parameters
    ----------
    page : NDArray
        A grey image (H, W): 255 is paper. It may be turned by up to 6 degrees, seen from the
        side, and unevenly lit.

    Returns
    -------
    list of Staff
        Each cut out and made straight.

    Raises
    ------
    CaptureError
        If there is no staff of Labanotation.
    """
    shrink = min((_MOST / max(page.size, 1)) ** 0.5, LONGEST / max(*page.shape, 1), 1.0)
    if shrink < 1:
        small = cv2.resize(page, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
        page = np.asarray(small, np.uint8)
    even = evenly_lit(page)
    if min(even.shape) >= _LEAST:
        grid = _flat((255 - even).astype(np.float32) / 255)
        for again in (True, False):
            flat = _remapped(even, grid)
            ink = (255 - flat).astype(np.float32) / 255
            trios = _trios(ink)
            if not trios:
                break
            to_page = (grid + np.float32(0.5)) / np.float32(shrink) - np.float32(0.5)
            found, rows = _measured(np.asarray(flat, np.uint8), ink, trios, to_page)
            if not found:
                break
            if not again or np.abs(rows - np.arange(len(rows))).max() < 0.4:
                return found
            places = _grid(*flat.shape)
            places[..., 1] = rows[:, None]
            grid = _through(grid, places)
    wanted = "three vertical lines at equal distances, joined by a line at either end"
    remedy = "Give it an upright page of Labanotation, not turned by more than 6 degrees."
    raise CaptureError("no staff of Labanotation", wanted=wanted, remedy=remedy)


def evenly_lit(page: Image) -> Image:
    """Return a page with its paper white and its ink black, however it is lit."""
    height, width = page.shape
    step = max(max(height, width) // 400, 1)
    small = cv2.resize(page, (max(width // step, 1), max(height // step, 1)), interpolation=3)
    small = cv2.medianBlur(small, 3)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (25, 25))
    paper = cv2.morphologyEx(small, cv2.MORPH_CLOSE, kernel)
    paper = cv2.GaussianBlur(paper, (0, 0), 8)
    paper = cv2.resize(paper, (width, height), interpolation=cv2.INTER_LINEAR)
    light = page.astype(np.float32) / np.maximum(paper, 1).astype(np.float32)
    marks = light[light < 0.75]
    black = float(np.percentile(marks, 5)) if len(marks) > 50 else 0.0
    return np.asarray(((light - black) / (1 - black) * 255).clip(0, 255), np.uint8)


def _remapped(image: Ink, grid: NDArray[np.float32]) -> Ink:
    """Return an image whose pixels lie at places (h, w, 2) of another: paper beyond its edges."""
    paper = 255 if image.dtype == np.uint8 else 0
    x, y = np.ascontiguousarray(grid[..., 0]), np.ascontiguousarray(grid[..., 1])
    return np.asarray(cv2.remap(image, x, y, cv2.INTER_CUBIC, borderValue=paper))


def _thin(ink: Ink) -> Ink:
    """Return of ink (H, W) what is narrow from left to right."""
    kernel = np.ones((1, 9 if max(ink.shape) > 1800 else 7), np.uint8)
    return np.asarray(ink - cv2.morphologyEx(ink, cv2.MORPH_OPEN, kernel), np.float32)


def _upright(ink: Ink) -> Ink:
    """Return ink lying on its side (W, H), so that what is level is upright."""
    return np.ascontiguousarray(ink.T)


def _flat(ink: Ink) -> NDArray[np.float32]:
    """Return where the pixels (h, w) of a flat page lie on a page (H, W): (h, w, 2)."""
    grid, seen = _grid(ink.shape[0], ink.shape[1]), ink
    for most, step in ((_TURNED, 0.005), (0.012, 0.0)):
        shrink = min(max(_COARSE / max(seen.shape), _NARROW / min(seen.shape)), 1.0) if step else 1
        upright, level = (
            _slopes(cv2.resize(it, None, fx=shrink, fy=shrink, interpolation=3), most, step)
            for it in (_thin(seen), _thin(_upright(seen)))
        )
        there, size = _squared(seen.shape[0], seen.shape[1], upright, level)
        grid = _through(grid, cv2.perspectiveTransform(_grid(*size), np.linalg.inv(there)))
        seen = _remapped(ink, grid)
        places = _grid(seen.shape[0], seen.shape[1])
        places[..., 0] += _drift(_thin(seen))[:, None]
        places[..., 1] += _drift(_thin(_upright(seen)))
        grid = _through(grid, places)
        seen = _remapped(ink, grid)
    return grid


def _grid(height: int, width: int) -> NDArray[np.float32]:
    """Return x and y of each pixel, (H, W, 2)."""
    x, y = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    return np.stack([x, y], axis=-1)


def _through(grid: NDArray[np.float32], places: Ink) -> NDArray[np.float32]:
    """Return where places (h, w, 2) of a page that lies on another by a grid are on that one."""
    x, y = (np.ascontiguousarray(places[..., at], np.float32) for at in (0, 1))
    edge = cv2.BORDER_REPLICATE
    return np.asarray(cv2.remap(grid, x, y, cv2.INTER_LINEAR, borderMode=edge), np.float32)


def _slopes(thin: Ink, most: float, step: float) -> tuple[float, float]:
    """Return the slopes of nearly upright lines at the left and at the right edge of an image.

    Those that most of the lines agree in; between the edges slopes change evenly. They are tried in
    steps, or so that lines end a pixel apart. No line leaves the image by its sides.
    """
    height, width = thin.shape
    most, step = min(most, width / height), step or 1 / height
    low = cv2.resize(thin, (width, max(height // 3, 1)), interpolation=cv2.INTER_AREA)
    slopes = np.arange(-round(most / step), round(most / step) + 1) * step
    sums = np.zeros((len(slopes), width), np.float32)
    for index, slope in enumerate((slopes * height / len(low)).tolist()):
        place = np.array([[1, slope, -slope * (len(low) - 1) / 2], [0, 1, 0]], np.float64)
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        sums[index] = cv2.warpAffine(low, place, (width, len(low)), flags=flags).sum(axis=0)
    sharp = np.maximum(sums - cv2.blur(sums, (15, 1)), 0) ** 2
    columns, share = np.arange(width), np.linspace(0, 1, width)
    ends, best = np.arange(len(slopes)), (-1.0, 0, 0)
    parallel = 1 - 0.05 * np.abs(ends[:, None] - ends) / len(ends)  # unless lines tell otherwise
    for left in ends.tolist():
        at = np.rint(left + (ends[:, None] - left) * share).astype(int)
        worth = sharp[at, columns].sum(axis=1) * parallel[left]
        right = int(worth.argmax())
        best = max(best, (float(worth[right]), left, right))
    return float(slopes[best[1]]), float(slopes[best[2]])


def _squared(
    height: int, width: int, upright: tuple[float, float], level: tuple[float, float]
) -> tuple[Floats, tuple[int, int]]:
    """Return the homography that makes lines upright and level, and height and width then.

    Their slopes are those at the left and the right edge, and at the upper and the lower one.
    """
    corners = []
    for y, down in zip((0, height - 1), level, strict=True):
        for x, right in zip((0, width - 1), upright, strict=True):
            middle = (width - 1) / 2, (height - 1) / 2
            own = (x + right * (y - middle[1] - down * middle[0])) / (1 - right * down)
            corners.append((own, y + down * (own - middle[0])))
    seen = np.array(corners)
    wide = np.linalg.norm(seen[1::2] - seen[::2], axis=1).mean()
    tall = np.linalg.norm(seen[2:] - seen[:2], axis=1).mean()
    square = np.array([(0, 0), (wide, 0), (0, tall), (wide, tall)])
    there = cv2.getPerspectiveTransform(seen.astype(np.float32), square.astype(np.float32))
    page = np.array([[(0, 0), (width - 1, 0), (0, height - 1), (width - 1, height - 1)]], float)
    ends = cv2.perspectiveTransform(page, there)[0]
    least, size = ends.min(axis=0), np.ceil(np.ptp(ends, axis=0)).astype(int) + 1
    moved = np.array([[1, 0, -least[0]], [0, 1, -least[1]], [0, 0, 1]])
    return moved @ there, (int(size[1]), int(size[0]))


_BANDS, _WAVES = 20, 5
"""Bands of a page whose lines are compared, and the degree of the curve through them."""


def _drift(thin: Ink) -> Floats:
    """Return by how much upright lines of an image (H, W) lie to the right on each row: (H,)."""
    height, width = thin.shape
    edges = np.linspace(0, height, _BANDS + 1).astype(int)
    bands = np.array([thin[a:b].sum(axis=0) for a, b in pairwise(edges)], np.float32)
    sharp = cv2.GaussianBlur(bands, (0, 0), sigmaX=1.2, sigmaY=0.01)
    bands = np.asarray(sharp - cv2.blur(sharp, (31, 1)), np.float32)
    columns, reach = np.arange(width), np.arange(-5, 5.01, 0.5)
    rows = (edges[:-1] + edges[1:] - 1) / 2
    waves = np.polynomial.chebyshev.chebvander(rows / max(height - 1, 1) * 2 - 1, _WAVES)
    every = np.polynomial.chebyshev.chebvander(np.linspace(-1, 1, height), _WAVES)
    curve: Floats = np.zeros(_WAVES + 1)
    for _ in range(4):
        shifts = waves @ curve
        moved = np.array(
            [np.interp(columns + by, columns, band) for by, band in zip(shifts, bands, strict=True)]
        )
        found, weight = np.zeros(_BANDS), np.zeros(_BANDS)
        for number, band in enumerate(bands):
            others = moved.sum(axis=0) - moved[number]
            likeness = [
                float(others @ np.interp(columns + shifts[number] + by, columns, band))
                for by in reach
            ]
            at = int(np.argmax(likeness))
            found[number] = shifts[number] + reach[at]
            size = float(np.linalg.norm(others) * np.linalg.norm(band)) or 1.0
            weight[number] = max(likeness[at] / size, 0) ** 2 * (0 < at < len(reach) - 1)
        for _ in range(3):  # those far from the curve count less
            sides = (waves.T * weight) @ waves + np.diag(0.02 * np.arange(_WAVES + 1.0) ** 2 + 1e-6)
            curve = np.asarray(np.linalg.solve(sides, (waves.T * weight) @ found), float)
            weight = weight / (1 + (waves @ curve - found) ** 2)
    curve[0] = 0
    return np.asarray(every @ curve)


def _runs(shown: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp], Floats]:
    """Return where the longest stretches of upright lines (H, W) begin and end, and their cover."""
    gain = np.where(shown, np.float32(1), np.float32(-_COVERED / (1 - _COVERED)))
    total = np.concatenate([np.zeros((1, shown.shape[1]), np.float32), gain.cumsum(axis=0)])
    high = (total - np.minimum.accumulate(total, axis=0)).argmax(axis=0)
    rows = np.arange(len(total))[:, None]
    low = np.where(rows <= high, total, np.inf).argmin(axis=0)
    inked = np.concatenate([np.zeros((1, shown.shape[1])), shown.cumsum(axis=0)])
    columns = np.arange(shown.shape[1])
    cover = (inked[high, columns] - inked[low, columns]) / np.maximum(high - low, 1)
    return low, high, cover


def _trios(ink: Ink) -> list[_Trio]:
    """Return the lines of the staves of a flat page (H, W), from left to right.

    Those equally wide, without two at one place, whose lines show most ink.
    """
    height, width = ink.shape
    sums = cv2.GaussianBlur(_thin(ink).sum(axis=0)[None], (0, 0), 0.8)[0]
    peaks = np.flatnonzero((sums >= cv2.dilate(sums[None], np.ones((1, 5)))[0]) & (sums > 0))
    peaks = peaks[np.argsort(-sums[peaks])][:60]
    wide = cv2.dilate(ink, np.ones((1, 3), np.uint8))
    usual = float(np.median(np.quantile(wide[:, peaks[:6]], 0.7, axis=0))) if len(peaks) else 1.0
    low, high, cover = _runs(wide > max(0.45 * usual, 0.12))
    long = (high - low > max(_LEAST, 0.15 * height)) & (cover > _COVERED)
    worth = cv2.dilate(sums[None], np.ones((1, 3)))[0]
    centres = [it for it in peaks.tolist() if long[it] and 8 < it < width - 9]
    if not centres:
        return []
    value = np.zeros((len(centres), width // 2 + 1), np.float32)
    for row, x in zip(value, centres, strict=True):
        slack = 0.01 * (high[x] - low[x]) + 5
        like = long & (np.abs(low - low[x]) < slack) & (np.abs(high - high[x]) < slack)
        like = cv2.dilate(like[None].astype(np.uint8), np.ones((1, 3)))[0]
        halves = np.arange(8, min(x, width - 1 - x, int((high[x] - low[x]) / 1.2)) + 1)
        both = (like[x - halves] * like[x + halves]) > 0
        row[halves] = both * (sums[x] + worth[x - halves] + worth[x + halves])
    value = cv2.dilate(value, np.ones((1, 3)))
    inked = (cv2.dilate(ink, np.ones((3, 1), np.uint8)) > 0.4 * usual).astype(np.float32)
    total = np.concatenate([np.zeros((height, 1), np.float32), inked.cumsum(axis=1)], axis=1)

    def joined(x: int, half: int) -> bool:
        first, last = x - half + 3, x + half - 2
        rows = np.flatnonzero(total[:, last] - total[:, first] > 0.85 * (last - first))
        rows = rows[(rows > low[x] - 4) & (rows < high[x] + 4)]
        return len(rows) > 1 and bool(np.ptp(rows) > half / 2)

    # signs beside each other may look like a staff, but none is as tall
    heights = np.array([high[x] - low[x] for x in centres])
    for at in np.argsort(-heights).tolist():
        if any(joined(centres[at], half) for half in np.flatnonzero(value[at]).tolist()):
            value[heights < 0.6 * heights[at]] = 0
            break
    best = (0.0, 0, list[int]())
    for half in np.flatnonzero(value.sum(axis=0)).tolist():
        if value[:, half].sum() <= best[0]:
            continue
        own, sum_ = list[int](), 0.0
        for at in np.argsort(-value[:, half]).tolist():
            x = centres[at]
            apart = all(abs(x - it) > 2 * half + 2 for it in own)
            if value[at, half] and apart and joined(x, half):
                own.append(x)
                sum_ += float(value[at, half])
        best = max(best, (sum_, half, own))
    _, half, own = best
    if not own:
        return []
    middles = {x: x + _peak(sums, x) for x in own}
    away = [
        (sums[at], abs(at + _peak(sums, at) - middles[x]))
        for x in own
        for side in (-half, half)
        for at in [x + side - 2 + int(sums[x + side - 2 : x + side + 3].argmax())]
    ]
    weight, inner = np.array(sorted(away)[-max(len(away) // 2, 2) :]).reshape(-1, 2).T
    exact = float((weight * inner).sum() / max(weight.sum(), 1e-9))
    return [
        _Trio(middles[x], exact, float(low[x]), float(high[x]), float(cover[x]))
        for x in sorted(own)
    ]


def _peak(profile: Floats, x: int) -> float:
    """Return how far from a place the top of a profile's peak is."""
    if not 0 < x < len(profile) - 1:
        return 0.0
    a, b, c = profile[x - 1 : x + 2].tolist()
    return float(np.clip(0.5 * (a - c) / min(a - 2 * b + c, -1e-9), -0.5, 0.5))


@dataclass(frozen=True, slots=True, eq=False)
class _Marks:
    """What stands across a staff, by row of a flat page (H,)."""

    trio: _Trio
    lines: Floats  # Ink of lines from one outer line to the other; 0: hidden
    rows: list[float]  # Where such lines are, downwards


def _measured(
    flat: Image, ink: Ink, trios: list[_Trio], to_page: NDArray[np.float32]
) -> tuple[list[Staff], Floats]:
    """Return the staves of a flat page (H, W), and where its rows (H,) would make counts equal."""
    height, width = flat.shape
    stroke = _thickness(ink, trios)
    marks = [_across(ink, it, stroke) for it in trios]
    if sum(len(it.rows) for it in marks) < 2:
        return [], np.zeros(0)
    inner = trios[0].inner
    feet = [it.foot - stroke / 2 for it in trios]
    level = float(np.median(feet[1:])) if len(feet) > 1 else max(marks[0].rows, default=feet[0])
    begins = feet[0] - level > 0.35 * inner
    base, unit = level, 0.0
    if begins:
        middle = _middle(marks[0].lines, level, 0.12 * inner)
        unit = (feet[0] + stroke / 2 - middle) / (MARGIN + START - DOUBLE / 2)
        base = middle - unit * DOUBLE / 2
    if own := [_nearest(it.rows, level, 3.0) for it in marks[begins:]]:
        base = float(np.median(own))
    roof = float(np.median([_nearest(it.rows, it.trio.roof + stroke / 2, 3.0) for it in marks]))
    above = [it for it in marks[-1].rows if it < base - inner / 2]
    tops = [roof] * (len(marks) - 1) + [above[0] if above else roof]
    singles = [(it.lines, top) for it, top in zip(marks[:-1], tops, strict=False)]
    singles += [(it.lines, base) for it in marks[begins:]]
    reach, end = 0.12 * inner + 1, marks[-1].lines
    single = float(np.median([_ink(*it, reach) for it in singles])) if singles else 0.0
    last = _ink(end, tops[-1], reach) > 1.4 * (single or stroke)
    if last:
        double = unit * DOUBLE if unit else 0.06 * inner
        tops[-1] = _middle(end, tops[-1], reach) - double / 2
    tick = unit * C / 4 if unit else 0.05 * inner
    ticked = [_ticked(ink, it.trio, stroke, tick) for it in marks]
    beat, bent, first_count = _beat(marks, base, tops, ticked, unit * BEAT)
    zero = base + beat - first_count
    bars = _bars(marks, zero, tops, beat)
    # columns may lie nearer to the next staff than to their own
    begins_at = [0.0, *(it.trio.centre + inner for it in marks[:-1])]
    ends_at = [*(it.trio.centre - inner for it in marks[1:]), float(width)]
    found = list[Staff]()
    for number, (trio, top) in enumerate(zip(trios, tops, strict=True)):
        first = begins and number == 0
        foot = trio.foot if first else base
        y, x = max(round(trio.roof - inner / 2), 0), round(begins_at[number])
        rows = slice(y, min(round(foot + 2.3 * inner), height))
        columns = slice(x, round(ends_at[number]))
        counts = range(1, _counts(zero - top, beat)) if beat else range(0)
        heights = [zero - beat * count - y for count in counts]
        barred = [count in bars[number] for count in counts]
        found.append(
            Staff(
                image=np.ascontiguousarray(flat[rows, columns]),
                centre=trio.centre - x,
                inner=trio.inner,
                stroke=stroke,
                base=base - y,
                top=top - y,
                foot=foot - y,
                bars=tuple(at for at, bar in zip(heights, barred, strict=True) if bar),
                ticks=tuple(at for at, bar in zip(heights, barred, strict=True) if not bar),
                first=first,
                last=last and number + 1 == len(marks),
                to_page=to_page[rows, columns],
            )
        )
    every = np.arange(height, dtype=float)
    up = (base - every) / (beat or 1)
    most = int((base - min(tops) + 1) / (beat or 1))
    inside = up.clip(0, most)
    shift = inside * (inside - most) + (up - inside) * np.where(up < 0, -most, most)
    return found, every - bent * shift


def _nearest(rows: list[float], y: float, reach: float) -> float:
    """Return which of some rows is the nearest to one; itself, if none is near."""
    return min((it for it in rows if abs(it - y) < reach), key=lambda it: abs(it - y), default=y)


def _thickness(ink: Ink, trios: list[_Trio]) -> float:
    """Return how thick upright lines are: all ink of their rows without others."""
    reach, found = 5, list[Floats]()
    for it in trios:
        for x in (it.centre - it.inner, it.centre, it.centre + it.inner):
            rows = slice(round(it.roof) + 3, round(it.foot) - 3)
            part = ink[rows, max(round(x) - reach, 0) : round(x) + reach + 1]
            found.append(part.sum(axis=1)[part[:, [0, -1]].max(axis=1) < 0.15])
    sums = np.concatenate(found)
    return float(np.median(sums)) if len(sums) else 1.5


def _across(ink: Ink, trio: _Trio, stroke: float) -> _Marks:
    """Return what stands across a staff of a flat page (H, W)."""
    edge = stroke / 2 + 1.5
    left, right = trio.centre - trio.inner + edge, trio.centre + trio.inner - edge
    columns = np.rint(np.linspace(left, right, min(round(right - left), 80))).astype(int)
    columns = columns.clip(0, ink.shape[1] - 1)  # a staff may touch the page's edge
    columns = columns[np.abs(columns - trio.centre) > max(0.1 * trio.inner, 4)]
    lines, seen = _level(
        ink[:, columns], max(round(0.12 * trio.inner + 2 * stroke + 1), 5), stroke, 0.3
    )
    lines[seen < 0.12] = 0
    near = lines[max(round(trio.roof) - 6, 0) : round(trio.foot) + 6]
    rows = [y + max(round(trio.roof) - 6, 0) for y in _peaks(near, 0.5)]
    return _Marks(trio, lines, rows)


def _ticked(ink: Ink, trio: _Trio, stroke: float, tick: float) -> tuple[Floats, Floats]:
    """Return the ink of short lines on both sides of a centre line, by row (H,) of a flat page.

    And on how many sides it is not hidden.
    """
    short, room = np.zeros((2, len(ink)))
    near, reach = stroke / 2 + 1, max(tick - 0.5, stroke / 2 + 2)
    for side in (-1, 1):
        ends = sorted(round(trio.centre + side * it) for it in (near, reach))
        part, free = _level(ink[:, ends[0] : ends[1] + 1], max(round(tick), 3), stroke, 0.5)
        short += part * (free > 0.6)
        room += free > 0.6
    return short, room


def _level(part: Ink, gap: int, stroke: float, share: float) -> tuple[Floats, Floats]:
    """Return by how much of a line's ink each row (H,) of ink is darker than those around.

    Of the columns (H, W) that are paper above and below, and the share of these.
    """
    rows = 2 * round(stroke / 2 + 0.6) + 1  # that a blurred line takes
    thick = cv2.blur(part, (1, rows), borderType=cv2.BORDER_REPLICATE) * rows
    padded = np.pad(part, ((gap, gap), (0, 0)), mode="edge")
    above, below = padded[: len(part)], padded[2 * gap :]
    hidden = np.maximum(above, below) > 0.35
    ordered = np.sort(np.where(hidden, 9.0, thick - rows / 2 * (above + below)), axis=1)
    count = part.shape[1] - hidden.sum(axis=1)
    level = ordered[np.arange(len(part)), (share * count).astype(int).clip(0, part.shape[1] - 1)]
    return np.where(count > 0, np.maximum(level, 0), 0) / stroke, count / part.shape[1]


def _peaks(profile: Floats, least: float) -> list[float]:
    """Return where a profile (H,) has peaks, between its rows."""
    middle = profile[1:-1]
    tops = (middle > least) & (middle >= profile[:-2]) & (middle > profile[2:])
    return [y + _peak(profile, y) for y in (np.flatnonzero(tops) + 1).tolist()]


def _ink(profile: Floats, y: float, reach: float) -> float:
    """Return the sum of a profile (H,) near a row."""
    return float(profile[max(round(y - reach), 0) : round(y + reach) + 1].sum())


def _middle(profile: Floats, y: float, reach: float) -> float:
    """Return the middle of what a profile (H,) has near a row."""
    rows = np.arange(max(round(y - reach), 0), min(round(y + reach) + 1, len(profile)))
    weight = np.maximum(profile[rows] - 0.2 * profile[rows].max(), 0)
    return float(rows @ weight / max(weight.sum(), 1e-9))


def _counts(height: float, beat: float) -> int:
    """Return how many counts begin in a height: one that ends close to its end does not."""
    return int(np.ceil(height / beat - min(5 / beat, 0.25)))


_WANTED = 1.5  # as much as two lines say for a count of the usual height
_MARKED = 0.3  # ink of a short line on a count, of that of a whole one, at least


def _beat(
    marks: list[_Marks],
    base: float,
    tops: list[float],
    ticked: list[tuple[Floats, Floats]],
    wanted: float,
) -> tuple[float, float, float]:
    """Return the height of a count: that on whose multiples lines stand; 0 if there are none.

    On a short page that may be several: then it is the one that is `wanted`, if that is known. And
    by how much each is higher than the one below: a page that does not lie flat. And how high above
    the base the first count is.
    """
    tall = base - min(tops)
    size = int(tall) + 4
    seen, told = np.zeros((2, size))
    for it, top, (short, room) in zip(marks, tops, ticked, strict=True):
        heights = np.arange(min(int(base - top) + 3, size))
        rows = base - heights
        at = np.arange(len(it.lines))
        short, room, lines = (np.interp(rows, at, row) for row in (short, room, it.lines))
        told[heights] += np.maximum(np.minimum(short, room), 2.0 * (lines > 0.5))
        seen[heights] += np.maximum(room, 2.0 * (lines > 0.5))
    level = np.minimum(told / np.maximum(seen, 0.5), 1)
    wide = cv2.dilate(level[:, None], np.ones((3, 1)))[:, 0]
    weight = np.minimum(cv2.dilate(seen[:, None], np.ones((3, 1)))[:, 0], 2)
    least = max(8.0, 0.12 * marks[0].trio.inner)

    def worth(first: float, step: float) -> float:
        at = np.rint(np.arange(first, tall + 1, step)).astype(int)
        usual = max(float(np.sort(wide[at])[int(0.6 * len(at))]), _MARKED)
        value = float((weight[at] * (np.minimum(wide[at] / usual, 1) - 0.6)).sum())
        return value + _WANTED * (abs(step / wanted - 1) < 0.04 if wanted else 0)

    # edges of signs beside each other look like short lines: twice as many as counts
    most = min(tall + 1, 1.6 * wanted) if wanted else tall + 1
    least = max(least, 0.6 * wanted)
    steps = np.exp(np.arange(np.log(least), np.log(most), 0.6 / tall)).tolist()
    value, beat = max([(0.0, 0.0), *((worth(it, it), it) for it in steps)])
    if wanted and len(marks) == 1:  # it may begin between two counts
        near = [it for it in steps if abs(it / wanted - 1) < 0.04]
        between = [(at, it) for it in near for at in np.arange(4, it - 4, 2).tolist()]
        surer, first, step = max(((worth(*it), *it) for it in between), default=(0.0, 0.0, 0.0))
        if surer > value + _WANTED:
            return step, 0.0, first
    bent = 0.0
    for _ in range(3 if beat else 0):
        every = np.arange(1, int((tall + 1) / beat) + 1)
        guess = every * beat + bent * every * (every - every[-1])
        sure = wide[np.rint(guess).astype(int).clip(0, size - 1)]
        seen_at = np.array([_middle(level, it, 2.5) for it in guess.tolist()])
        sure = np.where(sure > _MARKED, sure, 0)
        terms = np.stack([every, every * (every - every[-1])], axis=1).astype(float)
        sides = (terms.T * sure) @ terms + np.diag([1e-6, 1.0])
        beat, bent = np.linalg.solve(sides, (terms.T * sure) @ seen_at).tolist()
    return beat, bent, beat


def _bars(marks: list[_Marks], base: float, tops: list[float], beat: float) -> list[set[int]]:
    """Return the counts of each staff on which a bar begins: every so many."""
    found, before = list[tuple[int, int, int, float]](), 0
    for number, (it, top) in enumerate(zip(marks, tops, strict=True)):
        for count in range(1, _counts(base - top, beat) if beat else 0):
            y = round(base - count * beat)
            level = min(float(it.lines[y - 1 : y + 2].max()), 1.0)
            found.append((number, count, before + count, level))
        before += round((base - top) / beat) if beat else 0
    best = (0.0, 0, 0)
    if found:
        every, levels = np.array([it[2] for it in found]), np.array([it[3] for it in found])
        least = 0.5 if (levels > 0.7).any() else 0.05
        for bar in range(1, 17):
            for first in range(bar):
                value = float((levels - least)[every % bar == first].sum())
                best = max(best, (value, -bar, -first))
    _, bar, first = best
    own: list[set[int]] = [set() for _ in marks]
    for number, count, at, _ in found:
        if bar and at % -bar == -first:
            own[number].add(count)
    return own


def runs(inked: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return stretches of rows (H,) that are inked, half-open."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], inked.astype(np.int8), [0]])))
    return [(a, b) for a, b in edges.reshape(-1, 2).tolist()]
