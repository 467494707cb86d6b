"""The errors of what stands where it cannot stand.

Each function returns the error that says so; the parser raises it.
"""

from __future__ import annotations

import re

from lanindex.errors import PatternError
from lanindex.search.language.cursor import Cursor
from lanindex.search.language.words import LANGUAGE, UNITS, VALUES

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
    ":": "A label is a name before a step: a: r_arm high",
    "@": 'Something is missing before the name: "->", "with" or "or".',
    "#": "A line of LND stands where a step could: behind an arrow, or at the beginning.",
    ";": 'A ";" ends a let: let up = mid -> high; r_arm low -> @up',
    "|": "Stages stand behind the whole pattern, not in brackets or a let.",
    ".": '"..." leads to a later movement: r_arm low ... high',
    "*": '"x0+" is any number of times, "..." any movements between: r_arm low ... high',
    "+": '"x1+" is once or more: r_arm rising x1+',
    "=": "Conditions stand behind where: r_arm high where match.length < 2s",
    "!=": "Conditions stand behind where: r_arm high where match.length < 2s",
    "^": '"start ->" is the beginning of a clip: start -> r_arm high',
    "$": '"-> end" is the end of a clip: r_arm high -> end',
    "{": '"x2..3" is two or three times: r_arm rising x2..3',
    "&": '"with" sets side by side: r_arm high with l_arm high',
    "!": '"not" denies a word, "without" a line: r_arm not low without head',
}
_STRAY_WORDS = {
    "start": '"start" begins a line: start -> r_arm high',
    "end": 'An arrow goes before "end": r_arm high -> end',
    "either": '"either side" speaks of the whole pattern: put it at its end.',
    "mirror": 'Something is missing before "mirror": "->", "with" or "or".',
    "not": '"not" goes with direction and level, before length and count: r_arm not low <1s',
    "at": '"at" is a step of its own: r_arm at high, or r_arm mid -> at high',
    "hold": '"hold" is a step of its own: r_arm right -> hold',
    "via": '"via" is a step of its own: r_arm via right high, or r_arm low -> via right',
    "and": 'Did you mean "with"? "and" joins conditions.',
    "let": '"let" stands before the whole pattern: let up = mid -> high; r_arm low -> @up',
    "where": '"where" speaks of the whole pattern: put it at its end.',
    "rhythm": '"rhythm" speaks of the whole pattern: put it at its end.',
    "mirrors": "Conditions stand behind where: a: r_arm with b: l_arm where a mirrors b",
    "clip": 'Conditions stand behind where: r_arm high where clip.label = "wave"',
    "match": "Conditions stand behind where: r_arm high where match.length < 2s",
    "count": 'A "|" goes before count: r_arm high | count by clip.label',
    "sort": 'A "|" goes before sort: r_arm high | sort by match.start',
    "first": 'A "|" goes before first: r_arm high | first 3',
    "by": '"by" belongs to a stage: | sort by match.start',
    "direction": "A line of LND stands where a step could: behind an arrow, or at the beginning.",
}

_STRANGERS = {
    "for": "Times stand behind the step that they speak of: r_arm forward 1s",
    "x": '"x3" is three times, in one word: r_arm rising x3',
    "times": '"x3" is three times: r_arm rising x3',
    "twice": '"x2" is twice: r_arm rising x2',
}
"""Words that are none, and what is probably meant."""

_NO_STEPS = ("start", "let", "count", "sort", "first", "by", "mirrors", "clip", "match", "and")
"""Words that are no step, wherever they stand."""


def stranger(cursor: Cursor, part_expected: bool = False) -> PatternError:
    """Return the error of a word that is not in the vocabulary."""
    said = cursor.said(cursor.token)
    if cursor.stands("string"):
        return cursor.error("Take the quotation marks away.")
    meant = _STRANGERS.get(said.lower())
    return cursor.error(meant or cursor.vocabulary.stranger(said, part_expected))


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
    token = cursor.token
    if is_strange(cursor):
        return stranger(cursor, part_expected=True)
    if token.kind in ("arrow", "dots"):
        if after in ("->", "start"):
            return cursor.error("Two arrows, and no movement between them.")
        return cursor.error("Nothing before the arrow. Name a part first: r_arm low -> high")
    if token.kind in ("unknown", "string"):
        known = _STRAY_MARKS.get(token.text)
        return cursor.error(known) if known else stranger(cursor)
    if token.text in _NO_STEPS:
        return cursor.error(_STRAY_WORDS[token.text])
    if after == "":
        if token.kind == "end":
            return cursor.error("Nothing follows this bracket.", cursor.before)
        return cursor.error(f'Nothing before "{cursor.said(token)}". Name a part first: r_arm high')
    what = "the arrow" if after in ("->", "start") else f'"{after}"'
    return cursor.error(f"Nothing after {what}: a movement follows it.", cursor.before)


def stray(cursor: Cursor) -> PatternError:
    """Return the error of what follows a line that is complete."""
    token = cursor.token
    if token.kind == "word" and cursor.ahead(1).text == ":":
        return cursor.error(
            "A label goes before a step, behind the arrow: r_arm low -> a: high",
            token,
            cursor.ahead(1),
        )
    known = token.text in _STRAY_MARKS
    if is_strange(cursor) or (token.kind in ("unknown", "string") and not known):
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
