"""How the standard body kneels, sits, lies and props itself.

Source: ``encoding/BODY.md``, "Other supports", read backwards. Lengths are those of a leg,
angles degrees from straight down to forward.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import CARRIERS
from lanindex.model import Score
from lanindex.perform.limbs import FORWARD, Body, dot, minimum_jerk, unit

Floats = NDArray[np.float64]

OTHER = "other_support"  # the track that is carried out here
# Seconds that the body takes to come down and to rise, and that it takes at least
DOWN, RISES, LEAST = 0.9, 0.8, 0.4
LANDS = 0.15  # seconds after a step that its leg still tells the level

HURRIES = "there is no time to come down, or to rise"

# Seconds in which feet are drawn up at least, and before a rest ends; and at most
DRAWS = (0.1, 1.0)
LIES = 0.07  # lengths of a leg above the floor: so high lies a knee or a wrist that carries

Window = tuple[float, float]
CarrierSpan = tuple[float, float, str]
"""From when to when something else than feet carries, in seconds, and what."""


@dataclass(frozen=True, slots=True)
class Pose:
    """How the body rests on one carrier."""

    ahead: float  # Of the hips before the feet
    up: float | None  # Height of the hips; None: such that the lower knee lies at `LIES`
    # How long before it has come down support begins, and after it begins to rise support ends:
    # seconds, if it is on the way for one; else with the power of 1.5 of that time
    comes: float
    leaves: float
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


POSES = {
    "knee": Pose(0.417, None, 0.14, 0.3, heels=0.12, knees=45.0, drop=0.45),
    "seat": Pose(-0.35, 0.12, 0.1, 0.2),
    "trunk": Pose(-0.35, 0.13, 0.1, 0.2, trunk=-90.0),
    "prone trunk": Pose(1.08, 0.13, 0.17, 0.28, heels=0.12, knees=45.0, early=0.7),
    "hand": Pose(
        0.72, None, 0.16, 0.35, heels=0.12, knees=45.0, trunk=110.0, props=True, least=0.5
    ),
    "other": Pose(-0.35, 0.57, 0.06, 0.16, least=0.6),
}
"""By what carries; prone, who lies face down."""


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
        return self.start, min(
            max(self.stop - DRAWS[0], self.start + DRAWS[0]), self.start + DRAWS[1]
        )

    def middle(self, times: Floats) -> int:
        """Return the frame in the middle of it."""
        return min(int(np.searchsorted(times, (self.start + self.stop) / 2)), len(times) - 1)

    def share(self, times: Floats) -> Floats:
        """Return how much of it is done."""
        return part(times, self.down) * (1 - part(times, self.rise))


def part(times: Floats, window: Window) -> Floats:
    """Return the share done, (T,), of what fills a window of time."""
    share = (times - window[0]) / max(window[1] - window[0], 1e-9)
    return minimum_jerk(np.clip(share, 0, 1))


Mix = Callable[[Floats, Floats, Floats], Floats]


def carrier_spans(score: Score) -> list[CarrierSpan]:
    """Return from when to when something else than feet carries, in seconds, and what."""
    rows = score.tracks[OTHER].symbols if OTHER in score.tracks else ()
    rate = float(score.rate)
    return [
        (float(row["start"]) / rate, float(row["stop"]) / rate, CARRIERS[row["amount"]])
        for row in rows
        if 0 <= row["amount"] < len(CARRIERS) and row["start"] < row["stop"]
    ]


def plan_rests(
    those: Sequence[CarrierSpan], busy: Sequence[tuple[float, float, float]], last: float
) -> tuple[list[Rest], tuple[str, ...]]:
    """Return how the body comes down to each carrier and rises, and which have no time for it."""
    joined = [None, *map(_joined, those[:-1], those[1:]), None]
    halves = [-np.inf, *((one[1] + two[0]) / 2 for one, two in pairwise(those)), np.inf]
    ends, rests, doubts = [it[1] for it in busy], list[Rest](), dict[str, None]()
    for number, (start, stop, what) in enumerate(those):
        pose, (before, after) = POSES[what], joined[number : number + 2]
        past, next_one = bisect_right(ends, start), bisect_right(ends, stop)
        step_end, height = (ends[past - 1] + LANDS, busy[past - 1][2]) if past else (-np.inf, 0.0)
        length = min(max(start - max(step_end, halves[number]), LEAST), DOWN)
        until = start + pose.comes * pose.slower(height) * length**1.5 if start > 0 else 0.0
        down = before or (until - length, until)
        room, returns = halves[number + 1] - stop, after is None
        if next_one < len(busy):
            begin, end, then = busy[next_one]
            if begin - stop < LEAST:
                returns, begin, height = False, end, min(height, then)
            room = min(room, begin - stop)
        length = min(max(room, LEAST), RISES)
        begin = stop - pose.leaves * pose.slower(height) * length**1.5
        rise = after or ((begin, begin + length) if stop < last else (stop + 1, stop + 2))
        rests.append(Rest(start, stop, down, rise, what, returns))
        tight = (not before and 0 < start < step_end - LANDS + LEAST / 2) or room < LEAST / 2
        if tight or after:
            doubts[f"{what} carries at {start:g} s: {HURRIES}"] = None
        if stop - start < pose.least:
            doubts[f"{what} carries at {start:g} s for so short a time that nobody sees it"] = None
    return rests, tuple(doubts)


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


_RANKS = ("other", "knee", "hand", "seat", "trunk")  # carriers; of several the last one is written


class MovedParts:
    """Whether a score moves parts while the body comes down or rests."""

    def __init__(self, score: Score) -> None:
        self._begins = dict[str, Floats]()
        for part, track in score.tracks.items():
            rows = track.symbols
            rows = rows[~rows["passing"] & (rows["stop"] > rows["start"])]
            self._begins[part] = np.sort(rows["start"] / float(score.rate))

    def __call__(self, rest: Rest, *parts: str) -> bool:
        """Return whether a score moves one of some parts in a rest."""
        return any(self._count(rest, part) for part in parts)

    def beside(self, rests: Sequence[Rest], part: str) -> bool:
        """Return whether a score moves a part at another time than in rests."""
        begins = self._begins.get(part, ())
        return len(begins) > sum(self._count(rest, part) for rest in rests)

    def _count(self, rest: Rest, part: str) -> int:
        begins = self._begins.get(part, ())
        first, last = np.searchsorted(begins, (rest.start - DOWN, rest.stop)).tolist()
        return int(last - first)


class RestBlend:
    """Blends values of a standing body with those of its rests, frame by frame."""

    def __init__(self, rests: Sequence[Rest], times: Floats) -> None:
        self.rests, self.done = rests, np.zeros(len(times))
        self._parts = list[tuple[slice, Floats]]()
        for rest in rests:
            some = slice(*np.searchsorted(times, (rest.down[0], rest.rise[1])).tolist())
            own = rest.share(times[some])
            self.done[some] += own
            self._parts.append((some, own / np.maximum(self.done[some], 1e-9)))

    def blended(self, base: Floats, aims: Sequence[Any], mix: Mix) -> Floats:
        """Return values blended with the aim of each rest; None leaves them."""
        if not self.rests:
            return base
        aimed = base.copy()
        for (some, own), aim in zip(self._parts, aims, strict=True):
            there = np.broadcast_to(base[some] if aim is None else aim, base[some].shape)
            aimed[some] = mix(aimed[some], there, own)
        return mix(base, aimed, self.done)


def straight(start: Floats, stop: Floats, share: Floats) -> Floats:
    """Return numbers on the way from one to another, (T,)."""
    return start + share * (stop - start)


def slerp(start: Floats, stop: Floats, share: Floats) -> Floats:
    """Return directions on the way from one to another, (T, 3); opposite ones pass the front."""
    along = np.clip(dot(start, stop), -1, 1)
    across = stop - along * start
    size = np.linalg.norm(across, axis=1, keepdims=True)
    across = unit(np.where(size < 1e-6, FORWARD - dot(start, FORWARD) * start, across))
    angle = np.arctan2(size, along) * share[:, None]
    found: Floats = np.cos(angle) * start + np.sin(angle) * across
    return found


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


def rest_bones(
    score: Score,
    resting: RestBlend,
    times: Floats,
    hips: Floats,
    bones: dict[str, Floats],
    body: Body,
) -> tuple[dict[str, Floats], tuple[str, ...]]:
    """Return directions of trunk, head and arms, (T, 3) by bone, at rest, and warnings."""
    rests, doubts = resting.rests, dict[str, None]()
    moved, middles = MovedParts(score), [rest.middle(times) for rest in rests]
    aims = list[Floats | None]()
    for rest, middle in zip(rests, middles, strict=True):
        pose, lean = rest.pose, bones["torso"][middle]
        moves = moved(rest, "torso", "torso_incline")
        suits = abs(lean[1]) < LEVEL or (pose.props and lean[0] > LEVEL)
        aims.append(None if pose.trunk is None or moves or suits else direction_at(pose.trunk))
        if pose.trunk is not None and moves and not suits:
            doubts[f"torso goes as told at {rest.start:g} s: {rest.what} may not carry"] = None
    blended = {"torso": resting.blended(bones["torso"], aims, slerp)}
    if bones["head"] is bones["torso"]:
        blended["head"] = blended["torso"]
    up, length = hips + body.shoulders * blended["torso"][:, 1], sum(body.arm[:2])
    for side in "rl":
        names = [f"{side}_{it}" for it in ARM]
        touches = (f"{side}_hand_touch", "hands_touch")
        arm_moves = [
            moved(it, f"{side}_arm", *names, *(touches if it.pose.props else ())) for it in rests
        ]
        reaches = list[list[Floats | None]]()
        for rest, middle, moves in zip(rests, middles, arm_moves, strict=True):
            high = float(up[middle])
            down = direction_at(float(np.degrees(np.arccos(min(max(high / length - LIES, 0), 1)))))
            props = rest.pose.props and not moves  # the hand is on the floor
            reaches.append([down, down, direction_at(90.0)] if props else [None] * len(ARM))
            if rest.pose.props and (moves or high > (1 + 2 * LIES) * length):
                doubts[f"{side}_hand does not prop at {rest.start:g} s: it goes as told"] = None
        heights, lies = up, resting.done > 0
        for number, (name, size) in enumerate(zip(names, body.arm, strict=True)):
            ways = resting.blended(bones[name], [it[number] for it in reaches], slerp)
            ways[lies] = above(ways[lies], (heights[lies] - FLESH) / size)
            blended[name], heights = ways, heights + size * ways[:, 1]
        for rest, middle, moves in zip(rests, middles, arm_moves, strict=True):
            cosines = (float(blended[it][middle] @ bones[it][middle]) for it in names[:2])
            if moves and min(cosines) < LEVEL:
                doubts[f"{side}_arm would go through the floor at {rest.start:g} s"] = None
    return blended, tuple(doubts)
