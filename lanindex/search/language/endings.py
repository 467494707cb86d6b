"""Read what stands behind a pattern: ``either side``, ``rhythm``, ``where``, and the pipe."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from fractions import Fraction

from lanindex.errors import PatternError
from lanindex.search.language.clauses import Condition, Count, First, Sort, Stage
from lanindex.search.language.cursor import Cursor
from lanindex.search.language.lexer import Token
from lanindex.search.language.measures import decimal_at, whole_at
from lanindex.search.language.mistakes import is_strange, stray
from lanindex.search.language.query import Bracket, Choice, Item, Line, Query
from lanindex.search.language.terms import condition_at, reference_at

_STAGES = "count, count by clip.label, sort by match.start, first 10"

_NOT_IN_WHERE = {
    "or": '"and" joins conditions. "or" joins lines, before "where".',
    "/": 'A condition has one word: a.level >= mid. "/" is for steps.',
    **dict.fromkeys(
        ("<", "<=", ">", ">=", "=", "!="),
        "One comparison in each condition: a.length > 1s and a.length < 2s",
    ),
}
"""What may seem to go on behind a condition."""


class Endings:
    """Reads the clauses and stages behind a pattern.

    Parameters
    ----------
    cursor : Cursor
        Stands behind the pattern.
    pattern : Choice
        What was read.
    labels : collection of str
        Those that stand in it.
    """

    def __init__(self, cursor: Cursor, pattern: Choice, labels: Collection[str]) -> None:
        self.cursor, self.pattern, self.labels = cursor, pattern, labels
        self.seen: list[str] = []
        self.rhythm: tuple[Fraction, ...] = ()
        self.where: tuple[Condition, ...] = ()

    def query(self) -> Query:
        """Read all that is left, and return the whole query.

        Raises
        ------
        PatternError
            It is no clause and no stage, or does not fit the pattern.
        """
        readers = {"either": self._side, "rhythm": self._rhythm, "where": self._where}
        while word := self.cursor.take("word", *readers):
            said = "either side" if word.text == "either" else word.text
            if said in self.seen:
                more = ': "and" joins conditions' if said == "where" else ""
                raise self.cursor.error(f'"{said}" stands once{more}.', word)
            readers[word.text](word)
            self.seen.append(said)
        stages = tuple(self._stages())
        if not self.cursor.stands("end"):
            raise self._stray(bool(stages))
        return Query(self.pattern, "either side" in self.seen, self.rhythm, self.where, stages)

    def _stray(self, piped: bool) -> PatternError:
        cursor = self.cursor
        if piped:
            return cursor.error('Behind a stage comes another one, with a "|", or nothing.')
        if self.seen[-1:] == ["where"] and cursor.token.text in _NOT_IN_WHERE:
            return cursor.error(_NOT_IN_WHERE[cursor.token.text])
        if not self.seen or is_strange(cursor) or cursor.token.kind in ("unknown", "string"):
            return stray(cursor)
        return cursor.error(f'"{self.seen[-1]}" ends the pattern: steps and lines stand before it.')

    def _side(self, begin: Token) -> None:
        if not self.cursor.take("word", "side"):
            raise self.cursor.error('"either side": the pattern or its mirror image.', begin)

    def _rhythm(self, begin: Token) -> None:
        cursor = self.cursor
        numbers = [self._proportion(begin)]
        while cursor.take("mark", ":"):
            numbers.append(self._proportion(cursor.before))
        if len(numbers) == 1:
            raise cursor.error("A rhythm has two numbers or more: 1:2", begin, cursor.before)
        counts = [steps_in(lines.first) for lines in self.pattern.alternatives]
        if not any(least <= len(numbers) <= most for least, most in counts):
            steps = " or ".join(dict.fromkeys(_range(*count) for count in counts))
            raise cursor.error(
                f"{len(numbers)} numbers, but the first line has {steps}: one number each.",
                begin,
                cursor.before,
            )
        self.rhythm = tuple(numbers)

    def _proportion(self, before: Token) -> Fraction:
        token = self.cursor.token
        if token.kind != "number":
            raise self.cursor.error("Numbers go here, one a step: rhythm 1:1:2", before)
        number = decimal_at(self.cursor)
        if not number:
            raise self.cursor.error("No step lasts for nothing: a number above 0.", token)
        return number

    def _where(self, begin: Token) -> None:
        conditions = [condition_at(self.cursor, self.labels)]
        while self.cursor.take("word", "and"):
            conditions.append(condition_at(self.cursor, self.labels))
        self.where = tuple(conditions)

    def _stages(self) -> Iterator[Stage]:
        counted = False
        while bar := self.cursor.take("mark", "|"):
            begin = self.cursor.token
            stage = self._stage(bar)
            if counted and not isinstance(stage, First):
                raise self.cursor.error(
                    'After "count" there are no hits any more: only "first" may follow.',
                    begin,
                    self.cursor.before,
                )
            counted |= isinstance(stage, Count)
            yield stage

    def _stage(self, bar: Token) -> Stage:
        cursor = self.cursor
        word = cursor.take("word", "count", "sort", "first")
        if word is None:
            here = bar if cursor.stands("end") else cursor.token
            raise cursor.error(f'A stage follows "|": {_STAGES}', here)
        if word.text == "first":
            if (number := whole_at(cursor)) is None or not number:
                raise cursor.error("The first how many? first 10", word, cursor.before)
            return First(number)
        if not cursor.take("word", "by"):
            if word.text == "count":
                if cursor.stands("word") and cursor.ahead(1).text == ".":
                    raise cursor.error('"by" is missing: count by clip.label', word)
                return Count()
            raise cursor.error("By what? sort by match.start", word)
        reference = reference_at(cursor, self.labels)
        return Count(reference) if word.text == "count" else Sort(reference)


def steps_in(line: Line) -> tuple[int, float]:
    """Return the fewest and the most steps that a line has, repetitions counted."""
    least, most = 0, 0.0
    for item in line.items:
        few, many = _steps_of(item)
        least, most = least + few, most + many
    return least, most


def _steps_of(item: Item) -> tuple[int, float]:
    least, most = item.repeat.least, item.repeat.most
    few, many = 1, 1.0
    if isinstance(item.unit, Bracket):
        counts = [steps_in(lines.first) for lines in item.unit.pattern.alternatives]
        few, many = min(it[0] for it in counts), max(it[1] for it in counts)
    return least * few, float("inf") if most is None else most * many


def _range(least: int, most: float) -> str:
    if least == most:
        return f"{least} step{'' if least == 1 else 's'}"
    return f"{least} steps or more" if most == float("inf") else f"{least} to {most:.0f} steps"
