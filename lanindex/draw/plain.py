"""The reduction of a score that is drawn by default: what its reader takes for granted is left out.

The rules are told in ``guide/looking.md``. What is drawn keeps its frames, or begins with what lay
on the way to it; nothing is added.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import replace
from functools import cache
from math import degrees, dist

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import HIGH, LOW, MID, PLACE, SIXTHS, group_of, kind_of
from lanindex.draw.staff import Key, has_column, keys_of, turns, usual_tracks
from lanindex.model import Score, Symbol, Track
from lanindex.model.derived import STEP, degree_of
from lanindex.model.score import rows_of
from lanindex.model.symbol import blank

Rows = NDArray[np.void]
Mask = NDArray[np.bool_]

_PAUSE = 0.5  # seconds between steps of one walk, at most
_LONG = 2.5  # in lengths of its step: a foot that is free for longer makes a gesture
_CHANGE = 2  # degrees by which a bend differs from the one that is drawn last, at least
_SWINGING = 3  # the same of an arm that swings with a walk; knees of steps are not drawn
_UNDONE = 0.5  # seconds: a bend that is undone sooner is not drawn
_UPRIGHT = 22.5  # degrees: an incline below this is nearer to upright than to the next direction
_PULSE = 5  # movements in which a part that pulses is back, at most, the first included
_GRID = 0.25  # beats: what is shorter cannot be read
_ALIKE = 45.5  # degrees: below it, positions of quick movements to and fro are the same
_AGAIN = 4  # quick movements to and fro that are not drawn each, at least
_DETOUR = 45.0  # degrees by which a position on the way may lie off it
_ELBOW = 3  # degrees of a bent arm that swings as a runner's does, at least
_TWIST = 45  # degrees by which shoulders that swing with a walk stay below
_KNEES = 2  # movements of a thigh that give it a column, at least
_FINER = {
    "forearm": ("upper_arm", "arm", 2),
    "hand": ("forearm", "forearm", 4),
    "palm": ("forearm", "forearm", 2),
}
"""What a part hangs on, what tells of it otherwise, and how many movements give it a column."""

_IN_DEGREES = {"torso": "torso_incline", "head": "head_incline"}


def plain(
    score: Score, marked: Iterable[Symbol] = (), columns: Collection[str] | None = None
) -> Score:
    """Return a score with what a reader expects, and with symbols that are marked.

    `columns` are those of the staff, if other stretches of it are in the same.
    """
    keys = keys_of(score, marked)
    found = _reduced(score, keys)
    if columns is None:
        left_out = {part for part, track in found.items() if not len(track)}
        left_out |= _told_otherwise(found, _walks(score))
    else:
        left_out = {part for part in found if has_column(part) and part not in columns}
    left_out -= {part for part, *_ in keys}
    kept = {it: found[it] for it in found if it not in left_out}
    for part, track in kept.items():
        if kind_of(part) == "gesture":
            rows = _again(score, track.symbols, _lit(part, track.symbols, keys))
            kept[part] = replace(track, symbols=rows)
    return replace(score, tracks=kept or score.tracks)


def usual_columns(score: Score, tracks: Collection[str]) -> list[str]:
    """Return which of some tracks have columns, as far as samples of them in a score tell."""
    left_out = _told_otherwise(_reduced(score, frozenset()), _walks(score))
    return [
        it for it in usual_tracks([it for it in tracks if it not in left_out]) if has_column(it)
    ]


def _reduced(score: Score, keys: Collection[Key]) -> dict[str, Track]:
    """Return what is drawn of each track that has a column."""
    found = dict[str, Track]()
    for part, track in score.tracks.items():
        rows = rows_of(score, part)
        lit, rule = _lit(part, rows, keys), _RULES.get(group_of(part))
        told = lit | (rule is None or rule(score, part, rows))
        rows = rows[told]
        if kind_of(part) == "gesture":
            rows = _merged(score, rows, lit[told])
        elif kind_of(part) == "travel":
            rows = _straight(rows, lit[told])
        found[part] = replace(track, symbols=rows)
    return found


def _lit(part: str, rows: Rows, keys: Collection[Key]) -> Mask:
    """Return which rows of a part are marked."""
    own = {(start, stop) for it, start, stop in keys if it == part}
    spans = zip(rows["start"].tolist(), rows["stop"].tolist(), strict=True)
    return np.array([span in own for span in spans] if own else np.zeros(len(rows)), bool)


def _told_otherwise(tracks: Mapping[str, Track], walks: Rows) -> set[str]:
    """Return tracks without a column, as others say the same in fewer signs."""
    rows, left_out = {part: track.symbols for part, track in tracks.items()}, set[str]()
    for side in ("r_", "l_"):
        alone = {it for it in _FINER if _moves_alone(rows, side, it, walks)}
        left_out |= {side + it for it in ("hand", "palm") if it not in alone}
        if f"{side}arm" in rows:
            elbow = ("arm", "arm_bend") if "forearm" in alone else ("upper_arm", "forearm")
            left_out |= {side + it for it in elbow}
        if f"{side}leg" in rows:
            lifted = int((rows.get(f"{side}thigh", blank(0))["level"] > LOW).sum())
            knee = lifted >= max(_KNEES, len(rows[f"{side}leg"]) + 1)  # it is lifted bent
            left_out |= {side + it for it in ("leg" if knee else "thigh", "shank", "foot")}
    for part, incline in _IN_DEGREES.items():
        both = [it for it in (incline, part) if len(rows.get(it, ()))]
        left_out |= {*sorted(both, key=lambda it: len(rows[it]))[1:]}
    return left_out


def _moves_alone(rows: Mapping[str, Rows], side: str, part: str, walks: Rows) -> bool:
    """Return whether a part moves while the one that it hangs on rests, or twice as often."""
    base, whole, least = _FINER[part]
    if side + part not in rows or side + base not in rows:
        return side + part in rows

    def moving(part: str) -> Rows:  # what swings with a walk does not count
        own = rows.get(side + part, blank(0))
        return own[(own["start"] < own["stop"]) & ~_during(own, walks)]

    moves = moving(part)
    if (moves["level"] > LOW).sum() < least:
        return False  # it hangs
    alone = int((~_during(moves, rows[side + base])).sum())
    return alone >= max(least, len(moves) / 2) or len(moves) >= max(least, 2 * len(moving(whole)))


def _during(rows: Rows, others: Rows) -> Mask:
    """Return which rows lie by half in the time of others, which follow one another."""
    edges = np.concatenate([[0], np.stack([others["start"], others["stop"]], axis=1).ravel()])
    over = np.cumsum(np.diff(edges, prepend=0) * (np.arange(len(edges)) % 2 == 0))  # of them
    lengths = np.maximum(rows["stop"] - rows["start"], 1)
    shared = [np.interp(rows["start"] + it, edges, over) for it in (0, lengths)]
    return np.asarray(2 * (shared[1] - shared[0]) >= lengths)


def _merged(score: Score, rows: Rows, marked: Mask) -> Rows:
    """Return movements; what is too short to be read, and on the way, is part of the next one."""
    grid = float(score.rate * 60 / score.meter.speed) * _GRID
    rows, told, before = rows.copy(), np.ones(len(rows), bool), 0
    ways, fixed = _ways_of(rows), (marked | (rows["start"] == rows["stop"])).tolist()
    fields = ("start", "stop", "tick", "ticks")
    starts, stops, ticks, lengths = (rows[name].tolist() for name in fields)
    for at in range(1, len(rows) - 1):
        joined = stops[at] - starts[at] < grid and stops[at] >= starts[at + 1]
        if joined and not (fixed[at] or fixed[at + 1]):
            first, middle, last = ways[before], ways[at], ways[at + 1]
            around = _angle(first, middle) + _angle(middle, last)
            if around <= _angle(first, last) + _DETOUR:
                lengths[at + 1] += ticks[at + 1] - ticks[at]
                starts[at + 1], ticks[at + 1], told[at] = starts[at], ticks[at], False
                continue
        before = at
    rows["start"], rows["tick"], rows["ticks"] = starts, ticks, lengths
    return rows[told]


def _again(score: Score, rows: Rows, marked: Mask) -> Rows:
    """Return movements; of quick ones to and fro the first two, and a row that points nowhere."""
    whole, told, at = rows.copy(), np.ones(len(rows), bool), 0
    ways, most = _ways_of(rows), float(score.rate) * _UNDONE
    far = (rows["stop"] - rows["start"] > most) | marked
    far[1:] |= rows["start"][1:] > rows["stop"][:-1]
    slow, moves = far.tolist(), (rows["start"] < rows["stop"]).tolist()
    while at + 2 + _AGAIN <= len(rows):
        end, pair = at + 1, ways[at : at + 2]
        while (
            end < len(rows) and not slow[end] and _angle(ways[end], pair[(end - at) % 2]) < _ALIKE
        ):
            end += 1
        end -= (end - at) % 2
        if end - at < 2 + _AGAIN or not moves[at] or _angle(*pair) < 1:  # or a starting position
            at += 1
            continue
        more = whole[at + 2]
        more["direction"] = more["level"] = more["amount"] = -1
        more["stop"], told[at + 3 : end] = rows["stop"][end - 1], False
        more["ticks"] = rows["tick"][end - 1] + rows["ticks"][end - 1] - more["tick"]
        at = end
    return whole[told]


def _straight(rows: Rows, marked: Mask) -> Rows:
    """Return ways; those that swerve by 45 degrees at most are one, as they go most of the time."""
    told, first, whole = ~np.zeros(len(rows), bool), 0, rows.copy()
    for at in range(1, len(rows)):
        ways, way = rows["direction"][first : at + 1], whole[first]
        joined = rows["start"][at] <= rows["stop"][at - 1] and not marked[at - 1 : at + 1].any()
        if joined and np.isin((ways[:, None] - ways) % 8, (0, 1, 7)).all():
            lengths = (rows["stop"] - rows["start"])[first : at + 1]
            way["direction"] = np.bincount(ways, lengths).argmax()
            way["stop"] = rows["stop"][at]
            way["ticks"] = rows["tick"][at] + rows["ticks"][at] - way["tick"]
            told[at] = False
        else:
            first = at
    return whole[told]


def _points(rows: Rows) -> NDArray[np.float64]:
    """Return where rows point to, (S, 3); at nothing, where a limb is folded."""
    place, around = rows["direction"] == PLACE, np.radians(45.0 * rows["direction"])
    up = np.radians(np.where(place, 90.0, 45.0) * (rows["level"] - 1.0))
    flat = np.cos(up) * ~place
    return np.stack([flat * np.cos(around), np.sin(up), flat * np.sin(around)], axis=-1)


Way = tuple[int, int]  # a direction and a level


def _ways_of(rows: Rows) -> list[Way]:
    return [*zip(rows["direction"].tolist(), rows["level"].tolist(), strict=True)]


@cache  # of 28 ways at most
def _angle(one: Way, other: Way) -> float:
    """Return the degrees between two ways."""
    rows = blank(2)
    rows["direction"], rows["level"] = zip(one, other, strict=True)
    points = _points(rows)
    return float(np.degrees(np.arccos(np.clip(points[0] @ points[1], -1.0, 1.0))))


def _walks(score: Score) -> Rows:
    """Return the stretches of steps that follow each other."""
    steps, pause = rows_of(score, STEP), float(score.rate) * _PAUSE
    ends = np.maximum.accumulate(steps["stop"])
    apart = steps["start"][1:] > ends[:-1] + pause
    walks: Rows = steps[np.append(True, apart)[: len(steps)]]
    walks["stop"] = ends[np.append(apart, True)[: len(steps)]] + pause  # the last step swings out
    return walks


def _gestures(score: Score, part: str, rows: Rows) -> Mask:
    """Return the movements of a free leg that are more than the swing of its step."""
    stances, steps = rows_of(score, f"{part[:2]}stance"), rows_of(score, f"{part[:2]}support")
    flights, walk = rows_of(score, "jump"), rows_of(score, STEP)
    if not len(stances):
        return np.ones(len(rows), bool)
    other = rows_of(score, f"{'l' if part[0] == 'r' else 'r'}_stance")
    carried = np.sort(np.concatenate([other, flights]), order="start")
    sure = _during(rows, carried) | _during(rows, rows_of(score, "other_support"))
    told, sure = ~_during(rows, stances), sure | (rows["level"] > LOW)  # that it is free
    after = np.searchsorted(stances["start"], rows["stop"] - 1, "right")
    free = np.append(0, stances["stop"])[after]
    landed = np.append(stances["start"], score.frames)[after]
    last = np.searchsorted(steps["start"], landed) - 1
    step = np.append(steps, blank(1))[last]
    swung = (last >= 0) & (step["stop"] > np.maximum(free, rows["start"]))
    swing = landed - free <= _LONG * np.maximum(step["stop"] - step["start"], 1)
    begun, over = (
        np.searchsorted(flights[it], at) for it, at in (("start", landed), ("stop", free + 1))
    )
    way, toward = rows["direction"].astype(int), step["direction"].astype(int)
    turned = np.where((way == PLACE) | (toward == PLACE), 0, (way - toward) % 8)
    both = ~np.isin(step["stop"], walk["stop"])
    aside = both & (way != PLACE) & (toward == PLACE) & (way % 4 != 2)  # legs that open together
    least = np.where((begun > over) & (part[2:] == "thigh"), MID, LOW)  # knees of runners
    more = ~swing | (turned == 2) | (turned == 6) | (rows["level"] > least) & (turned != 4)
    return np.asarray(told & np.where(swung, aside | sure & more, sure))


def _swings(score: Score, part: str, rows: Rows) -> Mask:
    """Return the movements of an arm but those that swing with a walk, low or bent."""
    swings = (rows["level"] == LOW) | (rows["level"] == MID) & (rows["amount"] >= _ELBOW)
    told = (~_during(rows, _walks(score)) | ~swings).tolist()
    last = False
    for at, swing in enumerate(swings.tolist()):
        told[at] |= not last  # what comes down is drawn
        last = swing if told[at] else last
    return np.array(told, bool)


def _bends(score: Score, part: str, rows: Rows) -> Mask:
    """Return the bends that differ from the one before by degrees that are seen."""
    told, last, hold = np.zeros(len(rows), bool), 0, float(score.rate) * _UNDONE
    folded = degree_of(rows["amount"])
    walks = _during(rows, _walks(score))
    swinging = _SWINGING if part[2:] == "arm_bend" else SIXTHS + 1
    least = np.where(walks, swinging, _CHANGE)
    for at, degree in enumerate(folded.tolist()):
        if abs(degree - last) >= (least[at] if degree >= _CHANGE else _CHANGE):
            undone = abs(folded[at + 1 : at + 2] - last) < _CHANGE
            if not (undone & (rows["start"][at + 1 : at + 2] < rows["start"][at] + hold)).any():
                told[at], last = True, degree
    return told


def _leans(score: Score, part: str, rows: Rows) -> Mask:
    """Return what leaves its rest, comes back to it or changes, and is not undone at once."""
    walks, rest = _during(rows, _walks(score)), rows["direction"] == PLACE
    if kind_of(part) == "gesture":
        rest &= rows["level"] == HIGH
        points, last = _points(rows).tolist(), [0.0, 1.0, 0.0]
    else:
        rest |= (rows["amount"] < _UPRIGHT) & (kind_of(part) == "incline")
        if part == "torso_twist":
            rest |= (rows["amount"] < _TWIST) & walks
        around, size = np.radians(45.0 * rows["direction"]), np.radians(rows["amount"] * ~rest)
        points = np.stack([size * np.cos(around), size * np.sin(around)], axis=-1).tolist()
        last = [0.0, 0.0]
    told, fixed = np.zeros(len(rows), bool), (rows["start"] == rows["stop"]).tolist()
    second, beat = float(score.rate), float(score.rate * 60 / score.meter.speed)
    until = (rows["start"] + np.where(walks, second * _UNDONE, beat * _GRID)).tolist()
    starts = rows["start"].tolist()
    for at, point in enumerate(points):
        off = degrees(dist(point, last))
        if fixed[at]:
            told[at] = not rest[at]
        elif off >= _UPRIGHT:
            told[at] = off > 2 * _UPRIGHT or not any(
                starts[soon] < until[at] and degrees(dist(points[soon], last)) < _UPRIGHT
                for soon in range(at + 1, min(at + _PULSE, len(points)))
            )
        last = point if told[at] or fixed[at] else last
    return told


def _ways(score: Score, part: str, rows: Rows) -> Mask:
    """Return ways that lead somewhere, but those that a turn by steps tells."""
    told: Mask = (rows["direction"] != PLACE) & ~_during(rows, turns(score)[1])
    return told


_RULES: dict[str, Callable[[Score, str, Rows], Mask]] = {
    **dict.fromkeys(("leg", "thigh", "shank", "foot"), _gestures),
    **dict.fromkeys(("arm", "upper_arm", "forearm", "hand", "palm"), _swings),
    **dict.fromkeys(("arm_bend", "leg_bend"), _bends),
    **dict.fromkeys((*_IN_DEGREES, *_IN_DEGREES.values(), "torso_twist", "head_turn"), _leans),
    "body_travel": _ways,
}
"""What is drawn of a track, by its group; all of those that are not named."""
