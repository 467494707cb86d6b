"""Which foot carries, frame by frame, and when neither does.

Source: ``encode/BODY.md``, "Which foot carries".
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import PARTS
from lanindex.encode.arithmetic import runs
from lanindex.encode.limbs import body, lengths, smooth, window
from lanindex.encode.profile import Profile
from lanindex.encode.resample import resample
from lanindex.model import Motion, Span

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

STANDS, SLIDES = 0.3, 0.9
"""Lengths of a leg a second: a foot that is slower begins to carry; a faster one ends."""

STIRS = 0.1
"""Lengths of a leg a second: a foot that is slower does not leave the floor yet."""

NEAR, LIFTED = 0.06, 0.09
"""Lengths of a leg above the floor: a lower foot begins to carry; a higher one ends."""

FLICKER = 0.07
"""Seconds: what lasts no longer is no lifting, no carrying and no flight."""

UNEVEN = 0.2
"""Lengths of a leg between the feet of a capture that stand: with more there is no floor."""

STANCE = 0.25
"""Seconds that a foot stands at least where the floor is looked for."""

LOST = 0.2
"""Part of a stretch in which the feet neither carry nor fly: more is doubtful."""

FALL = 5.5
"""Lengths of a leg a second squared: a body in the air is drawn down so much at least."""

SIDES = "RL"

STEEP = 0.15
"""How far a floor may rise, as a part of the way: steeper are stairs."""

_STANDS, _SPREAD = 4, 1.0  # stands, and lengths of a leg between them, that tell how a floor slopes
_FLAT = 0.1  # of stands in a row, how far they stray from it: less tells no slope across
LEGS = ("r_leg", "l_leg")
FOOT = ("Ankle", "Toe")


@dataclass(frozen=True, eq=False)
class Ground:
    """A body over the ground, over one stretch in which hips and ankles are known.

    All frames are resampled ones, counted from the stretch's first; coordinates are those of the
    capture, smoothed.

    Attributes
    ----------
    known : Span
        The stretch, in frames of the source.
    begin : int
        Number of the first resampled frame.
    rate : float
        Resampled frames a second.
    leg : float
        Its length, mm.
    places : dict of str to ndarray
        (N, 3) float64, mm, by joint: hips, ankles, and knees and toes where they are known.
    carries : ndarray
        (2, N) bool: the right foot, the left foot.
    speed : ndarray
        (2, N) float64, lengths of a leg a second: of each foot the slower of ankle and toe.
    air : list of tuple of int and int
        Flights: the first frame in which no foot carries, and the one behind the last.
    doubts : tuple of str
        What was doubtful.
    """

    known: Span
    begin: int
    rate: float
    leg: float
    places: dict[str, Floats]
    carries: Flags
    speed: Floats
    air: list[tuple[int, int]]
    doubts: tuple[str, ...] = ()

    @cached_property
    def pelvis(self) -> Floats:
        """The middle of the hips, (N, 3), mm."""
        return middle(self.places)

    @cached_property
    def flat(self) -> tuple[float | None, float | None]:
        """How much higher the ankle stands than the toe, usually, of each foot; mm."""
        usual = []
        for side, carries in zip(SIDES, self.carries, strict=True):
            known = side + "Toe" in self.places and carries.any()
            ankle, toe = (self.places[side + it][carries, 1] if known else None for it in FOOT)
            usual.append(None if ankle is None or toe is None else fifth(ankle - toe))
        return usual[0], usual[1]


def middle(places: dict[str, Floats]) -> Floats:
    """Return the middle of the hips, (N, 3)."""
    found: Floats = (places["RHip"] + places["LHip"]) / 2
    return found


def stretches(
    motion: Motion, profile: Profile, needed: Sequence[str], wished: Sequence[str] = ()
) -> Iterator[tuple[Span, int, dict[str, Floats]]]:
    """Yield the stretches in which joints are known, resampled and smoothed.

    Parameters
    ----------
    motion : Motion
        The capture.
    profile : Profile
        Rate and smoothing.
    needed : sequence of str
        Joints without which there is no stretch.
    wished : sequence of str
        Joints that are there if they are known over the whole of it.

    Yields
    ------
    tuple of Span, int and dict
        Frames of the source, the first resampled frame, and (N, 3) float64 places, mm.
    """
    joints = body(motion, [*needed, *wished])
    seen = {name: ~np.isnan(joints[name].sum(axis=1)) for name in joints.names}
    width = window(profile.smoothing, profile.rate)
    for start, stop in runs(np.logical_and.reduce([seen[name] for name in needed])):
        places, begin = dict[str, Floats](), 0
        for name in (*needed, *(it for it in wished if seen[it][start:stop].all())):
            points = joints[name][start:stop]
            begin, points = resample(points, start, motion.rate, profile.rate)
            places[name] = smooth(points[None], width)[0]
        if len(places[needed[0]]):
            yield Span(start, stop), begin, places


def grounds(motion: Motion, profile: Profile, leg: float) -> Iterator[Ground]:
    """Yield how a body stands and goes, stretch by stretch.

    Parameters
    ----------
    motion : Motion
        The capture.
    profile : Profile
        Rate and smoothing.
    leg : float
        As from `leg_of`.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.encode.ground import grounds, leg_of
    >>> motion = lanindex.read("corpus/jumping_jacks.bvh")
    >>> (found,) = grounds(motion, lanindex.load_profile(), leg_of(motion))
    >>> found.carries.shape
    (2, 719)
    """
    needed = [side + name for side in SIDES for name in ("Hip", "Ankle")]
    wished = [side + name for side in SIDES for name in ("Knee", "Toe")]
    rate = float(profile.rate)
    for known, begin, places in stretches(motion, profile, needed, wished):
        carries, speed, doubts = _carries(places, leg, rate)
        air = _flights(carries, middle(places)[:, 1] / leg, rate)
        lost = np.count_nonzero(~np.any(carries, axis=0)) - sum(stop - start for start, stop in air)
        if lost > LOST * carries.shape[1]:
            doubts += ("the feet slide over the floor: what steps there are is told in part",)
        yield Ground(known, begin, rate, leg, places, carries, speed, air, doubts)


def leg_of(motion: Motion) -> float | None:
    """Return the length of the legs in mm, the mean of both; None where neither is known."""
    chains = {joint for part in LEGS for joint in PARTS[part].chain}
    found = [size for size in lengths(body(motion, chains), LEGS).tolist() if size > 0]
    return sum(found) / len(found) if found else None


def _carries(
    places: dict[str, Floats], leg: float, rate: float
) -> tuple[Flags, Floats, tuple[str, ...]]:
    """Return which feet carry, (2, N), how fast they are, and what was doubtful."""
    kinds = [it for it in FOOT if all(side + it in places for side in SIDES)]
    points = np.array([[places[side + it] for it in kinds] for side in SIDES]) / leg  # (2, K, N, 3)
    speeds = np.linalg.norm(_slope(points, rate), axis=-1)
    slow = speeds < STANDS
    speed = speeds.min(axis=1)
    heights = _above(points, slow, [runs(foot < STANDS) for foot in speed], STANCE * rate)
    height = heights.min(axis=1)
    doubts: tuple[str, ...] = ()
    if _uneven(height, speed, rate):
        height = np.zeros_like(height)
        doubts = ("the feet stand at different heights: which of them carries is told by speed",)
    begins, stays = (speed < STANDS) & (height < NEAR), (speed < SLIDES) & (height < LIFTED)
    carries = np.array([held(*foot) for foot in zip(begins, stays, strict=True)])
    brief = round(FLICKER * rate)
    for foot in carries:
        for start, stop in runs(~foot):
            if start > 0 and stop < len(foot) and stop - start <= brief:
                foot[start:stop] = True
        for start, stop in runs(foot):
            if start > 0 and stop < len(foot) and stop - start < brief:
                foot[start:stop] = False
    return carries, speed, doubts


def _slope(points: Floats, rate: float) -> Floats:
    """Return velocities of (..., N, 3) points."""
    if points.shape[-2] < 2:
        return np.zeros_like(points)
    slope: Floats = np.gradient(points, axis=-2) * rate
    return slope


def _above(
    points: Floats, slow: Flags, stands: list[list[tuple[int, int]]], least: float
) -> Floats:
    """Return how high joints of the feet are above where they stand, (2, K, N).

    The floor may slope: it is the plane nearest to where toes stand, of four stands at least.
    """
    heights = points[..., 1].copy()
    lower = heights[:, -1] <= heights[::-1, -1] + NEAR
    found = [
        (
            *np.median(points[side, -1, start:stop, ::2], axis=0),
            fifth(heights[side, -1, start:stop]),
        )
        for side, those in enumerate(stands)
        for start, stop in those
        if stop - start >= least and lower[side, start:stop].all()
    ]
    if len(found) >= _STANDS:
        table = np.array(found) - np.mean(found, axis=0)
        tilt = np.linalg.lstsq(table[:, :2], table[:, 2], rcond=_FLAT)[0]
        if np.ptp(table[:, :2], axis=0).max() > _SPREAD and np.hypot(*tilt) < STEEP:
            heights -= points[..., ::2] @ tilt
    for kind in range(heights.shape[1]):
        some = (heights[side, kind][slow[side, kind]] for side in range(2))
        rests = [fifth(one) for one in some if len(one)] or [fifth(heights[:, kind].ravel())]
        heights[:, kind] -= min(rests)
    return heights


def fifth(values: Floats) -> float:
    """Return the value of which a fifth of all are smaller: of heights, that of the floor."""
    place = (len(values) - 1) // 5
    return float(np.partition(values, place)[place])


def _uneven(height: Floats, speed: Floats, rate: float) -> bool:
    """Tell whether the lower of the feet stands at heights that no floor explains."""
    lower = np.minimum(*height)
    stands = [
        float(np.median(lower[start:stop]))
        for start, stop in runs(np.any(speed < STANDS, axis=0))
        if stop - start >= STANCE * rate
    ]
    return len(stands) > 1 and max(stands) - min(stands) > UNEVEN


def _flights(carries: Flags, height: Floats, rate: float) -> list[tuple[int, int]]:
    """Return when the body is in the air; the pelvis's height in lengths of a leg."""
    found = []
    for start, stop in runs(~np.any(carries, axis=0)):
        if stop - start > round(FLICKER * rate):
            seconds = np.arange(stop - start) / rate
            if -2 * np.polyfit(seconds, height[start:stop], 2)[0] >= FALL:
                found.append((start, stop))
    return found


def held(begins: Flags, stays: Flags) -> Flags:
    """Return a state with hysteresis: on from a frame where it begins, as long as it stays.

    Examples
    --------
    >>> import numpy as np
    >>> from lanindex.encode.ground import held
    >>> speed = np.array([3, 1, 2, 2, 3, 2])
    >>> held(speed < 2, speed < 3).tolist()
    [False, True, True, True, False, False]
    """
    on = begins & stays
    last = np.maximum.accumulate(np.where(on | ~stays, np.arange(len(on)), 0))
    state: Flags = on[last]
    return state
