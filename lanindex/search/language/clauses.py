"""Conditions behind ``where``, and the stages of a pipe: the syntax tree, then how it is read."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction

from lanindex.alphabet import MEASURES
from lanindex.errors import PatternError, guess
from lanindex.search.language.lexer import COUNT, Cursor, Token, remedies, unknown_word
from lanindex.search.language.times import Time, decimal
from lanindex.search.language.words import LANGUAGE, THINGS, UNITS, VALUES, WORD_KINDS, with_article

CLIP, MATCH = "clip", "match"
"""What has fields besides labels: the capture, and all that matched."""

FIELDS = {
    **{"part": "part", "direction": "direction", "level": "level"},
    **{"start": "time", "end": "time", "length": "time"},
    **{"swings": "number", "margin": "number", "else": "direction", "degrees": "number"},
    **{"feet": "feet", "bend": "number", "touched": "touched", "carrier": "carrier"},
    **dict.fromkeys(MEASURES, "number"),
}
"""The fields of a label and of `MATCH`, with their types; `CLIP` has the capture's columns."""


@dataclass(frozen=True, slots=True)
class Reference:
    """A field of a labelled step, of ``match`` or of ``clip``: ``a.start``."""

    name: str
    field: str

    def __str__(self) -> str:
        return f"{self.name}.{self.field}"


@dataclass(frozen=True, slots=True)
class Constant:
    """A bare number, a text in quotation marks, a part, or a word: ``right``, ``mid``, ``hop``."""

    kind: str  # number, text (parts, too), or a key of `words.WORD_KINDS`
    value: str | Fraction

    def __str__(self) -> str:
        if isinstance(self.value, Fraction):
            return decimal(self.value)
        return f'"{self.value}"' if self.kind == "text" else self.value


Term = Reference | Time | Constant


@dataclass(frozen=True, slots=True)
class Sum:
    """Terms with their signs, 1 or -1."""

    terms: tuple[tuple[int, Term], ...]

    def __str__(self) -> str:
        text = "".join(f" {'+' if sign > 0 else '-'} {term}" for sign, term in self.terms)
        return text.removeprefix(" + ")


@dataclass(frozen=True, slots=True)
class Comparison:
    """Two sums compared: ``b.start - a.end < 0.5s``."""

    left: Sum
    compare: str
    right: Sum

    def __str__(self) -> str:
        return f"{self.left} {self.compare} {self.right}"


@dataclass(frozen=True, slots=True)
class Mirrors:
    """Two labels that mirror each other, symbol by symbol."""

    first: str
    second: str

    def __str__(self) -> str:
        return f"{self.first} mirrors {self.second}"


Condition = Comparison | Mirrors


@dataclass(frozen=True, slots=True)
class Stage:
    """A step of the pipe behind a pattern: ``count``, ``count by``, ``sort by``, ``first 3``."""

    verb: str  # count, sort or first
    by: Reference | None = None  # the field to count or sort by
    most: int = 0  # of first, how many are kept

    def __str__(self) -> str:
        return f"{self.verb}{f' by {self.by}' * bool(self.by)}{f' {self.most}' * bool(self.most)}"


# Reading.

_ORDERED = ("time", "number", "level", "text", "clip")  # the types that can be more or less
_COMPARABLE = [{"part", "text"}, {"clip", "text"}, {"clip", "number"}, {"clip", "part"}]
_COLUMNS = ("label", "path", "format", "dataset", "fps", "frames", "seconds", "tempo")  # of a clip

_TWO_LABELS = "Two labels: a mirrors b"


def _type(term: Term) -> str:
    match term:
        case Reference(name=name, field=field):
            return "clip" if name == CLIP else FIELDS[field]
        case Constant(kind=kind):
            return kind
    return "time"


def _noun(kind: str) -> str:
    if kind == "clip":
        return "a text or a number"
    return with_article(WORD_KINDS[kind].noun if kind in WORD_KINDS else kind)


def stages_at(cursor: Cursor) -> Iterator[Stage]:
    """Read all stages."""
    counted = False
    while bar := cursor.take("mark", "|"):
        begin = cursor.token
        stage = _stage_at(cursor, bar)
        if counted and stage.verb != "first":
            found = 'After "count" there are no hits any more: only "first" may follow.'
            raise cursor.error_since(begin, found)
        counted |= stage.verb == "count"
        yield stage


def _stage_at(cursor: Cursor, bar: Token) -> Stage:
    word = cursor.take("word", "count", "sort", "first")
    if word is None:
        found = 'A stage follows "|": count, count by clip.label, sort by match.start, first 10'
        raise cursor.error(found, bar if cursor.stands("end") else cursor.token)
    if word.text == "first":
        is_whole = cursor.stands("number") and cursor.token.text.isdecimal()
        number = int(cursor.number()) if is_whole else 0
        if not number:
            raise cursor.error_since(word, "The first how many? first 10")
        return Stage(word.text, most=number)
    if cursor.take("word", "by"):
        return Stage(word.text, _reference_at(cursor))
    if word.text == "sort":
        raise cursor.error("By what? sort by match.start", word)
    if cursor.stands("word") and cursor.ahead(1).text == ".":
        raise cursor.error('"by" is missing: count by clip.label', word)
    return Stage(word.text)


def conditions_at(cursor: Cursor) -> tuple[Condition, ...]:
    """Read conditions joined by ``and``."""
    conditions: list[Condition] = []
    while not conditions or cursor.take("word", "and"):
        conditions.append(_condition_at(cursor))
    return tuple(conditions)


def _condition_at(cursor: Cursor) -> Condition:
    if cursor.token.kind == "word" and cursor.ahead(1).text == "mirrors":
        return _mirrors_at(cursor)
    begin = cursor.token
    left = _sum_at(cursor)
    compare = cursor.take("compare") or cursor.take("mark", "=", "!=")
    if compare is None:
        if cursor.stands("word", "mirrors"):
            raise cursor.error(_TWO_LABELS, begin, cursor.token)
        if cursor.stands("word") or cursor.token.text in ("*", "/"):
            raise cursor.error("Here goes =, !=, <, <=, > or >=: a.level = high")
        raise cursor.error_since(begin, "Compared with what? a.level = high")
    if again := cursor.take("mark", "="):
        remedy = "Write != once." if compare.text == "!=" else 'One "=" is enough.'
        raise cursor.error(remedy, compare, again)
    right = _sum_at(cursor)
    types = [_type(side.terms[0][1]) for side in (left, right)]
    things = next((THINGS[it] for it in types if it in THINGS), {})
    comparison = Comparison(_with_things(left, things), compare.text, _with_things(right, things))
    if found := _complaint(cursor, comparison):
        raise cursor.error_since(begin, found)
    return comparison


def _with_things(side: Sum, things: dict[str, tuple[str, str]]) -> Sum:
    """Return a side in which a text is read as the thing that it is compared with."""
    match side.terms:
        case ((sign, Constant("text", str(text))),) if text in things:
            return Sum(((sign, Constant(*things[text])),))
    return side


def _mirrors_at(cursor: Cursor) -> Mirrors:
    first = _label_at(cursor)
    cursor.advance()
    if cursor.token.kind != "word":
        raise cursor.error("Another label follows: a mirrors b", cursor.before)
    second = _label_at(cursor)
    if first == second:
        raise cursor.error(_TWO_LABELS, cursor.before)
    return Mirrors(first, second)


def _label_at(cursor: Cursor, *others: str) -> str:
    """Read the name of a label, or one of some others."""
    name, labels = cursor.token.text, cursor.labels
    if name in labels or name in others:
        return cursor.advance().text
    known = f"There is: {' '.join(labels)}"
    known = known if labels else f"It stands before a step: {name}: r_arm high"
    raise cursor.error(f'There is no label "{name}". {known}')


def _reference_at(cursor: Cursor) -> Reference:
    """Read ``a.start``, ``match.length`` or ``clip.label``."""
    token = cursor.token
    name, names = token.text, (*cursor.labels, CLIP, MATCH)
    taken = name in (*LANGUAGE, *VALUES) and name not in (*names, *FIELDS)
    if token.kind != "word" or taken:
        raise cursor.error("Of what? match.start, match.length, clip.label, or a label: a.start")
    if cursor.ahead(1).text != ".":
        raise cursor.error(_no_reference(name, cursor.labels))
    _label_at(cursor, CLIP, MATCH)
    dot, field = cursor.advance(), cursor.token
    if field.kind != "word":
        known = " ".join(FIELDS) if name != CLIP else "clip.label, clip.path or another column"
        raise cursor.error(f"A field follows: {known}", token, dot)
    if name != CLIP and field.text not in FIELDS:
        near = remedies("meant_field").get(field.text) or guess(field.text, FIELDS)
        meant = f"Did you mean {name}.{near}?" if near else f"It has: {' '.join(FIELDS)}"
        raise cursor.error(f'"{name}" has no "{field.text}". {meant}')
    return Reference(name, cursor.advance().text)


def _no_reference(name: str, labels: Iterable[str]) -> str:
    """Return the sentence about a name that no dot follows."""
    if name in FIELDS:
        label = next(iter(labels), "")
        return f'"{name}" of what? match.{name}' + (f", {label}.{name}" if label else "")
    if name in _COLUMNS:
        return f'"{name}" of what? clip.{name}'
    if name in labels or name in (CLIP, MATCH):
        return f"What of it? {name}.{'label' if name == CLIP else 'start'}"
    return f'"{name}" of what? match.start, clip.label, or a label: a.start'


def _sum_at(cursor: Cursor) -> Sum:
    first = _term_at(cursor)
    terms = [(1, first)]
    while sign := cursor.take("mark", "+", "-"):
        begin = cursor.token
        term = _term_at(cursor)
        terms.append((1 if sign.text == "+" else -1, term))
        for one in (first, term):
            if _type(one) not in ("time", "number", "clip"):
                only = "only times and numbers have a sum."
                raise cursor.error_since(begin, f'"{one}" is {_noun(_type(one))}: {only}')
        if {_type(term), _type(first)} == {"time", "number"}:
            raise cursor.error_since(begin, _unlike(first, term))
    return Sum(tuple(terms))


def _term_at(cursor: Cursor) -> Term:
    token, after = cursor.token, cursor.ahead(1)
    if token.kind == "number":
        timed = after.kind == "word" and after.text in UNITS
        return cursor.time() if timed else Constant("number", cursor.number())
    if token.kind == "string":
        text = cursor.text[token.start : token.stop]
        if len(text) < 2 or not text.endswith('"'):
            raise cursor.error("These quotation marks are never closed.", token)
        cursor.advance()
        return Constant("text", text[1:-1])
    if after.text == "." and token.kind == "word":
        return _reference_at(cursor)
    if token.kind == "word" and token.text in VALUES:
        kind, value = VALUES[cursor.advance().text]
        reasons = remedies("incomparable")
        if found := reasons.get(kind) or reasons.get(value):
            raise cursor.error(f'"{value}" {found}', token)
        return Constant(kind, value)
    if mover := cursor.mover():
        if mover.form != "one":
            right, left = mover.members
            found = f'One part is meant: {right} or {left}. "{mover}" is none by itself.'
            raise cursor.error(found, cursor.before)
        return Constant("text", mover.name)
    if any(token.text in known for known in THINGS.values()):
        return Constant("text", cursor.advance().text)
    raise _no_term(cursor, token)


def _no_term(cursor: Cursor, token: Token) -> PatternError:
    if remedy := remedies("no_term").get(token.text):
        return cursor.error(remedy)
    if token.text in (*cursor.labels, *FIELDS, *_COLUMNS, CLIP, MATCH):
        return cursor.error(_no_reference(token.text, cursor.labels))
    if token.kind == "word" and token.text not in LANGUAGE and not COUNT.fullmatch(token.text):
        text = cursor.excerpt(token)
        meant = f'A text has quotation marks: clip.label = "{text}"'
        return cursor.error(f'I don\'t know "{text}". {meant}')
    sentence = 'A condition goes here: a.start > 2s, a.level = high, clip.label = "wave"'
    return cursor.error(sentence, token if token.kind != "end" else cursor.before)


def _complaint(cursor: Cursor, comparison: Comparison) -> str | None:
    """Return why two sides cannot be compared, or None."""
    (_, left), (_, right) = comparison.left.terms[0], comparison.right.terms[0]
    types = [_type(left), _type(right)]
    terms = [term for _, term in (*comparison.left.terms, *comparison.right.terms)]
    if not any(isinstance(it, Reference) for it in terms):
        return "Neither side speaks of a label, of match or of clip: a.start > 1s"
    if types[0] != types[1] and set(types) not in _COMPARABLE:
        return _unlike(left, right)
    unordered = next((it for it in types if it not in _ORDERED), "")
    if comparison.compare not in ("=", "!=") and unordered:
        noun = _noun(unordered).capitalize()
        return f"{noun} is neither more nor less than another: use = or !="
    for term in (left, right):
        if isinstance(term, Constant) and set(types) == {"part", "text"}:
            mover = cursor.vocabulary.mover(str(term.value))
            if mover is None or mover.form != "one":
                return unknown_word(cursor.vocabulary, str(term.value), part_expected=True)
    return None


def _unlike(left: Term, right: Term) -> str:
    """Return why two terms of different types cannot be compared or added up."""
    types = [_type(left), _type(right)]
    for term in (right, left):
        match term:
            case Constant(kind="number") if "time" in types:
                return f"{term} what? {term}s is seconds, {term}b beats, {term}f frames."
            case Constant("text", text) if not {"direction", "level", "feet"}.isdisjoint(types):
                return f"Take the quotation marks away: {text}"
            case Constant(kind=kind) if kind in WORD_KINDS and "clip" in types:
                return f'A text has quotation marks: "{term}"'
    return f"{left} is {_noun(types[0])}, {right} is {_noun(types[1])}: they cannot be compared."
