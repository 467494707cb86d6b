"""Random scores whose signs are all legible: on a grid of quarters, none shorter than a half."""

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTION_CODES, FEET, KINDS, TOUCHED, kind_of
from lanindex.model import SYMBOL, Meter, Score, Span, Track
from lanindex.model.derived import bending, with_steps
from lanindex.model.symbol import blank

GRID = 4  # steps of a count

_SETS: dict[tuple[str, ...], int] = {
    ("r_arm", "l_arm"): 12,
    ("r_leg", "l_leg"): 6,
    ("r_support", "l_support"): 9,
    **{(f"r_{it}", f"l_{it}"): 2 for it in ("upper_arm", "forearm", "thigh", "shank", "foot")},
    **{(f"r_{it}", f"l_{it}"): 2 for it in ("hand", "palm", "arm_bend", "leg_bend")},
    **{(it,): 2 for it in ("head", "torso", "body_turn", "torso_twist", "head_turn")},
    **{(it,): 1 for it in ("torso_incline", "head_incline", "body_travel", "other_support")},
}
"""Tracks that are drawn together, and how often."""

_LENGTHS = (2, 2, 3, 4, 4, 4, 4, 6, 8, 12)
_GAPS = (0, 0, 0, 0, 1, 2, 4, 6, 12)


def _parts(rng: np.random.Generator) -> list[str]:
    """Return two to six tracks."""
    sets, weights = list(_SETS), np.array([*_SETS.values()], float)
    order = rng.choice(len(sets), len(sets), replace=False, p=weights / weights.sum())
    found, most = list[str](), int(rng.integers(2, 7))
    for number in order:
        own = sets[number][: 1 + (rng.random() < 0.9)]
        if len(found) + len(own) <= most:
            found += own
    return found


def _row(part: str, start: int, stop: int, rng: np.random.Generator) -> NDArray[np.void]:
    """Return a random symbol, () of `SYMBOL`."""
    row, kind = blank(()), KINDS[kind_of(part)]
    row["start"] = row["tick"] = start
    row["stop"], row["ticks"], row["margin"] = stop, stop - start, 1
    if kind.name == "gesture" and start and rng.random() < 0.03:
        return row  # it goes on so
    if "direction" in kind.fields:
        row["direction"] = DIRECTION_CODES[str(rng.choice(kind.directions))]
    if "level" in kind.fields:
        row["level"] = rng.integers(3)
    if kind.name == "bend":
        row["amount"] = bending(int(rng.integers(7)))
    elif kind.name == "carrier":
        row["amount"] = rng.integers(len(kind.amounts))
    elif kind.name in ("turn", "twist", "incline"):
        still = row["direction"] == DIRECTION_CODES["place"]
        steps = 15 if kind.name != "turn" else 45
        row["amount"] = 0 if still else steps * rng.integers(1, 7)
    return row


def _track(
    part: str, spans: Sequence[tuple[int, int]], ticks: int, rng: np.random.Generator, begins: bool
) -> Track:
    """Return a track of random symbols."""
    rows = [_row(part, 0, 0, rng)] * (begins and KINDS[kind_of(part)].lasts)
    rows += [_row(part, *span, rng) for span in spans]
    return Track(part, np.array(rows, SYMBOL), (Span(0, ticks),))


def random_track(part: str, ticks: int, rng: np.random.Generator) -> Track:
    """Return a track of random symbols, from a starting position on."""
    return _track(part, _spans(ticks, rng), ticks, rng, begins=True)


def _spans(
    ticks: int,
    rng: np.random.Generator,
    gaps: Sequence[int] = _GAPS,
    lengths: Sequence[int] = _LENGTHS,
) -> list[tuple[int, int]]:
    """Return when symbols of a track begin and end, flush or apart."""
    found, at = list[tuple[int, int]](), int(rng.choice(gaps))
    while (stop := at + int(rng.choice(lengths))) <= ticks:
        found.append((at, stop))
        at = stop + int(rng.choice(gaps))
    return found


def random_score(rng: np.random.Generator, seconds: bool) -> Score:
    """Return a score whose frames are quarters of a count."""
    beats = 4 if seconds else int(rng.choice([4, 4, 3, 2]))
    counts = int(rng.integers(5, 31)) if seconds else beats * int(rng.integers(2, 33 // beats))
    ticks, begins, tracks = counts * GRID, rng.random() < 0.9, dict[str, Track]()
    parts = _parts(rng)
    feet = [part for part in parts if kind_of(part) == "support"]
    for part in parts:
        if part not in feet:
            tracks[part] = _track(part, _spans(ticks, rng), ticks, rng, begins)
    if feet:
        steps = _spans(ticks, rng, (0, 0, 0, 0, 0, 2, 4, 8), (2, 2, 4, 4, 4, 8))
        for number, foot in enumerate(feet):
            tracks[foot] = _track(foot, steps[number :: len(feet)], ticks, rng, begins)
        tracks |= _stances(feet, steps, ticks, rng)
    more = rng.spawn(1)[0]  # leaves all other draws as they are
    tracks |= _jumps(feet, tracks, ticks, more) | _touches(ticks, more)
    speed = Fraction(60) if seconds else Fraction(int(rng.integers(50, 140)))
    meter = Meter(speed, beats, 4, GRID * beats)
    return Score(meter.tick_rate, ticks, meter, with_steps(tracks))


def _stances(
    feet: Sequence[str], steps: Sequence[tuple[int, int]], ticks: int, rng: np.random.Generator
) -> dict[str, Track]:
    """Return the tracks of what stands between steps: the foot that stepped, or both."""
    rows: dict[str, list[NDArray[np.void]]] = {"r_stance": [], "l_stance": []}
    ends = [(0, ""), *((stop, feet[at % len(feet)]) for at, (_, stop) in enumerate(steps))]
    begins = [*(start for start, _ in steps), ticks]
    for (start, foot), stop in zip(ends, begins, strict=True):
        for part, own in rows.items():
            both = foot == "" or rng.random() < 0.3
            if start < stop and (both or part[0] == foot[0]):
                own.append(_row(part, start, stop, rng))
    return {
        part: Track(part, np.array(own, SYMBOL), (Span(0, ticks),))
        for part, own in rows.items()
        if own
    }


def _jumps(
    feet: Sequence[str], tracks: dict[str, Track], ticks: int, rng: np.random.Generator
) -> dict[str, Track]:
    """Return the tracks in which some steps of a count or more are landings, and their flights.

    A flight takes the time of the step, the landing its second half, of one foot or both; between
    two flights the body stands, or steps.
    """
    rows = {part: [*tracks[part].symbols] for part in feet}
    steps = [(part, at, row) for part in feet for at, row in enumerate(rows[part])]
    flights, landed = list[NDArray[np.void]](), -1
    often = rng.random() * (rng.random() < 0.7)
    for part, at, row in sorted(steps, key=lambda it: int(it[2]["start"])):
        start, stop = int(row["start"]), int(row["stop"])
        if stop - start < GRID or start <= landed or rng.random() >= often:
            continue
        flight = _row("jump", start, stop, rng)
        flight["amount"], landed = FEET.index("unseen"), stop
        flights.append(flight)
        rows[part][at] = _row(part, (start + stop) // 2, stop, rng)
        for other in {*feet} - {part}:
            if rng.random() < 0.4:
                rows[other].append(_row(other, (start + stop) // 2, stop, rng))
    if not flights:
        return {}
    known = (Span(0, ticks),)
    for own in rows.values():
        own.sort(key=lambda it: int(it["start"]))
    return {
        part: Track(part, np.array(own, SYMBOL), known)
        for part, own in (*rows.items(), ("jump", flights))
        if own
    }


_APART = (2, 4, 4, 8, 12, 24)


def _touches(ticks: int, rng: np.random.Generator) -> dict[str, Track]:
    """Return the tracks of hands that touch something: each other, or one or both of them."""
    rows: dict[str, list[NDArray[np.void]]] = {}
    spans = _spans(ticks, rng, _APART) if rng.random() < 0.3 else []
    for span in spans:
        thing = int(rng.integers(len(TOUCHED)))
        hands = [("r_hand_touch",), ("l_hand_touch",), ("r_hand_touch", "l_hand_touch")]
        alone = TOUCHED[thing] == "arm"  # the bows of both would lie upon each other
        for part in hands[rng.integers(2 if alone else 3)] if thing else ("hands_touch",):
            row = _row(part, *span, rng)
            row["amount"] = thing
            rows.setdefault(part, []).append(row)
    known = (Span(0, ticks),)
    return {part: Track(part, np.array(own, SYMBOL), known) for part, own in rows.items()}
