"""Pattern text → Query: a method for each rule of the grammar, read from left to right."""

from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import count

from lanindex.alphabet import BENDS, DIRECTION_CODES, DIRECTIONS, KINDS, Kind, amounts_of, kind_of
from lanindex.errors import PatternError, guess, shown
from lanindex.search.dictionary import named_patterns
from lanindex.search.language import query as tree
from lanindex.search.language import words as language
from lanindex.search.language.clauses import conditions_at, stages_at
from lanindex.search.language.lexer import Cursor, Place, Token, ends_in_comment, tokens
from lanindex.search.language.natural import offer_reading
from lanindex.search.language.remedies import broken, is_unknown, no_step, remedies, stray, unknown
from lanindex.search.language.score import FilePattern, is_lnd, score_at
from lanindex.search.language.times import Length, Time
from lanindex.search.language.words import COUNT, Mover, Vocabulary

_LONGEST = 10_000
_DEEPEST = 40
_MOST_STEPS = 1000
_MOST_WORDS = 10_000

_CLAUSES = ("either side", "rhythm", "where")

_ANYONE = Mover("any part", "one", ("r_any",))
"""Stands for the part that each use of a named pattern will give."""


def parse(
    text: str,
    parts: Collection[str] | None = None,
    *,
    names: Mapping[str, str] | None = None,
    strict: bool = False,
) -> tree.Query:
    """Read a pattern that may name `parts`, those of the alphabet, and the patterns in `names`.

    `names` are by default those of the dictionary.

    With `strict` the timing of pasted LND counts. ``str()`` of the result is a pattern again.
    """
    vocabulary = Vocabulary(parts)

    named = named_patterns(text) if names is None else names

    def read(text: str) -> tree.Query:
        return _Parser(text, vocabulary, named, strict).query()

    try:
        if len(text) > _LONGEST:
            found = f"A pattern of {len(text)} characters; {_LONGEST} is the most."
            raise PatternError(found, text=f"{text[:60]}…", start=60, stop=61)
        return read(str(text))
    except PatternError as error:
        offer_reading(error, read)
        if isinstance(text, FilePattern):
            error.place = text.place(error.start)
        raise


def wanted(text: str, vocabulary: Vocabulary, names: Mapping[str, str]) -> dict[str, str]:
    """Return what may stand behind a text, each with its kind; nothing where it is wrong before."""
    if len(text) > _LONGEST or ends_in_comment(text):
        return {}
    parser = _Parser(text, vocabulary, names, strict=False)
    parser.wanted = {}
    with suppress(PatternError):
        parser.query()
    return parser.wanted


def read_places(
    text: str, vocabulary: Vocabulary, names: Mapping[str, str]
) -> tuple[tree.Choice, tree.Query, dict[int, Place]]:
    """Return a pattern as it is written, its query, and where each node was read, by identity."""
    parse(text, vocabulary.parts, names=names)  # raises the errors
    parser = _Parser(text, vocabulary, names, strict=False)
    parser.places = {}
    query = parser.query()
    return parser.written, query, parser.places


@dataclass(frozen=True, slots=True)
class Part:
    """What is in the text and not in the syntax tree as it is written: a clause, or a ``let``."""

    kind: str
    name: str


class _Parser(Cursor):
    """Each rule reads its tokens and returns its node; `carried` and `after` as for `_step_at`."""

    def __init__(
        self, text: str, vocabulary: Vocabulary, names: Mapping[str, str], strict: bool
    ) -> None:
        super().__init__(text, vocabulary)
        self.names, self.strict = names, strict
        self.lets: dict[str, str] = {}  # the text of each pattern, by name
        self.open_names: list[str] = []  # of the patterns that are being read
        self.words_named = self.depth = 0
        self.timed = False
        self.denied = False  # in a line that must not happen

    def query(self) -> tree.Query:
        begin = self.token
        while let := self.take("word", "let"):
            self.let(let)
        if self.stands("end") and self.wanted is None:
            raise self.fault("no pattern")
        self.written = pattern = self.pattern(frozenset())
        if self.strict and not self.timed:
            raise self.fault("nothing timed", begin, self.before)
        query = self.clauses(_without_brackets(pattern) if self.timed else pattern)
        if self.words_named and (length := len(str(query))) > _LONGEST:
            raise self.fault("too long", begin, self.before, length=length, most=_LONGEST)
        return query

    def pattern(self, carried: frozenset[Mover], after: str = "") -> tree.Choice:
        begin = self.token
        alternatives = [self.lines(carried, after)]
        while self.take("word", "or"):
            alternatives.append(self.lines(carried, "or"))
        return self.placed(tree.Choice(tuple(alternatives)), begin)

    def lines(self, carried: frozenset[Mover], after: str) -> tree.Lines:
        begin = self.token
        first = self.line(carried, after)
        others = []
        while word := self.take("word", *language.RELATIONS):
            relation = language.RELATIONS[word.text]
            if relation != word.text and not self.take("word", "with"):
                raise self.fault("no with", word, relation=relation)
            within = self.limit(relation)
            labelled, denied = len(self.labels), self.denied
            self.denied |= relation in ("without", "never")
            line = self.line(frozenset(), relation)
            self.denied = denied
            if relation in ("without", "never"):
                self.refuse_labels(labelled, f'"{relation}": it speaks of what does not happen.')
            others.append(self.placed(tree.Beside(relation, line, within), word))
        return self.placed(tree.Lines(first, tuple(others)), begin)

    def limit(self, relation: str) -> Length | None:
        """Read the limit of a relation, if one stands here: ``after[<1s]``, ``with[1s]``."""
        begin, reason = self.before, remedies("unlimited").get(relation.split()[0])
        if reason and self.token.text == "[":
            raise self.fault("unlimited", begin, self.token, relation=relation, reason=reason)
        opening = None if reason else self.take("mark", "[")
        plain = relation in ("with", "without")
        example = f"{relation}[{'1s' if plain else '<1s'}]"
        if opening is None:
            if self.at_length:
                raise self.fault("time without brackets", example=example)
            return None
        self.expect("number", "1s")
        if not plain:
            self.expect("compare", "<", "<=", ">", ">=")
        if not self.at_length:
            raise self.fault("no time in brackets", opening, example=example)
        if not plain:
            length = self.length()
            self.close(opening)
            return length
        begin = self.token
        time = None if begin.kind == "compare" else self.time()
        if time is None or self.token.text in ("+", ".."):
            raise self.fault("no plain time", relation=relation)
        within = self.placed(Length("<", time), begin)
        self.close(opening)
        if not time.number:
            raise self.fault("no time between", opening, self.before, relation=relation)
        return within

    def close(self, opening: Token) -> None:
        if not self.take("mark", "]"):
            raise self.fault("never closed", opening, mark="]")

    def line(self, carried: frozenset[Mover], after: str) -> tree.Line:
        begin = self.token
        start = None
        if self.take("word", "start") and (start := self.arrow()) is None:
            raise self.fault("no arrow behind start", begin)
        items = [self.item(carried, "start" if start else after)]
        arrows: list[tree.Arrow] = []
        end = None
        while arrow := self.arrow():
            if any(item.repeat.least for item in items):
                self.expect("word", "end")
            if self.token.text == "end":
                self.advance()
                end = arrow
                break
            arrows.append(arrow)
            items.append(self.item(tree.last_movers(items[-1].unit), "->"))
        if not any(item.repeat.least for item in items):
            raise self.fault("all optional", begin, self.before)
        return self.placed(tree.Line(tuple(items), tuple(arrows), start, end), begin)

    def arrow(self) -> tree.Arrow | None:
        """Read an arrow with its limit, if one stands here: ``->``, ``...[<2s]``."""
        begin = self.take("arrow") or self.take("dots")
        if begin is None:
            return None
        later = begin.kind == "dots"
        opening = self.take("mark", "[")
        if opening is None:
            return self.placed(tree.Arrow(later), begin)
        skips = self.skips(later)
        length = None if skips else self.length()
        if skips is None and length is None:
            raise self.fault("no limit in brackets", opening)
        self.close(opening)
        if skips and not later:
            raise self.fault("nothing skipped", begin, self.before, skips=skips)
        return self.placed(tree.Arrow(later, length, skips), begin)

    def skips(self, later: bool) -> Length | None:
        """Read a number of movements, if one stands here: a number that no unit follows."""
        number, unit = self.number_and_unit()
        self.expect_number("1" if later else "1s", *language.UNITS)
        if not number or unit in language.UNITS:
            return None
        begin = self.token
        compare, token = self.take("compare"), self.advance()
        if not number.isdecimal():
            raise self.fault("part of a movement", token)
        time = Time(Fraction(self.checked(token)), "")
        return self.placed(Length(compare.text if compare else "", time), begin)

    def item(self, carried: frozenset[Mover], after: str) -> tree.Item:
        begin, labelled = self.token, len(self.labels)
        label = self.label()
        first = self.token
        unit, timed = self.unit(carried, after)
        length = self.length()
        if length and self.at_length and (token := self.token) and self.length():
            raise self.fault("two lengths", token, self.before)
        item = tree.Item(unit, length or timed, self.repeat(), label)
        if item.repeat != tree.ONCE:
            self.refuse_after_count(first)
            self.refuse_labels(labelled + bool(label), "a repeat: put it before all of it.")
        if (steps := tree.steps_taken(item)) > _MOST_STEPS:
            raise self.fault("too many steps", begin, self.before, steps=steps, most=_MOST_STEPS)
        return self.placed(item, begin)

    def label(self) -> str:
        """Read a label with its colon, if one stands here: ``a:``."""
        if not self.denied:
            self.expect("name", f"{self.free_name(self.labels)}:")
            if self.token.text not in self.labels and not self.taken(self.token.text):
                self.expect("mark", ":", ahead=1)
        if not self.at_label:
            return ""
        label = self.name()
        colon = self.advance()
        if self.at_label:
            raise self.fault("two labels", self.token, self.ahead(1))
        if label.text in self.labels:
            raise self.fault("label again", label, colon, label=label.text)
        self.labels[label.text] = (label, colon)
        return label.text

    def free_name(self, used: Collection[str]) -> str:
        return next(it for it in map(chr, count(ord("a"))) if it not in used)

    def taken(self, word: str) -> str:
        """Return what a word means that cannot be a name; empty where it can."""
        return "a count" if COUNT.fullmatch(word) else self.vocabulary.meaning_of(word)

    def name(self) -> Token:
        token = self.token
        if token.kind != "word":
            raise self.fault("no name", self.before)
        if means := self.taken(token.text):
            raise self.fault("no free name", name=self.excerpt(token), means=means)
        return self.advance()

    def refuse_labels(self, before: int, where: str) -> None:
        """Refuse labels since a place, where they would be ambiguous."""
        for name, place in list(self.labels.items())[before:]:
            raise self.error(f'The label "{name}" stands inside {where}', *place)

    def repeat(self) -> tree.Repeat:
        """Read a count, if one stands here: ``x3``, ``x3+``, ``x2..3``, ``?``."""
        begin = self.token
        if self.take("mark", "?"):
            return self.placed(tree.Repeat(0, 1), begin)
        self.expect("count", "x2")
        counted = COUNT.fullmatch(begin.text) if begin.kind == "word" else None
        if counted is None:
            return tree.ONCE
        self.advance()
        least = int(self.checked(begin, counted[1]))
        if self.take("mark", "+"):
            return self.placed(tree.Repeat(least, None), begin)
        most = least
        if self.take("range"):
            self.expect("number", str(least + 1))
            number = self.take("number")
            if number is None or not number.text.isdecimal():
                raise self.fault("no second count", begin, self.before)
            most = int(self.checked(number))
            if most < least:
                raise self.fault("more to less", begin, self.before, right=f"x{most}..{least}")
        if most == 0:
            raise self.fault("x0", begin, self.before)
        return self.placed(tree.Repeat(least, most), begin)

    def refuse_after_count(self, begin: Token) -> None:
        """Refuse a length or another count after a count, since it is ambiguous."""
        counted, token = self.excerpt(begin, self.before), self.token
        if token.kind == "end":
            return
        rule = "length after count" if self.length() else "count after count"
        if self.token is not token or self.repeat() != tree.ONCE:
            again = self.excerpt(token, self.before)
            raise self.fault(rule, token, self.before, counted=counted, again=again)

    def unit(
        self, carried: frozenset[Mover], after: str
    ) -> tuple[tree.Step | tree.Bracket, Length | None]:
        """Read a step or a bracket, with the length that a line of LND has."""
        begin = self.token
        if word := self.take("word", "mirror"):
            if not self.stands("mark", "("):
                raise self.fault("no bracket behind mirror", word)
            # who carries into the bracket stays who it is: mirrored twice
            inner = self.bracket(frozenset(it.mirrored() for it in carried))
            return self.placed(tree.mirrored(inner), begin, "mirror", inner), None
        if self.stands("mark", "("):
            return self.bracket(carried), None
        self.expect("movement", *self.usable(carried))
        if self.token.text == "@":
            return self.placed(self.named(carried), begin, "named"), None
        if is_lnd(self):
            self.timed = True
            unit, timed = score_at(self, self.strict)
            return self.placed(unit, begin, "score"), timed
        return self.placed(_step_at(self, carried, after), begin), None

    def bracket(self, carried: frozenset[Mover]) -> tree.Bracket:
        opening = self.advance()
        self.deepen(opening)
        if self.token.text == ")":
            raise self.fault("empty brackets", opening, self.token)
        pattern = self.pattern(carried)
        if not self.take("mark", ")"):
            raise (
                self.fault("never closed", opening, mark=")") if self.stands("end") else stray(self)
            )
        self.depth -= 1
        return self.placed(tree.Bracket(pattern), opening)

    def deepen(self, opening: Token) -> None:
        self.depth += 1
        if self.depth > _DEEPEST:
            raise self.fault("too deep", opening, most=_DEEPEST)

    def let(self, let: Token) -> None:
        """Read ``let NAME = pattern ;``; each use reads it again, as a part may carry into it."""
        self.expect("name", f"{self.free_name(self.lets)} =")
        token = self.name()
        name = token.text
        if name in self.lets:
            raise self.fault("let again", token, name=name)
        if not self.take("mark", "="):
            raise self.fault("no = in let", let, token, name=name)
        begin = self.token
        self.open_names.append(name)
        self.pattern(frozenset((_ANYONE,)), "=")
        self.open_names.pop()
        if not self.stands("mark", ";"):
            ends = self.stands("end")
            raise self.fault("no ; behind let", let, self.before) if ends else stray(self)
        self.lets[name] = self.text[begin.start : self.before.stop]
        self.advance()
        self.placed(Part("let", name), let)
        self.labels.clear()

    def named(self, carried: frozenset[Mover]) -> tree.Bracket:
        """Read ``@NAME``: its pattern, in brackets."""
        at = self.advance()
        self.deepen(at)
        labelled = len(self.labels)
        name, text = self.pattern_behind(at)
        outside = self.text, self.tokens, self.index
        self.text, self.tokens, self.index = text, tokens(text), 0
        self.open_names.append(name)
        try:
            pattern = self.pattern(carried)
            if not self.stands("end"):
                raise stray(self)
        except PatternError as error:
            self.text, self.tokens, self.index = outside
            quote = self.excerpt(at, self.before)
            lacks_part = error.found == broken("no part")
            rule = "pattern without a part" if lacks_part else "fault in a pattern"
            raise self.fault(rule, at, self.before, quote=quote, found=error.found) from error
        self.text, self.tokens, self.index = outside
        self.open_names.pop()
        for label in list(self.labels)[labelled:]:
            self.labels[label] = (at, self.before)
        self.depth -= 1
        return tree.Bracket(pattern)

    def usable(self, carried: frozenset[Mover]) -> Iterator[str]:
        """Yield the patterns that may be named here, if this is the end that is asked about."""
        if not self.ends(0):
            return
        outside = self.typed, self.index, self.depth, self.labels, self.open_names
        for name in (*self.lets, *self.names):
            if name in self.lets:
                self.tokens, self.index, self.labels = tokens(f"@{name}"), 0, dict(outside[3])
                self.open_names = [*outside[4]]
                with suppress(PatternError):
                    self.named(carried)
                    yield f"@{name}"
                self.tokens, self.index, self.depth, self.labels, self.open_names = outside
            elif name not in self.open_names:
                yield f"@{name}"

    def pattern_behind(self, at: Token) -> tuple[str, str]:
        """Read a name behind ``@``, and return it with the text of its pattern."""
        token = self.token
        if token.kind != "word":
            raise self.fault("no name behind @", at)
        name = self.advance().text
        if name in self.open_names:
            raise self.fault("pattern in itself", at, token, name=name)
        if self.token.text == "." and self.ahead(1).text in ("lq", "lnd"):
            raise self.fault("file in a pattern", at, self.ahead(1))
        if text := self.lets.get(name) or self.names.get(name):
            self.words_named += len(tokens(text))
            if self.words_named > _MOST_WORDS:
                raise self.fault("too many words", at, token, most=_MOST_WORDS)
            return name, text
        near = guess(name, [*self.lets, *self.names])
        rule = "pattern misspelt" if near else "no such pattern"
        raise self.fault(rule, at, token, name=name, near=near, short=shown(name, 20))

    def clauses(self, pattern: tree.Choice) -> tree.Query:
        """Read the clauses and stages, and return the query."""
        query = tree.Query(pattern)
        seen: list[str] = []
        several = max(tree.steps_in(lines.first)[1] for lines in pattern.alternatives) > 1
        while word := self.clause(seen, several):
            name = "either side" if word.text == "either" else word.text
            if name in seen:
                raise self.fault("where again" if name == "where" else "again", word, name=name)
            seen.append(name)
            if name == "where":
                query = replace(query, where=conditions_at(self))
            elif name == "rhythm":
                query = replace(query, rhythm=self.rhythm(word, pattern))
            elif self.take("word", "side"):
                query = replace(query, either_side=True)
            else:
                raise self.fault("either without side", word)
            self.placed(Part("clause", name), word)
        query = replace(query, stages=tuple(stages_at(self)))
        token = self.token
        if token.kind == "end":
            return query
        if query.stages:
            raise self.fault("behind a stage")
        remedy = remedies("behind_condition").get(token.text)
        if seen[-1:] == ["where"] and remedy:
            raise self.error(remedy)
        if not seen or is_unknown(self) or token.kind in ("unknown", "string"):
            raise stray(self)
        raise self.fault("behind a clause", clause=seen[-1])

    def clause(self, seen: Collection[str], several: bool) -> Token | None:
        """Read the first word of a clause, if one stands here; `several`: it may have a rhythm."""
        left = [it for it in _CLAUSES if it not in seen and (several or it != "rhythm")]
        self.expect("clause", *left)
        first = {it.split()[0] for it in _CLAUSES}
        return self.advance() if self.token.text in first else None

    def rhythm(self, begin: Token, pattern: tree.Choice) -> tuple[Fraction, ...]:
        numbers: list[Fraction] = []
        counts = [tree.steps_in(lines.first) for lines in pattern.alternatives]
        while not numbers or self.take("mark", ":"):
            token = self.token
            self.expect("number", "1")
            if token.kind != "number":
                raise self.fault("no rhythm", self.before)
            numbers.append(self.number())
            if not numbers[-1]:
                raise self.fault("step of no length", token)
        if len(numbers) == 1:
            raise self.fault("rhythm of one", begin, self.before)
        if not any(least <= len(numbers) <= most for least, most in counts):
            steps = " or ".join(dict.fromkeys(_number_of_steps(*count) for count in counts))
            raise self.fault("other rhythm", begin, self.before, numbers=len(numbers), steps=steps)
        return tuple(numbers)


def _number_of_steps(least: int, most: float) -> str:
    if least == most:
        return f"{least} step{'' if least == 1 else 's'}"
    return f"{least} steps or more" if most == float("inf") else f"{least} to {most:.0f} steps"


def _without_brackets(pattern: tree.Choice) -> tree.Choice:
    """Return the pattern inside the brackets, if it is nothing but a bracket."""
    unit = pattern.alternatives[0].first.items[0].unit
    alone = tree.Choice((tree.Lines(tree.Line((tree.Item(unit),))),))
    return unit.pattern if isinstance(unit, tree.Bracket) and pattern == alone else pattern


# Steps: who moves, how, and the words, which must agree with each other.

_STAYING = {"at": "at is being there"} | dict.fromkeys(language.RESTS, "hold is staying put")
_ANGLE = "90deg"  # stands for all angles
_EXAMPLES = {"feet": "jump", "bend": "r_arm"}  # by kind of words, a part to name


def _step_at(cursor: Cursor, carried: frozenset[Mover], after: str) -> tree.Step:
    """Read a step.

    `carried` is who moved last, one or several alternatives; `after` is what comes before the
    step: ``->``, a relation, ``or``, ``start`` or nothing.
    """
    _check_meant(cursor, carried)
    cursor.expect_parts()
    named = cursor.mover()
    for mover in carried if not named and len(carried) == 1 else ():
        _expect_manners(cursor, mover)
        cursor.expect("word", "not")
        _expect_words(cursor, _fitting(cursor, mover, "move", ()))
    known = {*language.MANNERS, "not", *_values(*carried)}
    if named:
        mover = named
    elif (cursor.token.kind == "word" and cursor.token.text in known) or cursor.at_angle:
        mover = _carried(cursor, carried, after)
    else:
        raise no_step(cursor, after)
    _expect_manners(cursor, mover)
    bending = _bending(cursor, mover)
    mover = bending or mover
    token = cursor.advance() if cursor.token.text in language.MANNERS else None
    manner = token.text if token else "move"
    if rule := _wrong_manner(manner, mover):
        raise cursor.fault(rule, cursor.before, mover=mover)
    words = _words(cursor, mover, manner)
    remedy = remedies("no_words").get(manner)
    if remedy and not words:
        raise cursor.error(remedy, cursor.before)
    return tree.Step(mover, bool(named or bending), manner, words)


def _wrong_manner(manner: str, mover: Mover) -> str:
    """Return the rule that a manner of a mover breaks; empty: none."""
    if manner == "at" and not language.THINGS.keys().isdisjoint(_kind(mover).words):
        return "no stay"
    return "no swings" if manner == language.STILL and _kind(mover).name != "gesture" else ""


def _expect_manners(cursor: Cursor, mover: Mover) -> None:
    manners = [it for it in language.MANNERS if not _wrong_manner(it, mover)]
    cursor.expect("manner", *manners)


def _fitting(
    cursor: Cursor,
    mover: Mover,
    manner: str,
    words: tuple[tree.Word, ...],
    begun: tree.Word | None = None,
) -> Iterator[tuple[str, str]]:
    """Yield the kind and the text of each word that may follow others of a step.

    Nothing but angles, perhaps, away from the end; `begun` is the word with which ``/`` goes on.
    """
    at_end = cursor.ends(0)
    if not (at_end or cursor.ends(1) or cursor.ends(2)):
        return
    known = _values(mover) if at_end else {}
    limb = None if words else _limb(cursor, mover)
    negated = begun.negated if begun else cursor.before.text == "not"
    for name, (kind, value) in (*known.items(), (_ANGLE, ("degrees", _ANGLE))):
        if begun and (kind != begun.kind or (value in begun.values and kind != "bend")):
            continue
        word = tree.Word(kind, (*(begun.values if begun else ()), value), negated)
        bends = limb and value.split()[0] in language.BEND_MOVES
        if not _complaint((*words, word), limb if limb and bends else mover, manner):
            yield kind, name


def _expect_words(cursor: Cursor, fitting: Iterator[tuple[str, str]]) -> None:
    for kind, name in fitting:
        if name == _ANGLE:
            cursor.expect_number(name, language.DEGREES)
        else:
            cursor.expect(kind, name)


def _kind(mover: Mover) -> Kind:
    return KINDS[kind_of(mover.members[0])]


def _values(*movers: Mover) -> Mapping[str, tuple[str, str]]:
    """Return the words that are understood of some movers, as in `VALUES`."""
    return language.values_for({kind for mover in movers for kind in _kind(mover).words})


def _check_meant(cursor: Cursor, carried: frozenset[Mover]) -> None:
    """Refuse a bare word that may name a part, or the thing that a carried part touches."""
    word, after = cursor.token.text, cursor.ahead(1)
    goes_on = after.kind == "word" and after.text in (*language.MANNERS, "not", *language.VALUES)
    goes_on |= cursor.vocabulary.mover(word, after.text) is not None or cursor.ends(1)
    if word in _values(*carried) and cursor.vocabulary.mover(word) and not goes_on:
        (mover, *_) = carried
        raise cursor.fault("word or part", mover=mover, word=word)


def _carried(cursor: Cursor, carried: frozenset[Mover], after: str) -> Mover:
    if len(carried) == 1:
        return next(iter(carried))
    word = cursor.token.text
    if carried:
        names = ", ".join(sorted(mover.name for mover in carried))
        raise cursor.fault("several parts before", names=names)
    if part := _EXAMPLES.get(language.VALUES.get(word, ("", ""))[0]):
        raise cursor.error(f"Name the part first: {part} {word}")
    if remedy := remedies("no_part").get(after):
        raise cursor.error(remedy)
    raise cursor.fault("no part carried" if after else "no part", after=after)


def _bending(cursor: Cursor, mover: Mover) -> Mover | None:
    """Return the elbow or knee that the words are about: ``r_arm bend``, ``r_arm at bent``."""
    manner = cursor.token.text if cursor.token.text in language.MANNERS else ""
    ahead = int(bool(manner))
    ahead += cursor.ahead(ahead).text == "not"
    kind, value = language.VALUES.get(cursor.ahead(ahead).text, ("", ""))
    moves = manner in _STAYING or value.split(" ")[0] in language.BEND_MOVES
    if kind != "bend" or not moves or cursor.ahead(1).text == ":":
        return None
    return _limb(cursor, mover)


def _limb(cursor: Cursor, mover: Mover) -> Mover | None:
    """Return the elbow or knee of an arm or leg."""
    return cursor.vocabulary.of(mover.form, tuple(BENDS.get(it, "") for it in mover.members))


def _words(cursor: Cursor, mover: Mover, manner: str) -> tuple[tree.Word, ...]:
    words: list[tree.Word] = []
    checked: list[tree.Word] = []  # without repeated denials, so that a long line takes no longer
    _expect_words(cursor, _fitting(cursor, mover, manner, ()))
    while (_at_value(cursor, mover) or cursor.stands("word", "not")) and not cursor.at_label:
        begin = cursor.token
        negated = cursor.take("word", "not") is not None
        _expect_words(cursor, _fitting(cursor, mover, manner, tuple(checked)))
        if not _at_value(cursor, mover):
            raise _no_value(cursor, "not without a word")
        words.append(_word(cursor, mover, manner, tuple(checked), begin))
        if not (negated and words[-1] in checked):
            checked.append(words[-1])
            if found := _complaint(tuple(checked), mover, manner):
                raise cursor.error(found, begin, cursor.before)
        _expect_words(cursor, _fitting(cursor, mover, manner, tuple(checked)))
    number, unit = cursor.number_and_unit()
    if number and unit not in language.UNITS and "degrees" in _kind(mover).words:
        cursor.expect_number("1s", *language.UNITS)
        raise cursor.fault("angle without unit", number=number)
    for kind in language.THINGS.keys() & _kind(mover).words:
        if not words and is_unknown(cursor):
            noun, known = language.WORD_KINDS[kind].noun, " ".join(language.WORD_KINDS[kind].codes)
            raise cursor.fault("no such thing", noun=noun, word=cursor.token.text, known=known)
    return tuple(words)


def _at_value(cursor: Cursor, mover: Mover) -> bool:
    token = cursor.token
    return token.text in _values(mover) if token.kind == "word" else cursor.at_angle


def _value(cursor: Cursor, mover: Mover) -> tuple[str, str]:
    """Read a word or an angle: its kind, and its own spelling."""
    if cursor.at_angle:
        return "degrees", str(cursor.length((language.DEGREES,)))
    kind, value = _values(mover)[cursor.advance().text]
    has_degree = kind == "bend" and value in ("bend", "stretch", "bent")
    if has_degree and "bend" in _kind(mover).words:
        cursor.expect_number("3", *language.UNITS)
    degree = cursor.sixths() if has_degree else ""
    return kind, f"{value} {degree}".rstrip()


def _word(
    cursor: Cursor, mover: Mover, manner: str, words: tuple[tree.Word, ...], begin: Token
) -> tree.Word:
    """Read a word with its alternatives, behind other words; `begin`: it may be ``not``."""
    head, negated = cursor.token, begin.text == "not"
    kind, value = _value(cursor, mover)
    values = [value]
    while True:
        begun = tree.Word(kind, tuple(values), negated)
        if cursor.ends(0) and any(_fitting(cursor, mover, manner, words, begun)):
            cursor.expect("mark", "/")
        if cursor.token.text != "/":
            return cursor.placed(begun, begin)
        cursor.advance()
        _expect_words(cursor, _fitting(cursor, mover, manner, words, begun))
        if not _at_value(cursor, mover):
            raise _no_value(cursor, "/ without a word")
        first = cursor.token
        other, value = _value(cursor, mover)
        if other != kind:
            both = f"{head.text} {cursor.excerpt(first, cursor.before)}"
            raise cursor.fault("/ of two kinds", head, cursor.before, both=both)
        values.append(value)


def _no_value(cursor: Cursor, rule: str) -> PatternError:
    if is_unknown(cursor):
        return unknown(cursor)
    if cursor.token.kind == "word" and cursor.vocabulary.mover(cursor.token.text):
        return cursor.fault("part for a word")
    return cursor.fault(rule, cursor.before)


def _complaint(words: tuple[tree.Word, ...], mover: Mover, manner: str) -> str | None:
    """Return what is wrong with the last word, or None."""
    word, noun = words[-1], language.WORD_KINDS[words[-1].kind].noun
    kind, part = _kind(mover), mover.members[0]
    bends = word.kind == "bend" and word.values[0].split()[0] in language.BEND_MOVES
    cannot = f'"{word}" cannot be said of {mover.name}:'
    if word.kind not in kind.words and word.values != (language.ANY,):
        return f"{cannot} {language.with_article(kind.name)} has no {noun}."
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
    if manner in _STAYING and word.kind in language.MOVING:
        return f'{_STAYING[manner]}: say a direction or a level, not "{word.values[0]}".'
    if manner in _STAYING and bends:
        return f'{_STAYING[manner]}: say bent, bent 3+ or straight, not "{word}".'
    sideless = {it for it in language.RELATIVE if kind.name == "gesture" or it.startswith("across")}
    if not mover.sided and sideless.intersection(word.values):
        return f"The {mover.name} has no side of its own: say right or left."
    limited = word.kind == "direction" and kind.directions != DIRECTIONS
    reached = (language.codes_of("direction", value, part) for value in word.values)
    if limited and any(it.isdisjoint(map(DIRECTION_CODES.get, kind.directions)) for it in reached):
        return f"{cannot} it goes {' or '.join(kind.directions)}."
    if not tree.meaning(words, word.kind, part):
        return f'"{word}" leaves nothing: there is no {noun} that would match.'
    return None
