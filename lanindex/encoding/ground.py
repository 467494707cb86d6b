"""Which foot carries, frame by frame, and when neither does.

Source: ``encoding/BODY.md``, "Which foot carries".
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.arithmetic import bend, held, median, runs, slopes
from lanindex.encoding.joints import Body
from lanindex.encoding.places import Stretch, stretches

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

STANDS, SLIDES = 0.3, 0.9
"""Lengths of a leg a second: a foot that is slower begins to carry; a faster one ends."""

SHARE = 0.1
"""Of the speed of the pelvis: a foot that is slower begins to carry, too."""

STIRS = 0.1
"""Lengths of a leg a second: a foot that is slower does not leave the floor yet."""

NEAR, LIFTED = 0.06, 0.09
"""Lengths of a leg above the floor: a lower foot begins to carry; a higher one ends."""

FLICKER = 0.07
"""Seconds: what lasts no longer is no lifting, no carrying and no flight."""

UNEVEN = 0.2
"""Lengths of a leg between the feet of a capture that stand: with more there is no floor."""

RISES = 0.7
"""Lengths of a leg that a stand is above all lower ones at most: nobody steps up so high."""

SETTLES = 0.5
"""Seconds that a body is still at least, or its feet are off every floor, of which something unseen
must carry the weight."""

STANCE = 0.25
"""Seconds that a foot stands at least where the floor is looked for."""

LOST = 0.2
"""Part of a stretch in which the feet neither carry nor fly: more is doubtful."""

FALL, ONWARD = 7.5, 4.0
"""Lengths of a leg a second squared: a body in the air is drawn down so much at least; one that
runs so much."""

RUNS = 2.5
"""Lengths of a leg a second: nobody walks so fast."""

CLEARS = 0.025
"""Lengths of a leg: in a flight the lower foot rises so high over the ground around it."""

STEEP = 0.15
"""How far a floor may rise, as a part of the way: steeper are stairs."""

_STANDS, _SPREAD = 4, 1.0  # stands, and lengths of a leg between them, that tell how a floor slopes
_FLAT = 0.1  # of stands in a row, how far they stray from it: less tells no slope across

UNTOLD = "the feet stand at different heights: which of them carries is told by speed"

HANGS = "both feet are far above the floor for a while: what carries the body then is not seen"

SIDES = "RL"
HIPS = ("RHip", "LHip")
LEGS = ("r_leg", "l_leg")
LEG, FOOT = ("Hip", "Knee", "Ankle"), ("Ankle", "Toe")


@dataclass(frozen=True, slots=True, eq=False)
class Feet:
    """What feet do over one stretch, counted in lengths of a leg."""

    # (N,) float32, lengths of a leg a second: how fast the middle of the hips goes over the ground
    pace: NDArray[np.float32]
    # (2, K, N) float32: of ankle, and toe where both are known, of the right and the left foot
    heights: NDArray[np.float32]
    # (2, N) float64, lengths of a leg a second: of each foot the slower of ankle and toe
    speed: Floats
    slow: Flags  # (2, K, N) bool: which joints are slower than `STANDS`


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """A body on the ground, over one stretch in which hips and ankles are known.

    Frames are resampled ones, from the stretch's first; coordinates are the capture's, smoothed.
    """

    places: Stretch  # Where its joints are
    rate: float  # Resampled frames a second
    leg: float  # Its length, mm
    feet: Feet  # What they do
    # (2, N) float32, degrees from straight, of the knees; NaN where none is known
    bent: NDArray[np.float32]
    carries: Flags  # (2, N) bool: the right foot, the left foot
    high: Flags  # (N,) bool: whether both are so high that something else carries
    # Stretches in which no foot carries: the first frame, and the one behind the last
    bare: list[tuple[int, int]]
    air: list[tuple[int, int]]  # Those of them that are flights
    # How much higher the ankle stands than the toe, usually, of each foot; lengths of a leg
    usual: tuple[float | None, ...]
    doubts: tuple[str, ...] = ()  # What was doubtful


def grounds(body: Body, leg: float) -> Iterator[Ground]:
    """Yield how a body stands and goes, stretch by stretch."""
    needed = [side + name for side in SIDES for name in ("Hip", "Ankle")]
    wished = [side + name for side in SIDES for name in ("Knee", "Toe")]
    rate = float(body.profile.rate)
    for one in stretches(body, needed, wished):
        feet, wide = _feet(one, leg, rate)
        level = _level(one, leg, feet, STANCE * rate) if wide else feet.heights
        carries, over, high, uneven = carried(feet, level, rate)
        doubts: tuple[str, ...] = (UNTOLD,) if uneven else ()
        bent, height = _legs(one, leg)
        hips = level.min(axis=(0, 1)), height, feet.pace, rate
        flown = _flights(unsupported(carries, rate), *hips)
        carries |= _lowest(feet, over, carries, flown, rate)
        bare = unsupported(carries, rate)
        air = _flights(bare, *hips)
        for start, stop in air:
            high[start:stop] = False
        for start, stop in runs(high):
            high[start:stop] = stop - start >= SETTLES * rate
        doubts += (HANGS,) if high.any() else ()
        del level, over, height, hips
        lost = np.count_nonzero(~(np.any(carries, axis=0) | high))
        lost -= sum(stop - start for start, stop in air)
        if lost > LOST * carries.shape[1]:
            doubts += ("the feet slide over the floor: what steps there are is told in part",)
        usual = tuple(map(_flat, feet.heights, carries))
        yield Ground(one, rate, leg, feet, bent, carries, high, bare, air, usual, doubts)
        del feet, bent, carries, high


def _feet(one: Stretch, leg: float, rate: float) -> tuple[Feet, bool]:
    """Return what the feet do over a stretch, and whether they go far enough to tell a slope."""
    count, kinds = len(one.frames), _kinds(one)
    found = Feet(
        np.empty(count, np.float32),
        np.empty((2, len(kinds), count), np.float32),
        np.empty((2, count)),
        np.empty((2, len(kinds), count), bool),
    )
    low, high = np.full((2, 2, 1), [[[np.inf]], [[-np.inf]]], np.float32)
    for block, places in one.blocks(1, (*HIPS, *_joints(kinds))):
        points = np.array([[places[side + it].T for it in kinds] for side in SIDES]) / leg
        x, y, z = np.moveaxis(slopes(points) * rate, 2, 0)
        speeds = np.sqrt(x * x + (y * y + z * z))[..., block.within]
        found.heights[..., block.inner] = points[:, :, 1, block.within]
        found.speed[:, block.inner] = speeds.min(axis=1)
        found.slow[..., block.inner] = speeds < STANDS
        pelvis = (places["RHip"] + places["LHip"]).T / 2
        pace = np.hypot(*(slopes(pelvis[::2]) * rate)) / leg
        found.pace[block.inner] = pace[block.within]
        over = points[:, -1, ::2, block.within].astype(np.float32)
        low = np.minimum(low, over.min(axis=(0, 2))[:, None])
        high = np.maximum(high, over.max(axis=(0, 2))[:, None])
    return found, bool((high - low > _SPREAD).any())


def _kinds(one: Stretch) -> list[str]:
    """Return what of `FOOT` is known of both feet."""
    return [it for it in FOOT if all(side + it in one.names for side in SIDES)]


def _joints(kinds: Sequence[str]) -> list[str]:
    """Return these joints of both feet."""
    return [side + it for side in SIDES for it in kinds]


def _legs(one: Stretch, leg: float) -> tuple[NDArray[np.float32], Floats]:
    """Return how knees are bent, (2, N), and how high the pelvis is, (N,) lengths of a leg."""
    bent, height = np.full((2, len(one.frames)), np.nan, np.float32), np.empty(len(one.frames))
    known = [row for row, side in enumerate(SIDES) if side + "Knee" in one.names]
    needed = {side + "Hip": None for side in SIDES}
    needed |= dict.fromkeys(SIDES[row] + it for row in known for it in LEG)
    for block, places in one.blocks(names=tuple(needed)):
        height[block.inner] = (places["RHip"] + places["LHip"])[:, 1] / 2 / leg
        if known:
            legs = np.array([[places[SIDES[row] + it].T for row in known] for it in LEG])
            hip, knee, ankle = legs.swapaxes(1, 2)
            bent[known, block.inner] = bend(knee - hip, ankle - knee)
    return bent, height


def _flat(heights: NDArray[np.float32], carries: Flags) -> float | None:
    """Return how much higher an ankle stands than its toe, usually, while the foot carries."""
    if len(heights) < len(FOOT) or not carries.any():
        return None
    ankle, toe = heights[:, carries]
    return fifth(ankle - toe)


def _level(one: Stretch, leg: float, feet: Feet, least: float) -> NDArray[np.float32]:
    """Return the heights (2, K, N) of foot joints over the plane nearest to four or more stands."""
    kinds = _kinds(one)
    toes = np.empty((2, len(one.frames), 3), np.float32)
    for block, places in one.blocks(names=_joints(kinds[-1:])):
        for number, side in enumerate(SIDES):
            toes[number, block.inner] = places[side + kinds[-1]] / leg
    stands = stood(toes, feet.speed, least)
    del toes
    if len(stands) < _STANDS:
        return feet.heights
    table = stands - stands.mean(axis=0)
    tilt = np.linalg.lstsq(table[:, :2], table[:, 2], rcond=_FLAT)[0]
    if np.ptp(table[:, :2], axis=0).max() <= _SPREAD or np.hypot(*tilt) >= STEEP:
        return feet.heights
    heights = feet.heights.copy()
    for block, places in one.blocks(names=_joints(kinds)):
        over = np.array([[places[side + it] for it in kinds] for side in SIDES]) / leg
        heights[..., block.inner] -= over.astype(np.float32)[..., ::2] @ tilt
    return heights


def carried(
    feet: Feet, heights: NDArray[np.float32], rate: float
) -> tuple[Flags, NDArray[np.float32], Flags, bool]:
    """Return which feet carry and how high they are over the floor, (2, N) each.

    Then in which frames both are off every floor, (N,), and whether no floor explains `heights`
    (2, K, N).
    """
    speed = feet.speed
    height = np.full(speed.shape, np.inf, np.float32)
    for kind in range(heights.shape[1]):
        own = heights[:, kind]
        some = (own[side][feet.slow[side, kind]] for side in range(2))
        rests = np.array([fifth(one) if len(one) else np.inf for one in some])
        least = min(rests) if np.isfinite(rests).any() else fifth(own.ravel())
        rests = np.where(rests < least + LIFTED, rests, least).astype(np.float32)
        np.minimum(height, own - rests[:, None], out=height)
    lower = np.minimum(*height)
    stands = _stands(lower, speed, rate)
    long = [level for level, frames in stands if frames >= STANCE * rate]
    uneven = len(long) > 1 and long[-1] - long[0] > UNEVEN
    levels = [level for level, _ in stands] or [0.0]
    most = levels[int(np.append(np.diff(levels) > RISES, True).argmax())] + RISES
    if uneven:
        height = np.where(height > most, np.float32(np.inf), np.float32(0))
    return _standing(feet, height, rate), height, lower > most, uneven


def _lowest(
    feet: Feet,
    height: NDArray[np.float32],
    carries: Flags,
    flown: list[tuple[int, int]],
    rate: float,
) -> Flags:
    """Return which feet carry where none does near the floor for long, and nobody flies."""
    lower = np.minimum(*height)
    lost = ~np.any(carries, axis=0) & (lower < RISES)
    for start, stop in flown:
        lost[start:stop] = False
    for start, stop in runs(lost):
        lost[start:stop] = stop - start >= STANCE * rate
    over = height - np.where(lost, lower, 0)
    over[:, ~lost] = np.inf
    alone = over[::-1] >= LIFTED  # the other foot does not carry
    return _standing(feet, over, rate, alone & lost)


def _standing(
    feet: Feet, height: NDArray[np.float32], rate: float, slides: Flags | None = None
) -> Flags:
    """Return which feet are slow at heights over a floor, (2, N), without flicker.

    Those that may slide, (2, N), are slow up to `SLIDES`.
    """
    speed, share = feet.speed, SHARE * feet.pace
    begins = speed < np.maximum(STANDS, share)
    if slides is not None:
        begins |= slides & (speed < np.maximum(SLIDES, share))
    begins &= height < NEAR
    stays = (speed < SLIDES) & (height < LIFTED)
    carries = np.array([held(*foot) for foot in zip(begins, stays, strict=True)])
    brief = round(FLICKER * rate)
    for foot in carries:
        for there, most in ((False, brief), (True, brief - 1)):
            for start, stop in runs(foot == there):
                if start > 0 and stop < len(foot) and stop - start <= most:
                    foot[start:stop] = not there
    return carries


def stood(points: NDArray[np.float32], speed: Floats, least: float) -> Floats:
    """Return the stands of `least` frames or more, (S, 3): over the ground, and up.

    `points` (2, N, 3) of toes or ankles, lengths of a leg; `speed` (2, N) as in `Feet`.
    """
    heights = points[..., 1]
    lower = heights <= heights[::-1] + NEAR
    found = [
        (
            *(median(points[side, start:stop, axis]) for axis in (0, 2)),
            fifth(heights[side, start:stop]),
        )
        for side, foot in enumerate(speed)
        for start, stop in runs(foot < STANDS)
        if stop - start >= least and lower[side, start:stop].all()
    ]
    return np.array(found).reshape(-1, 3)


def fifth(values: NDArray[Any]) -> float:
    """Return the value of which a fifth of all are smaller: of heights, that of the floor."""
    place = (len(values) - 1) // 5
    return float(np.partition(values, place)[place])


def _stands(lower: NDArray[np.float32], speed: Floats, rate: float) -> list[tuple[float, int]]:
    """Return the heights at which the lower of the feet stands, rising; and for how many frames."""
    slow = np.any(speed < STANDS, axis=0)
    if not slow.any() or np.ptp(lower[slow]) <= UNEVEN:
        return []
    brief = round(FLICKER * rate)
    found = (it for it in runs(slow) if it[1] - it[0] >= brief)
    return sorted((median(lower[start:stop]), stop - start) for start, stop in found)


def unsupported(carries: Flags, rate: float) -> list[tuple[int, int]]:
    """Return the stretches, longer than a flicker, in which no foot carries."""
    brief = round(FLICKER * rate)
    return [it for it in runs(~np.any(carries, axis=0)) if it[1] - it[0] > brief]


def _flights(
    bare: list[tuple[int, int]],
    lower: Floats,
    height: Floats,
    pace: NDArray[np.float32],
    rate: float,
) -> list[tuple[int, int]]:
    """Return when the body is in the air; of the lower foot and the pelvis, lengths of a leg."""
    found = []
    around = round(STANCE * rate)
    for start, stop in bare:
        least = ONWARD if pace[start:stop].mean() > RUNS else FALL
        rim = (stop - start) // 6  # smoothed with what the legs do before and after
        floor = lower[max(start - around, 0) : stop + around].min()
        clears = lower[start:stop].max() - floor >= CLEARS
        sinks = stop == len(height) or height[stop - 1] < height[stop - 2]
        if clears and sinks and -_bent(height[start + rim : stop - rim]) * rate**2 >= least:
            found.append((start, stop))
    return found


def _bent(values: Floats) -> float:
    """Return the second derivative of the parabola nearest to values, a step apart."""
    count = len(values)
    if count < 3:
        return 0.0
    square = (np.arange(count) - (count - 1) / 2) ** 2
    square -= square.mean()  # at right angles to what is level or a straight line
    return 2 * float(values @ square / (square @ square))
