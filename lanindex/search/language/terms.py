"""Read the conditions of ``where``, and what they and the stages of a pipe speak of."""

from __future__ import annotations

from collections.abc import Collection

from lanindex.alphabet import MEASURES
from lanindex.errors import PatternError
from lanindex.model.measures import GRADES
from lanindex.search.language.clauses import (
    CLIP,
    FIELDS,
    MATCH,
    Comparison,
    Condition,
    Mirrors,
    Number,
    Reference,
    Sum,
    Term,
    Text,
    Value,
)
from lanindex.search.language.cursor import Cursor
from lanindex.search.language.lexer import Token
from lanindex.search.language.measures import decimal_at, time_at
from lanindex.search.language.mistakes import COUNT
from lanindex.search.language.things import OWN
from lanindex.search.language.times import Time
from lanindex.search.language.words import ANY, LANGUAGE, RELATIVE, UNITS, VALUES

_SORTS = {
    "part": "part",
    "direction": "direction",
    "level": "level",
    "swings": "number",
    "margin": "number",
    "else": "direction",
    "degrees": "number",
    "bend": "number",
    **{"feet": "feet", "touched": "touched", "carrier": "carrier"},
    **dict.fromkeys(MEASURES, "number"),
}
"""What a field of a label is; all others are times."""

_NOUNS = {
    "part": "a part",
    "direction": "a direction",
    "level": "a level",
    "feet": "a kind of jump",
    "touched": "a thing touched",
    "carrier": "a carrier",
    "number": "a number",
    "time": "a time",
    "text": "a text",
    "clip": "a text or a number",
}
_ORDERED = ("time", "number", "level", "text", "clip")
"""What can be more or less."""

_AGREE = [{"part", "text"}, {"clip", "text"}, {"clip", "number"}, {"clip", "part"}]
"""Of two kinds, what can still be compared."""


def sort_of(term: Term) -> str:
    """Return what a term is: a key of what can be compared."""
    match term:
        case Reference(name=name, field=field):
            return "clip" if name == CLIP else _SORTS.get(field, "time")
        case Value(kind=kind):
            return kind
        case Time():
            return "time"
        case Number():
            return "number"
        case Text():
            return "text"


def condition_at(cursor: Cursor, labels: Collection[str]) -> Condition:
    """Read one condition.

    Parameters
    ----------
    cursor : Cursor
        Stands where it begins.
    labels : collection of str
        Those of the pattern.

    Raises
    ------
    PatternError
        None begins here, or what it compares cannot be compared.
    """
    if cursor.token.kind == "word" and cursor.ahead(1).text == "mirrors":
        return _mirrors_at(cursor, labels)
    begin = cursor.token
    left = _sum_at(cursor, labels)
    compare = cursor.take("compare") or cursor.take("mark", "=", "!=")
    if compare is None:
        if cursor.stands("word", "mirrors"):
            raise cursor.error("Two labels: a mirrors b", begin, cursor.token)
        if cursor.stands("word") or cursor.token.text in ("*", "/"):
            raise cursor.error("Here goes =, !=, <, <=, > or >=: a.level = high")
        raise cursor.error("Compared with what? a.level = high", begin, cursor.before)
    if again := cursor.take("mark", "="):
        remedy = "Write != once." if compare.text == "!=" else 'One "=" is enough.'
        raise cursor.error(remedy, compare, again)
    said = _own(Comparison(left, compare.text, _sum_at(cursor, labels)))
    if found := _complaint(cursor, said):
        raise cursor.error(found, begin, cursor.before)
    return said


def _own(said: Comparison) -> Comparison:
    """Understand a word that is compared with what a hand touches, or what carries, as such."""
    sorts = [sort_of(side.terms[0][1]) for side in (said.left, said.right)]
    known = next((OWN[sort] for sort in sorts if sort in OWN), {})
    sides = []
    for side in (said.left, said.right):
        (sign, term), *more = side.terms
        if isinstance(term, Text) and term.text in known and not more:
            side = Sum(((sign, Value(*known[term.text])),))
        sides.append(side)
    return Comparison(sides[0], said.compare, sides[1])


def _mirrors_at(cursor: Cursor, labels: Collection[str]) -> Mirrors:
    first = _label_at(cursor, labels)
    cursor.advance()
    if cursor.token.kind != "word":
        raise cursor.error("Another label follows: a mirrors b", cursor.before)
    token = cursor.token
    second = _label_at(cursor, labels)
    if first == second:
        raise cursor.error("Two labels: a mirrors b", token)
    return Mirrors(first, second)


def _label_at(cursor: Cursor, labels: Collection[str]) -> str:
    name = cursor.token.text
    if name not in labels:
        raise cursor.error(_no_label(name, labels))
    return cursor.advance().text


def _no_label(name: str, labels: Collection[str]) -> str:
    if labels:
        return f'There is no label "{name}". There is: {" ".join(labels)}'
    return f'There is no label "{name}". It stands before a step: {name}: r_arm high'


def reference_at(cursor: Cursor, labels: Collection[str]) -> Reference:
    """Read what a term or a stage speaks of: ``a.start``, ``match.length``, ``clip.label``.

    Raises
    ------
    PatternError
        It speaks of no label, or of no field.
    """
    token = cursor.token
    taken = token.text in (*LANGUAGE, *VALUES) and token.text not in (CLIP, MATCH, *labels)
    if token.kind != "word" or (taken and token.text not in FIELDS):
        raise cursor.error("Of what? match.start, match.length, clip.label, or a label: a.start")
    if cursor.ahead(1).text != ".":
        raise cursor.error(_no_reference(token.text, labels))
    if token.text not in (*labels, CLIP, MATCH):
        raise cursor.error(_no_label(token.text, labels))
    cursor.advance()
    dot, field = cursor.advance(), cursor.token
    if field.kind != "word":
        raise cursor.error(f"A field follows: {_fields(token.text)}", token, dot)
    if token.text != CLIP and field.text not in FIELDS:
        raise cursor.error(_no_field(token.text, field.text))
    return Reference(token.text, cursor.advance().text)


def _fields(name: str) -> str:
    return "clip.label, clip.path or another column" if name == CLIP else " ".join(FIELDS)


_COLUMNS = ("label", "path", "format", "dataset", "fps", "frames", "seconds", "tempo")
"""What people ask a clip for."""


def _no_reference(name: str, labels: Collection[str]) -> str:
    if name in FIELDS:
        return f'"{name}" of what? match.{name}' + (
            f", {next(iter(labels))}.{name}" if labels else ""
        )
    if name in _COLUMNS:
        return f'"{name}" of what? clip.{name}'
    if name in labels or name in (CLIP, MATCH):
        return f"What of it? {name}.{'label' if name == CLIP else 'start'}"
    return f'"{name}" of what? match.start, clip.label, or a label: a.start'


_MEANT = {"duration": "length", "time": "length", "begin": "start", "stop": "end"}
_MEANT |= {"height": "level", "fit": "margin", "limb": "part"}
_MEANT |= {"velocity": "speed", "pace": "speed", "extent": "size", "angle": "size"}
"""Fields by other names."""


def _no_field(name: str, field: str) -> str:
    from rapidfuzz import process

    guess = process.extractOne(field, FIELDS, score_cutoff=60)
    near = _MEANT.get(field) or (guess[0] if guess else "")
    meant = f"Did you mean {name}.{near}?" if near else f"It has: {' '.join(FIELDS)}"
    return f'"{name}" has no "{field}". {meant}'


def _sum_at(cursor: Cursor, labels: Collection[str]) -> Sum:
    first, begin = _term_at(cursor, labels), cursor.before
    terms = [(1, first)]
    while sign := cursor.take("mark", "+", "-"):
        begin = cursor.token
        term = _term_at(cursor, labels)
        terms.append((1 if sign.text == "+" else -1, term))
        for _, one in (terms[0], terms[-1]):
            if sort_of(one) not in ("time", "number", "clip"):
                raise cursor.error(
                    f'"{one}" is {_NOUNS[sort_of(one)]}: only times and numbers have a sum.',
                    begin,
                    cursor.before,
                )
        if {sort_of(term), sort_of(first)} == {"time", "number"}:
            raise cursor.error(_unlike(first, term), begin, cursor.before)
    return Sum(tuple(terms))


def _term_at(cursor: Cursor, labels: Collection[str]) -> Term:
    token = cursor.token
    if token.kind == "number":
        timed = cursor.ahead(1).kind == "word" and cursor.ahead(1).text in UNITS
        return time_at(cursor) if timed else Number(decimal_at(cursor))
    if token.kind == "string":
        return _text_at(cursor)
    if cursor.ahead(1).text == "." and token.kind == "word":
        return reference_at(cursor, labels)
    if token.kind == "word" and (kind := VALUES.get(token.text)):
        return _value_at(cursor, *kind)
    if mover := cursor.mover_at():
        if mover.form != "one":
            right, left = mover.members
            raise cursor.error(
                f'One part is meant: {right} or {left}. "{mover}" is none by itself.',
                cursor.before,
            )
        return Text(mover.name)
    if any(token.text in known for known in OWN.values()):
        return Text(cursor.advance().text)
    raise _no_term(cursor, token, labels)


_NO_CONDITION = {
    "not": "A condition is not denied but turned round: a.level != high",
    "(": "Conditions stand without brackets; + and - add times up from left to right.",
    "-": "Times and numbers are 0 or more; turn it round: a.start - b.end < 1s",
    "'": 'Double quotation marks, please: clip.label = "wave"',
}
"""What stands where a term should, and what to do about it."""


def _no_term(cursor: Cursor, token: Token, labels: Collection[str]) -> PatternError:
    if token.text in _NO_CONDITION:
        return cursor.error(_NO_CONDITION[token.text])
    if token.text in (*labels, *FIELDS, *_COLUMNS, CLIP, MATCH):
        return cursor.error(_no_reference(token.text, labels))
    if token.kind == "word" and token.text not in LANGUAGE and not COUNT.fullmatch(token.text):
        said = cursor.said(token)
        return cursor.error(
            f'I don\'t know "{said}". A text has quotation marks: clip.label = "{said}"'
        )
    sentence = 'A condition goes here: a.start > 2s, a.level = high, clip.label = "wave"'
    return cursor.error(sentence, token if token.kind != "end" else cursor.before)


def _text_at(cursor: Cursor) -> Text:
    token = cursor.advance()
    said = cursor.text[token.start : token.stop]
    if len(said) < 2 or not said.endswith('"'):
        raise cursor.error("These quotation marks are never closed.", token)
    return Text(said[1:-1])


def _value_at(cursor: Cursor, kind: str, value: str) -> Value:
    token = cursor.advance()
    if kind in GRADES:
        raise cursor.error(
            f'"{value}" compares with others of its kind. A condition has a number: '
            f"a.{GRADES[kind]} > {'3' if kind == 'pace' else '90'}",
            token,
        )
    if kind == "change":
        raise cursor.error(
            f'"{value}" compares with the symbol before. A condition speaks of what is: '
            "a.level = high",
            token,
        )
    if value in RELATIVE:
        raise cursor.error(
            f'"{value}" is a direction for each side: say right or left here.', token
        )
    if value == ANY:
        raise cursor.error('"any" is every direction: there is nothing to compare.', token)
    return Value(kind, value)


def _complaint(cursor: Cursor, said: Comparison) -> str | None:
    """Return why two sides cannot be compared so, or None."""
    (_, left), (_, right) = said.left.terms[0], said.right.terms[0]
    sorts = [sort_of(left), sort_of(right)]
    terms = [term for side in (said.left, said.right) for _, term in side.terms]
    if not any(isinstance(term, Reference) for term in terms):
        return "Neither side speaks of a label, of match or of clip: a.start > 1s"
    if sorts[0] != sorts[1] and set(sorts) not in _AGREE:
        return _unlike(left, right)
    if said.compare not in ("=", "!=") and not all(sort in _ORDERED for sort in sorts):
        noun = next(_NOUNS[sort] for sort in sorts if sort not in _ORDERED)
        return f"{noun.capitalize()} is neither more nor less than another: use = or !="
    text = next((term.text for term in (left, right) if isinstance(term, Text)), None)
    if text is not None and "part" in sorts:
        mover = cursor.vocabulary.mover(text)
        if mover is None or mover.form != "one":
            return cursor.vocabulary.stranger(text, part_expected=True)
    return None


def _unlike(left: Term, right: Term) -> str:
    sorts = [sort_of(left), sort_of(right)]
    number = next((it for it in (right, left) if isinstance(it, Number)), None)
    if number and "time" in sorts:
        return f"{number} what? {number}s is seconds, {number}b beats, {number}f frames."
    text = next((it for it in (right, left) if isinstance(it, Text)), None)
    if text and not {"direction", "level", "feet"}.isdisjoint(sorts):
        return f"Take the quotation marks away: {text.text}"
    value = next((it for it in (right, left) if isinstance(it, Value)), None)
    if value and "clip" in sorts:
        return f'A text has quotation marks: "{value}"'
    return f"{left} is {_NOUNS[sorts[0]]}, {right} is {_NOUNS[sorts[1]]}: they cannot be compared."
