"""How the standard body travels: steps, jumps and turns to its place, its front and its legs.

Source: ``encoding/BODY.md``, read backwards.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTION_CODES, FEET, HIGH, LOW, PLACE
from lanindex.model import Score
from lanindex.perform.limbs import (
    FORWARD,
    UP,
    Body,
    dot,
    minimum_jerk,
    reach_when_bent,
    shown,
    unit,
)
from lanindex.perform.resting import (
    LIES,
    CarrierSpan,
    MovedParts,
    Rest,
    RestBlend,
    above,
    carrier_spans,
    direction_at,
    part,
    plan_rests,
    slerp,
    straight,
)

Floats = NDArray[np.float64]

LIFTED = 0.05  # lengths of a leg above the floor: a foot so high goes wherever the knee takes it
HEIGHTS = 70  # hundredths of a leg in which the height is looked for at which a body rests
SITS = 0.12  # lengths of a leg above the floor: so high are hips that sit
TOES = 64.0  # millimetres from the toe's joint to its tip

SIDES = "rl"


@dataclass(frozen=True, slots=True, eq=False)
class FootPlacement:
    """Where the feet are, frame by frame; in lengths of a leg but for `over`."""

    # (T, 2) mm, by side: where the ankle is over the ground while the heel is down
    over: dict[str, Floats]
    raised: dict[str, Floats]  # (T,) height of the foot
    heels: dict[str, Floats]  # (T,) height of the heel above it
    knees: dict[str, Floats]  # (T, 3) unit vectors of the body frame: where the knee goes
    high: Floats  # (T,) height of the body's flight

    def at(self, frame: int, count: int) -> FootPlacement:
        """Return one frame so many times."""
        some = np.full(count, frame)
        over, raised, heels, knees = (
            {side: it[some] for side, it in one.items()}
            for one in (self.over, self.raised, self.heels, self.knees)
        )
        return FootPlacement(over, raised, heels, knees, self.high[some])


def leg_bones(
    side: str, hips: Floats, front: Floats, stand: FootPlacement, reach: Floats, body: Body
) -> dict[str, Floats]:
    """Return the directions of a leg's bones, (T, 3), to its foot's place."""
    joint, ahead = body.hips[side], toward(front + np.pi / 2)
    foot_size, raised = float(np.linalg.norm(body.toe)), stand.raised[side]
    back = body.leg * stand.heels[side] - body.toe[1]
    back = np.sqrt(foot_size**2 - np.minimum(back, 0.99 * foot_size) ** 2)
    tip = stand.over[side] + body.toe[0] * ahead  # the toe stays where the heel cannot
    heel = tip - back[:, None] * ahead
    height = body.ankle + body.leg * (raised + stand.heels[side])
    target = np.stack((heel[:, 0], height, heel[:, 1]), axis=1)
    way = (turned(target - hips, -front) - joint) / body.leg
    far, free = np.linalg.norm(way, axis=1), np.clip((raised - stand.high) / LIFTED, 0, 1)
    way *= (1 - free * np.maximum(1 - reach / np.maximum(far, 1e-9), 0))[:, None]
    reach = np.linalg.norm(way, axis=1, keepdims=True)
    along, reach = unit(way), np.minimum(reach, 1.0)
    aside = stand.knees[side] - dot(along, stand.knees[side]) * along
    size = np.linalg.norm(aside, axis=1, keepdims=True)
    aside = np.where(size > 1e-6, aside / np.maximum(size, 1e-6), UP)
    bow = np.sqrt(np.maximum(1 - reach**2, 0)) * aside
    thigh, shank = reach * along + bow, reach * along - bow
    point = np.stack((tip[:, 0], body.sole + body.leg * raised, tip[:, 1]), axis=1)
    foot = unit(turned(point - hips, -front) - joint - body.leg / 2 * (thigh + shank))
    toes = above(foot, (body.sole + body.leg * raised) / TOES)
    return {
        f"{side}_thigh": thigh,
        f"{side}_shank": shank,
        f"{side}_foot": foot,
        f"{side}_toes": toes,
    }


def resting_height(
    rest: Rest, times: Floats, hips: Floats, front: Floats, stand: FootPlacement, body: Body
) -> float:
    """Return the height of the hips of a resting body whose lower knee is on the floor."""
    leg = body.leg
    if rest.pose.up is not None:
        return leg * rest.pose.up
    frame = min(int(np.searchsorted(times, min(rest.stop, rest.rise[0]))), len(times) - 1)
    heights = leg * np.arange(HEIGHTS) / 100
    there = np.tile(hips[frame], (HEIGHTS, 1))
    there[:, 1] = heights
    some, ahead = stand.at(frame, HEIGHTS), np.full(HEIGHTS, front[frame])
    knees = [
        heights
        + leg
        / 2
        * leg_bones(side, there, ahead, some, np.ones(HEIGHTS), body)[f"{side}_thigh"][:, 1]
        for side in SIDES
    ]
    sunk = np.flatnonzero(np.minimum(*knees) < LIES * leg)
    if not len(sunk):  # knees that stand up carry nothing
        return leg * SITS
    return float(heights[min(sunk[-1] + 1, HEIGHTS - 1)])


def toward(azimuth: Any) -> Floats:
    """Return directions over the ground, (..., 2): forward, right; 0 is right, 90 forward."""
    return np.stack((np.sin(azimuth), np.cos(azimuth)), axis=-1)


def turned(vectors: Floats, left: Floats) -> Floats:
    """Turn vectors, (T, 3), to the left about the vertical by (T,) radians."""
    sine, cosine = np.sin(left), np.cos(left)
    forward, right = vectors[:, 0], vectors[:, 2]
    turned = (forward * cosine + right * sine, vectors[:, 1], right * cosine - forward * sine)
    return np.stack(turned, axis=1)


STRIDE, SHORT = 0.45, 0.22  # lengths of a leg that a step takes the body, at most and at least
# Lengths of a leg that the toe may hang above the floor which a step leaves behind: steps back,
# and to the side on the toes, are shorter
HANGS = 0.03
# Lengths of a leg that the body sinks for a low step, and that heels rise for a high one
SINKS, HEELS = 0.16, 0.11
HEIGHT = {LOW: -SINKS, HIGH: HEELS}  # lengths of a leg that a step takes the body up, by its level
REACHES = 0.995  # part of its length that a leg that carries has from hip to ankle
BRIEF = 0.1  # seconds: a step that begins so soon after a rest begins at once
DRAWN = 12.0  # lengths of a leg a second squared: how bodies fall


@dataclass(frozen=True, slots=True)
class Move:
    """A step, a flight or the drawing of a foot, in seconds."""

    start: float
    stop: float
    direction: int  # Codes of the alphabet; -1: none
    level: int
    feet: str  # Sides of the feet that stand anew
    flies: bool = False  # Whether the body is in the air
    # (2,) mm: where a foot is drawn that is not lifted, while the body goes nowhere
    to: Floats | None = None

    @property
    def steps(self) -> bool:
        """Whether a foot is lifted, and stands anew."""
        return not self.flies and self.to is None

    def share(self, times: Floats, longer: float = 0.0) -> Floats:
        """Return the share done, (T,), if it takes `longer` by that share of its time."""
        length = max((1 + longer) * (self.stop - self.start), 1e-9)
        part = np.clip((times - self.start) / length, 0, 1)
        return part if self.flies else minimum_jerk(part)

    def within(self, times: Floats) -> tuple[slice, Floats]:
        """Return its frames, and the share done in them."""
        some = slice(*np.searchsorted(times, (self.start, self.stop)).tolist())
        return some, self.share(times[some])


def add(steps: Floats, frames: slice, values: Floats, total: Any) -> None:
    """Add to per-frame increments those of a value that grows to `total` over some frames."""
    if len(values):
        steps[frames] += np.diff(values, axis=0, prepend=0 * values[:1])
        total = total - values[-1]
    if frames.stop < len(steps):
        steps[frames.stop] += total


class FeetPath:
    """Places of body and feet, move after move."""

    def __init__(self, body: Body, times: Floats, front: Floats) -> None:
        self.body, self.times, self.front = body, times, front
        # (T, 2) mm from frame to frame that steps move the hips, and that rests move them
        self.steps, self.shift = np.zeros((2, len(times), 2))
        self.high = np.zeros(len(times))  # Height of flights in lengths of a leg
        # Feet that are drawn up while the body rests, or behind it as it rises
        self.drawn = list[Move]()
        self._now, self._until = np.zeros(2), -np.inf
        self._feet = self._joints(0.0)

    def follow(
        self, moves: Sequence[Move], rests: Sequence[Rest], placed: Sequence[dict[str, Floats]]
    ) -> None:
        """Apply moves and rests; `placed` are feet by rest and side that a score places itself."""
        feet = dict(zip(rests, placed, strict=True))
        both: list[Move | Rest] = [*moves, *rests]
        for one in sorted(both, key=lambda it: it.stop):
            if isinstance(one, Move):
                self._move(one)
                continue
            if not moves:  # its feet have turned along
                self._feet = self._joints(self._front(one.start))
            self._rest(one, feet[one])

    def _front(self, time: float) -> float:
        return float(np.interp(time, self.times, self.front))

    def _joints(self, front: float) -> dict[str, Floats]:
        """Return where both hips are over the ground."""
        return {side: self._now + self.body.hips[side][2] * toward(front) for side in SIDES}

    def _rest(self, rest: Rest, placed: dict[str, Floats]) -> None:
        """Bring the hips before the foot in front, or behind the other; feet are drawn up."""
        leg, before = self.body.leg, toward(self._front(rest.start) + np.pi / 2)
        apart = abs(float((self._feet["r"] - self._feet["l"]) @ before)) / 2
        away = leg * rest.pose.ahead + np.copysign(apart, rest.pose.ahead)
        self._shift((self._feet["r"] + self._feet["l"]) / 2 + away * before, rest.forth)
        front = self._front(rest.stop)
        back = np.array([-rest.pose.ahead, 0.0])
        for side, joint in self._joints(front).items():
            ahead, right = leg * placed.get(side, back)
            to = joint + ahead * toward(front + np.pi / 2) + right * toward(front)
            self._feet[side] = to
            self.drawn.append(Move(*rest.draws, PLACE, -1, side, to=to))
        self._until = rest.stop
        if rest.returns:
            self._shift((self._feet["r"] + self._feet["l"]) / 2, rest.back)

    def _shift(self, place: Floats, window: tuple[float, float]) -> None:
        some = slice(*np.searchsorted(self.times, window).tolist())
        way_there = place - self._now
        add(self.shift, some, way_there * part(self.times[some], window)[:, None], way_there)
        self._now = place

    def _move(self, move: Move) -> None:
        """Step or jump."""
        body, front = self.body, self._front(move.stop)
        some, share = move.within(self.times)
        toe, reach = body.toe[0] * toward(front + np.pi / 2), body.leg + np.linalg.norm(body.toe)
        high = body.leg * (REACHES + HEIGHT.get(move.level, 0.0) - HANGS) - body.toe[1]
        room = np.sqrt(max(reach**2 - high**2, 0))  # of a toe near the floor, over the ground
        if move.direction != PLACE:
            way, stride = toward(np.radians(45.0 * move.direction) + front), STRIDE
            if not move.flies:  # so far that the other foot keeps its toe near the floor
                side = SIDES[1 - SIDES.index(move.feet)]
                away = self._feet[side] + toe - self._joints(front)[side]
                along = float(away @ way)
                square = along**2 - float(away @ away) + room**2
                stride = np.clip((along + np.sqrt(max(square, 0))) / body.leg, SHORT, STRIDE)
            way *= body.leg * stride
            add(self.steps, some, way * share[:, None], way)
            self._now = self._now + way
        for side, joint in self._joints(front).items():
            if move.flies or side in move.feet:
                self._feet[side] = joint
            elif move.start < self._until + BRIEF:  # it carries a body that rises as it steps
                away = self._feet[side] + toe - joint
                far = float(np.hypot(*away))
                if far > room:
                    self._feet[side] = to = joint + room / far * away - toe
                    begin = max(move.start, self._until)
                    self.drawn.append(Move(begin, move.stop, PLACE, -1, side, to=to))
        if move.flies:
            self.high[some] += DRAWN / 2 * (move.stop - move.start) ** 2 * share * (1 - share)
        self._until = -np.inf


Rows = NDArray[Any]
Bones = dict[str, Floats]  # by bone, or by side
# Lengths of a leg that a foot is lifted on its way, and that a foot hangs that does not carry
LIFTS, FREE = 0.15, 0.25
SETTLES = 0.1  # part of a step's time that a foot that carries still takes to come to rest
GIVES = 0.04  # lengths of a leg that hips sink at most for a toe to stay on the floor
# How often hips are raised for knees that would sink, and millimetres that these lie high
SETTLED, FLESH = 5, 30.0
PRONE = 0.7  # how far forward a trunk leans that lies face down: half a right angle
# Lengths of a leg from where a foot is while something else carries: it is told to go there
ELSEWHERE = 0.5
# The cosine between where a bone of a leg points and where it is told to: of three borders
UNLIKE = 0.38
WEIGHT = ("r_support", "l_support", "jump", "body_turn")  # the tracks that are carried out here

_LANDS = {"spring": 2, "hop": 1, "leap": 1, "assemble": 2, "sissonne": 1, "unseen": 2}


@dataclass(frozen=True, slots=True, eq=False)
class Travel:
    """Where the body is, how it faces, and where its legs point."""

    front: Floats  # (T,) radians turned to the left
    hips: Floats  # (T, 3) mm: forward of the start, above the floor, right of the start
    legs: dict[str, Floats]  # (T, 3) unit vectors of the body frame, by bone
    resting: RestBlend
    left_out: tuple[str, ...]  # Warnings


def travel_of(score: Score, times: Floats, body: Body, bones: dict[str, Floats]) -> Travel | None:
    """Return how the body goes at seconds, (T,), where the score tells anything of it."""
    moving = {name: shown(score, name) for name in WEIGHT}
    moving = {name: rows[rows["stop"] > rows["start"]] for name, rows in moving.items()}
    carried = carrier_spans(score)
    if not carried and not any(len(rows) for rows in moving.values()):
        return None
    rate = float(score.rate)
    front = _front(moving["body_turn"], times, rate)
    moves, left_out = _free_moves(_moves(moving, rate), carried)
    for number, (start, stop, what) in enumerate(carried):
        lean = bones["torso"][min(int(np.searchsorted(times, (start + stop) / 2)), len(times) - 1)]
        if what == "trunk" and lean[0] > PRONE:
            carried[number] = start, stop, "prone trunk"
    busy = [(it.start, it.stop, HEIGHT.get(it.level, 0.0)) for it in moves]
    rests, doubts = plan_rests(carried, busy, score.frames / rate)
    moved, path = MovedParts(score), FeetPath(body, times, front)
    placed = _placed_feet(moved, rests, times, bones)
    path.follow(moves, rests, placed)
    feet_at, high = path.steps.cumsum(axis=0), path.high
    body_at = feet_at + path.shift.cumsum(axis=0)
    levels, legs_reach = _levels(score, moves, times), dict[str, Floats]()
    over, raised = dict[str, Floats](), dict[str, Floats]()
    own = sorted((*moves, *path.drawn), key=lambda it: it.start)
    for side in SIDES:
        legs_reach[side] = reach_when_bent(shown(score, f"{side}_leg_bend"), times, score.rate)
        places = body_at, feet_at
        over[side], raised[side] = _foot(side, own, times, places, front, body.hips[side], high)
    heels = np.maximum(levels, 0)
    stands = np.minimum(REACHES + levels, heels + np.maximum(*legs_reach.values()))
    resting = RestBlend(rests, times)
    heel, knees = _heels_and_knees(resting, placed, times, heels)
    stand = FootPlacement(over, raised, heel, knees, high)
    up = body.ankle + body.leg * (stands + high)
    up = _hip_heights(up, body_at, front, stand, body)
    hips = np.stack((body_at[:, 0], up, body_at[:, 1]), axis=1)
    lies = [resting_height(it, times, hips, front, stand, body) for it in rests]
    hips[:, 1] = resting.blended(up, lies, straight)
    legs = dict[str, Floats]()
    for _ in range(SETTLED):  # hips rise where a knee would sink
        sinks = np.zeros(len(hips))
        for side in SIDES:
            reach = straight(legs_reach[side], np.ones(len(hips)), resting.done)
            legs |= leg_bones(side, hips, front, stand, reach, body)
            thigh = body.leg / 2 * legs[f"{side}_thigh"][:, 1]
            sinks = np.maximum(sinks, FLESH - hips[:, 1] - thigh)
        if not sinks.any():
            break
        hips[:, 1] += sinks
    unlike = tuple(_leg_doubts(moved, rests, times, bones, legs, legs_reach))
    if not any(map(len, moving.values())):  # it stands, and does nothing but rest
        limbs = [f"{side}_{it}" for side in SIDES for it in ("leg", "thigh", "shank", "foot")]
        only = "goes as told only while something else than feet carries"
        unlike += tuple(f"{name} {only}" for name in limbs if moved.beside(rests, name))
    return Travel(front, hips, legs, resting, (*left_out, *doubts, *unlike))


def _heels_and_knees(
    resting: RestBlend, placed: Sequence[dict[str, Floats]], times: Floats, heels: Floats
) -> tuple[Bones, Bones]:
    """Return how high heels are raised, (T,), and where knees go, (T, 3), by side."""
    heel, knees = dict[str, Floats](), dict[str, Floats]()
    ahead, rests = np.tile(FORWARD, (len(times), 1)), resting.rests
    for side in SIDES:
        heel[side] = resting.blended(heels, [it.pose.heels for it in rests], straight)
        knees[side] = resting.blended(ahead, [direction_at(it.pose.knees) for it in rests], slerp)
        for rest, feet in zip(rests, placed, strict=True):
            if side in feet and feet[side][0] > 0:  # that foot stands
                some = slice(*np.searchsorted(times, (rest.start, rest.rise[1])).tolist())
                share = part(times[some], rest.draws) * (1 - part(times[some], rest.rise))
                heel[side][some] *= 1 - share
                up = np.broadcast_to(direction_at(135.0), knees[side][some].shape)
                knees[side][some] = slerp(knees[side][some], up, share)
    return heel, knees


def _placed_feet(
    moved: MovedParts, rests: Sequence[Rest], times: Floats, bones: dict[str, Floats]
) -> list[dict[str, Floats]]:
    """Return where legs have their feet that are told to go elsewhere: see `FeetPath.follow`."""
    found = list[dict[str, Floats]]()
    for rest in rests:
        feet, frame = dict[str, Floats](), rest.middle(times)
        for side in SIDES:
            thigh, shank = (f"{side}_{it}" for it in ("thigh", "shank"))
            foot = (bones[thigh][frame, ::2] + bones[shank][frame, ::2]) / 2
            elsewhere = np.hypot(foot[0] + rest.pose.ahead, foot[1]) > ELSEWHERE
            if elsewhere and moved(rest, f"{side}_leg", thigh, shank):
                feet[side] = foot
        found.append(feet)
    return found


def _leg_doubts(
    moved: MovedParts,
    rests: Sequence[Rest],
    times: Floats,
    wanted: Bones,
    legs: Bones,
    reaches: Bones,
) -> Iterator[str]:
    """Say which legs do not go as told while something else carries."""
    for rest in rests:
        frame = rest.middle(times)
        for side in SIDES:
            limb, bones = f"{side}_leg", [f"{side}_{it}" for it in ("thigh", "shank")]
            for name in bones:
                cosine = float(wanted[name][frame] @ legs[name][frame])
                if moved(rest, name, limb) and cosine < UNLIKE:
                    yield f"{name} goes as {rest.what} needs it at {rest.start:g} s, not as told"
            reach = np.linalg.norm(sum(legs[name][frame] for name in bones)) / 2
            turn = np.arccos(np.minimum((reach, reaches[side][frame]), 1))
            if moved(rest, f"{limb}_bend") and abs(turn[0] - turn[1]) > np.pi / 8:
                yield f"{limb} bends as {rest.what} needs it at {rest.start:g} s, not as told"


def _free_moves(
    moves: list[Move], carriers: Sequence[CarrierSpan]
) -> tuple[list[Move], tuple[str, ...]]:
    """Return the steps and flights that do not end while something else carries; and the others."""
    begins, free, left_out = [start for start, *_ in carriers], list[Move](), list[str]()
    for move in moves:
        number = bisect_left(begins, move.stop) - 1
        _, stop, what = carriers[number] if number >= 0 else (0.0, -1.0, "")
        if (move.start if move.flies else move.stop) > stop:
            free.append(move)
        else:
            name = "jump" if move.flies else "step"
            left_out.append(f"a {name} at {move.start:g} s is left out: {what} carries meanwhile")
    return free, tuple(left_out)


def _hip_heights(
    up: Floats, place: Floats, front: Floats, stand: FootPlacement, body: Body
) -> Floats:
    """Return how high hips are, mm, that sink a little where toes would leave the floor."""
    least = up.copy()
    longest = body.leg + float(np.linalg.norm(body.toe))
    for side in SIDES:
        joint = place + body.hips[side][2] * toward(front)
        toe = stand.over[side] + body.toe[0] * toward(front + np.pi / 2)
        far = np.linalg.norm(toe - joint, axis=1)
        floor = body.sole + body.leg * stand.raised[side]
        high = floor + np.sqrt(np.maximum(longest**2 - far**2, 0))
        least = np.minimum(least, high)
    return np.maximum(least, up - GIVES * body.leg)


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


def _moves(rows: dict[str, Rows], rate: float) -> list[Move]:
    """Return what takes the body along, in order of time: steps, and flights with their feet."""
    moves = list[Move]()
    supports = {side: rows[f"{side}_support"] for side in SIDES}
    lands = {side: np.zeros(len(own), bool) for side, own in supports.items()}
    for row in rows["jump"]:
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


def _levels(score: Score, moves: list[Move], times: Floats) -> Floats:
    """Return how much higher the body is than with straight legs, in lengths of a leg."""
    level = -1  # at which the feet stand at first
    for track in (score.tracks.get(f"{side}_support") for side in SIDES):
        if track and len(track) and track.symbols["start"][0] == track.symbols["stop"][0]:
            level = int(track.symbols["level"][0])
            break
    knots, values = [-1.0], [HEIGHT.get(level, 0.0)]
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
