"""Events and arrows of the language, found by trying every row."""

from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import product

from lanindex.alphabet import CARRIERS, FEET, TOUCHED
from lanindex.model.columns import LIMITS
from lanindex.search.language.query import meaning
from lanindex.search.language.times import Clock

AMOUNTS = {"feet": FEET, "degrees": (), "bend": (), "touched": TOUCHED, "carrier": CARRIERS}
"""What the amounts of symbols are called, by the kind of the word; of degrees their number."""

MEASURED = {"pace": "speed", "extent": "size"}
SINKING, NEITHER, RISING = range(3)


def grade(part, name, value):
    """Return 0 for slow and small, 1, 2 for fast and large; -1 where it was not measured."""
    group = part.removeprefix("r_").removeprefix("l_")
    if value < 0 or group not in LIMITS:
        return -1
    low, high = LIMITS[group][name]
    value = round(value, 2)
    return 0 if value < low else 2 if value > high else 1


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
    via: bool = False

    @property
    def borders(self):
        """Whether a line may begin or end with it."""
        return self.via or not self.passing

    @property
    def claims(self):
        return {(self.manner, part, row) for part, rows in self.members for row in rows}


@dataclass
class Things:
    """The movements, stays and rests of one capture."""

    capture: object
    tracks: dict
    known: dict = field(default_factory=dict)

    @property
    def clock(self):
        return Clock(self.capture.rate, self.capture.meter.speed / 60)

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
        direction, level = rows[row]["direction"], rows[row]["level"]
        fits = direction in meaning(step.words, "direction", part)
        fits = fits and level in meaning(step.words, "level", part)
        for kind in AMOUNTS:
            if any(word.kind == kind for word in step.words):
                fits = fits and rows[row]["amount"] in meaning(step.words, kind, part)
        for kind, name in MEASURED.items():
            if any(word.kind == kind for word in step.words):
                told = grade(part, name, float(rows[row][name]))
                fits = fits and told in meaning(step.words, kind, part)
        fits = fits and not (step.manner == "still" and rows[row]["swings"])
        if rows[row]["passing"] and step.manner == "via":
            return fits and NEITHER in meaning(step.words, "change", part)
        if rows[row]["passing"]:
            words = [it for it in step.words if not it.negated and it.values != ("any",)]
            named = bool(words) and all(it.kind != "change" for it in step.words)
            return fits and named and step.manner == "move"
        before = self.neighbours(part, row)[0]
        change = NEITHER if level >= 0 else -1
        if before is not None and -1 not in (level, rows[before]["level"]):
            if rows[before]["level"] < level:
                change = RISING
            if rows[before]["level"] > level:
                change = SINKING
        return fits and change in meaning(step.words, "change", part)

    def singles(self, step, part) -> list[Thing]:
        rows = self.rows(part)
        fitting = [k for k in range(len(rows)) if self.fits(step, part, k)]
        manner = "hold" if step.manner == "still" else step.manner
        return list(getattr(self, f"{manner}s")(part, rows, fitting))

    def moves(self, part, rows, fitting):
        for k in fitting:
            start, stop = int(rows[k]["start"]), int(rows[k]["stop"])
            passing = bool(rows[k]["passing"])
            starting = start == stop
            until = max(self.leaves(part, k), start + 1) if starting else stop
            yield Thing("move", ((part, (k,)),), start, stop, until, passing, starting)

    def vias(self, part, rows, fitting):
        for thing in self.moves(part, rows, fitting):
            yield replace(thing, via=True)

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
        one = length.time.frames(self.clock)
        two = (length.last or length.time).frames(self.clock)
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
        between = [k for k in self.shown(part) if beginnings[0] <= k < first]
        return len([k for k in between if after.manner != "at" or self.stays(part, k)])

    def stays(self, part, row):
        """Whether a shown row alone is a stay."""
        symbol = self.rows(part)[row]
        return symbol["start"] < symbol["stop"] or symbol["stop"] < self.leaves(part, row)

    def leads(self, before, arrow, after):
        counts = self.skipped(before, after)
        if after.starting or counts is None or not all(allowed(arrow, it) for it in counts):
            return False
        same = [part for part, _ in before.members] == [part for part, _ in after.members]
        moving = before.passing and same and not arrow.later
        return self.meets(0 if moving else max(0, after.start - before.end), arrow.length)

    def begins(self, thing, arrow):
        for part, rows in thing.members:
            if self.home(part, rows[0]) != self.stretch(part, 0):
                return False
            before = [k for k in self.shown(part) if k < rows[0]]
            if thing.manner == "move":
                symbols = self.rows(part)
                before = [k for k in before if symbols[k]["start"] < symbols[k]["stop"]]
            elif not arrow.later and thing.start > 0:
                return False
            if thing.manner == "at":
                before = [k for k in before if self.stays(part, k)]
            if thing.starting or not allowed(arrow, len(before)):
                return False
        return thing.borders and self.meets(thing.start, arrow.length)

    def ends(self, thing, arrow):
        for part, rows in thing.members:
            after = [k for k in self.shown(part) if k > rows[-1]]
            if self.home(part, rows[-1]).stop != self.capture.frames:
                return False
            if not allowed(arrow, len(after)):
                return False
        return not thing.passing and self.meets(self.capture.frames - thing.end, arrow.length)


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
        one.via,
    )


def allowed(arrow, count):
    if count is None:
        return False
    if not arrow.later:
        return count == 0
    if arrow.skips is None:
        return True
    wanted = arrow.skips.time.number
    return {
        "": count == wanted,
        "<": count < wanted,
        "<=": count <= wanted,
        ">": count > wanted,
        ">=": count >= wanted,
    }[arrow.skips.form]
