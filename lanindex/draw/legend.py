"""What the signs of a score mean, beside its staves."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from lanindex.alphabet import DIRECTION_CODES, DIRECTIONS
from lanindex.draw.holds import ONE
from lanindex.draw.picture import C, Circle, Group, Mark, Text, box, line
from lanindex.draw.shapes import sign
from lanindex.draw.signs import BOW, SIGNS, bow
from lanindex.model import Symbol
from lanindex.model.symbol import blank, listed

WIDTH = 13 * C
"""Room for signs and words."""

_PITCH = round(1.35 * C)
_NAME = round(0.45 * C)

_LEVELS = {
    "high": "high; a support: on the toes",
    "mid": "middle",
    "low": "low; a support: knees bent",
}

_SAMPLES = {
    "turn": ("body_turn", "right", 90, "turns, so many degrees"),
    "twist": ("torso_twist", "left", 45, "is twisted, so many degrees"),
    "incline": ("torso_incline", "forward", 45, "leans, so many degrees"),
    "travel": ("body_travel", "forward", 0, "goes somewhere"),
    "bend": ("r_arm_bend", None, 3, "bends so far (6: all); posts: stretches"),
    "carrier": ("other_support", None, 1, "carries, beside the feet or alone"),
}
"""Of kinds that have a sign of their own: a track, what one of its symbols says, what it means."""


def legend(
    kinds: Collection[str], x: int, y: int, *, marked: bool = False
) -> tuple[list[Group], int]:
    """Return what signs mean, a row each, and how high that is."""
    rows = list[Group]()
    for number, (marks, said) in enumerate(_rows(kinds, x + C, y + _PITCH, marked)):
        words = Text(
            x + 2 * C, y + number * _PITCH + _PITCH // 2 + _NAME // 3, said, _NAME, "begin"
        )
        rows.append(Group((*marks, words), said))
    return rows, len(rows) * _PITCH


def _rows(kinds: Collection[str], x: int, y: int, marked: bool) -> Iterator[tuple[list[Mark], str]]:
    """Yield the marks of each row, from its middle and its lower end, and what they mean."""
    step, size, left = _PITCH, C, x - C // 2

    def low() -> int:
        nonlocal y
        y += step
        return y - step - (step - size) // 2

    for name in DIRECTIONS:
        yield (
            sign(left, low(), name, None, size),
            name.replace("r_", "right ").replace("l_", "left "),
        )
    for level, said in _LEVELS.items():
        yield sign(left, low(), "place", level, size), said
    for kind, (part, direction, amount, said) in _SAMPLES.items():
        if kind in kinds:
            yield SIGNS[kind](_sample(part, direction, amount), x, low(), size), said
    if "stance" in kinds:
        yield [Circle(x, low() - size // 2, ONE // 2)], "stands, while supports are silent"
    if "touch" in kinds:
        yield [bow(left, left + C, low() - size // 2 + BOW // 2)], "touches"
    if "jump" in kinds:
        base = low()
        yield [line(x + at, base, x + at, base - size) for at in (-C // 3, C // 3)], "is in the air"
    if marked:
        yield [box(left, low() - size, C, size, "band")], "is what was asked for"


def _sample(part: str, direction: str | None, amount: int) -> Symbol:
    row = blank(1)
    row["direction"] = -1 if direction is None else DIRECTION_CODES[direction]
    row["amount"] = amount
    return listed(part, row)[0]
