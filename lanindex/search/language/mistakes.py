"""The errors of what stands where it cannot stand.

Each function returns the error that says so; the parser raises it.
"""

from __future__ import annotations

import re

from lanindex.errors import PatternError
from lanindex.search.language.cursor import Cursor
from lanindex.search.language.words import LANGUAGE, NOT_YET, UNITS, VALUES

COUNT = re.compile(r"x(\d+)")
"""A count: ``x3``."""

_STRAY_MARKS = {
    ")": 'This bracket was never opened: take it away, or put a "(" before.',
    "(": 'Something is missing before the bracket: "->", "with" or "or".',
    "/": '"/" joins words, high/low; "or" joins lines: r_arm high or l_arm low',
    "[": "Square brackets follow an arrow: ->[<2s], ...[<=2]",
    "]": 'This bracket was never opened: ->[<2s] has a "[" too.',
    ",": 'No commas: "with" sets side by side, "->" puts one after the other.',
    "?": "Only a step can be left out, once: r_arm low -> mid? -> high",
}
_STRAY_WORDS = {
    "start": '"start" begins a line: start -> r_arm high',
    "end": 'An arrow goes before "end": r_arm high -> end',
    "either": '"either side" speaks of the whole pattern: put it at its end.',
    "mirror": 'Something is missing before "mirror": "->", "with" or "or".',
    "not": '"not" goes with direction and level, before length and count: r_arm not low <1s',
    "at": '"at" is a step of its own: r_arm at high, or r_arm mid -> at high',
    "hold": '"hold" is a step of its own: r_arm right -> hold',
}


def not_yet(cursor: Cursor) -> PatternError | None:
    """Return the error of a construct that is not understood yet, if one begins here."""
    token, following = cursor.token, cursor.ahead(1)
    label = token.kind == "word" and following.text == ":"
    reference = token.text == "@" and following.kind == "word"
    word = token.kind == "word" and token.text in NOT_YET
    if not (label or word or (token.kind == "mark" and token.text in "@|#;")):
        return None
    last = following if label or reference else token
    if word and following.text == "." and cursor.ahead(2).kind == "word":
        last = cursor.ahead(2)
    return cursor.error(f'"{cursor.said(token, last)}" is not understood yet.', token, last)


def not_yet_bounded(cursor: Cursor) -> PatternError | None:
    """Return the error of a relation with a time, ``with[1s]``, if one was just begun."""
    if not cursor.stands("mark", "["):
        return None
    begin = cursor.before
    while not cursor.stands("end") and not cursor.take("mark", "]"):
        cursor.advance()
    said = cursor.said(begin, cursor.before)
    return cursor.error(f'"{said}" is not understood yet.', begin, cursor.before)


def stranger(cursor: Cursor, part_expected: bool = False) -> PatternError:
    """Return the error of a word that is not in the vocabulary."""
    said = cursor.said(cursor.token)
    if cursor.stands("string"):
        return cursor.error("Take the quotation marks away.")
    return cursor.error(cursor.vocabulary.stranger(said, part_expected))


def is_strange(cursor: Cursor) -> bool:
    """Tell whether the next token is a word that the language does not know."""
    word = cursor.token.text
    return cursor.stands("word") and not (
        word in VALUES
        or word in LANGUAGE
        or word in UNITS
        or COUNT.fullmatch(word)
        or cursor.vocabulary.mover(word)
    )


def nothing(cursor: Cursor, after: str) -> PatternError:
    """Return the error where a step should begin, and none does.

    Parameters
    ----------
    cursor : Cursor
        Stands where the step should begin.
    after : str
        What comes before: ``->``, a relation, ``or``, ``start`` or nothing.
    """
    if late := not_yet(cursor):
        return late
    token = cursor.token
    if is_strange(cursor):
        return stranger(cursor, part_expected=True)
    if token.kind in ("arrow", "dots"):
        if after in ("->", "start"):
            return cursor.error("Two arrows, and no movement between them.")
        return cursor.error("Nothing before the arrow. Name a part first: r_arm low -> high")
    if token.kind in ("unknown", "string"):
        return stranger(cursor)
    if cursor.stands("word", "start"):
        return cursor.error(_STRAY_WORDS["start"])
    if after == "":
        if token.kind == "end":
            return cursor.error("Nothing follows this bracket.", cursor.before)
        return cursor.error(f'Nothing before "{cursor.said(token)}". Name a part first: r_arm high')
    what = "the arrow" if after in ("->", "start") else f'"{after}"'
    return cursor.error(f"Nothing after {what}: a movement follows it.", cursor.before)


def stray(cursor: Cursor) -> PatternError:
    """Return the error of what follows a line that is complete."""
    if late := not_yet(cursor):
        return late
    token = cursor.token
    if is_strange(cursor) or token.kind in ("unknown", "string"):
        return stranger(cursor)
    if token.kind == "word" and cursor.vocabulary.mover(token.text):
        return cursor.error(
            'Another part: "with" sets it beside, "->" puts it after, "or" is either of them.'
        )
    if cursor.before.text == "end":
        return cursor.error('After "end" the line does not go on.')
    if token.text in _STRAY_WORDS:
        return cursor.error(_STRAY_WORDS[token.text])
    if token.text in VALUES:
        return cursor.error(
            f"Direction and level stand before length and count: r_arm high <1s x2. "
            f"The next movement has an arrow: -> {token.text}"
        )
    sentence = _STRAY_MARKS.get(token.text, f'"{cursor.said(token)}" says nothing here.')
    return cursor.error(sentence)
