"""AMC and ASF → Motion, a block of frames at a time.

A bone turns about axes of its own, fixed to its parent: those of the world at rest, turned by the
angles of its skeleton. (Written with matrices: parent · C · M · C⁻¹.)
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lanindex.body import Declared
from lanindex.body.calibration import UNITS
from lanindex.errors import CaptureError
from lanindex.formats.amc.asf import Bone, Bones, parse, skeleton_of
from lanindex.formats.amc.frames import AmcLayout, Numbers, scan
from lanindex.formats.file import File, Wanted, holding, line_of
from lanindex.formats.points import END, Points, motion_of
from lanindex.formats.rates import nearest_rate, told_rate
from lanindex.formats.turning import product, rotated
from lanindex.model import Motion, Reading

BLOCK = 1024
"""Frames whose numbers are held at a time."""

USUAL_RATE = Fraction(120)
"""Hz, of the public collections in this format, which for the most part does not tell it."""

MANY_PLACES = 100_000
"""Of joints that do not move: so many cost nothing."""

_INCH = 25.4
_SAME = 0.01  # of a unit: two of its names


def read(file: File, options: Reading, wanted: Wanted) -> Motion:
    """Read an AMC file with the skeleton beside it: see `lanindex.formats.read_file`.

    A joint is where a bone begins, and has its name; where the last ones end there is one
    more, ``head End``.
    """
    layout = scan(file.content, file.name)
    asf, doubts = skeleton_of(file, options)
    skeleton = parse(asf)
    rate, rate_doubts = _rate(layout, options)
    names, parents, offsets = joints_of(skeleton.bones)
    numbers = Numbers(skeleton.bones)
    radians = not skeleton.degrees if layout.radians is None else layout.radians
    turn, tilt = (1.0 if it else math.pi / 180 for it in (radians, not skeleton.degrees))
    axes, count = axes_of(skeleton.bones, tilt), len(layout.starts)
    if count * len(names) > len(file.content) + MANY_PLACES:
        found = f"{len(names)} joints in {count} frames, of which few can move"
        raise CaptureError(found, place=asf.name, wanted="at most as many places as bytes")
    places = np.empty((count, len(names), 3), np.float32)
    turns = np.empty((count, len(names), 4), np.float32)
    for start in range(0, count, BLOCK):
        block = slice(start, start + BLOCK)
        stops, ends = layout.stops[block], layout.ends[block]
        data, first = holding(file.content, int(stops[0]), int(ends[-1]))
        values = numbers.read(data, stops - first, ends - first, _Places(file, first))
        places[block], turns[block] = world(skeleton.bones, axes, values, turn)
    doubts += (*skeleton.doubts, *_order_doubt(skeleton), *_count_doubt(layout), *rate_doubts)
    declared = Declared(_unit(skeleton.inches), "y")
    points = Points(names, places, rate, declared, parents, offsets, turns, doubts)
    return motion_of(points, file, "amc", options, wanted)


def beside(file: File, options: Reading | None = None) -> tuple[tuple[str, bytes], ...]:
    """Return what has to lie beside a clip: the skeleton, by the ending of its name."""
    skeleton, _ = skeleton_of(file, options or Reading())
    return ((".asf", skeleton.content[:]),)


class _Places:
    """Says in which line a byte stands, counted from the first that is held."""

    def __init__(self, file: File, first: int) -> None:
        self._file, self._first = file, first

    def __call__(self, at: int) -> str:
        return f"{self._file.name}:{line_of(self._file.content, self._first + at)}"


def _rate(layout: AmcLayout, options: Reading) -> tuple[Fraction, tuple[str, ...]]:
    if options.rate is not None:
        return told_rate(options.rate), ()
    if layout.rate is not None:
        return nearest_rate(layout.rate), ()
    doubt = f"it does not tell its rate: {USUAL_RATE} frames a second. If that is wrong, give --fps"
    return USUAL_RATE, (doubt,)


def _unit(inches: float) -> str | None:
    """Return the unit of which an inch has so many, if it has a name."""
    if inches <= 0:
        return None
    size = _INCH / inches
    names = (name for name, length in UNITS.items() if abs(length - size) <= _SAME * size)
    return next(names, None)


def _order_doubt(skeleton: Bones) -> tuple[str, ...]:
    """Return a warning where a bone's numbers and its axes are in different orders."""
    for bone in skeleton.bones:
        turns = [code for code in bone.dof if code < 3]
        if [axis for axis in bone.order if axis in turns] != turns:
            name = bone.name.decode("utf-8", "replace")[:40]
            return (f"{name} turns in the order of its dof, not that of its axis",)
    return ()


def _count_doubt(layout: AmcLayout) -> tuple[str, ...]:
    """Return a warning where frames are missing, by their numbers."""
    jumps = np.flatnonzero(np.diff(layout.numbers) != 1)
    if not len(jumps):
        return ()
    before, behind = layout.numbers[jumps[0] : jumps[0] + 2].tolist()
    return (f"frame {behind} follows frame {before}: taken for the next",)


Floats = NDArray[np.float64]


def joints_of(bones: Sequence[Bone]) -> tuple[tuple[str, ...], tuple[int, ...], Floats]:
    """Return a skeleton's joints: where each bone begins, by its name, then where the last end.

    Returns (J, 3).
    """
    names = [bone.name.decode("utf-8", "replace") for bone in bones]
    last = _last(bones)
    parents = [*(bone.parent for bone in bones), *last]
    shifts = [(0.0,) * 3 if bone.parent < 0 else bone.shift for bone in bones]
    offsets = [(0.0,) * 3 if parent < 0 else shifts[parent] for parent in parents]
    return (*names, *(names[bone] + END for bone in last)), tuple(parents), np.array(offsets)


def axes_of(bones: Sequence[Bone], tilt: float) -> list[Floats]:
    """Return the axes that each bone turns about, as columns."""
    return [_axes(bone, tilt) for bone in bones]


def world(
    bones: Sequence[Bone], axes: Sequence[Floats], values: Floats, turn: float
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return where joints are, and their rotations from rest.

    Takes `values` (T, W); returns (T, J, 3), (T, J, 4).
    """
    last = _last(bones)
    places = np.empty((len(bones) + len(last), len(values), 3))
    turns = np.empty((len(bones) + len(last), len(values), 4))
    column = 0
    for index, bone in enumerate(bones):
        numbers = values[:, column : column + len(bone.dof)].T
        column += len(bone.dof)
        if bone.parent < 0:
            places[index] = bone.shift
            turned: Floats = np.broadcast_to((1.0, 0.0, 0.0, 0.0), turns[index].shape)
        else:
            places[index] = places[bone.parent]
            turned = turns[bone.parent]
            if bone.parent:
                places[index] += rotated(turned, np.array(bones[bone.parent].shift))
        for code, number in reversed(list(zip(bone.dof, numbers, strict=True))):
            if code < 3:
                half = number * (turn / 2.0)
                own = np.column_stack((np.cos(half), np.outer(np.sin(half), axes[index][:, code])))
                turned = product(turned, own)
            else:
                places[index, :, code - 3] += number
        turns[index] = turned
    for index, above in enumerate(last, len(bones)):
        turns[index] = turns[above]
        places[index] = places[above] + rotated(turns[above], np.array(bones[above].shift))
    return places.transpose(1, 0, 2).astype(np.float32), turns.transpose(1, 0, 2).astype(np.float32)


def _last(bones: Sequence[Bone]) -> list[int]:
    """Return the bones from which no other goes on."""
    above = {bone.parent for bone in bones}
    return [index for index in range(1, len(bones)) if index not in above]


def _axes(bone: Bone, tilt: float) -> Floats:
    axes = np.eye(3)
    for axis in bone.order:
        one, other = (axis + 1) % 3, (axis + 2) % 3
        cosine, sine = np.cos(bone.axis[axis] * tilt), np.sin(bone.axis[axis] * tilt)
        turn = np.eye(3)
        turn[one, one] = turn[other, other] = cosine
        turn[one, other], turn[other, one] = -sine, sine
        axes = turn @ axes
    return axes
