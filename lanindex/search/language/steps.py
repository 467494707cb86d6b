"""Read one step: who moves, how, and the words, which must agree with each other."""

from __future__ import annotations

from collections.abc import Mapping

from lanindex.alphabet import BENDS, DIRECTIONS, KINDS, Kind, amounts_of, kind_of
from lanindex.errors import PatternError
from lanindex.search.language.lexer import Cursor
from lanindex.search.language.query import Step, Word, meaning
from lanindex.search.language.suggestions import is_unknown, no_step, unknown
from lanindex.search.language.words import (
    ANY,
    BEND_MOVES,
    DEGREES,
    MANNERS,
    MOVING,
    RELATIVE,
    THINGS,
    UNITS,
    VALUES,
    WORD_KINDS,
    Mover,
    values_for,
    values_of,
    with_article,
)

_STILL = {"at": "at is being there", "hold": "hold is staying put"}
_NO_WORDS = {
    "at": "At what? Say where: at high, at place low",
    "via": "Via what? Say where it goes through: via right, via any",
}
NO_PART = "Name the part first: r_arm high"
_NO_PART = {
    "": NO_PART,
    "start": "Name the part here: start -> r_arm high",
    "or": 'Name the part here; "/" is either-or between words: high/low.',
}
_EXAMPLES = {"feet": "jump", "bend": "r_arm"}  # by kind of words, a part to name


def step_at(cursor: Cursor, carried: frozenset[Mover], after: str, mirror: bool) -> Step:
    """Read a step.

    `carried` is who moved last, one or several alternatives; `after` is what comes before the
    step: ``->``, a relation, ``or``, ``start`` or nothing; `mirror`: return its mirror image.
    """
    _check_meant(cursor, carried)
    named = cursor.mover()
    if named:
        mover = named.mirrored() if mirror else named
    elif cursor.stands("word", *MANNERS, "not", *_values(*carried)) or cursor.at_angle:
        mover = _carried(cursor, carried, after)
    else:
        raise no_step(cursor, after)
    bending = _bending(cursor, mover)
    mover = bending or mover
    token = cursor.take("word", *MANNERS)
    manner = token.text if token else "move"
    if manner == "at" and not THINGS.keys().isdisjoint(_kind(mover).words):
        raise cursor.error(f"It lasts as long as its movement does: {mover} 1s+", cursor.before)
    words = _words(cursor, mover, manner)
    if manner in _NO_WORDS and not words:
        raise cursor.error(_NO_WORDS[manner], cursor.before)
    if mirror:
        words = tuple(word.mirrored() for word in words)
    return Step(mover, bool(named or bending), manner, words)


def _kind(mover: Mover) -> Kind:
    return KINDS[kind_of(mover.members[0])]


def _values(*movers: Mover) -> Mapping[str, tuple[str, str]]:
    """Return the words that are understood of some movers, as in `VALUES`."""
    return values_for({kind for mover in movers for kind in _kind(mover).words})


def _check_meant(cursor: Cursor, carried: frozenset[Mover]) -> None:
    """Refuse a bare word that may name a part, or the thing that a carried part touches."""
    word, after = cursor.token.text, cursor.ahead(1)
    goes_on = after.kind == "word" and after.text in (*MANNERS, "not", *VALUES)
    goes_on |= cursor.vocabulary.mover(word, after.text) is not None
    if word in _values(*carried) and cursor.vocabulary.mover(word) and not goes_on:
        (mover, *_) = carried
        raise cursor.error(f"Which is meant? {mover} {word}, or the part: {word} any")


def _carried(cursor: Cursor, carried: frozenset[Mover], after: str) -> Mover:
    if len(carried) == 1:
        return next(iter(carried))
    word = cursor.token.text
    if carried:
        names = ", ".join(sorted(mover.name for mover in carried))
        found = f"The alternatives before end with different parts ({names}). Name the part here."
    elif part := _EXAMPLES.get(VALUES.get(word, ("", ""))[0]):
        found = f"Name the part first: {part} {word}"
    else:
        found = _NO_PART.get(after, f'Name the part here: nothing carries over "{after}".')
    raise cursor.error(found)


def _bending(cursor: Cursor, mover: Mover) -> Mover | None:
    """Return the elbow or knee that the words are about: ``r_arm bend``, ``r_arm at bent``."""
    manner = cursor.token.text if cursor.stands("word", *MANNERS) else ""
    ahead = int(bool(manner))
    ahead += cursor.ahead(ahead).text == "not"
    kind, value = VALUES.get(cursor.ahead(ahead).text, ("", ""))
    moves = manner in _STILL or value.split(" ")[0] in BEND_MOVES
    if kind != "bend" or not moves or cursor.ahead(1).text == ":":
        return None
    return cursor.vocabulary.of(mover.form, tuple(BENDS.get(it, "") for it in mover.members))


def _words(cursor: Cursor, mover: Mover, manner: str) -> tuple[Word, ...]:
    words: list[Word] = []
    checked: list[Word] = []  # without repeated denials, so that a long line takes no longer
    while (_at_value(cursor, mover) or cursor.stands("word", "not")) and not cursor.at_label:
        begin = cursor.token
        negated = cursor.take("word", "not") is not None
        if not _at_value(cursor, mover):
            raise _no_value(cursor, "Not what? A direction or level follows: not low")
        words.append(_word(cursor, mover, negated))
        if not (negated and words[-1] in checked):
            checked.append(words[-1])
            if found := _complaint(tuple(checked), mover, manner):
                raise cursor.error_since(begin, found)
    number, unit = cursor.number_and_unit()
    if number and unit not in UNITS and "degrees" in _kind(mover).words:
        units = f"{number}deg is degrees, {number}s seconds, {number}b beats, {number}f frames."
        raise cursor.error(f"{number} what? {units}")
    for kind in THINGS.keys() & _kind(mover).words:
        if not words and is_unknown(cursor):
            word, known = cursor.token.text, " ".join(WORD_KINDS[kind].codes)
            raise cursor.error(f'No {WORD_KINDS[kind].noun} "{word}". There is: {known}')
    return tuple(words)


def _at_value(cursor: Cursor, mover: Mover) -> bool:
    token = cursor.token
    return token.text in _values(mover) if token.kind == "word" else cursor.at_angle


def _value(cursor: Cursor, mover: Mover) -> tuple[str, str]:
    """Read a word or an angle: its kind, and its own spelling."""
    if cursor.at_angle:
        return "degrees", str(cursor.length((DEGREES,)))
    kind, value = _values(mover)[cursor.advance().text]
    degree = cursor.sixths() if kind == "bend" and value in ("bend", "stretch", "bent") else ""
    return kind, f"{value} {degree}".rstrip()


def _word(cursor: Cursor, mover: Mover, negated: bool) -> Word:
    begin = cursor.token
    kind, value = _value(cursor, mover)
    values = [value]
    while cursor.take("mark", "/"):
        if not _at_value(cursor, mover):
            raise _no_value(cursor, 'Or what? A word of the same kind follows "/": high/low')
        first = cursor.token
        other, value = _value(cursor, mover)
        if other != kind:
            both = f"{begin.text} {cursor.said(first, cursor.before)}"
            one_kind = '"/" joins words of one kind: right/left, high/low.'
            raise cursor.error_since(begin, f'{one_kind} Both at once have no "/": {both}')
        values.append(value)
    return Word(kind, tuple(values), negated)


def _no_value(cursor: Cursor, sentence: str) -> PatternError:
    if is_unknown(cursor):
        return unknown(cursor)
    if cursor.token.kind == "word" and cursor.vocabulary.mover(cursor.token.text):
        return cursor.error('Here goes a direction or a level. "or" joins lines of other parts.')
    return cursor.error(sentence, cursor.before)


def _complaint(words: tuple[Word, ...], mover: Mover, manner: str) -> str | None:
    """Return what is wrong with the last word, or None."""
    word, noun = words[-1], WORD_KINDS[words[-1].kind].noun
    kind, part = _kind(mover), mover.members[0]
    bends = word.kind == "bend" and word.values[0].split()[0] in BEND_MOVES
    cannot = f'"{word}" cannot be said of {mover.name}:'
    if word.kind not in kind.words and word.values != (ANY,):
        return f"{cannot} {with_article(kind.name)} has no {noun}."
    if word.kind == "bend" and not {*mover.members} <= {*BENDS, *BENDS.values()}:
        return f"{cannot} only arms and legs bend and stretch."
    if bends and kind.name == "gesture":
        bent = str(word).replace("bend", "bent").replace("stretch", "bent")
        return f'"{word}" is a movement of its own; that of {mover.name} may end {bent}.'
    things = {*word.values} - {*amounts_of(part)} if word.kind == "touched" else set()
    if things and "hand" in word.values:
        return "Hand touches hand by itself: hands touch"
    if things:
        return f"Hands touch each other. Both of them something else: hand_touches {word}"
    same = (it for it in words[:-1] if it.kind == word.kind and not (it.negated or word.negated))
    if first := next(same, None):
        if word.kind == "degrees":
            return "Two angles. From 90deg to 180deg is 90deg..180deg"
        either = f'One movement has one {noun}. "{first}/{word}" means either'
        then = f'; "{first} -> {word}" means one after the other.'
        return f"{either}{then if word.kind != 'change' else '.'}"
    if manner in _STILL and word.kind in MOVING:
        return f'{_STILL[manner]}: say a direction or a level, not "{word.values[0]}".'
    if manner in _STILL and bends:
        return f'{_STILL[manner]}: say bent, bent 3+ or straight, not "{word}".'
    sideless = {it for it in RELATIVE if kind.name == "gesture" or it.startswith("across")}
    if not mover.sided and sideless.intersection(word.values):
        return f"The {mover.name} has no side of its own: say right or left."
    limited = word.kind == "direction" and kind.directions != DIRECTIONS
    reached = (values_of("direction", value, part) for value in word.values)
    if limited and any(it.isdisjoint(kind.directions) for it in reached):
        return f"{cannot} it goes {' or '.join(kind.directions)}."
    if not meaning(words, word.kind, part):
        return f'"{word}" leaves nothing: there is no {noun} that would match.'
    return None
