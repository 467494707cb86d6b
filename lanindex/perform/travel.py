"""How the standard body travels and rests: where it is, and where its bones point.

Steps, jumps and turns take it along; it kneels, sits, lies or props itself where something else
than feet carries. Source: ``encoding/BODY.md``, read backwards. Lengths are those of a leg, angles
degrees from straight down to forward, unless a comment says otherwise.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import CARRIERS, DIRECTION_CODES, FEET, HIGH, LOW, PLACE
from lanindex.data import shipped
from lanindex.model import Score
from lanindex.model.score import rows_of
from lanindex.perform.limbs import (
    FORWARD,
    UP,
    Body,
    Floats,
    dot,
    great_circle,
    minimum_jerk,
    reach_when_bent,
    share_done,
    turned,
    unit,
)

OTHER = "other_support"  # the track that is carried out here
# Seconds that the body takes to come down and to rise, and that it takes at least
DOWN, RISES, LEAST = 0.9, 0.8, 0.4
LANDS = 0.15  # seconds after a step that its leg still tells the level

# Seconds in which feet are drawn up at least, and before a rest ends; and at most
DRAWS = (0.1, 1.0)
SIDES = "rl"
Rows = NDArray[Any]
Bones = dict[str, Floats]  # by bone, or by side

_RANKS = ("other", "knee", "hand", "seat", "trunk")  # carriers; of several the last one is written
LIES = 0.07  # lengths of a leg above the floor: so high lies a knee or a wrist that carries

Window = tuple[float, float]
CarrierSpan = tuple[float, float, str]
"""From when to when something else than feet carries, in seconds, and what."""


@dataclass(frozen=True, slots=True)
class Pose:
    """How the body rests on one carrier."""

    ahead: float  # Of the hips before the feet
    # How long before it has come down support begins, and after it begins to rise support ends:
    # seconds, if it is on the way for one; else with the power of 1.5 of that time
    comes: float
    leaves: float
    up: float | None = None  # Height of the hips; None: such that the lower knee lies at `LIES`
    heels: float = 0.0  # How high they are raised
    knees: float = 90.0  # Direction in which they bend
    trunk: float | None = None  # Direction; None: as before
    props: bool = False  # Whether hands carry
    least: float = 0.25  # Seconds that it lasts at least to be seen
    # In which part of the time hips come there over the ground, before they have come down
    early: float = 1.0
    drop: float = 1.0  # How far what carries comes down, about

    def slower(self, height: float) -> float:
        """Return how much longer it takes who stands so much higher than with straight legs."""
        return float(np.sqrt(self.drop / (self.drop + height)))


POSES = {name: Pose(**row) for name, row in shipped("perform/figure.toml")["poses"].items()}
"""By what carries."""


@dataclass(frozen=True, slots=True)
class Rest:
    """A time in which something else than feet carries, in seconds."""

    start: float  # Of the symbol
    stop: float
    down: Window  # In which the body comes down
    rise: Window  # In which it rises
    what: str  # What carries
    # Whether the hips come back over the feet as it rises: not if it steps at once, or goes on
    # resting on something else
    returns: bool

    @property
    def pose(self) -> Pose:
        """How the body rests."""
        return POSES[self.what]

    @property
    def forth(self) -> Window:
        """From when to when the hips come before or behind the feet."""
        return self.down[0], self.down[0] + self.pose.early * (self.down[1] - self.down[0])

    @property
    def back(self) -> Window:
        """From when to when the hips come back over the feet."""
        return self.rise[1] - self.pose.early * (self.rise[1] - self.rise[0]), self.rise[1]

    @property
    def draws(self) -> Window:
        """From when to when feet are drawn up: before it ends, so that no step is seen."""
        until = max(self.stop - DRAWS[0], self.start + DRAWS[0])
        return self.start, min(until, self.start + DRAWS[1])


def carrier_spans(score: Score) -> list[CarrierSpan]:
    """Return from when to when something else than feet carries, in seconds, and what."""
    rate = float(score.rate)
    return [
        (float(row["start"]) / rate, float(row["stop"]) / rate, CARRIERS[row["amount"]])
        for row in rows_of(score, OTHER)
        if 0 <= row["amount"] < len(CARRIERS) and row["start"] < row["stop"]
    ]


def plan_rests(
    carriers: Sequence[CarrierSpan], moves: Sequence[Move], last: float
) -> tuple[list[Rest], list[str]]:
    """Return how the body comes down to each carrier and rises, and which have no time for it."""
    joined = [None, *map(_joined, carriers[:-1], carriers[1:]), None]
    halves = [-np.inf, *((one[1] + two[0]) / 2 for one, two in pairwise(carriers)), np.inf]
    ends, rests, doubts = [it.stop for it in moves], list[Rest](), list[str]()
    for number, (start, stop, what) in enumerate(carriers):
        pose, (before, after) = POSES[what], joined[number : number + 2]
        past, next_one = bisect_right(ends, start), bisect_right(ends, stop)
        step_end, height = -np.inf, 0.0
        if past:
            step_end, height = ends[past - 1] + LANDS, moves[past - 1].height
        length = min(max(start - max(step_end, halves[number]), LEAST), DOWN)
        until = start + pose.comes * pose.slower(height) * length**1.5 if start > 0 else 0.0
        down = before or (until - length, until)
        room, returns = halves[number + 1] - stop, after is None
        if next_one < len(moves):
            step = moves[next_one]
            begin = step.start
            if begin - stop < LEAST:
                returns, begin, height = False, step.stop, min(height, step.height)
            room = min(room, begin - stop)
        length = min(max(room, LEAST), RISES)
        begin = stop - pose.leaves * pose.slower(height) * length**1.5
        rise = after or ((begin, begin + length) if stop < last else (stop + 1, stop + 2))
        rests.append(Rest(start, stop, down, rise, what, returns))
        tight = (not before and 0 < start < step_end - LANDS + LEAST / 2) or room < LEAST / 2
        if tight or after:
            late = "there is no time to come down, or to rise"
            doubts.append(f"{what} carries at {start:g} s: {late}")
        if stop - start < pose.least:
            doubts.append(f"{what} carries at {start:g} s for so short a time that nobody sees it")
    return rests, list(dict.fromkeys(doubts))


def _joined(one: CarrierSpan, two: CarrierSpan) -> Window | None:
    """Return from when to when a body goes from one support to the next, if it does not rise."""
    gap = two[0] - one[1]
    if gap >= 1.25 * LEAST:
        return None
    length = max(gap, 1.5 * LEAST)
    ranks = [_RANKS.index(it[2].removeprefix("prone ")) for it in (one, two)]
    if ranks[1] > ranks[0]:
        until = two[0] + POSES[two[2]].comes * length**1.5
        return until - length, until
    begin = one[1] - POSES[one[2]].leaves * length**1.5
    return begin, begin + length


class Resting:
    """The rests of a score in the frames of a motion, and what the score moves meanwhile."""

    def __init__(self, score: Score, rests: Sequence[Rest], times: Floats) -> None:
        self.rests, self.times, self.done = rests, times, np.zeros(len(times))
        middles = [(rest.start + rest.stop) / 2 for rest in rests]
        self.middles = [_frame(time, times) for time in middles]  # the frame amid each rest
        self._shares = list[tuple[slice, Floats]]()
        for rest in rests:
            some = slice(*np.searchsorted(times, (rest.down[0], rest.rise[1])).tolist())
            share = share_done(times[some], *rest.down) * (1 - share_done(times[some], *rest.rise))
            self.done[some] += share
            self._shares.append((some, share / np.maximum(self.done[some], 1e-9)))
        self._begins = dict[str, Floats]()
        for part in score.tracks:
            rows = rows_of(score, part)
            rows = rows[rows["stop"] > rows["start"]]
            self._begins[part] = np.sort(rows["start"] / float(score.rate))

    def moves(self, rest: Rest, *parts: str) -> bool:
        """Return whether the score moves one of some parts while the body comes down or rests."""
        return any(self._count(rest, part) for part in parts)

    def moves_beside(self, part: str) -> bool:
        """Return whether the score moves a part at another time."""
        begins = self._begins.get(part, ())
        return len(begins) > sum(self._count(rest, part) for rest in self.rests)

    def _count(self, rest: Rest, part: str) -> int:
        begins = self._begins.get(part, ())
        first, last = np.searchsorted(begins, (rest.start - DOWN, rest.stop)).tolist()
        return int(last - first)

    def blended(self, base: Floats, aims: Sequence[Any]) -> Floats:
        """Return numbers, (T,), or directions, (T, 3), with each rest's aim; None: no aim."""
        if not self.rests:
            return base
        mix = straight if base.ndim == 1 else great_circle
        aimed = base.copy()
        for (some, share), aim in zip(self._shares, aims, strict=True):
            target = np.broadcast_to(base[some] if aim is None else aim, base[some].shape)
            aimed[some] = mix(aimed[some], target, share)
        return mix(base, aimed, self.done)


def _frame(time: float, times: Floats) -> int:
    """Return the first frame at a time or behind it, or else the last one."""
    return min(int(np.searchsorted(times, time)), len(times) - 1)


def straight(start: Floats, stop: Floats, share: Floats) -> Floats:
    """Return numbers on the way from one to another, (T,)."""
    return start + share * (stop - start)


def above(directions: Floats, high: Floats) -> Floats:
    """Raise directions, (T, 3), to end above the floor; `high` (T,) is their start in lengths."""
    ahead = unit(directions * [1, 0, 1] + [1e-6, 0, 0])  # of what points straight down, too
    up = np.maximum(directions[:, 1], np.clip(-high, -1, 1))
    found: Floats = np.sqrt(1 - np.minimum(up**2, 1))[:, None] * ahead
    found[:, 1] = up
    return found


def direction_at(degrees: float) -> Floats:
    """Return the direction at an angle forward from straight down."""
    angle = np.radians(degrees)
    return np.array([np.sin(angle), -np.cos(angle), 0.0])


# The sine of half a right angle: what is lower lies; the cosine of two that differ by more
LEVEL = 0.7
FLESH = 10.0  # millimetres above the floor: lower goes no joint of an arm

ARM = ("upper_arm", "forearm", "hand")


def rest_bones(resting: Resting, hips: Floats, bones: Bones, body: Body) -> tuple[Bones, list[str]]:
    """Return directions of trunk, head and arms, (T, 3) by bone, at rest, and warnings."""
    rests, middles, doubts = resting.rests, resting.middles, list[str]()
    aims = list[Floats | None]()
    for rest, middle in zip(rests, middles, strict=True):
        pose, lean = rest.pose, bones["torso"][middle]
        moves = resting.moves(rest, "torso", "torso_incline")
        suits = abs(lean[1]) < LEVEL or (pose.props and lean[0] > LEVEL)
        aims.append(None if pose.trunk is None or moves or suits else direction_at(pose.trunk))
        if pose.trunk is not None and moves and not suits:
            doubts.append(f"torso goes as told at {rest.start:g} s: {rest.what} may not carry")
    blended = {"torso": resting.blended(bones["torso"], aims)}
    if bones["head"] is bones["torso"]:
        blended["head"] = blended["torso"]
    up, length = hips + body.shoulders * blended["torso"][:, 1], sum(body.arm[:2])
    for side in SIDES:
        names = [f"{side}_{it}" for it in ARM]
        touches = (f"{side}_hand_touch", "hands_touch")
        arm_moves = [
            resting.moves(it, f"{side}_arm", *names, *(touches if it.pose.props else ()))
            for it in rests
        ]
        reaches = list[list[Floats | None]]()
        for rest, middle, moves in zip(rests, middles, arm_moves, strict=True):
            high = float(up[middle])
            down = direction_at(float(np.degrees(np.arccos(min(max(high / length - LIES, 0), 1)))))
            props = rest.pose.props and not moves  # the hand is on the floor
            reaches.append([down, down, direction_at(90.0)] if props else [None] * len(ARM))
            if rest.pose.props and (moves or high > (1 + 2 * LIES) * length):
                doubts.append(f"{side}_hand does not prop at {rest.start:g} s: it goes as told")
        heights, lies = up, resting.done > 0
        for number, (name, size) in enumerate(zip(names, body.arm, strict=True)):
            ways = resting.blended(bones[name], [it[number] for it in reaches])
            ways[lies] = above(ways[lies], (heights[lies] - FLESH) / size)
            blended[name], heights = ways, heights + size * ways[:, 1]
        for rest, middle, moves in zip(rests, middles, arm_moves, strict=True):
            cosines = (float(blended[it][middle] @ bones[it][middle]) for it in names[:2])
            if moves and min(cosines) < LEVEL:
                doubts.append(f"{side}_arm would go through the floor at {rest.start:g} s")
    return blended, list(dict.fromkeys(doubts))


LIFTED = 0.05  # lengths of a leg above the floor: a foot so high goes wherever the knee takes it
HEIGHTS = 70  # hundredths of a leg in which the height is looked for at which a body rests
SITS = 0.12  # lengths of a leg above the floor: so high are hips that sit
TOES = 64.0  # millimetres from the toe's joint to its tip


@dataclass(frozen=True, slots=True, eq=False)
class FootPlacement:
    """Where a foot is, frame by frame; in lengths of a leg but for `over`."""

    side: str
    over: Floats  # (T, 2) mm: where the ankle is over the ground while the heel is down
    raised: Floats  # (T,) height of the foot
    heel: Floats  # (T,) height of the heel above it
    knee: Floats  # (T, 3) unit vectors of the body frame: where the knee goes
    high: Floats  # (T,) height of the body's flight
    front: Floats  # (T,) radians that the body has turned to the left

    def at(self, frame: int) -> FootPlacement:
        """Return the placement in one frame, T = 1."""
        arrays = self.over, self.raised, self.heel, self.knee, self.high, self.front
        return FootPlacement(self.side, *(it[frame : frame + 1] for it in arrays))


def leg_bones(foot: FootPlacement, hips: Floats, reach: Floats, body: Body) -> dict[str, Floats]:
    """Return the directions of a leg's bones, (T, 3), from hips, (T, 3) mm, to its foot's place."""
    joint, ahead = body.hips[foot.side], toward(foot.front + np.pi / 2)
    length, raised = float(np.linalg.norm(body.toe)), foot.raised
    back = body.leg * foot.heel - body.toe[1]
    back = np.sqrt(length**2 - np.minimum(back, 0.99 * length) ** 2)
    tip = foot.over + body.toe[0] * ahead  # the toe stays where the heel cannot
    ankle = tip - back[:, None] * ahead
    height = body.ankle + body.leg * (raised + foot.heel)
    target = np.stack((ankle[:, 0], height, ankle[:, 1]), axis=1)
    way = (turned(target - hips, -foot.front) - joint) / body.leg
    far, free = np.linalg.norm(way, axis=1), np.clip((raised - foot.high) / LIFTED, 0, 1)
    way *= (1 - free * np.maximum(1 - reach / np.maximum(far, 1e-9), 0))[:, None]
    reach = np.linalg.norm(way, axis=1, keepdims=True)
    along, reach = unit(way), np.minimum(reach, 1.0)
    aside = foot.knee - dot(along, foot.knee) * along
    size = np.linalg.norm(aside, axis=1, keepdims=True)
    aside = np.where(size > 1e-6, aside / np.maximum(size, 1e-6), UP)
    bow = np.sqrt(np.maximum(1 - reach**2, 0)) * aside
    thigh, shank = reach * along + bow, reach * along - bow
    point = np.stack((tip[:, 0], body.sole + body.leg * raised, tip[:, 1]), axis=1)
    toe = unit(turned(point - hips, -foot.front) - joint - body.leg / 2 * (thigh + shank))
    toes = above(toe, (body.sole + body.leg * raised) / TOES)
    bones = {"thigh": thigh, "shank": shank, "foot": toe, "toes": toes}
    return {f"{foot.side}_{bone}": ways for bone, ways in bones.items()}


def resting_height(
    rest: Rest, times: Floats, hips: Floats, feet: Sequence[FootPlacement], body: Body
) -> float:
    """Return the height, mm, of the hips of a resting body whose lower knee is on the floor."""
    if rest.pose.up is not None:
        return body.leg * rest.pose.up
    frame = min(int(np.searchsorted(times, min(rest.stop, rest.rise[0]))), len(times) - 1)
    tried = np.tile(hips[frame], (HEIGHTS, 1))
    tried[:, 1] = heights = body.leg * np.arange(HEIGHTS) / 100
    thighs = [
        leg_bones(foot.at(frame), tried, np.ones(HEIGHTS), body)[f"{foot.side}_thigh"]
        for foot in feet
    ]
    knees = [heights + body.leg / 2 * thigh[:, 1] for thigh in thighs]
    sunk = np.flatnonzero(np.minimum(*knees) < LIES * body.leg)
    if not len(sunk):  # knees that stand up carry nothing
        return body.leg * SITS
    return float(heights[min(sunk[-1] + 1, HEIGHTS - 1)])


def toward(azimuth: Any) -> Floats:
    """Return directions over the ground, (..., 2): forward, right; 0 is right, 90 forward."""
    return np.stack((np.sin(azimuth), np.cos(azimuth)), axis=-1)


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
    def height(self) -> float:
        """Lengths of a leg that it takes the body up."""
        return HEIGHT.get(self.level, 0.0)

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


def spun(places: Floats, left: float) -> Floats:
    """Return places over the ground, (..., 2), turned to the left about the middle by radians."""
    ahead, right = places[..., 0], places[..., 1]
    cos, sin = np.cos(left), np.sin(left)
    return np.stack((cos * ahead + sin * right, cos * right - sin * ahead), axis=-1)


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
        self._feet, self._pivot = self._joints(0.0), np.zeros(len(times))
        self._pivoted = 0.0  # Radians of the pivot that the feet have made

    def follow(
        self, moves: Sequence[Move], rests: Sequence[Rest], placed: Sequence[dict[str, Floats]]
    ) -> None:
        """Apply moves and rests; `placed` are feet by rest and side that a score places itself."""
        feet = dict(zip(rests, placed, strict=True))
        self._pivot = pivots(self.front, moves, self.times)
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
        add(self.shift, some, way_there * share_done(self.times[some], *window)[:, None], way_there)
        self._now = place

    def _move(self, move: Move) -> None:
        pivot = float(np.interp(move.start, self.times, self._pivot))
        for side, foot in self._feet.items():
            self._feet[side] = self._now + spun(foot - self._now, pivot - self._pivoted)
        self._pivoted = pivot
        body, front = self.body, self._front(move.stop)
        some, share = move.within(self.times)
        toe, reach = body.toe[0] * toward(front + np.pi / 2), body.leg + np.linalg.norm(body.toe)
        high = body.leg * (REACHES + move.height - HANGS) - body.toe[1]
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


# Lengths of a leg that a foot is lifted on its way, and that a foot hangs that does not carry
LIFTS, FREE = 0.15, 0.25
SETTLES = 0.1  # part of a step's time that a foot that carries still takes to come to rest
GIVES = 0.04  # lengths of a leg that hips sink at most for a toe to stay on the floor
# How often hips are raised for knees that would sink, and millimetres that these lie high
SETTLED, KNEES = 5, 30.0
PRONE = 0.7  # how far forward a trunk leans that lies face down: half a right angle
# Lengths of a leg from where a foot is while something else carries: it is told to go there
ELSEWHERE = 0.5
# The cosine between where a bone of a leg points and where it is told to: of three borders
UNLIKE = 0.38
WEIGHT = ("r_support", "l_support", "jump", "body_turn")  # the tracks that are carried out here

_LANDS = {"spring": 2, "hop": 1, "leap": 1, "assemble": 2, "sissonne": 1, "unseen": 2}


@dataclass(frozen=True, slots=True, eq=False)
class Travel:
    """Where the body is, how it faces, and where its bones point."""

    front: Floats  # (T,) radians turned to the left
    hips: Floats  # (T, 3) mm: forward of the start, above the floor, right of the start
    # (T, 3) unit vectors of the body frame, of its legs and, where it rests, of all else
    bones: Bones
    warnings: list[str]


def travel_of(score: Score, times: Floats, body: Body, bones: Bones) -> Travel | None:
    """Return how the body goes at seconds, (T,), where the score tells anything of it."""
    moving = {name: rows_of(score, name) for name in WEIGHT}
    moving = {name: rows[rows["stop"] > rows["start"]] for name, rows in moving.items()}
    carried = carrier_spans(score)
    if not carried and not any(map(len, moving.values())):
        return None
    rate = float(score.rate)
    front = _front(moving["body_turn"], times, rate)
    moves, warnings = _free_moves(_moves(moving, rate), carried)
    for number, (start, stop, what) in enumerate(carried):
        lean = bones["torso"][_frame((start + stop) / 2, times)]
        if what == "trunk" and lean[0] > PRONE:
            carried[number] = start, stop, "prone trunk"
    rests, doubts = plan_rests(carried, moves, score.frames / rate)
    resting, path = Resting(score, rests, times), FeetPath(body, times, front)
    placed = _placed_feet(resting, bones)
    path.follow(moves, rests, placed)
    feet_at, high = path.steps.cumsum(axis=0), path.high
    body_at = feet_at + path.shift.cumsum(axis=0)
    levels = _levels(score, moves, times)
    heels, ahead = np.maximum(levels, 0), np.tile(FORWARD, (len(times), 1))
    reaches = {
        side: reach_when_bent(rows_of(score, f"{side}_leg_bend"), times, score.rate)
        for side in SIDES
    }
    own, feet = sorted((*moves, *path.drawn), key=lambda it: it.start), list[FootPlacement]()
    for side in SIDES:
        over, raised = _foot(side, own, times, (body_at, feet_at), front, body.hips[side], high)
        heel = resting.blended(heels, [it.pose.heels for it in rests])
        knee = resting.blended(ahead, [direction_at(it.pose.knees) for it in rests])
        for rest, places in zip(rests, placed, strict=True):
            if side in places and places[side][0] > 0:  # that foot stands
                some = slice(*np.searchsorted(times, (rest.start, rest.rise[1])).tolist())
                share = share_done(times[some], *rest.draws)
                share *= 1 - share_done(times[some], *rest.rise)
                heel[some] *= 1 - share
                knee[some] = great_circle(knee[some], direction_at(135.0), share)
        feet.append(FootPlacement(side, over, raised, heel, knee, high, front))
    stands = np.minimum(REACHES + levels, heels + np.maximum(*reaches.values()))
    up = _hip_heights(body.ankle + body.leg * (stands + high), body_at, feet, body)
    hips = np.stack((body_at[:, 0], up, body_at[:, 1]), axis=1)
    hips[:, 1] = resting.blended(up, [resting_height(it, times, hips, feet, body) for it in rests])
    legs = dict[str, Floats]()
    for _ in range(SETTLED):  # hips rise where a knee would sink
        sinks = np.zeros(len(hips))
        for foot in feet:
            reach = straight(reaches[foot.side], np.ones(len(hips)), resting.done)
            legs |= leg_bones(foot, hips, reach, body)
            thigh = body.leg / 2 * legs[f"{foot.side}_thigh"][:, 1]
            sinks = np.maximum(sinks, KNEES - hips[:, 1] - thigh)
        if not sinks.any():
            break
        hips[:, 1] += sinks
    warnings += [*doubts, *_leg_doubts(resting, bones, legs, reaches)]
    if not any(map(len, moving.values())):  # it stands, and does nothing but rest
        limbs = [f"{side}_{it}" for side in SIDES for it in ("leg", "thigh", "shank", "foot")]
        only = "goes as told only while something else than feet carries"
        warnings += [f"{name} {only}" for name in limbs if resting.moves_beside(name)]
    if rests:
        others, doubts = rest_bones(resting, hips[:, 1], bones, body)
        legs, warnings = legs | others, warnings + doubts
    return Travel(front, hips, legs, warnings)


def _placed_feet(resting: Resting, bones: Bones) -> list[Bones]:
    """Return where legs have their feet that are told to go elsewhere: see `FeetPath.follow`."""
    placed = list[Bones]()
    for rest, frame in zip(resting.rests, resting.middles, strict=True):
        feet = dict[str, Floats]()
        for side in SIDES:
            thigh, shank = f"{side}_thigh", f"{side}_shank"
            foot = (bones[thigh][frame, ::2] + bones[shank][frame, ::2]) / 2
            elsewhere = np.hypot(foot[0] + rest.pose.ahead, foot[1]) > ELSEWHERE
            if elsewhere and resting.moves(rest, f"{side}_leg", thigh, shank):
                feet[side] = foot
        placed.append(feet)
    return placed


def _leg_doubts(resting: Resting, wanted: Bones, legs: Bones, reaches: Bones) -> Iterator[str]:
    """Say which legs do not go as told while something else carries."""
    for rest, frame in zip(resting.rests, resting.middles, strict=True):
        for side in SIDES:
            limb, bones = f"{side}_leg", (f"{side}_thigh", f"{side}_shank")
            for name in bones:
                cosine = float(wanted[name][frame] @ legs[name][frame])
                if resting.moves(rest, name, limb) and cosine < UNLIKE:
                    yield f"{name} goes as {rest.what} needs it at {rest.start:g} s, not as told"
            reach = np.linalg.norm(sum(legs[name][frame] for name in bones)) / 2
            turn = np.arccos(np.minimum((reach, reaches[side][frame]), 1))
            if resting.moves(rest, f"{limb}_bend") and abs(turn[0] - turn[1]) > np.pi / 8:
                yield f"{limb} bends as {rest.what} needs it at {rest.start:g} s, not as told"


def _free_moves(moves: list[Move], carriers: Sequence[CarrierSpan]) -> tuple[list[Move], list[str]]:
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
    return free, left_out


def _hip_heights(up: Floats, place: Floats, feet: Sequence[FootPlacement], body: Body) -> Floats:
    """Return how high hips are, mm, that sink a little where toes would leave the floor."""
    least, longest = up, body.leg + float(np.linalg.norm(body.toe))
    for foot in feet:
        joint = place + body.hips[foot.side][2] * toward(foot.front)
        toe = foot.over + body.toe[0] * toward(foot.front + np.pi / 2)
        far = np.linalg.norm(toe - joint, axis=1)
        floor = body.sole + body.leg * foot.raised
        least = np.minimum(least, floor + np.sqrt(np.maximum(longest**2 - far**2, 0)))
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


def pivots(front: Floats, moves: Sequence[Move], times: Floats) -> Floats:
    """Return how far the body has turned to the left while no foot was lifted, radians."""
    turning = np.diff(front, prepend=front[:1])
    for move in moves:
        turning[move.within(times)[0]] = 0
    return np.asarray(turning.cumsum())


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
    firsts = [it[:1] for it in (rows_of(score, f"{side}_support") for side in SIDES)]
    stood = [int(it["level"][0]) for it in firsts if (it["start"] == it["stop"]).any()]
    level = stood[0] if stood else -1  # at which the feet stand at first
    knots, values = [-1.0], [HEIGHT.get(level, 0.0)]
    for move in moves:
        if move.level >= 0:
            knots += [max(move.start, knots[-1] + 1e-6), max(move.stop, knots[-1] + 2e-6)]
            values += [values[-1], move.height]
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
    pivot = pivots(front, [it for it in moves if it.to is None], times) if goes else 0 * front
    begins = [int(np.searchsorted(times, move.start)) for move in own]
    turns = np.flatnonzero(np.diff(pivot, prepend=0.0))

    def stand(begin: int, end: int) -> None:
        """Turn the foot with the body, from where it stands in the first of some frames."""
        for frame in turns[(turns > begin) & (turns < end)].tolist():
            turn, middle = float(pivot[frame] - pivot[frame - 1]), places[1][frame]
            over[frame:end] = middle + spun(over[frame:end] - middle, turn)

    stand(0, begins[0] if begins else len(times))
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
        stand(max(last, now), until)
        raised[some] += move.steps * 4 * LIFTS * share * (1 - share)
    return over, raised
