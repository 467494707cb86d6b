"""How the standard body goes: steps, jumps and turns to its place, its front and its legs.

Source: ``encode/BODY.md``, read backwards.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTION_CODES, FEET, HIGH, JOINT_CODES, LOW, PLACE
from lanindex.model import SYMBOL, Score
from lanindex.perform.figure import Body
from lanindex.perform.reach import UP, bent, minimum_jerk

Floats = NDArray[np.float64]
Rows = NDArray[Any]

STRIDE = 0.45
"""Lengths of a leg that a step takes the body."""

SINKS, HEELS, LIFTS, FREE = 0.16, 0.11, 0.15, 0.25
"""Lengths of a leg: how far the body sinks for a low step, the heels rise for a high one, a foot is
lifted on its way, and a foot hangs that does not carry."""

SETTLES = 0.1
"""Part of a step's time that a foot that carries still takes to come to rest."""

REACHES = 0.995
"""Part of its length that a leg that carries has from hip to ankle."""

DRAWN = 12.0
"""Lengths of a leg a second squared: how bodies fall."""

LIFTED = 0.05
"""Lengths of a leg above the floor: a foot so high goes wherever the knee takes it."""

SIDES = "rl"
WEIGHT = ("r_support", "l_support", "jump", "body_turn")
"""The tracks that are carried out here."""

_LANDS = {"spring": 2, "hop": 1, "leap": 1, "assemble": 2, "sissonne": 1, "unseen": 2}


@dataclass(frozen=True, slots=True, eq=False)
class Going:
    """Where the body is, how it faces, and where its legs point.

    Attributes
    ----------
    front : ndarray
        (T,) radians that it has turned to the left.
    hips : ndarray
        (T, 3) mm: forward of where it began, above the floor, right of where it began.
    legs : dict of str to ndarray
        (T, 3) unit vectors of the body frame, by bone.
    """

    front: Floats
    hips: Floats
    legs: dict[str, Floats]


@dataclass(frozen=True, slots=True)
class _Move:
    """Something that takes its time, in seconds, and takes the body along."""

    start: float
    stop: float
    direction: int
    level: int
    feet: str
    flies: bool = False

    def share(self, times: Floats, longer: float = 0.0) -> Floats:
        """Return how much of it is done, if it takes longer by some part of its time."""
        length = max((1 + longer) * (self.stop - self.start), 1e-9)
        part = np.clip((times - self.start) / length, 0, 1)
        return part if self.flies else minimum_jerk(part)

    def within(self, times: Floats) -> tuple[slice, Floats]:
        """Return the frames that it takes, and how much of it is done in them."""
        some = slice(*np.searchsorted(times, (self.start, self.stop)).tolist())
        return some, self.share(times[some])


def _add(steps: Floats, some: slice, done: Floats, whole: Any) -> None:
    """Add to the steps of a sum, frame by frame, what comes to it over some frames."""
    if len(done):
        steps[some] += np.diff(done, axis=0, prepend=0 * done[:1])
        whole = whole - done[-1]
    if some.stop < len(steps):
        steps[some.stop] += whole


def going(score: Score, times: Floats, body: Body) -> Going | None:
    """Return how the body goes, where the score tells anything of it.

    Parameters
    ----------
    score : Score
        What is to be carried out.
    times : ndarray
        (T,) seconds.
    body : Body
        Who carries it out.
    """
    shown = {part: _shown(score, part) for part in WEIGHT}
    if not any(len(rows) for rows in shown.values()):
        return None
    rate = float(score.rate)
    front, moves = _front(shown["body_turn"], times, rate), _moves(shown, rate)
    leg = sum(float(np.linalg.norm(_bone(body, f"R{joint}"))) for joint in ("Knee", "Ankle"))
    place, high = _place(moves, times, front, leg)
    levels, asked = _levels(_begun(score), moves, times), _asked(score, times)
    heels, toe = np.maximum(levels, 0), _bone(body, "RToe")
    ankle = body.sole - float(toe[1])
    stands = np.minimum(REACHES + levels, heels + np.maximum(*asked))
    up = ankle + leg * (stands + high) - _hip(body, "r")[1]
    hips = np.stack((place[:, 0], up, place[:, 1]), axis=1)
    size, ahead = float(np.linalg.norm(toe)), _over(front + np.pi / 2)
    back = np.sqrt(size**2 - np.minimum(leg * heels - toe[1], 0.99 * size) ** 2)
    legs = dict[str, Floats]()
    for side, reach in zip(SIDES, asked, strict=True):
        hip = _hip(body, side)
        over, raised = _foot(side, moves, times, place, front, hip, high)
        tip = over + toe[0] * ahead  # the toe stays where the heel cannot
        heel = tip - back[:, None] * ahead
        target = np.stack((heel[:, 0], ankle + leg * (raised + heels), heel[:, 1]), axis=1)
        way = (_turned(target - hips, -front) - hip) / leg
        size, free = np.linalg.norm(way, axis=1), np.clip((raised - high) / LIFTED, 0, 1)
        way *= (1 - free * np.maximum(1 - reach / np.maximum(size, 1e-9), 0))[:, None]
        thigh, shank = _bent(way)
        point = np.stack((tip[:, 0], body.sole + leg * raised, tip[:, 1]), axis=1)
        foot = _turned(point - hips, -front) - hip - leg / 2 * (thigh + shank)
        foot /= np.linalg.norm(foot, axis=1, keepdims=True)
        legs |= {f"{side}_thigh": thigh, f"{side}_shank": shank, f"{side}_foot": foot}
    return Going(front, hips, legs)


def _asked(score: Score, times: Floats) -> tuple[Floats, Floats]:
    """Return how much of their lengths the legs may reach, right and left; all, if not told."""
    tracks = [score.tracks.get(f"{side}_leg_bend") for side in SIDES]
    right, left = (
        np.ones(len(times)) if track is None else bent(track.symbols, times, score.rate)
        for track in tracks
    )
    return right, left


def _place(moves: list[_Move], times: Floats, front: Floats, leg: float) -> tuple[Floats, Floats]:
    """Return where the body is over the ground, (T, 2) mm, and how high it flies, in legs."""
    place, high = np.zeros((len(times), 2)), np.zeros(len(times))
    for move in moves:
        turned = float(np.interp(move.stop, times, front))
        way = STRIDE * leg * _over(np.radians(45.0 * move.direction) + turned)
        some, share = move.within(times)
        if move.direction != PLACE:
            _add(place, some, way * share[:, None], way)
        if move.flies:
            high[some] += DRAWN / 2 * (move.stop - move.start) ** 2 * share * (1 - share)
    return place.cumsum(axis=0), high


def _shown(score: Score, part: str) -> Rows:
    rows = score.tracks[part].symbols if part in score.tracks else np.zeros(0, SYMBOL)
    shown: Rows = rows[~rows["passing"] & (rows["stop"] > rows["start"])]
    return shown


def _front(rows: Rows, times: Floats, rate: float) -> Floats:
    """Return how far the body has turned to the left, radians."""
    front = np.zeros(len(times))
    for row in rows:
        move = _Move(row["start"] / rate, row["stop"] / rate, PLACE, -1, "")
        sign = 1 if row["direction"] == DIRECTION_CODES["left"] else -1
        whole = sign * np.radians(float(row["amount"]))
        some, share = move.within(times)
        _add(front, some, whole * share, whole)
    return front.cumsum()


def _moves(shown: dict[str, Rows], rate: float) -> list[_Move]:
    """Return what takes the body along, in order of time: steps, and flights with their feet."""
    moves = list[_Move]()
    supports = {side: shown[f"{side}_support"] for side in SIDES}
    lands = {side: np.zeros(len(own), bool) for side, own in supports.items()}
    for row in shown["jump"]:
        feet, level = "", -1
        for side, own in supports.items():
            first = int(np.searchsorted(own["stop"], row["start"], "right"))
            last = int(np.searchsorted(own["start"], row["stop"]))
            if first < last:
                feet, level = feet + side, int(own["level"][last - 1])
                lands[side][first:last] = True
        word = FEET[row["amount"]] if 0 <= row["amount"] < len(FEET) else "unseen"
        feet = feet or (SIDES if _LANDS[word] == 2 else SIDES[0])
        start, stop = row["start"] / rate, row["stop"] / rate
        moves.append(_Move(start, stop, int(row["direction"]), level, feet, True))
    for side, own in supports.items():
        for row in own[~lands[side]]:
            start, stop = row["start"] / rate, row["stop"] / rate
            moves.append(_Move(start, stop, int(row["direction"]), int(row["level"]), side))
    return sorted(moves, key=lambda move: move.stop)


def _begun(score: Score) -> int:
    """Return the level at which the feet stand at first; -1 where nothing tells."""
    for side in SIDES:
        track = score.tracks.get(f"{side}_support")
        if track and len(track) and track.symbols["start"][0] == track.symbols["stop"][0]:
            return int(track.symbols["level"][0])
    return -1


def _levels(begun: int, moves: list[_Move], times: Floats) -> Floats:
    """Return how much higher the body is than with straight legs, in lengths of a leg."""
    height = {LOW: -SINKS, HIGH: HEELS}
    knots, values = [-1.0], [height.get(begun, 0.0)]
    for move in moves:
        if move.level >= 0:
            knots += [max(move.start, knots[-1] + 1e-6), max(move.stop, knots[-1] + 2e-6)]
            values += [values[-1], height.get(move.level, 0.0)]
    return np.interp(times, knots, values)


def _foot(
    side: str,
    moves: list[_Move],
    times: Floats,
    place: Floats,
    front: Floats,
    offset: Floats,
    high: Floats,
) -> tuple[Floats, Floats]:
    """Return where an ankle is over the ground, (T, 2) mm, and how high, in lengths of a leg."""
    beside = place + offset[2] * _over(front)
    over, raised = np.tile(beside[0], (len(times), 1)), high.copy()
    own = [move for move in moves if side in move.feet or move.flies]
    if not own:  # a body that turns without a step takes its feet along
        return beside, raised
    begins = [int(np.searchsorted(times, move.start)) for move in own]
    free = False
    for move, now, until in zip(own, begins, [*begins, len(times)][1:], strict=True):
        now, until = min(now, len(times) - 1), max(now, until)
        last = min(int(np.searchsorted(times, move.stop)), len(times) - 1)
        some = slice(now, until)
        share = move.share(times[some], 0.0 if move.flies else SETTLES)
        held = FREE if free else 0.0
        free = side not in move.feet
        if free:
            over[some] = beside[some]
            raised[some] = high[some] + held + (FREE - held) * share
            continue
        begun = over[max(now - 1, 0)].copy()
        along = beside[some] if move.flies else beside[last]
        over[some] = begun + (along - begun) * share[:, None]
        over[max(last, now) : until] = beside[last] if move.flies else over[max(last, now) : until]
        raised[some] = high[some] + held * (1 - share)
        raised[some] += (not move.flies) * 4 * LIFTS * share * (1 - share)
    return over, raised


def _bent(way: Floats) -> tuple[Floats, Floats]:
    """Return where thigh and shank point for an ankle to lie there, (T, 3) lengths of the leg."""
    reach = np.linalg.norm(way, axis=1, keepdims=True)
    along = way / np.maximum(reach, 1e-9)
    reach = np.minimum(reach, 1.0)
    ahead = np.array([1.0, 0.0, 0.0])
    aside = ahead - (along @ ahead)[:, None] * along
    size = np.linalg.norm(aside, axis=1, keepdims=True)
    aside = np.where(size > 1e-6, aside / np.maximum(size, 1e-6), UP)
    bow = np.sqrt(np.maximum(1 - reach**2, 0)) * aside
    return reach * along + bow, reach * along - bow


def _bone(body: Body, joint: str) -> Floats:
    """Return the offset of a joint of the body model, in the body frame at rest, mm."""
    x, y, z = body.skeleton.offsets[body.skeleton.body[JOINT_CODES[joint]]].astype(float)
    return np.array([z, y, -x])


def _hip(body: Body, side: str) -> Floats:
    return _bone(body, f"{side.upper()}Hip")


def _over(azimuth: Any) -> Floats:
    """Return directions over the ground, (..., 2): forward, right; 0 is right, 90 forward."""
    return np.stack((np.sin(azimuth), np.cos(azimuth)), axis=-1)


def _turned(vectors: Floats, left: Floats) -> Floats:
    """Turn vectors, (T, 3), to the left about the vertical by (T,) radians."""
    sine, cosine = np.sin(left), np.cos(left)
    forward, right = vectors[:, 0], vectors[:, 2]
    turned = (forward * cosine + right * sine, vectors[:, 1], right * cosine - forward * sine)
    return np.stack(turned, axis=1)
