"""Bodies that step, jump and turn as told: what each foot does, and when, is known."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTION_CODES, JOINT_CODES
from lanindex.model import Motion
from tests.made_motion import motion_of

Floats = NDArray[np.float64]

LEG = 800.0
"""Millimetres: thigh and shank of 400 each."""

ANKLE, SHORT, WIDE = 80.0, 20.0, 90.0
FALL = 12.0
"""Lengths of a leg a second squared: how bodies fall."""


@dataclass(frozen=True)
class Do:
    """What the body does next.

    Attributes
    ----------
    what : str
        ``r`` or ``l``: a step of that foot; ``stand``; ``jump``: from the feet of `feet` to others.
    way : str
        A direction of the alphabet, seen from the front at its end.
    size : float
        Lengths of a leg that the pelvis goes.
    seconds : float
        How long it takes.
    turn : float
        Degrees to the left, on the way.
    feet : str
        Of a jump: ``rl>r``.
    bent : float
        Lengths of a leg that the body sinks.
    toes : bool
        Whether the heels are up at its end.
    """

    what: str
    way: str = "place"
    size: float = 0.0
    seconds: float = 0.5
    turn: float = 0.0
    feet: str = "rl>rl"
    bent: float = 0.0
    toes: bool = False


@dataclass
class _Stage:
    """Where everything is, and what has been recorded."""

    rate: int
    place: Floats = field(default_factory=lambda: np.zeros(2))  # x, z
    front: float = 90.0  # degrees, of the walk: 90 is along +x
    feet: dict[str, Floats] = field(default_factory=dict)
    raised: dict[str, float] = field(default_factory=lambda: {"r": 0.0, "l": 0.0})
    sunk: float = 0.0
    heels: float = 0.0
    frames: list[Floats] = field(default_factory=list)

    def beside(self, place: Floats, front: float, foot: str) -> Floats:
        """Return where a foot stands under the body."""
        return place + (WIDE if foot == "r" else -WIDE) * _unit(front - 90)


def _unit(degrees: float) -> Floats:
    """Return a direction over the ground, (x, z); 0 is right of a body that faces +x."""
    angle = math.radians(degrees)
    return np.array([math.sin(angle), math.cos(angle)])


def walk(does: Sequence[Do], rate: int = 60) -> Motion:
    """Return the motion of a body that does what it is told."""
    stage = _Stage(rate)
    stage.feet = {foot: stage.beside(stage.place, stage.front, foot) for foot in "rl"}
    stage.frames.append(_body(stage, stage.place, stage.front, 0.0))
    for one in does:
        _do(stage, one)
    return motion_of(np.array(stage.frames), Fraction(rate))


def _do(stage: _Stage, one: Do) -> None:
    front = stage.front + one.turn
    there = stage.place.copy()
    if one.way != "place":
        azimuth = 45.0 * DIRECTION_CODES[one.way]  # 0 right, 90 forward
        there += LEG * one.size * _unit(front - 90 + azimuth)
    count = max(round(one.seconds * stage.rate), 1)
    begun, raised, sunk, heels = dict(stage.feet), dict(stage.raised), stage.sunk, stage.heels
    before, after = one.feet.split(">")
    goes = {"r": "r", "l": "l", "stand": "", "jump": "rl"}[one.what]
    for number in range(1, count + 1):
        share = number / count
        eased = 10 * share**3 - 15 * share**4 + 6 * share**5
        place = stage.place * (1 - eased) + there * eased
        high = 0.0
        if one.what == "jump":
            place = stage.place * (1 - share) + there * share
            high = FALL / 2 * one.seconds**2 * share * (1 - share) * LEG
        for foot in goes:
            if one.what == "jump":
                lifted = [raised[foot], 0.25 * LEG * (foot not in after)]
                if foot not in before:
                    lifted[0] = raised[foot]
                stage.raised[foot] = high + lifted[0] * (1 - share) + lifted[1] * share
                aim = stage.beside(there, front, foot)
                stage.feet[foot] = begun[foot] * (1 - share) + aim * share
            else:
                aim = stage.beside(there, front, foot)
                stage.feet[foot] = begun[foot] * (1 - eased) + aim * eased
                stage.raised[foot] = raised[foot] * (1 - share) + 0.5 * LEG * share * (1 - share)
        stage.sunk = sunk * (1 - eased) + one.bent * eased
        stage.heels = heels * (1 - eased) + (0.15 if one.toes else 0.0) * eased
        turned = stage.front + one.turn * eased
        stage.frames.append(_body(stage, place, turned, high))
    stage.place, stage.front = there, front


def _body(stage: _Stage, place: Floats, front: float, high: float) -> Floats:
    """Return the places of the joints, (20, 3)."""
    found = np.zeros((20, 3))
    right, forward = _unit(front - 90), _unit(front)
    up = ANKLE + LEG - SHORT + high + (stage.heels - stage.sunk) * LEG

    def put(joint: str, over: Floats, height: float) -> None:
        found[JOINT_CODES[joint]] = (over[0], height, over[1])

    put("Pelvis", place, up)
    put("Chest", place, up + 250)
    put("Neck", place, up + 500)
    put("Head", place, up + 650)
    for foot, sign in (("r", 1.0), ("l", -1.0)):
        side = foot.upper()
        aside = place + sign * right * 180
        put(f"{side}Shoulder", aside, up + 450)
        put(f"{side}Elbow", aside, up + 180)
        put(f"{side}Wrist", aside, up - 70)
        put(f"{side}Hand", aside, up - 150)
        hip = np.array([*(place + sign * right * WIDE), up])
        ankle = np.array([*stage.feet[foot], ANKLE + stage.raised[foot] + stage.heels * LEG])
        toe = stage.feet[foot] + forward * 150
        put(f"{side}Hip", hip[:2], hip[2])
        put(f"{side}Knee", *_knee(hip, ankle, forward))
        put(f"{side}Ankle", ankle[:2], ankle[2])
        put(f"{side}Toe", toe, 20 + stage.raised[foot])
    return found


def _knee(hip: Floats, ankle: Floats, forward: Floats) -> tuple[Floats, float]:
    """Return where a knee is that is bent forward: over the ground, and how high."""
    way = ankle - hip
    reach = min(float(np.linalg.norm(way)), LEG - 1e-6)
    bow = math.sqrt((LEG / 2) ** 2 - (reach / 2) ** 2)
    ahead = np.array([*forward, 0.0])
    ahead -= way * (ahead @ way) / max(way @ way, 1e-9)
    knee = hip + way / 2 + bow * ahead / max(float(np.linalg.norm(ahead)), 1e-9)
    return knee[:2], float(knee[2])
