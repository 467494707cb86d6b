"""Small random captures, several at once, from a seed: for comparing matchers many times over."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from random import Random

from lanindex.alphabet import DIRECTION_CODES, KINDS, Kind, is_limb, kind_of
from lanindex.model import Capture, Meter, Span, Track
from lanindex.model.derived import with_bends
from lanindex.model.symbol import blank

PARTS = ("r_arm", "l_arm", "head")
WHOLE = (
    "r_support",
    "l_support",
    "step",
    "jump",
    "body_travel",
    "body_turn",
    "r_arm",
    "r_arm_bend",
)
TOUCHES = ("hands_touch", "r_hand_touch", "l_hand_touch", "other_support", "r_arm")
DIRECTIONS = ("right", "left", "place")
RATES = (Fraction(10), Fraction(10), Fraction(30), Fraction(30000, 1001))


def _times(random: Random, begin: int, end: int, most: int) -> list[tuple[int, int, bool]]:
    """Return a starting position and some rows; a passing one lies inside the row after it."""
    rows, now = [(begin, begin, False)], begin
    while len(rows) < most:
        start = now + random.choice((0, 0, 0, 1, 2, 4))
        stop = start + random.randint(1, 4)
        if stop > end:
            break
        if stop - start > 1 and random.random() < 0.3:
            middle = random.randint(start, stop - 2)
            rows.append((middle, random.randint(middle + 1, stop), True))
        rows.append((start, stop, False))
        now = stop
    return rows


def random_track(random: Random, part: str, frames: int, most: int) -> Track:
    """Return a track, with a gap now and then, of at most about so many rows."""
    known = [Span(0, frames)]
    if random.random() < 0.2 and frames > 12:
        gap = random.randint(5, frames - 6)
        known = [Span(random.randint(0, 2), gap), Span(gap + 2, random.randint(gap + 4, frames))]
    kind = KINDS[kind_of(part)]
    times = [row for span in known for row in _times(random, span.start, span.stop, most)]
    if random.random() < 0.05:
        times = times[: random.randint(0, 1)]
    if not is_limb(part) and random.random() < 0.7:  # what just happens starts nowhere
        times = [row for row in times if row[0] < row[1] or row[2]]
    rows, apart = blank(len(times)), Random(sum(random.getstate()[1]))
    for row, (start, stop, passing) in zip(rows, times, strict=True):
        row["start"], row["stop"], row["passing"] = start, stop, passing
        if "direction" in kind.fields:
            row["direction"] = DIRECTION_CODES[random.choice(_directions(kind))]
        row["level"] = random.randrange(3) if "level" in kind.fields else -1
        if "amount" in kind.fields:
            row["amount"] = random.choice(
                range(min(len(kind.amounts), 14)) if kind.amounts else (45, 90, 112, 400)
            )
        row["margin"] = random.randint(0, 20) / 20
        row["swings"] = apart.choice((0, 0, 3))
        if kind.measures and apart.random() < 0.8:
            own = {}
            own["speed"] = apart.choice((0, 0.5, 1, 1.2, 2.19, 2.2, 3, 5.9, 5.91, 12.5, 40.94))
            own["size"] = apart.choice((0, 1, 5, 18, 19, 33, 55, 56, 90, 180))
            own["straightness"] = apart.choice((0, 0.5, 0.75, 1))
            for name in kind.measures:
                row[name] = own[name]
        if "direction" in kind.fields and random.random() < 0.8:
            row["runner_direction"] = DIRECTION_CODES[random.choice(_directions(kind))]
            row["runner_level"] = random.randrange(3) if "level" in kind.fields else -1
    return Track(part, rows, tuple(known))


def _directions(kind: Kind) -> list[str]:
    return [name for name in DIRECTIONS if name in kind.directions]


def random_library(
    random: Random, captures: int = 4, most: int = 8, known: Sequence[str] = PARTS
) -> list[tuple[Capture, Mapping[str, Track]]]:
    """Return some captures of different rates and lengths; some lack a part."""
    found = []
    for number in range(1, random.randint(1, captures) + 1):
        frames, rate = random.randint(4, 5 * most), random.choice(RATES)
        name, meter = f"made{number}.lnd", Meter(Fraction(random.choice((60, 120))))
        capture = Capture(number, name, "lnd", "0" * 64, "made", rate, frames, meter)
        parts = [part for part in known if random.random() < 0.9]
        tracks = with_bends({part: random_track(random, part, frames, most) for part in parts})
        found.append((capture, tracks))
    return found
