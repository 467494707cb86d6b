"""Pages of printed Labanotation of which every sign is known: drawn, not read.

Seeds below 10,000 are for making a reader, those from `JUDGING` on for judging it.
"""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from reader_damage import Forward, Points, damaged
from reader_scores import GRID, random_score

import lanindex
from lanindex.alphabet import TOUCHED, amounts_of, kind_of
from lanindex.draw import svg
from lanindex.draw.picture import PIXEL, Circle, Label, MarkGroup, Picture, Polyline
from lanindex.draw.staff import (
    BEAT,
    MARGIN,
    NAMES,
    START,
    StaffColumns,
    draw,
    staff_columns,
    turns,
)
from lanindex.model import Score
from lanindex.model.derived import degree_of

CORPUS = sorted((Path(lanindex.__file__).parents[1] / "corpus").glob("*.lnd"))
JUDGING = 10_000


@dataclass(frozen=True, slots=True)
class Sign:
    """A sign on a page."""

    staff: int  # On which it begins, from the left
    part: str
    kind: str  # Of `alphabet.KINDS`, or "again" for a gesture that goes on
    direction: str | None
    level: str | None
    amount: int | None  # What is written: degrees, or the degree of a bend; None: nothing
    start: float  # Counts from the beginning of the score; two of the corpus have eighths
    end: float  # A starting position has no length


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """Where a staff lies on its page, in pixels; rows are x and y."""

    counts: tuple[float, float]  # At its base and its top
    corners: Points  # (4, 2) of its outer lines: left and right at the base, then at the top
    foot: Points  # (2,) the lower end of the centre line
    base: Points  # (2,) on the centre line, as all below
    top: Points  # (2,)
    bars: Points  # (B, 2) lines of bars between, upwards
    ticks: Points  # (T, 2)


@dataclass(frozen=True, slots=True, eq=False)
class Made:
    """A page and what it says."""

    image: NDArray[np.uint8]  # (H, W) grey
    truth: list[Sign]
    holds: list[tuple[int, str, float]]  # Circles of weight: staff, what stands, count
    staves: list[Place]
    beats: int  # In a bar; where seconds are counted, 5
    seconds: bool  # Whether it counts seconds
    score: Score
    columns: StaffColumns
    drawn: list[tuple[int, int]]  # Centre and base of each staff, units of the picture
    beat: int  # Height of a count, units
    forward: Forward  # From units of the picture to pixels

    def boxes(self, part: str, start: float, end: float) -> list[Points]:
        """Return the corners (4, 2) on the page of a sign, a piece for each staff."""
        found, at = list[Points](), self.columns.places.get(part.replace("stance", "support"), 0)
        for number, ((x, base), place) in enumerate(zip(self.drawn, self.staves, strict=True)):
            low, high = (min(max(it, place.counts[0]), place.counts[1]) for it in (start, end))
            ys = base - np.array([low, high]) * self.beat + place.counts[0] * self.beat
            if start == end and place.counts[0] == start and number == 0:
                ys = np.array([base + MARGIN // 2 + START, base + MARGIN // 2])
            if ys[0] > ys[1]:
                left, right = x + at - 70, x + at + 70
                corners = [(left, ys[0]), (right, ys[0]), (right, ys[1]), (left, ys[1])]
                found.append(self.forward(np.array(corners)))
        return found


@lru_cache(maxsize=16)
def _corpus(path: Path) -> Score:
    return lanindex.read_lnd(str(path))


def made(seed: int, damage: str = "clean") -> Made:
    """Return a page; every fourth is of the corpus, the others are random."""
    rng = np.random.default_rng(seed)
    seconds = bool(rng.random() < 0.25)
    if seed % 4 == 3:
        score = _corpus(CORPUS[seed // 4 % len(CORPUS)])
        seconds &= score.meter.speed == 60  # else its symbols begin anywhere
    else:
        score = random_score(rng, seconds)
    beats = 5 if seconds else score.meter.beats
    bars = int(rng.integers(2, max(17 // beats, 3)))
    beat = round(BEAT * float(rng.choice([1, 1, 1, 0.75])))
    tempo = f"{beats}/{score.meter.beat}, {float(score.meter.speed):g} beats a minute"
    lines = (f"page {seed}", f"{'a tick a second' if seconds else tempo}; full score")
    heading = lines if rng.random() < 0.8 else ()
    picture = draw(score, heading=heading, bars=bars, seconds=seconds, beat=beat)
    scale = rng.uniform(1.5, 2.5)
    text = svg.write(picture, scale=scale, ink=svg.INK)
    for usual in (7, 10):  # symbols and staves
        thick = round(usual * rng.uniform(0.8, 1.3), 1)
        text = text.replace(f'stroke-width="{usual}"', f'stroke-width="{thick:g}" ')
    image, moved = damaged(_grey(svg.image(text)), damage, rng)

    def forward(points: Points) -> Points:
        return moved(np.asarray(points, float).reshape(-1, 2) / PIXEL * scale - 0.5)

    drawn, staves = _staves(picture, beat, forward)
    truth = signs(picture, score, seconds=seconds, beat=beat)
    columns = staff_columns({it.data["part"] for it in picture.groups()})
    holds = _holds(picture, drawn, staves, beat)
    return Made(image, truth, holds, staves, beats, seconds, score, columns, drawn, beat, forward)


def _grey(content: bytes) -> NDArray[np.uint8]:
    """Return PNG as grey pixels (H, W)."""
    import cv2

    image = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_GRAYSCALE)
    return np.asarray(image, np.uint8)


def _left(group: MarkGroup) -> int:
    """Return where the leftmost of a group's marks begins, units."""
    return min(
        it.x + (it.lines[0][0][0] if isinstance(it, Polyline) else 0)
        for it in group.marks
        if not isinstance(it, MarkGroup)
    )


def signs(picture: Picture, score: Score, *, seconds: bool, beat: int = BEAT) -> list[Sign]:
    """Return what the symbols of a picture say, and its circles of weight."""
    groups = [it for it in picture.groups() if it.marks]
    columns = staff_columns({it.data["part"] for it in picture.groups()})
    found = _landed([_sign(it, picture, score, columns, seconds) for it in groups])
    drawn, staves = _staves(picture, beat, lambda points: points)
    holds = _holds(picture, drawn, staves, beat)
    return found + _stances(holds, found, _spots(score, seconds), staves)


def _sign(
    group: MarkGroup, picture: Picture, score: Score, columns: StaffColumns, seconds: bool
) -> Sign:
    """Return what a symbol that is drawn says."""
    data, part = group.data, group.data["part"]
    kind = kind_of(part)
    direction, amount = data.get("direction"), data.get("amount")
    told = None if amount is None or kind in ("gesture", "travel") else int(amount)
    if kind == "bend" and told is not None:
        told = degree_of(told)
    elif kind == "touch" and told is not None:
        part, told = _touch(part, told, columns)
    elif not any(isinstance(mark, Label) for mark in group.marks):
        told = None  # there is no number, or no room for it
    start, end = (
        round(float(data[it]) * _per(score, seconds) * 2 * GRID) / (2 * GRID)
        for it in ("start", "end")
    )
    if kind == "touch":
        end = start + 1 / GRID  # until when is not on paper
    direction = None if kind == "jump" else direction  # nor is where to
    staff = bisect_right(picture.staves, _left(group)) - 1
    again = kind == "gesture" and direction is None
    name = "again" if again else kind
    return Sign(staff, part, name, direction, data.get("level"), told, start, end)


def _per(score: Score, seconds: bool) -> float:
    """Return the counts in a second."""
    return 1.0 if seconds else float(score.meter.speed) / 60


def _touch(part: str, thing: int, columns: StaffColumns) -> tuple[str, int]:
    """Return the first touch, by the table, whose bow is between the same columns as another's."""
    ends = columns.touched(part, TOUCHED[thing])
    for number, name in enumerate(TOUCHED):
        for other in _TOUCHES:
            if name in amounts_of(other) and columns.touched(other, name) == ends:
                return other, number
    return part, thing


_TOUCHES = ("hands_touch", "r_hand_touch", "l_hand_touch")


def _landed(signs: Sequence[Sign]) -> list[Sign]:
    """Return signs, of supports that end a flight only what is drawn of them: its second half."""
    found = []
    for sign in signs:
        if sign.kind == "support":
            for it in signs:
                if it.kind == "jump" and it.start < sign.end <= it.end:
                    sign = replace(sign, start=max(sign.start, (it.start + sign.end) / 2))
        found.append(sign)
    return found


def _staves(
    picture: Picture, beat: int, forward: Forward
) -> tuple[list[tuple[int, int]], list[Place]]:
    """Return the centre and base of each staff in units, and where each lies on the page."""
    lines = [
        (it.x, it.y, it.x + it.lines[0][1][0], it.y + it.lines[0][1][1])
        for it in picture.marks
        if isinstance(it, Polyline) and it.style in ("staff", "light")
    ]
    base = picture.height - 2 * MARGIN - START - NAMES
    upright = sorted((x, y) for x, y, to_x, _ in lines if x == to_x)
    drawn, places, count = [], [], 0.0
    for number in range(len(picture.staves)):
        (left, foot), (x, _), (right, _) = upright[3 * number : 3 * number + 3]
        wide = {y for at, y, to_x, _ in lines if (at, to_x) == (left, right)}
        ticks = {y for at, y, to_x, _ in lines if left < at < x and at + to_x == 2 * x}
        top, last = min(wide), number + 1 == len(picture.staves)
        double = {min(wide - {top})} if last else set()
        bars = sorted((y for y in wide - double if top < y < base), reverse=True)
        ends = count, count + (base - top) / beat
        count = ends[1]
        corners = forward(np.array([(left, base), (right, base), (left, top), (right, top)]))
        points = [
            forward(np.array([(x, y) for y in ys])) for ys in (bars, sorted(ticks, reverse=True))
        ]
        single = forward(np.array([(x, foot), (x, base), (x, top)]))
        places.append(Place(ends, corners, *single, *points))
        drawn.append((x, base))
    return drawn, places


def _holds(
    picture: Picture, drawn: Sequence[tuple[int, int]], staves: Sequence[Place], beat: int
) -> list[tuple[int, str, float]]:
    """Return the circles of weight: staff, what they say, and the count from which it holds."""
    found = []
    for group in picture.marks:
        if isinstance(group, MarkGroup) and not group.data and "stands" in group.title:
            for mark in group.marks:
                if isinstance(mark, Circle):
                    staff = bisect_right(picture.staves, mark.x) - 1
                    up = (drawn[staff][1] - mark.y - mark.radius) / beat
                    count = staves[staff].counts[0] + up
                    found.append((staff, group.title, round(count * GRID) / GRID))
    return found


def _spots(score: Score, seconds: bool) -> list[float]:
    """Return the counts at which the body begins to turn on the spot."""
    starts = turns(score)[0]["start"] / float(score.rate) * _per(score, seconds)
    return [round(it * GRID) / GRID for it in starts.tolist()]


_FEET = {
    "stands on the right foot": ("r_stance",),
    "stands on the left foot": ("l_stance",),
    "stands on both feet": ("r_stance", "l_stance"),
}


def _stances(
    holds: Sequence[tuple[int, str, float]],
    signs: Sequence[Sign],
    spots: Sequence[float],
    staves: Sequence[Place],
) -> list[Sign]:
    """Return what circles say: a foot stands until the next symbol of support, or circle."""
    ends = [staves[-1].counts[1], *(count for *_, count in holds), *spots]
    ends += [it.start for it in signs if it.kind in ("support", "jump", "carrier")]
    ends += [it.end for it in signs if it.kind == "carrier"]
    ends.sort()
    found = dict[str, list[Sign]]()
    for staff, words, start in sorted(holds, key=lambda it: it[2]):
        end = ends[bisect_right(ends, start)]
        for part in _FEET.get(words, ()):
            own = found.setdefault(part, [])
            one = Sign(staff, part, "stance", None, None, None, start, end)
            if own and own[-1].end == start:  # a circle stands again on each staff
                one = replace(own.pop(), end=end)
            own.append(one)
    return [it for own in found.values() for it in own]
