"""Random patterns and small random tracks for them, as hypothesis strategies."""

from fractions import Fraction

from hypothesis import strategies as st

from lanindex.alphabet import DIRECTION_CODES, LEVEL_CODES
from lanindex.model import Capture, Meter, Span, Track
from lanindex.model.columns import Columns, columns_of
from lanindex.model.symbol import blank

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


@st.composite
def bare_lines(draw, part: str = "r_arm") -> str:
    """Return one part's steps with arrows between, and nothing else."""
    steps = draw(st.lists(st.sampled_from(_BARE_STEPS), min_size=1, max_size=4))
    arrows = [draw(st.sampled_from((" -> ", " ... "))) for _ in steps[1:]]
    return f"{part} " + "".join(map("".join, zip(steps, [*arrows, ""], strict=True)))
