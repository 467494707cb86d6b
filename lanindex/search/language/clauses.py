"""Conditions behind ``where``, and the stages of a pipe: the syntax tree, then how it is read."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction

from lanindex.alphabet import MEASURES
from lanindex.errors import PatternError, guess
from lanindex.search.language.lexer import Cursor, Token
from lanindex.search.language.remedies import broken, remedies, unknown_word
from lanindex.search.language.times import Time, decimal
from lanindex.search.language.words import (
    COUNT,
    LANGUAGE,
    THINGS,
    UNITS,
    VALUES,
    WORD_KINDS,
    Mover,
    values_for,
    with_article,
)

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

_ADDED = ("time", "number", "clip")  # those of which there are sums
_ORDERED = ("time", "number", "level", "text", "clip")  # the types that can be more or less
_COMPARABLE = [{"part", "text"}, {"clip", "text"}, {"clip", "number"}, {"clip", "part"}]
_COLUMNS = ("label", "path", "format", "dataset", "fps", "frames", "seconds", "tempo")  # of a clip


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
        stage = cursor.placed(_stage_at(cursor, bar, counted), begin)
        if counted and stage.verb != "first":
            raise cursor.fault("hits after count", begin, cursor.before)
        counted |= stage.verb == "count"
        yield stage


def _stage_at(cursor: Cursor, bar: Token, counted: bool) -> Stage:
    cursor.expect("stage", *(() if counted else ("count", "sort by")), "first")
    word = cursor.advance() if cursor.token.text in ("count", "sort", "first") else None
    if word is None:
        raise cursor.fault("no stage", bar if cursor.stands("end") else cursor.token)
    if word.text == "first":
        cursor.expect("number", "3")
        is_whole = cursor.stands("number") and cursor.token.text.isdecimal()
        number = int(cursor.number()) if is_whole else 0
        if not number:
            raise cursor.fault("first of none", word, cursor.before)
        return Stage(word.text, most=number)
    if cursor.take("word", "by"):
        _expect_reference(cursor)
        return Stage(word.text, _reference_at(cursor))
    if word.text == "sort":
        raise cursor.fault("no by behind sort", word)
    if cursor.stands("word") and cursor.ahead(1).text == ".":
        raise cursor.fault("no by behind count", word)
    return Stage(word.text)


def conditions_at(cursor: Cursor) -> tuple[Condition, ...]:
    """Read conditions joined by ``and``."""
    conditions: list[Condition] = []
    while not conditions or cursor.take("word", "and"):
        begin = cursor.token
        conditions.append(cursor.placed(_condition_at(cursor), begin))
    return tuple(conditions)


def _condition_at(cursor: Cursor) -> Condition:
    if cursor.token.text in cursor.labels and len(cursor.labels) > 1:
        cursor.expect("word", "mirrors", ahead=1)
    if cursor.token.kind == "word" and cursor.ahead(1).text == "mirrors":
        return _mirrors_at(cursor)
    begin = cursor.token
    left = _sum_at(cursor)
    kind = _type(left.terms[0][1])
    cursor.expect("compare", "=", "!=", *(("<", "<=", ">", ">=") if kind in _ORDERED else ()))
    compares = cursor.token.kind == "compare" or cursor.token.text in ("=", "!=")
    compare = cursor.advance() if compares else None
    if compare is None:
        if cursor.token.text == "mirrors":
            raise cursor.fault("no two labels", begin, cursor.token)
        if cursor.stands("word") or cursor.token.text in ("*", "/"):
            raise cursor.fault("no comparison")
        raise cursor.fault("compared with nothing", begin, cursor.before)
    if (again := cursor.token).text == "=":
        raise cursor.fault("two !=" if compare.text == "!=" else "two =", compare, again)
    right = _sum_at(cursor, _Wanted(kind, isinstance(left.terms[0][1], Reference)))
    types = [_type(side.terms[0][1]) for side in (left, right)]
    things = next((THINGS[it] for it in types if it in THINGS), {})
    comparison = Comparison(_with_things(left, things), compare.text, _with_things(right, things))
    if found := _complaint(cursor, comparison):
        raise cursor.error(found, begin, cursor.before)
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
    cursor.expect("name", *(it for it in cursor.labels if it != first))
    if cursor.token.kind != "word":
        raise cursor.fault("mirrors nothing", cursor.before)
    second = _label_at(cursor)
    if first == second:
        raise cursor.fault("no two labels", cursor.before)
    return Mirrors(first, second)


def _label_at(cursor: Cursor, *others: str) -> str:
    """Read the name of a label, or one of some others."""
    name, labels = cursor.token.text, cursor.labels
    if name in labels or name in others:
        return cursor.advance().text
    rule = "no such label" if labels else "no labels"
    raise cursor.fault(rule, label=name, known=" ".join(labels))


@dataclass(frozen=True, slots=True)
class _Wanted:
    """What a term is compared with or added to."""

    kind: str = ""  # its type; empty: nothing yet
    speaks: bool = True  # whether that is a field, so that this may be a constant
    added: bool = False  # whether this is added to it

    def fits(self, kind: str) -> bool:
        if self.added:
            return kind in _ADDED and {self.kind, kind} != {"time", "number"}
        return self.kind in ("", kind) or {self.kind, kind} in _COMPARABLE


_ANYTHING = _Wanted()


def _expect_reference(cursor: Cursor, wanted: _Wanted = _ANYTHING) -> None:
    fields = [name for name, kind in FIELDS.items() if wanted.fits(kind)]
    columns = _COLUMNS if wanted.fits("clip") else ()
    names = {**dict.fromkeys((*cursor.labels, MATCH), fields), CLIP: columns}
    cursor.expect("field", *(f"{name}." for name, known in names.items() if known))
    if known := names.get(cursor.token.text):
        cursor.expect("mark", ".", ahead=1)
        cursor.expect("field", *known, ahead=2 if cursor.ahead(1).text == "." else 3)


def _reference_at(cursor: Cursor) -> Reference:
    """Read ``a.start``, ``match.length`` or ``clip.label``."""
    token = cursor.token
    name, names = token.text, (*cursor.labels, CLIP, MATCH)
    taken = name in (*LANGUAGE, *VALUES) and name not in (*names, *FIELDS)
    if token.kind != "word" or taken:
        raise cursor.fault("no field")
    if cursor.ahead(1).text != ".":
        raise cursor.error(_no_reference(name, cursor.labels))
    _label_at(cursor, CLIP, MATCH)
    dot, field = cursor.advance(), cursor.token
    if field.kind != "word":
        known = " ".join(FIELDS) if name != CLIP else "clip.label, clip.path or another column"
        raise cursor.fault("no field behind dot", token, dot, known=known)
    if name != CLIP and field.text not in FIELDS:
        near = remedies("meant_field").get(field.text) or guess(field.text, FIELDS)
        rule, known = "field misspelt" if near else "no such field", " ".join(FIELDS)
        raise cursor.fault(rule, name=name, field=field.text, near=near, known=known)
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


def _sum_at(cursor: Cursor, wanted: _Wanted = _ANYTHING) -> Sum:
    first = _term_at(cursor, wanted)
    terms = [(1, first)]
    if _type(first) in _ADDED:
        cursor.expect("mark", "+", "-")
    while cursor.token.text in ("+", "-"):
        sign, begin = cursor.advance(), cursor.token
        term = _term_at(cursor, _Wanted(_type(first), added=True))
        cursor.expect("mark", "+", "-")
        terms.append((1 if sign.text == "+" else -1, term))
        for one in (first, term):
            if _type(one) not in _ADDED:
                noun = _noun(_type(one))
                raise cursor.fault("no sum", begin, cursor.before, term=one, noun=noun)
        if {_type(term), _type(first)} == {"time", "number"}:
            raise cursor.error(_unlike(first, term), begin, cursor.before)
    return Sum(tuple(terms))


def _term_at(cursor: Cursor, wanted: _Wanted) -> Term:
    token, after = cursor.token, cursor.ahead(1)
    _expect_reference(cursor, wanted)
    _expect_constant(cursor, wanted)
    if token.kind == "number":
        timed = after.kind == "word" and after.text in UNITS
        return cursor.time() if timed else Constant("number", cursor.number())
    if token.kind == "string":
        text = cursor.text[token.start : token.stop]
        if len(text) < 2 or not text.endswith('"'):
            raise cursor.fault("open quotation", token)
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
            raise cursor.fault("two parts", cursor.before, parts=mover.members, mover=mover)
        return Constant("text", mover.name)
    if any(token.text in known for known in THINGS.values()):
        return Constant("text", cursor.advance().text)
    raise _no_term(cursor, token)


def _expect_constant(cursor: Cursor, wanted: _Wanted) -> None:
    if not wanted.speaks or not (cursor.ends(0) or cursor.ends(1)):
        return
    if wanted.fits("number"):
        cursor.expect("number", "0.5")
    if wanted.fits("time"):
        cursor.expect("number", "1s")
        cursor.expect("unit", *[*UNITS] * (cursor.token.kind == "number"), ahead=1)
    if wanted.kind in ("", "clip") and not wanted.added:
        cursor.expect("text", '""')
    if wanted.fits("part") and wanted.kind:
        cursor.expect_parts("one")
    for name, (kind, value) in values_for(THINGS if wanted.kind in THINGS else ()).items():
        reasons = remedies("incomparable")
        mover = cursor.vocabulary.mover(name)
        if kind == wanted.kind and not {kind, value} & reasons.keys() and not _is_pair(mover):
            cursor.expect(kind, name)


def _is_pair(mover: Mover | None) -> bool:
    return mover is not None and mover.form != "one"


def _no_term(cursor: Cursor, token: Token) -> PatternError:
    if remedy := remedies("no_term").get(token.text):
        return cursor.error(remedy)
    if token.text in (*cursor.labels, *FIELDS, *_COLUMNS, CLIP, MATCH):
        return cursor.error(_no_reference(token.text, cursor.labels))
    if token.kind == "word" and token.text not in LANGUAGE and not COUNT.fullmatch(token.text):
        return cursor.fault("no quotation", text=cursor.excerpt(token))
    return cursor.fault("no condition", token if token.kind != "end" else cursor.before)


def _complaint(cursor: Cursor, comparison: Comparison) -> str | None:
    """Return why two sides cannot be compared, or None."""
    (_, left), (_, right) = comparison.left.terms[0], comparison.right.terms[0]
    types = [_type(left), _type(right)]
    terms = [term for _, term in (*comparison.left.terms, *comparison.right.terms)]
    if not any(isinstance(it, Reference) for it in terms):
        return broken("no side speaks")
    if types[0] != types[1] and set(types) not in _COMPARABLE:
        return _unlike(left, right)
    unordered = next((it for it in types if it not in _ORDERED), "")
    if comparison.compare not in ("=", "!=") and unordered:
        return broken("no order", noun=_noun(unordered).capitalize())
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
                return broken("time without unit", number=term)
            case Constant("text", text) if not {"direction", "level", "feet"}.isdisjoint(types):
                return f"Take the quotation marks away: {text}"
            case Constant(kind=kind) if kind in WORD_KINDS and "clip" in types:
                return f'A text has quotation marks: "{term}"'
    return f"{left} is {_noun(types[0])}, {right} is {_noun(types[1])}: they cannot be compared."
