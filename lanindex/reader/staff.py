"""Staves of a page, found by their lines, cut out, and made straight."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, pairwise
from math import ceil, radians, tan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.draw.staff import FIVE
from lanindex.errors import CaptureError, extra

with extra("reader", error_type=CaptureError):
    import cv2

_TURNED = 7.0  # degrees by which a page may be turned, at most
_SIDE = 1800  # pixels of a page's longer side, at most, where lines are looked for
_LEAST = 60  # pixels of a staff's height, at least
_COVERED = 0.9  # share of a line that shows ink, at least
_DOUBLE = 0.115  # from one line of a double line to the other, by the staff's half width, at most

Image = NDArray[np.uint8]
Ink = NDArray[Any]  # of floats: 0 paper, 1 ink; also what OpenCV makes of it
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Staff:
    """A staff cut out of a page and made straight: time runs up, its lines are vertical."""

    image: Image  # (h, w) grey, evenly lit: 255 paper, 0 ink; half way to the next staff
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


@dataclass(frozen=True, slots=True, eq=False)
class _Line:
    """A long line of a page, nearly vertical."""

    xs: Floats  # (H,) where it is on each row of the page, also beyond its ends
    low: int  # Rows of its upper end and its lower end
    high: int
    cover: float  # Share of rows between that show ink


_Lines = tuple[_Line, _Line, _Line]


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """A staff on a page, and where its marks are when it is made straight, as of `Staff`."""

    lines: _Lines
    inner: float
    lean: Floats  # (2,) slope of lines across by height, from 0 to 1, as `polyval` takes it
    stroke: float
    base: float
    top: float
    foot: float
    bars: tuple[float, ...]
    ticks: tuple[float, ...]
    first: bool
    last: bool


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
    even = evenly_lit(page)
    ink = (255 - even).astype(np.float32) / 255
    found = [_straight(ink, lines) for lines in _trios(_long_lines(ink))]
    chosen = list[_Found]()
    for it in sorted(filter(None, found), key=lambda it: it.lines[1].low - it.lines[1].high):
        if chosen and not 0.8 < it.inner / chosen[0].inner < 1.25:  # staves of a page are alike
            continue
        row = (it.lines[1].low + it.lines[1].high) // 2
        apart = [abs(it.lines[1].xs[row] - other.lines[1].xs[row]) for other in chosen]
        if all(x > 0.9 * (it.inner + other.inner) for x, other in zip(apart, chosen, strict=True)):
            chosen.append(it)
    if not chosen:
        wanted = "three vertical lines at equal distances, joined by a line at either end"
        remedy = "Give it an upright page of Labanotation, not turned by more than 6 degrees."
        raise CaptureError("no staff of Labanotation", wanted=wanted, remedy=remedy)
    chosen.sort(key=lambda it: float(it.lines[1].xs[len(page) // 2]))
    places = [0.0, *(float(it.lines[1].xs[len(page) // 2]) for it in chosen), float(page.shape[1])]
    cut = list[Staff]()
    for number, it in enumerate(chosen, 1):
        before, behind = (abs(places[number] - places[number + side]) for side in (-1, 1))
        before /= 2 if number > 1 else 1
        behind /= 2 if number < len(chosen) else 1
        cut.append(_cut(even, it, before, behind))
    return cut


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


def _thin(ink: Ink, wide: int) -> Ink:
    """Return of ink (H, W) what is narrower than a width, from left to right."""
    kernel = np.ones((1, wide), np.uint8)
    return np.asarray(ink - cv2.morphologyEx(ink, cv2.MORPH_OPEN, kernel), np.float32)


def _long_lines(ink: Ink) -> list[_Line]:
    """Return the lines of a page (H, W) that are long and nearly vertical."""
    height, width = ink.shape
    thin = cv2.GaussianBlur(_thin(ink, 7 if max(height, width) < 2500 else 11), (0, 0), 0.8)
    shrink = max(max(height, width) / _SIDE, 1.0)
    size = max(round(width / shrink), 1), max(round(height / shrink / 4), 1)
    small = cv2.resize(thin, size, interpolation=cv2.INTER_AREA)
    coarse, _ = _slopes(small, np.arange(-_TURNED, _TURNED + 0.01, 0.5), 4)
    mid = float((coarse**2).sum(axis=1).argmax() * 0.5 - _TURNED)
    sums, degrees = _slopes(small, mid + np.arange(-2.5, 2.51, 0.125), 4)
    best = sums.max(axis=0)
    peaks = np.flatnonzero((best >= cv2.dilate(best[None], np.ones((1, 5)))[0]) & (best > 0))
    peaks = peaks[np.argsort(-best[peaks])][:150]
    lines = []
    for x in peaks.tolist():
        slope = tan(radians(float(degrees[sums[:, x].argmax()])))
        rows = np.arange(height)
        xs = (x + 0.5) * shrink - 0.5 + slope * (rows - height / 2)
        if (line := _traced(ink, thin, xs)) is not None:
            lines.append(line)
    return lines


def _slopes(thin: Ink, degrees: Floats, tall: int) -> tuple[Floats, Floats]:
    """Return sums (D, W) of an image (H, W) along lines through its middle row.

    Its pixels are `tall` times as high as wide.
    """
    height, width = thin.shape
    sums = np.zeros((len(degrees), width))
    for index, degree in enumerate(degrees):
        slope = tan(radians(float(degree))) * tall
        place = np.array([[1, slope, -slope * (height - 1) / 2], [0, 1, 0]], np.float64)
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        sums[index] = cv2.warpAffine(thin, place, (width, height), flags=flags).sum(axis=0)
    return sums, degrees


def _traced(ink: Ink, thin: Ink, xs: Floats) -> _Line | None:
    """Return the line near places (H,) of an image (H, W), with its ends."""
    height, width = ink.shape
    reach, rows = 6, np.arange(height)
    offsets = np.arange(-reach, reach + 1)
    for _ in range(2):
        grid = (xs[:, None] + offsets).astype(np.float32)
        lines = np.repeat(rows[:, None], len(offsets), axis=1).astype(np.float32)
        near = cv2.remap(thin, grid, lines, cv2.INTER_LINEAR)
        near = cv2.blur(near, (1, max(height // 60, 9)))
        weight = near.max(axis=1).astype(float)
        shift = offsets[near.argmax(axis=1)].astype(float)
        inside = (xs > 1) & (xs < width - 2)
        good = (
            inside & (weight > 0.4 * np.quantile(weight[inside], 0.9)) if inside.any() else inside
        )
        if good.sum() < _LEAST:
            return None
        keep = good
        for _ in range(3):
            ends = np.flatnonzero(keep)[[0, -1]]
            at = (rows - ends[0]) / (ends[1] - ends[0])
            fit = np.polynomial.Polynomial.fit(
                at[keep], shift[keep], 3 if ends[1] - ends[0] > height / 3 else 1, w=weight[keep]
            )
            error = np.abs(fit(at) - shift)
            keep = good & (error < max(1.0, 2 * float(np.median(error[keep]))))
            if keep.sum() < _LEAST:
                return None
        moved = fit(at.clip(0, 1))  # beyond its ends it goes on straight
        moved += (at - at.clip(0, 1)) * np.where(at < 0.5, fit.deriv()(0.1), fit.deriv()(0.9))
        xs = xs + moved
        offsets = np.arange(-3, 4)
    grid = (xs[:, None] + np.arange(-1, 2)).astype(np.float32)
    lines = np.repeat(rows[:, None], 3, axis=1).astype(np.float32)
    level = cv2.remap(ink, grid, lines, cv2.INTER_LINEAR).max(axis=1)
    usual = float(np.median(level[keep]))
    shown = (level > 0.45 * usual).astype(np.uint8)[:, None]
    joined = cv2.morphologyEx(shown, cv2.MORPH_CLOSE, np.ones((max(height // 150, 7), 1)))[:, 0]
    edges = np.flatnonzero(np.diff(np.concatenate([[0], joined, [0]])))
    begins, ends_ = edges[::2], edges[1::2]
    if not len(begins):
        return None
    longest = int((ends_ - begins).argmax())
    low, high = int(begins[longest]), int(ends_[longest])
    if high - low < _LEAST:
        return None
    return _Line(xs, low, high, float(shown[low:high].mean()))


def _trios(lines: list[_Line]) -> list[_Lines]:
    """Return lines that may be those of a staff: equally far apart, and equally high."""
    good = list[_Line]()
    for it in lines:  # the strongest first, and one of those that run together
        if it.cover > _COVERED and not any(_together(it, other) for other in good):
            good.append(it)
    good.sort(key=lambda it: float(it.xs[(it.low + it.high) // 2]))
    found = []
    for left, right in combinations(good, 2):
        low, high = max(left.low, right.low), min(left.high, right.high)
        if high - low < _LEAST:
            continue
        ends = [low + (high - low) // 10, high - (high - low) // 10]
        wide = right.xs[ends] - left.xs[ends]
        if wide.min() < 16 or wide.max() > 1.25 * wide.min() or wide.mean() > high - low:
            continue
        middle, slack = (left.xs[ends] + right.xs[ends]) / 2, max(2.5, 0.03 * float(wide.mean()))
        between = [it for it in good if (np.abs(it.xs[ends] - middle) < slack).all()]
        for centre in between:
            lows, highs = zip(*((it.low, it.high) for it in (left, centre, right)), strict=True)
            if min(highs) - max(lows) > 0.85 * (max(highs) - min(lows)):
                found.append((left, centre, right))
    return found


def _together(line: _Line, other: _Line) -> bool:
    """Return whether a line is another, longer one, or a piece of it."""
    rows = [line.low, (line.low + line.high) // 2, line.high - 1]
    beside = np.abs(line.xs[rows] - other.xs[rows]) < 3.5
    return bool(beside[1] or beside.sum() > 1) and other.low <= rows[1] < other.high


def _straight(ink: Ink, lines: _Lines) -> _Found | None:
    """Return the staff of three lines on a page (H, W); None if no lines join them."""
    left, centre, right = lines
    low, high = max(it.low for it in lines), min(it.high for it in lines)
    inner = float(np.median((right.xs - left.xs)[low:high] / 2))
    turned = -np.polyfit(np.arange(low, high), centre.xs[low:high], 1)[0]
    lean, near = np.array([0.0, turned]), ink
    for _ in range(4):
        grid = _grid(ink.shape, lines, inner, lean, inner * 1.15, inner * 1.15)
        near = cv2.remap(ink, grid[..., 0], grid[..., 1], cv2.INTER_LINEAR)
        change = _leaning(near, inner)
        if np.abs(change).max() < 0.002:
            break
        lean = lean + change
    return _measured(near, lines, inner, lean)


def _grid(
    shape: tuple[int, ...],
    lines: _Lines,
    inner: float,
    lean: Floats,
    before: float,
    behind: float,
) -> NDArray[np.float32]:
    """Return where the pixels (h, w) of a straight staff lie on the page, (h, w, 2)."""
    left, _, right = (it.xs for it in lines)
    low = max(0, min(it.low for it in lines) - ceil(inner / 2))
    high = min(shape[0], max(it.high for it in lines) + ceil(1.3 * inner))
    rows = np.arange(low, high).astype(float)
    half = (right - left)[low:high] / 2
    along = np.concatenate([[0], np.cumsum(inner / half)[:-1]])  # stretched as it is across
    steps = np.interp(np.arange(int(along[-1]) + 1), along, rows)
    across = np.arange(-round(before), round(behind) + 1) / inner
    span = (steps - low) / max(high - 1 - low, 1)
    leans = np.polyval(lean, span)
    everywhere = np.arange(shape[0])
    middle, wide = (left + right) / 2, (right - left) / 2
    x, y = np.zeros((2, len(steps), len(across)))
    y += steps[:, None]
    for _ in range(2):  # the lines are met at heights that depend on where they are met
        own = np.interp(y, everywhere, middle) + across * np.interp(y, everywhere, wide)
        x = own
        origin = np.interp(steps, everywhere, middle)[:, None]
        y = steps[:, None] + leans[:, None] * (x - origin)
    return np.stack([x, y], axis=-1).astype(np.float32)


def _leaning(near: Ink, inner: float) -> Floats:
    """Return by how much lines across lean in a nearly straight staff (h, w): slope by height."""
    height, width = near.shape
    thin = _thin(np.ascontiguousarray(near.T), 7 if inner < 120 else 11)  # (w, h)
    columns = np.arange(width) - width // 2
    used = np.abs(columns) < inner * 0.96
    thin[~used] = 0
    slopes, found = np.arange(-0.06, 0.0601, 0.004), list[tuple[float, float, float]]()
    sums = np.zeros((len(slopes), height))
    for index, slope in enumerate(slopes):
        place = np.array([[1, slope, -slope * (width // 2)], [0, 1, 0]], np.float64)
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        sums[index] = cv2.warpAffine(thin, place, (height, width), flags=flags).sum(axis=0)
    best = sums.max(axis=0)
    least = 0.5 * np.sort(best)[-3:].mean()
    for y in np.flatnonzero((best >= cv2.dilate(best[None], np.ones((1, 9)))[0]) & (best > least)):
        at = int(sums[:, y].argmax())
        shift = 0.0
        if 0 < at < len(slopes) - 1:
            a, b, c = sums[at - 1 : at + 2, y]
            shift = 0.5 * (a - c) / (a - 2 * b + c) if a - 2 * b + c < 0 else 0.0
        found.append((y / max(height - 1, 1), slopes[at] + 0.004 * shift, best[y]))
    if not found:
        return np.zeros(2)
    at_, lean, weight = np.array(found).T
    if len(found) < 3 or np.ptp(at_) < 0.4:
        return np.array([0.0, float(np.median(lean))])
    keep = np.ones(len(lean), bool)
    fit = np.zeros(2)
    for _ in range(3):
        fit = np.polyfit(at_[keep], lean[keep], 1, w=weight[keep])
        error = np.abs(np.polyval(fit, at_) - lean)
        keep = error <= max(0.004, 2 * float(np.median(error)))
        if keep.sum() < 3:
            return np.array([0.0, float(np.median(lean))])
    return np.asarray(fit)


def _measured(near: Ink, lines: _Lines, inner: float, lean: Floats) -> _Found | None:
    """Return the staff of lines with what stands across it, from ink made straight (h, w)."""
    height, width = near.shape
    middle, far = width // 2, round(inner)
    uprights = np.stack(
        [near[:, x - 1 : x + 2].max(axis=1) for x in (middle - far, middle, middle + far)]
    )
    columns = np.abs(np.arange(width) - middle)
    inside = near[:, (columns < inner * 0.94) & (columns > 0.04 * inner)]
    full = np.quantile(cv2.blur(inside, (5, 1)), 0.12, axis=1)
    strength = float(np.median(uprights))
    rise = _prominence(full, max(round(0.2 * inner), 5))
    peaks = _peaks(rise, 0.07 * strength)
    strong = [y for y in peaks if rise[round(y)] > 0.5 * strength]
    if len(strong) < 2:
        return None
    lowest, top = strong[-1], strong[0]
    first = len(strong) > 2 and lowest - strong[-2] < _DOUBLE * inner
    last = len(strong) > 2 and strong[1] - top < _DOUBLE * inner
    base = strong[-2] if first else lowest
    if base - top < inner:
        return None
    outer = cv2.blur(uprights[[0, 2]].min(axis=0)[:, None], (1, 5))[:, 0]
    foot = round(lowest)
    while foot + 1 < height and outer[foot + 1 : foot + 6].max() > 0.4 * strength:
        foot += 1
    below = foot - lowest > inner / 3
    least = 0.25 * inner
    dark = [y for y in strong if top + least < y < base - least]
    beats = _ticks(near, inner, strength, top, base, dark)
    bars = dark or _light(peaks, beats, rise, 0.08 * strength)
    return _Found(
        lines=lines,
        inner=inner,
        lean=lean,
        stroke=_thickness(near, (middle - far, middle + far)),
        base=base,
        top=top,
        foot=float(foot) if below else base,
        bars=tuple(bars[::-1]),
        ticks=tuple(y for y in beats[::-1] if min(map(abs, np.subtract(bars, y)), default=9) > 3),
        first=first or below,
        last=last,
    )


def _prominence(profile: Floats, reach: int) -> Floats:
    """Return by how much each of a profile (H,) stands out from what is near on both sides."""
    padded = np.pad(profile, reach, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, reach)
    lows = windows.min(axis=1)
    return np.asarray(profile - np.maximum(lows[: len(profile)], lows[-len(profile) :]))


def _peaks(profile: Floats, least: float) -> list[float]:
    """Return where a profile (H,) has peaks, between its rows."""
    found = list[float]()
    for y in range(1, len(profile) - 1):
        a, b, c = profile[y - 1 : y + 2].tolist()
        if b > least and b >= a and b > c:
            found.append(y + 0.5 * (a - c) / min(a - 2 * b + c, -1e-9))
    return found


def _thickness(near: Ink, xs: tuple[int, int]) -> float:
    """Return how thick lines of ink (h, w) at columns are: all ink of their rows without others."""
    reach, found = 5, list[Floats]()
    for x in xs:
        part = near[:, max(x - reach, 0) : x + reach + 1]
        found.append(part.sum(axis=1)[part[:, [0, -1]].max(axis=1) < 0.15])
    sums = np.concatenate(found)
    return float(np.median(sums)) if len(sums) else 1.5


def _ticks(
    near: Ink,
    inner: float,
    strength: float,
    top: float,
    base: float,
    bars: list[float],
) -> list[float]:
    """Return rows of short lines on the centre line of a straight staff's ink (h, w)."""
    middle = near.shape[1] // 2
    reach = max(round(0.05 * inner), 3)
    sides = [near[:, middle - reach : middle - 1], near[:, middle + 2 : middle + reach + 1]]
    level = np.minimum(*(it.mean(axis=1) for it in sides))
    rise = _prominence(level, max(round(0.11 * inner), 4))
    marks = sorted({*bars, *(y for y in _peaks(rise, 0.35 * strength) if top < y < base)})
    best = max((_beats(marks, *pair, top, base) for pair in pairwise(marks)), key=_fits, default=())
    taken = [top, base, *bars]
    return [y for y, _ in best if min(abs(y - it) for it in taken) > 0.15 * inner]


def _light(peaks: list[float], beats: list[float], rise: Floats, least: float) -> list[float]:
    """Return rows of light bar lines, which stand on every fifth beat, of peaks of a profile (H,).

    Edges of symbols side by side look like them, but are not where all of these are.
    """
    near = [[y for y in peaks if abs(y - beat) < 2.5] for beat in beats]
    level = [max((float(rise[round(y)]) for y in own), default=0.0) for own in near]
    first = max(range(FIVE), key=lambda it: float(np.mean(level[it::FIVE] or [0.0])))
    if float(np.mean(level[first::FIVE] or [0.0])) < least:
        return []
    return [
        own[0] if own else beat
        for own, beat in zip(near[first::FIVE], beats[first::FIVE], strict=True)
    ]


def _beats(
    marks: list[float], first: float, second: float, top: float, base: float
) -> tuple[tuple[float, bool], ...]:
    """Return rows of beats between two ends that go on from two, and whether each has a mark."""
    step = second - first
    if step < 6:
        return ()
    found = [(first, True), (second, True)]
    for at, way in ((first, -step), (second, step)):
        while top < at + way < base:
            near = min(marks, key=lambda it: abs(it - at - way))
            seen = abs(near - at - way) < max(0.06 * step, 1.5)
            way, at = (0.7 * way + 0.3 * (near - at), near) if seen else (way, at + way)
            found.append((at, seen))
    return tuple(sorted(found))


def _fits(beats: tuple[tuple[float, bool], ...]) -> int:
    """Return how many beats have marks, less those that do not."""
    return sum(1 if seen else -1 for _, seen in beats)


def _cut(even: Image, found: _Found, before: float, behind: float) -> Staff:
    """Return a staff with what stands beside it, as far as two distances from its centre."""
    grid = _grid(even.shape, found.lines, found.inner, found.lean, before, behind)
    image = cv2.remap(even, grid[..., 0], grid[..., 1], cv2.INTER_LINEAR, borderValue=255)
    return Staff(
        image=np.asarray(image, np.uint8),
        centre=float(round(before)),
        inner=found.inner,
        stroke=found.stroke,
        base=found.base,
        top=found.top,
        foot=found.foot,
        bars=found.bars,
        ticks=found.ticks,
        first=found.first,
        last=found.last,
        to_page=grid,
    )
