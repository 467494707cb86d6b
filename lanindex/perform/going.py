"""How the standard body goes: steps, jumps and turns to its place, its front and its legs.

Source: ``encode/BODY.md``, read backwards.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTION_CODES, FEET, PLACE
from lanindex.model import SYMBOL, Score
from lanindex.perform.figure import Body
from lanindex.perform.legs import SIDES, Size, Stand, hip, leg_to, lying_height, toward
from lanindex.perform.path import HEIGHT, REACHES, Move, Path, add
from lanindex.perform.reach import FORWARD, bent
from lanindex.perform.resting import (
    Rest,
    Resting,
    Tells,
    Told,
    part,
    planned,
    slerp,
    straight,
    told,
    way,
)

Floats = NDArray[np.float64]
Rows = NDArray[Any]
Bones = dict[str, Floats]
"""By bone, or by side."""

LIFTS, FREE = 0.15, 0.25
"""Lengths of a leg that a foot is lifted on its way, and that a foot hangs that does not carry."""

SETTLES = 0.1
"""Part of a step's time that a foot that carries still takes to come to rest."""

GIVES = 0.04
"""Lengths of a leg that hips sink at most for a toe to stay on the floor."""

SETTLED, FLESH = 5, 30.0
"""How often hips are raised for knees that would sink, and millimetres that these lie high."""

PRONE = 0.7
"""How far forward a trunk leans that lies face down: half a right angle."""

ELSEWHERE = 0.5
"""Lengths of a leg from where a foot is while something else carries: it is told to go there."""

UNLIKE = 0.38
"""The cosine between where a bone of a leg points and where it is told to: of three borders."""

WEIGHT = ("r_support", "l_support", "jump", "body_turn")
"""The tracks that are carried out here."""

_LANDS = {"spring": 2, "hop": 1, "leap": 1, "assemble": 2, "sissonne": 1, "unseen": 2}


@dataclass(frozen=True, slots=True, eq=False)
class Going:
    """Where the body is, how it faces, and where its legs point."""

    front: Floats  # (T,) radians that it has turned to the left
    hips: Floats  # (T, 3) mm: forward of where it began, above the floor, right of where it began
    legs: dict[str, Floats]  # (T, 3) unit vectors of the body frame, by bone
    resting: Resting  # When something else than feet carries
    left_out: tuple[str, ...]  # What is not carried out


def going(score: Score, times: Floats, body: Body, bones: dict[str, Floats]) -> Going | None:
    """Return how the body goes, where the score tells anything of it.

    `times`: (T,) seconds; `bones`: (T, 3) where bones point as told.
    """
    shown, carried = {name: _shown(score, name) for name in WEIGHT}, told(score)
    if not carried and not any(len(rows) for rows in shown.values()):
        return None
    rate = float(score.rate)
    front = _front(shown["body_turn"], times, rate)
    moves, left_out = _on_feet(_moves(shown, rate), carried)
    carried = [_faced(it, times, bones["torso"]) for it in carried]
    busy = [(it.start, it.stop, HEIGHT.get(it.level, 0.0)) for it in moves]
    rests, doubts = planned(carried, busy, score.frames / rate)
    path = Path.of(body, times, front)
    tells = Tells(score)
    placed = _placed(tells, rests, times, bones)
    path.follow(moves, rests, placed)
    feet_at, high = path.steps.cumsum(axis=0), path.high
    body_at = feet_at + path.shift.cumsum(axis=0)
    levels, asked = _levels(_begun(score), moves, times), _asked(score, times)
    over, raised = dict[str, Floats](), dict[str, Floats]()
    own = sorted((*moves, *path.drawn), key=lambda it: it.start)
    for side in SIDES:
        places = body_at, feet_at
        over[side], raised[side] = _foot(side, own, times, places, front, hip(body, side), high)
    heels = np.maximum(levels, 0)
    stands = np.minimum(REACHES + levels, heels + np.maximum(*asked.values()))
    resting, size = Resting(rests, times), Size.of(body)
    heel, knees = _drawn_up(resting, placed, times, heels)
    stand = Stand(over, raised, heel, knees, high)
    up = size.ankle + size.leg * (stands + high)
    up = _sunk(up, body_at, front, stand, body)
    hips = np.stack((body_at[:, 0], up, body_at[:, 1]), axis=1)
    lies = [lying_height(it, times, hips, front, stand, body) for it in rests]
    hips[:, 1] = resting.blended(up, lies, straight)
    legs = _on_floor(hips, front, stand, asked, resting, body)
    stands = () if any(map(len, shown.values())) else tuple(_stands(tells, rests))
    unlike = _unlike(tells, rests, times, bones, legs, asked)
    return Going(front, hips, legs, resting, (*left_out, *doubts, *unlike, *stands))


def _on_floor(
    hips: Floats,
    front: Floats,
    stand: Stand,
    asked: Bones,
    resting: Resting,
    body: Body,
) -> Bones:
    """Return where the bones of legs point, hips raised, in place, where a knee would sink."""
    leg, legs = Size.of(body).leg, dict[str, Floats]()
    for _ in range(SETTLED):
        sinks = np.zeros(len(hips))
        for side, told_of in asked.items():
            reach = straight(told_of, np.ones(len(hips)), resting.done)
            legs |= leg_to(side, hips, front, stand, reach, body)
            sinks = np.maximum(sinks, FLESH - hips[:, 1] - leg / 2 * legs[f"{side}_thigh"][:, 1])
        if not sinks.any():
            break
        hips[:, 1] += sinks
    return legs


def _faced(one: Told, times: Floats, torso: Floats) -> Told:
    """Return what carries: of a trunk that is told to lean forward, a prone one."""
    start, stop, what = one
    lean = torso[min(int(np.searchsorted(times, (start + stop) / 2)), len(times) - 1)]
    return (start, stop, "prone trunk") if what == "trunk" and lean[0] > PRONE else one


def _drawn_up(
    resting: Resting, placed: Sequence[dict[str, Floats]], times: Floats, heels: Floats
) -> tuple[Bones, Bones]:
    """Return how high heels are raised, (T,), and where knees go, (T, 3), by side."""
    heel, knees = dict[str, Floats](), dict[str, Floats]()
    ahead, rests = np.tile(FORWARD, (len(times), 1)), resting.rests
    for side in SIDES:
        heel[side] = resting.blended(heels, [it.pose.heels for it in rests], straight)
        knees[side] = resting.blended(ahead, [way(it.pose.knees) for it in rests], slerp)
        for rest, feet in zip(rests, placed, strict=True):
            if side in feet and feet[side][0] > 0:  # that foot stands
                some = slice(*np.searchsorted(times, (rest.start, rest.rise[1])).tolist())
                share = part(times[some], rest.draws) * (1 - part(times[some], rest.rise))
                heel[side][some] *= 1 - share
                up = np.broadcast_to(way(135.0), knees[side][some].shape)
                knees[side][some] = slerp(knees[side][some], up, share)
    return heel, knees


def _placed(
    tells: Tells, rests: Sequence[Rest], times: Floats, bones: dict[str, Floats]
) -> list[dict[str, Floats]]:
    """Return where legs have their feet that are told to go elsewhere: see `Path.follow`."""
    found = list[dict[str, Floats]]()
    for rest in rests:
        feet, frame = dict[str, Floats](), rest.middle(times)
        for side in SIDES:
            thigh, shank = (f"{side}_{it}" for it in ("thigh", "shank"))
            foot = (bones[thigh][frame, ::2] + bones[shank][frame, ::2]) / 2
            elsewhere = np.hypot(foot[0] + rest.pose.ahead, foot[1]) > ELSEWHERE
            if elsewhere and tells(rest, f"{side}_leg", thigh, shank):
                feet[side] = foot
        found.append(feet)
    return found


def _unlike(
    tells: Tells, rests: Sequence[Rest], times: Floats, told: Bones, legs: Bones, asked: Bones
) -> Iterator[str]:
    """Say which legs do not go as told while something else carries."""
    for rest in rests:
        frame = rest.middle(times)
        for side in SIDES:
            limb, bones = f"{side}_leg", [f"{side}_{it}" for it in ("thigh", "shank")]
            for name in bones:
                cosine = float(told[name][frame] @ legs[name][frame])
                if tells(rest, name, limb) and cosine < UNLIKE:
                    yield f"{name} goes as {rest.what} needs it at {rest.start:g} s, not as told"
            reach = np.linalg.norm(sum(legs[name][frame] for name in bones)) / 2
            turn = np.arccos(np.minimum((reach, asked[side][frame]), 1))
            if tells(rest, f"{limb}_bend") and abs(turn[0] - turn[1]) > np.pi / 8:
                yield f"{limb} bends as {rest.what} needs it at {rest.start:g} s, not as told"


def _stands(tells: Tells, rests: Sequence[Rest]) -> Iterator[str]:
    """Say which legs do not go as told while a body stands that a score lets rest."""
    for name in (f"{side}_{it}" for side in SIDES for it in ("leg", "thigh", "shank", "foot")):
        if tells.beside(rests, name):
            yield f"{name} goes as told only while something else than feet carries"


def _on_feet(moves: list[Move], carried: Sequence[Told]) -> tuple[list[Move], tuple[str, ...]]:
    """Return the steps and flights that do not end while something else carries; and the others."""
    begins, free, left_out = [start for start, *_ in carried], list[Move](), list[str]()
    for move in moves:
        number = bisect_left(begins, move.stop) - 1
        _, stop, what = carried[number] if number >= 0 else (0.0, -1.0, "")
        if (move.start if move.flies else move.stop) > stop:
            free.append(move)
        else:
            name = "jump" if move.flies else "step"
            left_out.append(f"a {name} at {move.start:g} s is left out: {what} carries meanwhile")
    return free, tuple(left_out)


def _asked(score: Score, times: Floats) -> Bones:
    """Return how much of their lengths the legs may reach, by side; all, if not told."""
    tracks = {side: score.tracks.get(f"{side}_leg_bend") for side in SIDES}
    return {
        side: np.ones(len(times)) if track is None else bent(track.symbols, times, score.rate)
        for side, track in tracks.items()
    }


def _sunk(up: Floats, place: Floats, front: Floats, stand: Stand, body: Body) -> Floats:
    """Return how high hips are, mm, that sink a little where toes would leave the floor."""
    size, least = Size.of(body), up.copy()
    longest = size.leg + float(np.linalg.norm(size.toe))
    for side in SIDES:
        joint = place + hip(body, side)[2] * toward(front)
        toe = stand.over[side] + size.toe[0] * toward(front + np.pi / 2)
        far = np.linalg.norm(toe - joint, axis=1)
        floor = body.sole + size.leg * stand.raised[side]
        high = floor + np.sqrt(np.maximum(longest**2 - far**2, 0))
        least = np.minimum(least, high)
    return np.maximum(least, up - GIVES * size.leg)


def _shown(score: Score, part: str) -> Rows:
    rows = score.tracks[part].symbols if part in score.tracks else np.zeros(0, SYMBOL)
    shown: Rows = rows[~rows["passing"] & (rows["stop"] > rows["start"])]
    return shown


def _front(rows: Rows, times: Floats, rate: float) -> Floats:
    """Return how far the body has turned to the left, radians."""
    front = np.zeros(len(times))
    for row in rows:
        move = Move(row["start"] / rate, row["stop"] / rate, PLACE, -1, "")
        sign = 1 if row["direction"] == DIRECTION_CODES["left"] else -1
        whole = sign * np.radians(float(row["amount"]))
        some, share = move.within(times)
        add(front, some, whole * share, whole)
    return front.cumsum()


def _moves(shown: dict[str, Rows], rate: float) -> list[Move]:
    """Return what takes the body along, in order of time: steps, and flights with their feet."""
    moves = list[Move]()
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
        moves.append(Move(start, stop, int(row["direction"]), level, feet, True))
    for side, own in supports.items():
        for row in own[~lands[side]]:
            start, stop = row["start"] / rate, row["stop"] / rate
            moves.append(Move(start, stop, int(row["direction"]), int(row["level"]), side))
    return sorted(moves, key=lambda move: move.stop)


def _begun(score: Score) -> int:
    """Return the level at which the feet stand at first; -1 where nothing tells."""
    for side in SIDES:
        track = score.tracks.get(f"{side}_support")
        if track and len(track) and track.symbols["start"][0] == track.symbols["stop"][0]:
            return int(track.symbols["level"][0])
    return -1


def _levels(begun: int, moves: list[Move], times: Floats) -> Floats:
    """Return how much higher the body is than with straight legs, in lengths of a leg."""
    knots, values = [-1.0], [HEIGHT.get(begun, 0.0)]
    for move in moves:
        if move.level >= 0:
            knots += [max(move.start, knots[-1] + 1e-6), max(move.stop, knots[-1] + 2e-6)]
            values += [values[-1], HEIGHT.get(move.level, 0.0)]
    levels: Floats = np.interp(times, knots, values)
    return levels


def _foot(
    side: str,
    moves: list[Move],
    times: Floats,
    places: tuple[Floats, Floats],
    front: Floats,
    offset: Floats,
    high: Floats,
) -> tuple[Floats, Floats]:
    """Return where an ankle is over the ground, (T, 2) mm, and how high, in lengths of a leg."""
    beside, stood = (place + offset[2] * toward(front) for place in places)
    own = [move for move in moves if side in move.feet or move.flies]
    goes = any(move.to is None for move in own)
    along = 0 * stood if goes else stood  # a body that turns without a step takes its feet along
    over, raised = along + (beside[0] if goes else 0), high.copy()
    begins = [int(np.searchsorted(times, move.start)) for move in own]
    free = False
    for move, now, until in zip(own, begins, [*begins, len(times)][1:], strict=True):
        now, until = min(now, len(times) - 1), max(now, until)
        last = min(int(np.searchsorted(times, move.stop)), len(times) - 1)
        some, begun = slice(now, until), over[max(now - 1, 0)].copy()
        share = move.share(times[some], SETTLES if move.steps else 0.0)
        held = FREE if free else 0.0
        free = side not in move.feet
        if free:
            over[some] = beside[some]
            raised[some] = high[some] + held + (FREE - held) * share
            continue
        raised[some] = high[some] + held * (1 - share)
        if move.to is not None:
            begun, there = begun - along[max(now - 1, 0)], move.to - along[last]
            over[some] = along[some] + begun + (there - begun) * share[:, None]
            continue
        there = beside[some] if move.flies else beside[last]
        over[some] = begun + (there - begun) * share[:, None]
        over[max(last, now) : until] = beside[last] if move.flies else over[max(last, now) : until]
        raised[some] += move.steps * 4 * LIFTS * share * (1 - share)
    return over, raised
