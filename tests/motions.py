"""Synthetic motions: swinging bones, walking people, and changes to either."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray
from rapidfuzz.distance import Levenshtein

from lanindex.alphabet import (
    DIRECTION_CODES,
    DIRECTIONS,
    JOINT_CODES,
    JOINTS,
    KINDS,
    MIRRORED,
    kind_of,
    mirrored_part,
)
from lanindex.model import Motion, Score, Skeleton, Source, Symbol

Floats = NDArray[np.float64]

RATES = tuple(
    Fraction(rate) for rate in (24, 25, 30, "30000/1001", 50, 60, 100, "120000/1001", 120, 240)
)

BONES = {
    "Chest": ("Pelvis", 300.0),
    "Neck": ("Chest", 220.0),
    "Head": ("Neck", 150.0),
    **{
        side + child: (parent if parent in ("Neck", "Pelvis") else side + parent, length)
        for side in "RL"
        for child, parent, length in (
            ("Shoulder", "Neck", 180.0),
            ("Elbow", "Shoulder", 290.0),
            ("Wrist", "Elbow", 260.0),
            ("Hand", "Wrist", 90.0),
            ("Hip", "Pelvis", 100.0),
            ("Knee", "Hip", 420.0),
            ("Ankle", "Knee", 410.0),
            ("Toe", "Ankle", 130.0),
        )
    },
}
"""Child: parent and length in mm."""


def motion_of(body: Floats, rate: Fraction, first: int = 0) -> Motion:
    """Return a motion whose joints are those of the body model: (T, 20, 3), mm, NaN unknown."""
    seen = ~np.isnan(body).all(axis=(0, 2))
    index = np.where(seen, np.arange(len(JOINTS)), -1).astype(np.int16)
    skeleton = Skeleton(JOINTS, np.full(20, -1, np.int16), np.zeros((20, 3), np.float32), index)
    source = Source("made", "made", "mm", 1.0, "y")
    return Motion(skeleton, rate, body.astype(np.float32), source, first)


def swung(seed: int, frames: int, rate: Fraction, tremble: float) -> Floats:
    """Return (T, 20, 3) float32-exact positions, mm: every bone swings from pose to pose.

    Bones go to directions drawn at random, in 0.1 to 1 s, wait up to 1 s there (some not at
    all), and tremble by noise of a standard deviation of `tremble` mm.
    """
    random = np.random.default_rng(seed)
    seconds = np.arange(frames) / float(rate)
    body = np.zeros((frames, 20, 3))
    body[:, 0] = (0.0, 900.0, 0.0)
    for joint, (parent, length) in BONES.items():
        point = _directions(random, seconds, lively=not joint.endswith("Hip"))
        if joint.endswith("Hip"):
            point[:, 2] += 2.0 if joint[0] == "R" else -2.0
        size = np.linalg.norm(point, axis=1, keepdims=True)
        bone = length * point / np.maximum(size, 1e-6)
        body[:, JOINT_CODES[joint]] = body[:, JOINT_CODES[parent]] + bone
    body += random.normal(0.0, 1.0, body.shape) * tremble
    return body.astype(np.float32).astype(np.float64)


def _directions(random: np.random.Generator, seconds: Floats, *, lively: bool) -> Floats:
    """Return (T, 3) vectors that move smoothly between random ones, with holds between."""
    here = random.normal(0.0, 1.0 if lively else 0.3, 3)
    path = np.tile(here, (len(seconds), 1))
    time = random.uniform(0.0, 0.5)
    while len(seconds) and time < seconds[-1]:
        there = here + random.normal(
            0.0, random.choice([0.1, 0.7, 1.5]) * (1 if lively else 0.2), 3
        )
        share = np.clip((seconds - time) / random.uniform(0.1, 1.0), 0.0, 1.0)[:, None]
        path += (there - here) * share**3 * (10 - 15 * share + 6 * share**2)
        here = there
        time += random.uniform(0.1, 1.0) + random.choice([0.0, random.uniform(0.0, 1.0)])
    return path


def with_gaps(body: Floats, gaps: list[tuple[int, int, int]]) -> Floats:
    """Return the body with joints unknown: (joint, first frame, frames) each."""
    holed = body.copy()
    for joint, start, frames in gaps:
        holed[start : start + frames, joint] = np.nan
    return holed


def body_of(motion: Motion) -> Floats:
    """Return a motion's joints as (T, 20, 3) float64, mm, NaN where there is none."""
    index = motion.skeleton.body
    body = np.asarray(motion.positions[:, index], np.float64)
    body[:, index < 0] = np.nan
    return body


LIMBS = ("r_arm", "l_arm", "r_leg", "l_leg")


def turned(motion: Motion, degrees: float) -> Motion:
    """Return the whole capture turned about the vertical."""

    def turn(vectors: np.ndarray) -> np.ndarray:
        angle = np.radians(degrees)
        x, y, z = np.moveaxis(vectors.astype(np.float64), 2, 0)
        front, side = np.cos(angle) * x + np.sin(angle) * z, np.cos(angle) * z - np.sin(angle) * x
        return np.stack((front, y, side), axis=2).astype(np.float32)

    axes = {joint: turn(own) for joint, own in motion.axes.items()}
    return replace(motion, positions=turn(motion.positions), axes=axes)


def moved(motion: Motion, way: tuple[float, float, float]) -> Motion:
    """Return the whole capture moved by so many mm."""
    return replace(motion, positions=motion.positions + np.asarray(way, np.float32))


def scaled(motion: Motion, factor: float) -> Motion:
    return replace(motion, positions=motion.positions * np.float32(factor))


def mirrored(motion: Motion) -> Motion:
    """Return the capture as a mirror shows it: left and right change their roles."""
    swapped = [
        JOINTS.index({"L": "R", "R": "L"}.get(name[0], name[0]) + name[1:]) for name in JOINTS
    ]
    skeleton = replace(motion.skeleton, body=motion.skeleton.body[swapped])
    mirror = np.array([1, 1, -1], np.float32)
    axes = {}
    for joint, own in motion.axes.items():
        side = {"R": "L", "L": "R"}.get(joint[0], "")
        sign = 1 if side else np.array([[-1], [1]], np.float32)  # of a head its right
        axes[side + joint[1:] if side else joint] = own * sign * mirror
    return replace(motion, skeleton=skeleton, positions=motion.positions * mirror, axes=axes)


def thinned(motion: Motion, step: int) -> Motion:
    """Return every `step`-th frame; the first of the movement stands in for those before it."""

    def thin(values: np.ndarray) -> np.ndarray:
        kept = values[::step].copy()
        kept[: -(-motion.first // step)] = values[motion.first]
        return kept

    axes = {joint: thin(own) for joint, own in motion.axes.items()}
    places = thin(motion.positions)
    return replace(motion, rate=motion.rate / step, positions=places, first=0, axes=axes)


def noisy(motion: Motion, size: float, seed: int = 0) -> Motion:
    """Return every coordinate of every joint with noise of a standard deviation of `size` mm."""
    noise = np.random.default_rng(seed).normal(0.0, size, motion.positions.shape)
    return replace(motion, positions=(motion.positions + noise).astype(np.float32))


def shown(score: Score, part: str) -> list[tuple[str, str]]:
    """Return direction and level of a part's symbols, the starting position first."""
    return [(s.direction, s.level) for s in score.symbols(part) if not s.passing]


def edits(score: Score, other: Score, part: str) -> tuple[int, int]:
    """Return how many edits lead from one track to the other, and the first's symbols."""
    one = shown(score, part)
    return Levenshtein.distance(one, shown(other, part)), len(one)


Row = tuple[str, str, int, int, bool, int]


def row(symbol: Symbol) -> Row:
    return (
        symbol.direction,
        symbol.level or (symbol.words.split()[-1] if KINDS[kind_of(symbol.part)].amounts else None),
        symbol.span.start,
        symbol.span.stop,
        symbol.passing,
        symbol.swings,
    )


def rows(score: Score) -> dict[str, list[Row]]:
    """Return all that a law says does not change."""
    return {part: [row(symbol) for symbol in score.symbols(part)] for part in score.tracks}


def mirrored_rows(score: Score) -> dict[str, list[Row]]:
    """Return the rows that the mirror image of a score has."""
    return {
        mirrored_part(part): [
            (direction and DIRECTIONS[MIRRORED[DIRECTION_CODES[direction]]], *rest)
            for direction, *rest in found
        ]
        for part, found in rows(score).items()
    }


def changed_tracks(one: dict[str, list[Row]], other: dict[str, list[Row]]) -> list[str]:
    """Return the parts whose rows differ."""
    return sorted(part for part in one.keys() | other.keys() if one.get(part) != other.get(part))


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
