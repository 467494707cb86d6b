"""Random patterns, by Hypothesis and by the grammar, and random tracks to find them in."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from fractions import Fraction
from random import Random

from hypothesis import strategies as st

from lanindex.alphabet import (
    DIRECTION_CODES,
    KINDS,
    LEVEL_CODES,
    Kind,
    amounts_of,
    is_limb,
    kind_of,
)
from lanindex.errors import PatternError
from lanindex.model import Capture, Meter, Span, Track
from lanindex.model.columns import Columns, columns_of
from lanindex.model.symbol import blank
from lanindex.search.language import parse

FRAMES = 24
PARTS = ("r_arm", "l_arm", "head")
NAMES = ("r_arm", "r_arm", "l_arm", "arm", "arm", "arms", "head")
DIRECTIONS = ("right", "left", "place")

CAPTURE = Capture(1, "made.lnd", "lnd", "0" * 64, "", Fraction(10), FRAMES, Meter(Fraction(120)))


@st.composite
def _row_times(draw, begin: int, end: int) -> list[tuple[int, int, bool]]:
    """Return a starting position and some rows; a passing one lies inside the row after it."""
    rows, now = [(begin, begin, False)], begin
    while now < end and len(rows) < 7 and draw(st.integers(0, 4)):
        start = now + draw(st.integers(0, 3))
        stop = start + draw(st.integers(1, 4))
        if stop > end:
            break
        if stop - start > 1 and not draw(st.integers(0, 2)):
            middle = draw(st.integers(start, stop - 2))
            rows.append((middle, draw(st.integers(middle + 1, stop)), True))
        rows.append((start, stop, False))
        now = stop
    return rows


@st.composite
def tracks(draw, part: str) -> Track:
    """Return a track of one or two known stretches."""
    known = [Span(0, FRAMES)]
    if not draw(st.integers(0, 3)):
        begin, gap = draw(st.integers(0, 2)), draw(st.integers(6, 14))
        known = [Span(begin, gap), Span(gap + 2, draw(st.integers(gap + 4, FRAMES)))]
    times = [row for span in known for row in draw(_row_times(span.start, span.stop))]
    rows = blank(len(times))
    for row, (start, stop, passing) in zip(rows, times, strict=True):
        row["start"], row["stop"], row["passing"] = start, stop, passing
        row["direction"] = DIRECTION_CODES[draw(st.sampled_from(DIRECTIONS))]
        row["level"] = draw(st.integers(0, 2))
        row["margin"] = draw(st.integers(0, 100)) / 100
    return Track(part, rows, tuple(known))


@st.composite
def recordings(draw) -> tuple[Capture, dict[str, Track]]:
    """Return a capture with the tracks of both arms and mostly a head."""
    parts = PARTS if draw(st.integers(0, 3)) else PARTS[:2]
    return CAPTURE, {part: draw(tracks(part)) for part in parts}


def _any_of(*texts: str) -> st.SearchStrategy[str]:
    return st.sampled_from(texts)


_word = _any_of(
    *("low", "mid", "high", "low", "high", "low/high", "not low", "right", "left", "any"),
    *("right/place", "rising", "sinking", "not rising", "side", "across", "right high"),
    *("place low", "left mid", "not right low"),
)
_length = _any_of("<0.3s", "2f+", "<=3f", "0.2s..0.5s", ">1b", "300ms", ">=0.1s", "1s")
_repeat = _any_of("x2", "x1+", "x2+", "x0+", "x1..2", "x0..2", "?", "?")
_arrow = _any_of(
    *("->", "->", "->", "->", "...", "...", "->[<0.3s]", "...[<0.5s]", "...[1]", "...[<=1]"),
    *("...[>0]", "->[2f+]", "then"),
)
_relation = _any_of(
    *("with", "with", "overlapping", "during"),
    *("starting with", "ending with", "exactly with", "without"),
)
_seldom = st.integers(0, 6).map(lambda number: number == 0)


@st.composite
def _steps(draw, named: bool) -> str:
    said = [draw(st.sampled_from(NAMES))] if named or draw(_seldom) else []
    manner = draw(_any_of("", "", "", "", "at", "hold"))
    words = draw(_word) if not (manner == "hold" and draw(st.booleans())) else ""
    return " ".join(filter(None, [*said, manner, words]))


def steps_of(part: str) -> st.SearchStrategy[str]:
    """Return single movements of a part."""
    return _word.map(lambda word: f"{part} {word}")


@st.composite
def _items(draw, named: bool, depth: int, most: int) -> str:
    if depth and draw(_seldom):
        inner = draw(patterns(depth - 1, named, most))
        unit = f"mirror({inner})" if draw(_seldom) else f"({inner})"
    else:
        unit = draw(_steps(named))
    length = draw(_length) if draw(_seldom) else ""
    repeat = draw(_repeat) if draw(_seldom) else ""
    return " ".join(filter(None, [unit, length, repeat]))


@st.composite
def lines(draw, depth: int = 2, named: bool = True, most: int = 3) -> str:
    """Return one line."""
    said = [f"start {draw(_arrow)}"] if draw(st.integers(0, 9)) == 0 else []
    said.append(draw(_items(named, depth, most)))
    for _ in range(draw(st.integers(0, most - 1))):
        said += [draw(_arrow), draw(_items(False, depth, most))]
    return " ".join([*said, *([f"{draw(_arrow)} end"] if draw(st.integers(0, 9)) == 0 else [])])


@st.composite
def patterns(draw, depth: int = 2, named: bool = True, most: int = 3) -> str:
    """Return a pattern; not all of them make sense."""
    said = [draw(lines(depth, named, most))]
    for _ in range(draw(st.integers(0, 2)) // 2):
        said += ["or", draw(lines(depth, True, most))]
    for _ in range(draw(_any_of("", "", " ", "  ")).count(" ")):
        said += [draw(_relation), draw(lines(depth, True, min(most, 2)))]
    return " ".join(said)


def one_symbol(
    part: str,
    direction: str,
    level: str,
    margin: float = 1.0,
    runner: tuple[str, str] | None = None,
) -> Columns:
    """Return the columns of one capture in which a part makes one movement."""
    rows = blank(1)
    rows["direction"], rows["level"] = DIRECTION_CODES[direction], LEVEL_CODES[level]
    rows["start"], rows["stop"], rows["margin"] = 2, 5, margin
    if runner:
        rows["runner_direction"] = DIRECTION_CODES[runner[0]]
        rows["runner_level"] = LEVEL_CODES[runner[1]]
    return columns_of(part, [CAPTURE], [Track(part, rows, (Span(0, FRAMES),))])


_BARE_STEPS = ("low", "right mid", "place high", "any", "left", "rising", "not low", "mid/high")
_WAY = ("right low", "right mid", "right high", "place high")


@st.composite
def bare_lines(draw, part: str = "r_arm") -> str:
    """Return one part's steps with arrows between, and nothing else."""
    drawn = st.lists(st.sampled_from(_BARE_STEPS), min_size=1, max_size=4)
    steps = draw(drawn | st.sampled_from((_WAY, _WAY[1:])))
    arrows = [draw(st.sampled_from((" -> ", " ... "))) for _ in steps[1:]]
    return f"{part} " + "".join(map("".join, zip(steps, [*arrows, ""], strict=True)))


CONSTRUCTS: dict[str, float] = {
    # how steps go on
    "->": 0.7,
    "...": 0.25,
    "limit": 0.2,
    "skips": 0.15,
    "start": 0.06,
    "end": 0.06,
    "another part": 0.12,
    # what a step is
    "at": 0.12,
    "hold": 0.1,
    "still": 0.3,
    "via": 0.1,
    "not": 0.1,
    "/": 0.15,
    "any": 0.1,
    "changes": 0.1,
    "measures": 0.12,
    "relative": 0.12,
    "either": 0.2,
    "both": 0.12,
    "lnd": 0.03,
    # what a step is made of, and how often
    "bracket": 0.15,
    "mirror": 0.15,
    "length": 0.15,
    "repeat": 0.12,
    "open repeat": 0.3,
    "optional": 0.06,
    # lines beside
    "or": 0.1,
    "with": 0.2,
    "within": 0.25,
    "overlapping": 0.07,
    "during": 0.07,
    "starting with": 0.05,
    "ending with": 0.05,
    "exactly with": 0.05,
    "after": 0.07,
    "before": 0.07,
    "without": 0.1,
    "never": 0.07,
    # names, clauses, stages
    "labels": 0.25,
    "let": 0.1,
    "either side": 0.1,
    "rhythm": 0.06,
    "where": 0.5,
    "mirrors": 0.3,
    "stages": 0.1,
}
"""Whatever a pattern may have or lack, and how likely it is to be taken where it could stand."""

RELATIONS = (
    *("with", "overlapping", "during", "starting with", "ending with", "exactly with"),
    *("after", "before", "without", "never"),
)
RELATIVE = ("side", "side_forward", "side_back", "across", "across_forward", "across_back")
LEVELS = ("low", "mid", "high")
AMOUNTS = {
    "touched": ("trunk", "knee", "arms"),
    "carrier": ("seat", "other", "knees"),
    "feet": ("spring", "hop", "leap"),
    "bend": ("bent", "straight", "bent 3+", "bent 1..2", "bent <5", "bent 4"),
    "degrees": ("90deg", "<=90deg", ">45deg", "100deg..400deg", "112deg+", "68deg"),
}
MEASURED = {"pace": ("fast", "slow"), "extent": ("large", "small")}
FIELDS = {
    "time": ("start", "end", "length"),
    "number": ("swings", "margin"),
    "part": ("part",),
    "direction": ("direction", "else"),
    "level": ("level",),
}


def random_pattern(
    random: Random,
    *,
    parts: Sequence[str] = ("r_arm", "l_arm", "head"),
    directions: Sequence[str] = ("right", "left", "forward", "place"),
    steps: int = 6,
    avoid: Collection[str] = (),
    only: Collection[str] | None = None,
    more: Mapping[str, float] | None = None,
) -> str:
    """Return a pattern that parses.

    Parameters
    ----------
    random : Random
        Where chance comes from.
    parts : sequence of str
        Who may move; of two sides also ``arm`` and ``arms``.
    directions : sequence of str
        Which may be named, besides those that are relative to a side.
    steps : int
        About how many movements it names at most.
    avoid : collection of str
        Of `CONSTRUCTS`: what it shall not have.
    only : collection of str, optional
        Of `CONSTRUCTS`: all that it may have.
    more : Mapping of str to float, optional
        Other chances, by construct.

    Returns
    -------
    str
    """
    chances = {**CONSTRUCTS, **(more or {})}
    unknown = {*avoid, *(only or ()), *(more or ())} - set(CONSTRUCTS)
    assert not unknown, f"no such constructs: {unknown}"
    for name in set(CONSTRUCTS) - set(CONSTRUCTS if only is None else only) | set(avoid):
        chances[name] = 0
    while True:  # what one step says may contradict itself, as "not low not mid not high" does
        text = Grammar(random, parts, directions, steps, chances).query()
        try:
            parse(text)
        except PatternError:
            continue
        return text


def random_patterns(seed: int, count: int, **how: object) -> Iterator[str]:
    """Yield so many patterns; the rest is as for `random_pattern`."""
    random = Random(seed)
    for _ in range(count):
        yield random_pattern(random, **how)  # type: ignore[arg-type]


class Grammar:
    """One method a rule; each returns text."""

    def __init__(
        self,
        random: Random,
        parts: Sequence[str],
        directions: Sequence[str],
        steps: int,
        chances: Mapping[str, float],
    ) -> None:
        self.random, self.parts, self.chances = random, tuple(parts), chances
        self.directions = tuple(directions)
        self.left = steps
        # of its own, so that all else is as without it
        self.apart = Random(sum(random.getstate()[1]))
        self.fields = FIELDS
        if not all(map(is_limb, parts)):
            numbers = (*FIELDS["number"], "degrees", "bend")
            self.fields = {**FIELDS, "number": numbers, "feet": ("feet",)}
        self.labels: list[str] = []
        self.lets: list[str] = []
        self.labelled = True

    def takes(self, name: str) -> bool:
        return self.random.random() < self.chances[name]

    def one(self, *texts: str) -> str:
        return self.random.choice(texts)

    # query, clauses and stages

    def query(self) -> str:
        said = [self.let()] if self.takes("let") else []
        said.append(self.pattern("", 2))
        clauses = ["either side"] if self.takes("either side") else []
        if self.takes("rhythm"):
            clauses.append(f"rhythm {':'.join(self.one('1', '2', '1.5') for _ in range(2))}")
        if self.labels and self.takes("where"):
            clauses.append(f"where {' and '.join(self.conditions())}")
        self.random.shuffle(clauses)
        stages = self.stages() if self.takes("stages") else ""
        return " ".join([*said, *clauses]) + stages

    def let(self) -> str:
        labelled, self.labelled = self.labelled, False
        pattern = self.pattern(self.one("", self.parts[0]), 1)
        self.labelled = labelled
        self.lets.append(pattern)
        return f"let name{len(self.lets)} = {pattern};"

    def stages(self) -> str:
        said = [f" | sort by {self.field()}"] if self.random.random() < 0.5 else []
        if self.random.random() < 0.5:
            said.append(self.one(" | count", f" | count by {self.field()}"))
        if not said or self.random.random() < 0.5:
            said.append(f" | first {self.random.randint(1, 3)}")
        return "".join(said)

    def field(self) -> str:
        kind = self.one(*self.fields)
        name = self.one("match", *self.labels)
        return self.one(f"{name}.{self.named(kind)}", "clip.label", "clip.path")

    def named(self, kind: str) -> str:
        name = self.one(*self.fields[kind])
        if kind == "number" and self.apart.random() < self.chances["measures"]:
            return self.apart.choice(("speed", "size", "straightness"))
        return name

    def conditions(self) -> Iterator[str]:
        for _ in range(self.random.randint(1, 2)):
            yield self.condition()

    def condition(self) -> str:
        if len(self.labels) > 1 and self.takes("mirrors"):
            first, second = self.random.sample(self.labels, 2)
            return f"{first} mirrors {second}"
        kind = self.one(*self.fields)
        left, right = (f"{self.one('match', *self.labels)}.{self.named(kind)}" for _ in "12")
        values = {
            "time": ("0.3s", "5f", "1b"),
            "number": ("0.5", "1", "0"),
            "part": tuple(self.parts),
            "direction": self.directions,
            "level": LEVELS,
            "feet": ("spring", "hop"),
        }[kind]
        if self.random.random() < 0.6:
            right = self.one(*values)
        if kind in ("time", "number") and self.random.random() < 0.4:
            left = f"{left} {self.one('+', '-')} {self.one(*values, right)}"
        equal = ("=", "!=")
        compares = (
            equal if kind in ("part", "direction", "feet") else (*equal, "<", "<=", ">", ">=")
        )
        return f"{left} {self.one(*compares)} {right}"

    # patterns, lines and what joins them

    def pattern(self, carried: str, depth: int) -> str:
        said = [self.lines(carried, depth)]
        while self.left > 0 and self.takes("or"):
            said.append(self.lines("", depth))
        return " or ".join(said)

    def lines(self, carried: str, depth: int) -> str:
        said = [self.line(carried, depth)]
        for relation in self.random.sample(RELATIONS, len(RELATIONS)):
            if self.left > 0 and self.takes(relation):
                labelled = self.labelled
                self.labelled = labelled and relation not in ("without", "never")
                said += [f"{relation}{self.within(relation)}", self.line("", depth, most=2)]
                self.labelled = labelled
        return " ".join(said)

    def within(self, relation: str) -> str:
        if relation in ("with", "without") and self.takes("within"):
            return f"[{self.one('0.5s', '3f', '1b')}]"
        if relation in ("after", "before") and self.takes("within"):
            return f"[{self.length()}]"
        return ""

    def line(self, carried: str, depth: int, most: int = 4) -> str:
        said = [f"start {self.arrow()}"] if self.takes("start") else []
        text, last = self.item(carried, depth)
        said.append(text)
        for _ in range(most - 1):
            if self.left <= 0 or not self.takes("->"):
                break
            arrow = self.arrow()
            text, last = self.item("" if self.takes("another part") else last, depth)
            said += [arrow, text]
        return " ".join([*said, *([f"{self.arrow()} end"] if self.takes("end") else [])])

    def arrow(self) -> str:
        later = self.takes("...")
        said = self.one("...", "…") if later else self.one("->", "->", "then", "→")
        if later and self.takes("skips"):
            return f"{said}[{self.one('', '<=', '<', '>', '>=')}{self.random.randint(0, 3)}]"
        return f"{said}[{self.length()}]" if self.takes("limit") else said

    # one step

    def item(self, carried: str, depth: int) -> tuple[str, str]:
        """Return an item, and who carries over an arrow behind it."""
        label = ""
        if self.labelled and self.takes("labels"):
            label = f"l{len(self.labels) + 1}: "
            self.labels.append(label[:-2])
        labelled, repeat = self.labelled, self.repeat()
        self.labelled = labelled and not repeat
        text, last = self.unit(carried, depth)
        self.labelled = labelled
        length = f" {self.length()}" if self.takes("length") else ""
        return f"{label}{text}{length}{repeat}", last

    def unit(self, carried: str, depth: int) -> tuple[str, str]:
        if self.lets and self.random.random() < 0.5:
            return f"@name{len(self.lets)}", ""
        if depth and self.takes("bracket"):
            mirror = "mirror" if self.takes("mirror") else ""
            return f"{mirror}({self.pattern(carried, depth - 1)})", "" if mirror else carried
        self.left -= 1
        if self.takes("lnd"):
            part = self.one(*(part for part in self.parts if part != "step"))
            kind = KINDS[kind_of(part)]
            words = {kind.names[-1]: amounts_of(part) or ("45", "90"), "level": LEVELS}
            words["direction"] = tuple(it for it in self.directions if it in kind.directions)
            said = " ".join(self.one(*words[name]) for name in kind.names)
            return f"{kind.keyword} {part} {said} 0 {self.random.randint(1, 2)}", part
        return self.step(carried)

    def step(self, carried: str) -> tuple[str, str]:
        mover = carried or self.mover()
        said = [] if carried and self.random.random() < 0.8 else [mover]
        manner = next((it for it in ("at", "hold", "via") if self.takes(it)), "")
        if mover.endswith(("touch", "touches", "other_support")):
            manner = "hold" if self.takes("hold") else ""
        sided = mover.removesuffix("s").removeprefix("r_").removeprefix("l_") != mover
        sided = sided or f"r_{mover}" in self.parts
        kind = KINDS[kind_of(mover if mover in self.parts else f"r_{mover.removesuffix('s')}")]
        kind = KINDS["touch"] if mover.endswith("touches") else kind
        swings = kind.name == "gesture" and self.apart.random() < self.chances["still"]
        manner = "still" if swings and manner == "hold" else manner
        words = self.words(mover, sided, manner, kind)
        if not words and (manner in ("at", "via") or not (said or manner)):
            words = self.one(*LEVELS) if "level" in kind.words else "any"
        return " ".join(filter(None, [*said, manner, words])), mover

    def mover(self) -> str:
        part = self.one(*self.parts)
        other = {"r": "l", "l": "r"}.get(part[0], "") + part[1:]
        if part[:2] not in ("r_", "l_") or other not in self.parts:
            return part
        if self.takes("either"):
            return part[2:]
        plural = {"foot": "feet", "hand_touch": "hand_touches"}.get(part[2:], f"{part[2:]}s")
        return plural if self.takes("both") else part

    def words(self, mover: str, sided: bool, manner: str, kind: Kind) -> str:
        said = []
        if "direction" in kind.words and self.random.random() < 0.5:
            known = [it for it in self.directions if it in kind.directions]
            relative = RELATIVE if sided else () if kind.name == "gesture" else RELATIVE[:1]
            known += relative if relative and self.takes("relative") else []
            said.append("any" if self.takes("any") else self.word(known))
        if self.random.random() < 0.6 and "level" in kind.words:
            said.append(self.word(LEVELS))
        staying = manner in ("at", "hold", "still")
        if "change" in kind.words and not staying and self.takes("changes"):
            said.append(self.word(("rising", "sinking")))
        for name, known in AMOUNTS.items():
            bends = name != "bend" or kind.name == "bend"
            if bends and name in kind.words and self.random.random() < 0.5:
                said.append(self.word(("hand",) if mover == "hands_touch" else known))
        for name, words in MEASURED.items():
            moving = name in kind.words and not staying
            if moving and self.apart.random() < self.chances["measures"]:
                denied = self.apart.random() < self.chances["not"]
                said.append("not " * denied + self.apart.choice(words))
        self.random.shuffle(said)
        return " ".join(said)

    def word(self, known: Sequence[str]) -> str:
        count = 2 if len(known) > 2 and self.takes("/") else 1
        said = "/".join(self.random.sample(list(known), count))
        return f"not {said}" if self.takes("not") else said

    def length(self) -> str:
        return self.one(
            *("<0.5s", "<=3f", "2f+", ">=0.2s", ">1b", "0.2s..1s", "300ms", "<1s", "1s", "4f..9f")
        )

    def repeat(self) -> str:
        if self.takes("optional"):
            return "?"
        if not self.takes("repeat"):
            return ""
        if self.takes("open repeat"):
            return self.one(" x1+", " x2+", " x0+")
        return self.one(" x2", " x3", " x1..2", " x0..2", " x2..3")
