"""Read what measures: lengths, counts and arrows with their limits."""

from __future__ import annotations

from fractions import Fraction

from lanindex.alphabet import SIXTHS
from lanindex.search.language.cursor import Cursor
from lanindex.search.language.lexer import Token
from lanindex.search.language.mistakes import COUNT
from lanindex.search.language.query import ONCE, Arrow, Repeat, Skips
from lanindex.search.language.times import Length, Time
from lanindex.search.language.words import DEGREES, UNITS

_LONGEST_NUMBER = 9
_OFTEN = {"1": "once", "2": "twice"}
_EDGES = "--tolerance tells how far the edges may lie apart."
_UNBOUNDED = {
    "during": "one lies inside the other.",
    "never": "it looks at all of the capture.",
    "starting with": _EDGES,
    "ending with": _EDGES,
    "exactly with": _EDGES,
}
"""Relations that take no time, and why."""


def _checked(cursor: Cursor, token: Token, number: str) -> str:
    if len(number) > _LONGEST_NUMBER:
        raise cursor.error(f"No more than {_LONGEST_NUMBER} digits, please.", token)
    return number


def decimal_at(cursor: Cursor) -> Fraction:
    """Read a number, which stands here."""
    token = cursor.advance()
    return Fraction(_checked(cursor, token, token.text))


def whole_at(cursor: Cursor) -> int | None:
    """Read a whole number, if one stands here."""
    if not (cursor.stands("number") and cursor.token.text.isdecimal()):
        return None
    return int(decimal_at(cursor))


def time_at(cursor: Cursor, units: tuple[str, ...] = UNITS) -> Time:
    """Read a time: ``0.3s``, ``300ms``, ``9f``, ``2b``; or what has other units.

    Raises
    ------
    PatternError
        None stands here, or it has no unit.
    """
    number = cursor.take("number")
    if number is None:
        raise cursor.error("A time goes here: 0.3s, 300ms, 9f, 2b", cursor.before)
    said = _checked(cursor, number, number.text)
    if not cursor.stands("word", *units):
        counted = f"; x{said} means {_OFTEN.get(said, f'{said} times')}"
        raise cursor.error(
            f"{said} what? {said}s is seconds, {said}b beats, {said}f frames"
            f"{counted if said.isdecimal() else ''}.",
            number,
        )
    return Time(Fraction(said), cursor.advance().text)


def _number_and_unit(cursor: Cursor) -> tuple[str, str]:
    """Return the number that stands here, also behind < or >, and what follows it; nothing read."""
    number, unit = (cursor.ahead(cursor.stands("compare") + ahead) for ahead in (0, 1))
    return (number.text, unit.text) if number.kind == "number" else ("", "")


def is_angle(cursor: Cursor) -> bool:
    """Tell whether an angle stands here."""
    return _number_and_unit(cursor)[1] == DEGREES


def angle_at(cursor: Cursor) -> str:
    """Read an angle, if one stands here: ``<90deg``, ``45deg..90deg``, ``360deg+``, ``90deg``."""
    return str(length_at(cursor, (DEGREES,))) if is_angle(cursor) else ""


def sixths_at(cursor: Cursor) -> str:
    """Read a degree of bending, if one stands here: ``3``, ``3+``, ``2..4``, ``<3``."""
    number, unit = _number_and_unit(cursor)
    if not number or unit in (*UNITS, DEGREES):
        return ""
    begin = cursor.token
    compare = cursor.take("compare")
    first, last = _sixth_at(cursor), ""
    if not compare and cursor.take("mark", "+"):
        last = "+"
    elif not compare and cursor.take("range"):
        most = _sixth_at(cursor)
        if most < first:
            raise cursor.error(f"From more to less: write {most}..{first}", begin, cursor.before)
        last = f"..{most}"
    return f"{compare.text if compare else ''}{first}{last}"


def _sixth_at(cursor: Cursor) -> str:
    token = cursor.advance()
    if not (token.kind == "number" and token.text.isdecimal() and int(token.text) <= SIXTHS):
        raise cursor.error(
            f"A limb is bent by 0, straight, to {SIXTHS} degrees, 3 being a right angle: bend 3+",
            token,
        )
    return str(int(token.text))


def bare_at(cursor: Cursor) -> str:
    """Return the number that stands here without a unit, or nothing; it is not read."""
    number, unit = _number_and_unit(cursor)
    return "" if unit in UNITS else number


def length_at(cursor: Cursor, units: tuple[str, ...] = UNITS) -> Length | None:
    """Read a length, if one stands here: ``<0.3s``, ``1s..2s``, ``2s+``, ``1s``."""
    begin = cursor.token
    if compare := cursor.take("compare"):
        return Length(compare.text, time_at(cursor, units))
    if not cursor.stands("number"):
        return None
    time = time_at(cursor, units)
    if cursor.take("mark", "+"):
        return Length("+", time)
    if not cursor.take("range"):
        return Length("~", time)
    last = time_at(cursor, units)
    if last.unit == time.unit and last.number < time.number:
        raise cursor.error(f"From more to less: write {last}..{time}", begin, cursor.before)
    return Length("..", time, last)


def repeat_at(cursor: Cursor) -> Repeat:
    """Read a count, if one stands here: ``x3``, ``x3+``, ``x2..3``, ``?``."""
    begin = cursor.token
    if cursor.take("mark", "?"):
        return Repeat(0, 1)
    counted = COUNT.fullmatch(begin.text) if begin.kind == "word" else None
    if counted is None:
        return ONCE
    cursor.advance()
    least = int(_checked(cursor, begin, counted[1]))
    most: int | None = least
    if cursor.take("mark", "+"):
        most = None
    elif cursor.take("range"):
        number = cursor.take("number")
        if number is None or not number.text.isdecimal():
            raise cursor.error("From how often to how often? x2..3", begin, cursor.before)
        most = int(_checked(cursor, number, number.text))
        if most < least:
            raise cursor.error(f"From more to less: write x{most}..{least}", begin, cursor.before)
    if most == 0:
        raise cursor.error(
            '"x0" is never. To say that it does not happen: without', begin, cursor.before
        )
    return Repeat(least, most)


def arrow_at(cursor: Cursor) -> Arrow | None:
    """Read an arrow with its limit, if one stands here: ``->``, ``...[<2s]``."""
    begin = cursor.take("arrow") or cursor.take("dots")
    if begin is None:
        return None
    later = begin.kind == "dots"
    opening = cursor.take("mark", "[")
    if opening is None:
        return Arrow(later)
    skips = _skips_at(cursor)
    length = None if skips else length_at(cursor)
    if skips is None and length is None:
        raise cursor.error(
            "A limit goes into the brackets: [<2s] of the time between, "
            "...[<=2] of the movements skipped.",
            opening,
        )
    _close(cursor, opening)
    if skips and not later:
        raise cursor.error(
            "The arrow -> skips nothing: it leads to the next movement. "
            f"...[{skips}] counts what is skipped, ->[{skips}s] is a time.",
            begin,
            cursor.before,
        )
    return Arrow(later, length, skips)


def _close(cursor: Cursor, opening: Token) -> None:
    if not cursor.take("mark", "]"):
        raise cursor.error('This bracket is never closed: a "]" is missing.', opening)


def _example(relation: str) -> str:
    return "1s" if relation in ("with", "without") else "<1s"


def within_at(cursor: Cursor, relation: str) -> Length | None:
    """Read the limit of a relation, if one stands here: ``after[<1s]``, ``with[1s]``."""
    begin = cursor.before
    opening = cursor.take("mark", "[")
    if opening is None and (cursor.stands("compare") or cursor.stands("number")):
        raise cursor.error(f"A time goes into square brackets: {relation}[{_example(relation)}]")
    if opening is None:
        return None
    if relation in _UNBOUNDED:
        raise cursor.error(
            f'No time goes with "{relation}": {_UNBOUNDED[relation]}', begin, opening
        )
    plain = relation in ("with", "without")
    if plain and cursor.stands("compare"):
        raise cursor.error(f"A plain time: {relation}[1s] is less than 1s between.")
    if plain and cursor.stands("number"):
        length: Length | None = Length("<", time_at(cursor))
    else:
        length = length_at(cursor)
    if length is None:
        sentence = f"A time goes into the brackets: {relation}[{_example(relation)}]"
        raise cursor.error(sentence, opening)
    if plain and (cursor.stands("mark", "+") or cursor.stands("range")):
        raise cursor.error(f"A plain time: {relation}[1s] is less than 1s between.")
    _close(cursor, opening)
    if plain and not length.time.number:
        raise cursor.error(
            f'Nothing is less than no time between. "{relation}" alone is about sharing a frame.',
            opening,
            cursor.before,
        )
    return length


def _skips_at(cursor: Cursor) -> Skips | None:
    """Read a number of movements: a number that no unit follows."""
    compared = 1 if cursor.stands("compare") else 0
    if cursor.ahead(compared).kind != "number" or cursor.ahead(compared + 1).text in UNITS:
        return None
    form = cursor.advance().text if compared else ""
    number = cursor.advance()
    if not number.text.isdecimal():
        raise cursor.error("Movements are counted in whole numbers; a time has a unit.", number)
    return Skips(form, int(_checked(cursor, number, number.text)))
