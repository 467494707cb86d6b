"""A twin of the matcher that tries everything: every way to write out a line's repeats, every
choice of movements for its steps, every choice of partners; then keeps what the page allows.

It shares nothing with the matcher but the tree of the pattern. Only for small tracks.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction

from plain_things import Things

from lanindex.search.language.query import NEXT, Bracket, Item, Line, Lines, Step


@dataclass(frozen=True)
class Flat:
    """A line with its repeats written out."""

    steps: tuple = ()  # of (Step, Length | None, label)
    arrows: tuple = ()
    starts: tuple = ()  # of (index, Arrow)
    ends: tuple = ()
    brackets: tuple = ()  # of (first, last, Length | None, companions), inner ones first

    def shifted(self, by, label):
        return Flat(
            tuple((step, length, (*label, *own)) for step, length, own in self.steps),
            self.arrows,
            tuple((index + by, arrow) for index, arrow in self.starts),
            tuple((index + by, arrow) for index, arrow in self.ends),
            tuple((first + by, last + by, *rest) for first, last, *rest in self.brackets),
        )


def joined(flats, arrows):
    """Join flat lines by arrows; each comes with its label."""
    whole = Flat()
    for number, (flat, label) in enumerate(flats):
        part = flat.shifted(len(whole.steps), label)
        whole = Flat(
            whole.steps + part.steps,
            whole.arrows + ((arrows[number - 1],) if number else ()) + part.arrows,
            whole.starts + part.starts,
            whole.ends + part.ends,
            whole.brackets + part.brackets,
        )
    return whole


def sides_of(line: Line) -> tuple:
    def unsided(line):
        for item in line.items:
            if isinstance(item.unit, Bracket):
                yield from (
                    it for lines in item.unit.pattern.alternatives for it in unsided(lines.first)
                )
            else:
                yield item.unit.mover.form == "either"

    return ("r_", "l_") if any(unsided(line)) else ("r_",)


@dataclass(frozen=True)
class Found:
    """A line that was found: its things with their labels, its hull, what it uses."""

    side: str
    path: tuple
    low: int
    high: int
    used: frozenset

    @property
    def start(self):
        return self.path[0][1].start

    @property
    def alone(self):
        return len(self.path) == 1 and self.path[0][1].starting

    @property
    def until(self):
        return self.path[-1][1].until if self.alone else self.path[-1][1].end

    def goes_on_in(self, other):
        return (
            self.side == other.side
            and len(self.path) < len(other.path)
            and other.path[: len(self.path)] == self.path
        )


@dataclass
class Plain(Things):
    """The twin, on one capture."""

    tolerance: Fraction = Fraction(1, 10)
    lines: dict = field(default_factory=dict)

    # Lines.

    def flat_lines(self, line: Line, side) -> Iterator[Flat]:
        """Yield a line's ways to be written out that can happen at all."""
        ways = [[]]
        for number, item in enumerate(line.items):
            flats = self.flat_items(item, side)
            ways = [
                longer
                for way in ways
                for flat in flats
                for longer in [[*way, (number, flat)] if flat else way]
                if not longer or self.happens(self.chosen(line, longer), side)
            ]
        for way in filter(None, ways):
            flat = self.chosen(line, way)
            first = way[0][0]
            if line.start:
                arrow = line.arrows[first - 1] if first else line.start
                flat = replace(flat, starts=(*flat.starts, (0, arrow)))
            if line.end:
                flat = replace(flat, ends=(*flat.ends, (len(flat.steps) - 1, line.end)))
            yield flat

    def chosen(self, line, way):
        arrows = [line.arrows[number - 1] for number, _ in way[1:]]
        return joined([(flat, (number,)) for number, flat in way], arrows)

    def flat_items(self, item: Item, side) -> list:
        units, copies = list(self.flat_units(item, side)), item.repeat.copies
        found = [None] if item.repeat.least == 0 else []
        ways, times = [[]], 0
        while ways and times != item.repeat.most:
            label = (min(times, copies - 1),)
            times += 1
            ways = [[*way, (flat, label)] for way in ways for flat in units]
            ways = [it for it in ways if self.happens(joined(it, [NEXT] * times), side)]
            if times >= item.repeat.least:
                found += [joined(it, [NEXT] * times) for it in ways]
        return found

    def flat_units(self, item: Item, side) -> Iterator[Flat]:
        if isinstance(item.unit, Step):
            yield Flat(((item.unit, item.length, ()),))
            return
        for number, lines in enumerate(item.unit.pattern.alternatives):
            for flat in self.flat_lines(lines.first, side):
                flat = flat.shifted(0, (number,))
                bracket = (0, len(flat.steps) - 1, item.length, lines.others)
                yield replace(flat, brackets=(*flat.brackets, bracket))

    def happens(self, flat, side):
        return any(True for _ in self.chains(flat, side))

    def found(self, line: Line) -> list[Found]:
        if line not in self.lines:
            self.lines[line] = [
                found
                for side in sides_of(line)
                for flat in self.flat_lines(line, side)
                for path in self.paths(flat, side)
                for found in self.with_brackets(flat, path, side)
            ]
        return self.lines[line]

    def chains(self, flat: Flat, side) -> Iterator[tuple]:
        """Yield all things that follow each other as the arrows say."""
        choices = [
            [(label, thing) for thing in self.things(step, length, side)]
            for step, length, label in flat.steps
        ]

        def extended(path):
            if len(path) == len(choices):
                yield path
                return
            for label, thing in choices[len(path)]:
                if not path or self.leads(path[-1][1], flat.arrows[len(path) - 1], thing):
                    yield from extended((*path, (label, thing)))

        return extended(())

    def paths(self, flat: Flat, side) -> Iterator[tuple]:
        for path in self.chains(flat, side):
            if (
                not (path[0][1].passing or path[-1][1].passing)
                and all(self.begins(path[index][1], arrow) for index, arrow in flat.starts)
                and all(self.ends(path[index][1], arrow) for index, arrow in flat.ends)
            ):
                yield path

    def with_brackets(self, flat, path, side):
        ways = [((), frozenset())]  # hulls of partners with the index where they close, claims
        for first, last, length, companions in sorted(
            flat.brackets, key=lambda it: (it[1], -it[0])
        ):
            things = [thing for _, thing in path[first : last + 1]]
            alone = first == last and things[0].starting
            if length and (alone or not self.meets(things[-1].end - things[0].start, length)):
                return
            ways = [
                ((*hulls, (first, last, low, high)), used | more)
                for hulls, used in ways
                for low, high, more in self.beside(
                    companions, path, first, last, alone, hulls, used
                )
            ]
        for hulls, used in ways:
            own = frozenset().union(*(thing.claims for _, thing in path))
            if not own & used:
                low = min([thing.start for _, thing in path] + [low for *_, low, _ in hulls])
                high = max([thing.end for _, thing in path] + [high for *_, high in hulls])
                yield Found(side, path, low, high, own | used)

    def beside(self, companions, path, first, last, alone, hulls, used):
        """Yield hull and claims of all that can stand beside a stretch of a path."""
        things = [thing for _, thing in path[first : last + 1]]
        before = frozenset().union(*(thing.claims for _, thing in path[: last + 1]))
        if before & used:
            return
        start, until = things[0].start, things[-1].until if alone else things[-1].end
        inner = [(low, high) for a, b, low, high in hulls if first <= a and b <= last]
        low = min([thing.start for thing in things] + [low for low, _ in inner])
        high = max([thing.end for thing in things] + [high for _, high in inner])
        ways = [(low, high, frozenset())]
        for companion in companions:
            if companion.relation == "without":
                continue
            ways = [
                (
                    low if companion.relation == "during" else min(low, it.low),
                    high if companion.relation == "during" else max(high, it.high),
                    more | it.used,
                )
                for low, high, more in ways
                for it in self.partners(companion, start, until, alone, before | used | more)
            ]
        for low, high, more in ways:
            if not any(
                companion.relation == "without"
                and it.start < high
                and low < it.until
                and (alone or not it.alone)
                and not it.used & (before | used | more)
                for companion in companions
                for it in self.found(companion.line)
            ):
                yield low, high, more

    def partners(self, companion, start, until, alone, used):
        slack = self.tolerance * self.capture.rate
        holds = {
            "with": lambda it: start < it.until and it.start < until,
            "during": lambda it: it.start <= start and until <= it.until,
            "starting with": lambda it: abs(it.start - start) <= slack,
            "ending with": lambda it: abs(it.until - until) <= slack,
            "exactly with": lambda it: (
                abs(it.start - start) <= slack and abs(it.until - until) <= slack
            ),
        }[companion.relation]
        fit = [
            it
            for it in self.found(companion.line)
            if holds(it) and (alone or not it.alone) and not it.used & used
        ]
        return longest(fit)

    def starts(self, lines: Lines) -> Iterator[tuple]:
        """Yield the first symbols and the span of all that the page allows."""
        whole = []
        for it in self.found(lines.first):
            if not it.alone:
                path, last = it.path, len(it.path) - 1
                hulls = ((0, last, it.low, it.high),)
                used = it.used - frozenset().union(*(thing.claims for _, thing in path))
                whole += [
                    replace(it, low=low, high=high, used=it.used | more)
                    for low, high, more in self.beside(
                        lines.others, path, 0, last, False, hulls, used
                    )
                ]
        for it in longest(whole):
            first = frozenset((part, rows[0]) for part, rows in it.path[0][1].members)
            yield first, (it.low, it.high)


def longest(found: list[Found]) -> list[Found]:
    return [it for it in found if not any(it.goes_on_in(other) for other in found)]


def find_plainly(query, capture, tracks, tolerance=Fraction(1, 10)) -> list[tuple[int, int]]:
    """Return the spans of all hits, in order, as with overlaps allowed."""
    plain = Plain(capture, tracks, tolerance=tolerance)
    best = {}
    for pattern in query.patterns:
        for lines in pattern.alternatives:
            for first, (low, high) in plain.starts(lines):
                rank = (high, -low)
                best[first] = min(best.get(first, rank), rank)
    return sorted((-low, high) for high, low in best.values())
