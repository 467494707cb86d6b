"""A twin of the matcher that tries everything: every way to write out a line's repeats, every
choice of movements for its steps, every choice of partners; then keeps what the page allows.

It shares nothing with the matcher but the tree of the pattern. Only for small tracks.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction

from plain_conditions import is_true, names_of, symbols_of
from plain_events import Thing, Things

from lanindex.search.language.query import NEXT, ONCE, Bracket, Item, Line, Lines, Step


@dataclass(frozen=True)
class Flat:
    """A line with its repeats written out."""

    steps: tuple = ()  # of (Step, Length | None, place, labels)
    arrows: tuple = ()
    starts: tuple = ()  # of (index, Arrow)
    ends: tuple = ()
    brackets: tuple = ()  # of (first, last, Length | None, companions), inner ones first

    def shifted(self, by, place):
        return Flat(
            tuple((step, length, (*place, *own), said) for step, length, own, said in self.steps),
            self.arrows,
            tuple((index + by, arrow) for index, arrow in self.starts),
            tuple((index + by, arrow) for index, arrow in self.ends),
            tuple((first + by, last + by, *rest) for first, last, *rest in self.brackets),
        )


def joined(flats, arrows):
    """Join flat lines by arrows; each comes with its place."""
    whole = Flat()
    for number, (flat, place) in enumerate(flats):
        part = flat.shifted(len(whole.steps), place)
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
class Check:
    """What must not happen beside a stretch; told at the end, when the whole hit is known."""

    companion: object
    low: int
    high: int
    alone: bool


@dataclass(frozen=True)
class Way:
    """What has been found beside a line."""

    hulls: tuple = ()  # of (first, last, low, high): of the brackets that have closed
    used: frozenset = frozenset()
    fit: float = 1.0
    told: tuple = ()  # of (label, Thing)
    checks: tuple = ()

    def joined(self, other):
        return replace(
            self,
            used=self.used | other.used,
            fit=min(self.fit, other.fit),
            told=self.told + other.told,
            checks=self.checks + other.checks,
        )


@dataclass(frozen=True)
class Found:
    """A line that was found: its things with their places, its hull, what it uses."""

    side: str
    path: tuple
    low: int
    high: int
    used: frozenset
    fit: float
    told: tuple
    checks: tuple

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

    query: object = None
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
        units, copies = (
            [named(it, item.label) for it in self.flat_units(item, side)],
            (item.repeat.copies),
        )
        found = [None] if item.repeat.least == 0 else []
        ways, times = [[]], 0
        while ways and times != item.repeat.most:
            place = (min(times, copies - 1),)
            times += 1
            ways = [[*way, (flat, place)] for way in ways for flat in units]
            ways = [it for it in ways if self.happens(joined(it, [NEXT] * times), side)]
            if times >= item.repeat.least:
                found += [joined(it, [NEXT] * times) for it in ways]
        return found

    def flat_units(self, item: Item, side) -> Iterator[Flat]:
        if isinstance(item.unit, Step):
            yield Flat(((item.unit, item.length, (), ()),))
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
            [(place, thing) for thing in self.things(step, length, side)]
            for step, length, place, _ in flat.steps
        ]

        def extended(path):
            if len(path) == len(choices):
                yield path
                return
            for place, thing in choices[len(path)]:
                if not path or self.leads(path[-1][1], flat.arrows[len(path) - 1], thing):
                    yield from extended((*path, (place, thing)))

        return extended(())

    def paths(self, flat: Flat, side) -> Iterator[tuple]:
        for path in self.chains(flat, side):
            if (
                path[0][1].borders
                and path[-1][1].borders
                and all(self.begins(path[index][1], arrow) for index, arrow in flat.starts)
                and all(self.ends(path[index][1], arrow) for index, arrow in flat.ends)
            ):
                yield path

    def margin(self, path):
        margins = [
            float(self.rows(part)[row]["margin"])
            for _, thing in path
            for part, rows in thing.members
            for row in rows
        ]
        return round(min(margins), 3)

    def with_brackets(self, flat, path, side):
        ways = [Way()]
        for first, last, length, companions in sorted(
            flat.brackets, key=lambda it: (it[1], -it[0])
        ):
            things = [thing for _, thing in path[first : last + 1]]
            alone = first == last and things[0].starting
            if length and (alone or not self.meets(things[-1].end - things[0].start, length)):
                return
            ways = [
                replace(beside, hulls=(*way.hulls, (first, last, low, high)))
                for way in ways
                for low, high, beside in self.beside(companions, path, (first, last), way, False)
            ]
        own = claims_of(path)
        told = tuple(
            (label, thing)
            for (*_, labels), (_, thing) in zip(flat.steps, path, strict=True)
            for label in labels
        )
        for way in ways:
            if not own & way.used:
                low = min([thing.start for _, thing in path] + [it[2] for it in way.hulls])
                high = max([thing.end for _, thing in path] + [it[3] for it in way.hulls])
                fit = min(way.fit, self.margin(path))
                yield Found(
                    *(side, path, low, high, own | way.used, fit, told + way.told, way.checks)
                )

    def beside(self, companions, path, stretch, way, whole) -> Iterator[tuple]:
        """Yield the hull and the way of all that can stand beside a stretch of a path.

        Only of the whole line all labels are told.
        """
        first, last = stretch
        things = [thing for _, thing in path[first : last + 1]]
        before = claims_of(path[: last + 1])
        if before & way.used:
            return
        alone = first == last and things[0].starting
        line = Thing("", (), things[0].start, 0, things[-1].until, False, alone)
        if not alone:
            line = replace(line, until=things[-1].end)
        inner = [(low, high) for a, b, low, high in way.hulls if first <= a and b <= last]
        low = min([thing.start for thing in things] + [low for low, _ in inner])
        high = max([thing.end for thing in things] + [high for _, high in inner])
        ways = [(low, high, way)]
        for companion in companions:
            if companion.relation in ("without", "never"):
                continue
            ways = [
                (*hull_with(companion, low, high, it), one.joined(it))
                for low, high, one in ways
                for it in self.partners(
                    companion, line, before | one.used, one.told if whole else ()
                )
            ]
        for low, high, one in ways:
            checks = tuple(
                Check(companion, low, max(high, line.until), alone)
                for companion in companions
                if companion.relation in ("without", "never")
            )
            yield low, high, replace(one, checks=one.checks + checks)

    def stands(self, companion, line, it):
        """Tell how another line lies to a first one, or to a hit."""
        slack = self.tolerance * self.capture.rate
        start, until, within = line.start, line.until, companion.within
        if companion.relation in ("after", "before"):
            after = companion.relation == "after"
            between = start - it.until if after else it.start - until
            lonely = line.starting or it.alone
            return not lonely and between >= 0 and self.meets(between, within)
        if it.alone and not line.starting:
            return False
        begins, ends = abs(it.start - start) <= slack, abs(it.until - until) <= slack
        shared = start < it.until and it.start < until
        common = min(until, it.until) - max(start, it.start)
        if within:
            apart = 0 if shared else max(it.start - until, start - it.until)
            shared = apart < within.time.frames(self.clock)
        return {
            "with": shared,
            "overlapping": shared and (it.alone or 2 * common >= it.until - it.start),
            "without": shared,
            "never": True,
            "during": it.start <= start and until <= it.until,
            "starting with": begins,
            "ending with": ends,
            "exactly with": begins and ends,
        }[companion.relation]

    def partners(self, companion, line, used, told):
        return longest(
            [
                it
                for it in self.found(companion.line)
                if self.stands(companion, line, it)
                and not it.used & used
                and self.may_hold((*told, *it.told))
            ]
        )

    # What is asked of the whole.

    def symbols(self, told):
        found = {}
        for label, thing in told:
            found.setdefault(label, []).extend(symbols_of(self.tracks, thing))
        return found

    def may_hold(self, told):
        symbols = self.symbols(told)
        return all(
            is_true(condition, self.capture, symbols)
            for condition in self.query.where
            if names_of(condition) <= set(symbols)
        )

    def passes(self, checks, used):
        """Return whether nothing happens that must not, but what uses a symbol of the hit."""
        return not any(
            self.stands(check.companion, check_line(check), it)
            and not it.used & forgiving(used)
            and self.passes(it.checks, it.used)
            for check in checks
            for it in self.found(check.companion.line)
        )

    def in_rhythm(self, path):
        rhythm = self.query.rhythm
        lasted = [thing.end - thing.start for _, thing in path]
        if not rhythm or len(lasted) != len(rhythm):
            return not rhythm
        shares = [Fraction(sum(lasted)) * it / sum(rhythm) for it in rhythm]
        return all(
            share * 3 / 4 <= it <= share * 5 / 4 for it, share in zip(lasted, shares, strict=True)
        )

    def asked_for(self, it):
        last = list(symbols_of(self.tracks, it.path[-1][1]))[-1]
        symbols = {**self.symbols(it.told), "match": [{**last, "start": it.low, "end": it.high}]}
        return (
            self.passes(it.checks, it.used)
            and self.in_rhythm(it.path)
            and all(is_true(it, self.capture, symbols) for it in self.query.where)
        )

    def starts(self, lines: Lines) -> Iterator[tuple]:
        """Yield the first symbols, the span and the fit of all that the page allows."""
        whole = []
        for it in self.found(lines.first):
            if it.alone:
                continue
            last = len(it.path) - 1
            way = Way(
                ((0, last, it.low, it.high),),
                it.used - claims_of(it.path),
                it.fit,
                it.told,
                it.checks,
            )
            for low, high, one in self.beside(lines.others, it.path, (0, last), way, True):
                used = it.used | one.used
                found = replace(it, low=low, high=high, used=used, fit=one.fit, told=one.told)
                found = replace(found, checks=one.checks)
                if self.asked_for(found):
                    whole.append(found)
        for it in longest(whole):
            first = frozenset((part, rows[0]) for part, rows in it.path[0][1].members)
            yield first, (it.low, it.high, it.fit)


def named(flat, label):
    if not label:
        return flat
    return replace(
        flat,
        steps=tuple(
            (step, length, place, (label, *own)) for step, length, place, own in flat.steps
        ),
    )


def claims_of(path):
    return frozenset().union(*(thing.claims for _, thing in path))


def forgiving(claims):
    """What is used, and the movements that led there."""
    return claims | {("move", part, row) for _, part, row in claims}


def hull_with(companion, low, high, it):
    if companion.relation in ("during", "after", "before"):
        return low, high
    return min(low, it.low), max(high, it.high)


def check_line(check):
    return Thing("", (), check.low, check.high, check.high, False, check.alone)


def longest(found: list[Found]) -> list[Found]:
    return [it for it in found if not any(it.goes_on_in(other) for other in found)]


def counted(pattern) -> bool:
    return any(
        item.repeat != ONCE or (isinstance(item.unit, Bracket) and counted(item.unit.pattern))
        for lines in pattern.alternatives
        for line in (lines.first, *(it.line for it in lines.others))
        for item in line.items
    )


def find_plainly(
    query, capture, tracks, tolerance=Fraction(1, 10), overlaps="all"
) -> list[tuple[int, int, float]]:
    """Return the span and the fit of all hits, in order."""
    plain = Plain(capture, tracks, query=query, tolerance=tolerance)
    best = {}
    for pattern in query.patterns:
        for lines in pattern.alternatives:
            for first, (low, high, fit) in plain.starts(lines):
                rank = (high, -low, -fit)
                best[first] = min(best.get(first, rank), rank)
    found = sorted((-low, high, fit) for high, low, fit in best.values())
    found = [(low, high, -fit) for low, high, fit in found]
    if overlaps == "all":
        return found
    if not counted(query.pattern):
        found = [it for it in found if it[0] == max(low for low, high, _ in found if high == it[1])]
    kept, end = [], 0
    for low, high, fit in found:
        if low >= end:
            kept.append((low, high, fit))
            end = high
    return kept
