"""The reduction of a score that is drawn by default: what its reader takes for granted is left out.

The rules are told in ``guide/looking.md``. What is drawn keeps its frames; nothing is added.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import LEVEL_CODES, PLACE, SIXTHS, kind_of
from lanindex.draw.staff import group_of, keys_of
from lanindex.model import Score, Symbol, Track
from lanindex.model.derived import STEP, degree_of
from lanindex.model.symbol import blank

Rows = NDArray[np.void]
Mask = NDArray[np.bool_]

_LOW, _HIGH = LEVEL_CODES["low"], LEVEL_CODES["high"]
_PAUSE = 0.5  # seconds between steps of one walk, at most
_LONG = 2.5  # in lengths of its step: a foot that is free for longer makes a gesture
_CHANGE = 2  # degrees by which a bend differs from the one that is drawn last, at least
_SWINGING = 3  # the same of an arm that swings with a walk; knees of steps are not drawn
_ALONE = 2  # movements of a finer part alone that give it a column, at least
_FINER = {"forearm": "upper_arm", "hand": "forearm", "palm": "forearm"}
_IN_DEGREES = {"torso": "torso_incline", "head": "head_incline"}


def plain(score: Score, marked: Iterable[Symbol] = ()) -> Score:
    """Return a score with what a reader expects, and with symbols that are marked."""
    keys, found = keys_of(score, marked), dict[str, Track]()
    for part, track in score.tracks.items():
        rows = track.symbols[~track.symbols["passing"]]
        spans = zip(rows["start"].tolist(), rows["stop"].tolist(), strict=True)
        told = np.array([(part, *span) in keys for span in spans], bool)
        told |= _RULES.get(group_of(part), _all)(score, part, rows)
        found[part] = replace(track, symbols=rows[told])
    left_out = _left_out(found, _walks(score)) - {part for part, *_ in keys}
    return replace(score, tracks={it: found[it] for it in found if it not in left_out})


def _left_out(tracks: Mapping[str, Track], walks: Rows) -> set[str]:
    """Return tracks without a column: they are empty, or others say the same in fewer signs."""
    rows = {part: track.symbols for part, track in tracks.items()}
    left_out = {part for part in rows if not len(rows[part])}
    for side in ("r_", "l_"):
        alone = {it for it in _FINER if _moves_alone(rows, side + it, side + _FINER[it], walks)}
        left_out |= {side + it for it in ("hand", "palm") if it not in alone}
        if f"{side}arm" in rows:
            elbow = ("arm", "arm_bend") if "forearm" in alone else ("upper_arm", "forearm")
            left_out |= {side + it for it in elbow}
        if f"{side}leg" in rows:
            lifted = int((rows.get(f"{side}thigh", blank(0))["level"] > _LOW).sum())
            knee = lifted >= max(_ALONE, len(rows[f"{side}leg"]) + 1)  # it is lifted bent
            left_out |= {side + it for it in ("leg" if knee else "thigh", "shank", "foot")}
    for part, degrees in _IN_DEGREES.items():
        both = [it for it in (degrees, part) if it in rows and it not in left_out]
        left_out |= {*sorted(both, key=lambda it: len(rows[it]))[1:]}
    return left_out


def _moves_alone(rows: Mapping[str, Rows], part: str, whole: str, walks: Rows) -> bool:
    """Return whether a part moves while the one that it hangs on rests, as often as not.

    What swings with a walk does not count.
    """
    if part not in rows or whole not in rows:
        return part in rows
    moves = rows[part][rows[part]["start"] < rows[part]["stop"]]
    alone = int((~_during(moves, rows[whole]) & ~_during(moves, walks)).sum())
    return alone >= max(_ALONE, len(moves) / 2)


def _during(rows: Rows, others: Rows) -> Mask:
    """Return which rows lie in the time of others, one after another, by half or as one moment."""
    if not len(others):
        return np.zeros(len(rows), bool)
    begins, ends = others["start"].astype(np.int64), others["stop"].astype(np.int64)
    over = np.cumsum(ends - begins)  # how much of them is over at the end of each
    last, shared = [], []
    for name in ("start", "stop"):
        at = np.searchsorted(begins, rows[name], "right") - 1
        shared.append(np.where(at < 0, 0, over[at] - np.clip(ends[at] - rows[name], 0, None)))
        last.append(at)
    inside = (last[0] >= 0) & (rows["start"] <= ends[last[0]])
    lengths = rows["stop"].astype(np.int64) - rows["start"]
    return np.where(lengths > 0, 2 * (shared[1] - shared[0]) >= lengths, inside)


def _rows(score: Score, part: str) -> Rows:
    return score.tracks[part].symbols if part in score.tracks else blank(0)


def _walks(score: Score) -> Rows:
    """Return the stretches of steps that follow each other."""
    steps, pause = _rows(score, STEP), float(score.rate) * _PAUSE
    ends = np.maximum.accumulate(steps["stop"])
    apart = steps["start"][1:] > ends[:-1] + pause
    walks = blank(int(apart.sum()) + 1 if len(steps) else 0)
    walks["start"] = steps["start"][np.append(True, apart)[: len(steps)]]
    walks["stop"] = ends[np.append(apart, True)[: len(steps)]]
    return walks


def _all(score: Score, part: str, rows: Rows) -> Mask:
    return np.ones(len(rows), bool)


def _gestures(score: Score, part: str, rows: Rows) -> Mask:
    """Return the movements of a free leg that are more than the swing of its step."""
    stances, steps = _rows(score, f"{part[:2]}stance"), _rows(score, f"{part[:2]}support")
    if not len(stances):
        return _all(score, part, rows)
    told = ~_during(rows, stances)
    for at in np.flatnonzero(told):
        row = rows[at]
        after = int(np.searchsorted(stances["start"], row["stop"] - 1, "right"))
        free = stances["stop"][after - 1] if after else 0
        landed = stances["start"][after] if after < len(stances) else score.frames
        step = steps[(steps["start"] < landed) & (steps["stop"] > max(free, row["start"]))]
        if not len(step):
            continue
        step = step[-1]
        swing = landed - free <= _LONG * max(step["stop"] - step["start"], 1)
        turned = (row["direction"] - step["direction"]) % 4
        across = PLACE not in (row["direction"], step["direction"]) and turned == 2
        lifted = row["level"] > _LOW and (row["direction"] - step["direction"]) % 8 != 4
        told[at] = not swing or across or lifted
    return told


def _swings(score: Score, part: str, rows: Rows) -> Mask:
    """Return the movements of an arm but those that swing low with a walk."""
    told: Mask = ~_during(rows, _walks(score)) | (rows["level"] != _LOW)
    last = -1
    for at, level in enumerate(rows["level"].tolist()):
        told[at] |= last != _LOW  # what comes down is drawn
        last = level if told[at] else last
    return told


def _bends(score: Score, part: str, rows: Rows) -> Mask:
    """Return the bends that differ from the one before by degrees that are seen."""
    told, last = np.zeros(len(rows), bool), 0
    degrees = degree_of(rows["amount"])
    walks = _during(rows, _walks(score))
    swinging = _SWINGING if part[2:] == "arm_bend" else SIXTHS + 1
    least = np.where(walks, swinging, _CHANGE)
    for at, degree in enumerate(degrees.tolist()):
        if abs(degree - last) >= (least[at] if degree >= _CHANGE else _CHANGE):
            told[at], last = True, degree
    return told


def _leans(score: Score, part: str, rows: Rows) -> Mask:
    """Return all symbols of what ever leaves its rest."""
    rest = rows["direction"] == PLACE
    if kind_of(part) == "gesture":
        rest &= rows["level"] == _HIGH
    return np.full(len(rows), not rest.all())


def _ways(score: Score, part: str, rows: Rows) -> Mask:
    told: Mask = rows["direction"] != PLACE
    return told


_RULES: dict[str, Callable[[Score, str, Rows], Mask]] = {
    **dict.fromkeys(("leg", "thigh", "shank", "foot"), _gestures),
    **dict.fromkeys(("arm", "upper_arm", "forearm", "hand", "palm"), _swings),
    **dict.fromkeys(("arm_bend", "leg_bend"), _bends),
    **dict.fromkeys((*_IN_DEGREES, *_IN_DEGREES.values(), "torso_twist", "head_turn"), _leans),
    "body_travel": _ways,
}
"""What is drawn of a track, by its group; all of those that are not named."""
