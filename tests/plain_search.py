"""A twin of the matcher that tries everything: every way to write out a line's repeats, every
choice of movements for its steps, every choice of partners; then keeps what the page allows.

It shares nothing with the matcher but the tree of the pattern. Only for small tracks.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import product

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.search.pattern import NEXT, Bracket, Item, Line, Lines, Step, meaning
from lanindex.search.times import Clock


@dataclass(frozen=True)
class Thing:
    """A movement, stay or rest of one part, or of two together."""

    manner: str
    members: tuple
    start: int
    end: int
    until: int
    passing: bool
    starting: bool

    @property
    def tokens(self):
        return {(self.manner, part, row) for part, rows in self.members for row in rows}


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
class Plain:
    """The twin, on one capture."""

    capture: object
    tracks: dict
    tolerance: Fraction
    lines: dict = field(default_factory=dict)
    known: dict = field(default_factory=dict)

    # What a track holds.

    def rows(self, part):
        return [] if part not in self.tracks else list(self.tracks[part].symbols)

    def shown(self, part):
        return [k for k, row in enumerate(self.rows(part)) if not row["passing"]]

    def stretch(self, part, frame):
        """The known stretch that a frame lies in."""
        for span in self.tracks[part].known:
            if span.start <= frame < span.stop:
                return span
        return None

    def home(self, part, row):
        return self.stretch(part, self.rows(part)[row]["start"])

    def neighbours(self, part, row):
        """The shown rows before and after a shown row, None at the border of a stretch."""
        shown = self.shown(part)
        place = shown.index(row)
        pair = []
        for other in (place - 1, place + 1):
            inside = 0 <= other < len(shown)
            same = inside and self.home(part, shown[other]) == self.home(part, row)
            pair.append(shown[other] if same else None)
        return pair

    def leaves(self, part, row):
        """Until when a shown row's place is kept."""
        after = self.neighbours(part, row)[1]
        rows = self.rows(part)
        return int(rows[after]["start"]) if after is not None else self.home(part, row).stop

    def fits(self, step, part, row):
        rows = self.rows(part)
        fits = DIRECTIONS[rows[row]["direction"]] in meaning(
            step.words, "direction", part
        ) and LEVELS[rows[row]["level"]] in meaning(step.words, "level", part)
        if rows[row]["passing"]:
            words = [it for it in step.words if not it.negated and it.values != ("any",)]
            named = bool(words) and all(it.kind != "change" for it in step.words)
            return fits and named and step.manner == "move"
        before = self.neighbours(part, row)[0]
        change = "neither"
        if before is not None and rows[before]["level"] != rows[row]["level"]:
            change = "rising" if rows[before]["level"] < rows[row]["level"] else "sinking"
        return fits and change in meaning(step.words, "change", part)

    def singles(self, step, part) -> list[Thing]:
        rows = self.rows(part)
        fitting = [k for k in range(len(rows)) if self.fits(step, part, k)]
        return list(getattr(self, f"{step.manner}s")(part, rows, fitting))

    def moves(self, part, rows, fitting):
        for k in fitting:
            start, stop = int(rows[k]["start"]), int(rows[k]["stop"])
            passing = bool(rows[k]["passing"])
            starting = start == stop
            until = max(self.leaves(part, k), start + 1) if starting else stop
            yield Thing("move", ((part, (k,)),), start, stop, until, passing, starting)

    def ats(self, part, rows, fitting):
        for first in fitting:
            if self.neighbours(part, first)[0] in fitting:
                continue
            stay = [first]
            while (after := self.neighbours(part, stay[-1])[1]) in fitting:
                stay.append(after)
            starting = rows[first]["start"] == rows[first]["stop"]
            start, end = int(rows[first]["stop"]) - (not starting), self.leaves(part, stay[-1])
            if start < end:
                yield Thing("at", ((part, tuple(stay)),), start, end, end, False, False)

    def holds(self, part, rows, fitting):
        for k in fitting:
            start, end = int(rows[k]["stop"]), self.leaves(part, k)
            if start < end:
                yield Thing("hold", ((part, (k,)),), start, end, end, False, False)

    def things(self, step, length, side) -> list[Thing]:
        key = (step, length, side)
        if key not in self.known:
            self.known[key] = self.tried(step, length, side)
        return self.known[key]

    def tried(self, step, length, side) -> list[Thing]:
        members = step.mover.members
        if step.mover.form == "either":
            members = [it for it in members if it.startswith(side)]
        found = []
        for chosen in product(*(self.singles(step, part) for part in members)):
            thing = together(chosen) if len(chosen) > 1 else chosen[0]
            if thing is None:
                continue
            if length and (thing.starting or not self.meets(thing.end - thing.start, length)):
                continue
            found.append(thing)
        return found

    def meets(self, frames, length):
        if length is None:
            return True
        clock = Clock(self.capture.rate, self.capture.meter.speed / 60)
        one, two = length.time.frames(clock), (length.last or length.time).frames(clock)
        return {
            "<": frames < one,
            "<=": frames <= one,
            ">": frames > one,
            ">=": frames >= one,
            "+": frames >= one,
            "..": one <= frames <= two,
            "~": one * Fraction(4, 5) <= frames <= one * Fraction(6, 5),
        }[length.form]

    # What an arrow joins.

    def skipped(self, before: Thing, after: Thing):
        """How many shown movements an arrow skips; None where it does not lead."""
        same = [part for part, _ in before.members] == [part for part, _ in after.members]
        counts = []
        for number, (part, rows) in enumerate(after.members):
            if same:
                last = before.members[number][1][-1]
                if self.home(part, last) != self.home(part, rows[0]):
                    return None
                counts.append(self.skipped_same(before, last, after, rows[0], part))
            else:
                counts.append(self.skipped_other(before, after, rows[0], part))
        return counts

    def skipped_same(self, before, last, after, first, part):
        between = [k for k in self.shown(part) if last < k < first]
        if after.manner != "hold":
            return len(between) if first > last else None
        if first == last:
            return 0 if before.manner == "move" else None
        return len(between) + 1 if first > last else None

    def skipped_other(self, before, after, first, part):
        home = self.stretch(part, before.end)
        if home is None or self.home(part, first) != home:
            return None
        rows = self.rows(part)
        beginnings = []
        for k in self.shown(part):
            if self.home(part, k) == home:
                starting = rows[k]["start"] == rows[k]["stop"]
                begin = {
                    "move": None if starting else rows[k]["start"],
                    "at": rows[k]["stop"] - (not starting),
                    "hold": rows[k]["stop"] if rows[k]["stop"] < self.leaves(part, k) else None,
                }[after.manner]
                if begin is not None and begin >= before.end:
                    beginnings.append(k)
        if rows[first]["passing"]:  # it belongs to the movement that it leads to
            first = next(k for k in self.shown(part) if k > first)
        if first not in beginnings:
            return None
        return len([k for k in self.shown(part) if beginnings[0] <= k < first])

    def leads(self, before, arrow, after):
        counts = self.skipped(before, after)
        if after.starting or counts is None or not all(allowed(arrow, it) for it in counts):
            return False
        moving = before.passing and not arrow.later
        return self.meets(0 if moving else max(0, after.start - before.end), arrow.length)

    def begins(self, thing, arrow):
        for part, rows in thing.members:
            if self.home(part, rows[0]) != self.stretch(part, 0):
                return False
            before = [k for k in self.shown(part) if k < rows[0]]
            if thing.manner == "move":
                symbols = self.rows(part)
                before = [k for k in before if symbols[k]["start"] < symbols[k]["stop"]]
            if thing.starting or not allowed(arrow, len(before)):
                return False
        return not thing.passing and self.meets(thing.start, arrow.length)

    def ends(self, thing, arrow):
        for part, rows in thing.members:
            after = [k for k in self.shown(part) if k > rows[-1]]
            if self.home(part, rows[-1]).stop != self.capture.frames:
                return False
            if not allowed(arrow, len(after)):
                return False
        return not thing.passing and self.meets(self.capture.frames - thing.end, arrow.length)

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
        ways = [((), frozenset())]  # hulls of partners with the index where they close, tokens
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
            own = frozenset().union(*(thing.tokens for _, thing in path))
            if not own & used:
                low = min([thing.start for _, thing in path] + [low for *_, low, _ in hulls])
                high = max([thing.end for _, thing in path] + [high for *_, high in hulls])
                yield Found(side, path, low, high, own | used)

    def beside(self, companions, path, first, last, alone, hulls, used):
        """Yield hull and tokens of all that can stand beside a stretch of a path."""
        things = [thing for _, thing in path[first : last + 1]]
        before = frozenset().union(*(thing.tokens for _, thing in path[: last + 1]))
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
                used = it.used - frozenset().union(*(thing.tokens for _, thing in path))
                whole += [
                    replace(it, low=low, high=high, used=it.used | more)
                    for low, high, more in self.beside(
                        lines.others, path, 0, last, False, hulls, used
                    )
                ]
        for it in longest(whole):
            first = frozenset((part, rows[0]) for part, rows in it.path[0][1].members)
            yield first, (it.low, it.high)


def together(chosen):
    one, two = chosen
    start, end = max(one.start, two.start), min(one.until, two.until)
    if start >= end:
        return None
    members = one.members + two.members
    if one.manner != "move":
        return Thing(one.manner, members, start, end, end, False, False)
    return Thing(
        "move",
        members,
        min(one.start, two.start),
        max(one.end, two.end),
        max(one.until, two.until),
        one.passing or two.passing,
        one.starting or two.starting,
    )


def allowed(arrow, count):
    if count is None:
        return False
    if not arrow.later:
        return count == 0
    if arrow.skips is None:
        return True
    wanted = arrow.skips.count
    return {
        "": count == wanted,
        "<": count < wanted,
        "<=": count <= wanted,
        ">": count > wanted,
        ">=": count >= wanted,
    }[arrow.skips.form]


def longest(found: list[Found]) -> list[Found]:
    return [it for it in found if not any(it.goes_on_in(other) for other in found)]


def find_plainly(query, capture, tracks, tolerance=Fraction(1, 10)) -> list[tuple[int, int]]:
    """Return the spans of all hits, in order, as with overlaps allowed."""
    plain = Plain(capture, tracks, tolerance)
    best = {}
    for pattern in query.patterns:
        for lines in pattern.alternatives:
            for first, (low, high) in plain.starts(lines):
                rank = (high, -low)
                best[first] = min(best.get(first, rank), rank)
    return sorted((-low, high) for high, low in best.values())
