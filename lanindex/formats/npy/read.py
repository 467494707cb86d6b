"""Arrays → Motion: which of them holds joints, what they are called, and how fast they follow.

An array of places is (T, J, 3). What it lacks, others say, by these names:

- names of the joints: ``joint_names``, ``names`` ...; else their number and their bones tell the
  order (`orders`);
- frames a second: ``fps``, ``rate``, ``mocap_framerate`` ...; else HumanML3D's and KIT-ML's own
  are assumed, and said;
- ``unit`` and ``up``; else the body tells them.

``poses``, or ``root_orient`` and ``pose_body``, with ``trans`` are AMASS: `smpl`. Rows of 263 or
251 numbers are features of HumanML3D or KIT-ML: `features`.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.body import Declared
from lanindex.errors import CaptureError, quoted
from lanindex.formats.file import File, Wanted
from lanindex.formats.npy import features, smpl
from lanindex.formats.npy.arrays import SUFFIX, Arrays, Header, archive, arrays, unpacked
from lanindex.formats.npy.orders import ORDERS, SMPL, Order, order_of
from lanindex.formats.points import Points, motion_of
from lanindex.formats.rates import rate_by
from lanindex.model import Motion, Reading, Span

PLACES = ("joints", "positions", "keypoints", "xyz", "joint_positions", "joints3d", "joints_3d",
          "keypoints3d", "keypoints_3d", "poses3d", "motion", "")  # fmt: skip
NAMES = ("joint_names", "names", "joints_names", "keypoint_names", "labels")
RATES = ("fps", "rate", "mocap_framerate", "mocap_frame_rate", "framerate", "frame_rate")

LARGEST = 1e9
"""Places are no further away, in any unit."""

_TURNS = 1e3  # radians
_PARTS = {"poses": ("poses",), "pose_body": ("root_orient", "pose_body")}  # of a pose, by its key
_REMEDY = "Save its joints as (T, J, 3): numpy.savez(path, joints=..., joint_names=..., fps=...)."
_WANTED = "places of joints, (T, J, 3)"


@dataclass(frozen=True, slots=True)
class MovementArray:
    """Which array holds the movement."""

    key: str  # its name
    axis: int  # its axis of frames
    frames: int  # how many
    kind: str = "places"  # ``places``, ``turns`` (poses of SMPL) or ``features``
    doubts: tuple[str, ...] = ()  # what was guessed


def read(file: File, options: Reading, wanted: Wanted) -> Motion:
    """Read an array, or a file of arrays: see `lanindex.formats.read_file`.

    Every joint; with its rotations where the file has them (AMASS).
    """
    found = arrays(file)
    layout = movement_of(found)
    form = "npz" if file.content[:2] == b"PK" else "npy"
    points = {"places": _from_places, "turns": _from_turns, "features": _from_features}[
        layout.kind
    ](found, layout, options)
    return motion_of(points, file, form, options, wanted)


def movement_of(found: Arrays) -> MovementArray:
    """Return where the movement is."""
    shapes = {name: header.shape for name, header in found.headers.items() if _number(header)}
    many = [name for name, shape in shapes.items() if _axis(shape) is not None]
    named = next((name for name in PLACES if name in many), None)
    poses, shift = shapes.get("poses", ()), shapes.get("trans", ())
    if named is None and len(poses) == 2 and poses[1] in smpl.WIDTHS and shift == (poses[0], 3):
        return _filled(found, MovementArray("poses", 0, poses[0], "turns"))
    root, poses = shapes.get("root_orient", ()), shapes.get("pose_body", ())
    if (
        named is None
        and len(root) == 2
        and root[1] == 3
        and shift == root
        and poses == (root[0], 63)
    ):
        return _filled(found, MovementArray("pose_body", 0, root[0], "turns"))
    rows = [
        name for name, shape in shapes.items() if len(shape) == 2 and shape[1] in features.TITLES
    ]
    if named is None and not many and len(rows) == 1:
        return _filled(found, MovementArray(rows[0], 0, shapes[rows[0]][0], "features"))
    doubts: tuple[str, ...] = ()
    if named is None and len(many) == 1:
        named = many[0]
        doubts = (f"its array {quoted(named)} is taken for places of joints",)
    if named is None:
        raise CaptureError(
            _instead(found, shapes, many), place=found.place, wanted=_WANTED, remedy=_REMEDY
        )
    axis = _axis(shapes[named]) or 0
    return _filled(found, MovementArray(named, axis, shapes[named][axis], doubts=doubts))


def _filled(found: Arrays, layout: MovementArray) -> MovementArray:
    if not layout.frames:
        raise CaptureError("no frames", place=found.place, wanted=_WANTED)
    return layout


def _number(header: Header) -> bool:
    return header.kind.kind in "fiu"


def _axis(shape: tuple[int, ...]) -> int | None:
    """Return the axis of frames of places; None where they are no places of one person."""
    if len(shape) == 3 and shape[2] == 3 and shape[1] > 3:
        return 0
    return 1 if len(shape) == 4 and shape[0] == 1 and _axis(shape[1:]) == 0 else None


def _instead(found: Arrays, shapes: dict[str, tuple[int, ...]], many: Iterable[str]) -> str:
    """Say what a file holds that has no movement."""
    if many:
        return f"several arrays that may be places of joints: {', '.join(map(quoted, many))}"
    for shape in shapes.values():
        if len(shape) == 4 and _axis((1, *shape[1:])) is not None:
            return f"places of {shape[0]} people {shape}"
        if len(shape) == 3 and shape[2] == 2:
            return f"points in a picture {shape}"
    refused = [f"{quoted(name)} {why}" for name, why in found.refused.items()]
    there = [f"{quoted(name)} {shape}" if name else f"an array {shape}"
             for name, shape in shapes.items()]  # fmt: skip
    listed = [*refused, *there]
    return "; ".join(listed[:6]) if listed else "no array of numbers"


def _text(found: Arrays, keys: Iterable[str], sizes: Iterable[int]) -> list[str] | None:
    """Return the texts of the first of some arrays that is there in one of these sizes."""
    for name in keys:
        header = found.headers.get(name)
        if header and header.kind.kind in "US" and header.size // header.kind.itemsize in sizes:
            words = found[name].ravel().tolist()
            return [word.decode("utf-8", "replace") if isinstance(word, bytes) else word
                    for word in words]  # fmt: skip
    return None


def _rate(found: Arrays) -> str:
    """Return what the file says of its rate; empty if nothing."""
    for name in RATES:
        header = found.headers.get(name)
        if header and _number(header) and header.size == header.kind.itemsize:
            return repr(float(found[name].ravel()[0]))
    return ""


def _declared(found: Arrays, unit: str | None = None, up: str | None = None) -> Declared:
    words = {name: _text(found, (name, f"{name}s"), (1,)) for name in ("unit", "up")}
    said = {name: word[0] for name, word in words.items() if word}
    return Declared(said.get("unit", unit), said.get("up", up))


def _from_places(found: Arrays, layout: MovementArray, options: Reading) -> Points:
    """Return the points of an array of places."""
    places = found[layout.key]
    places = _sound(places[0] if layout.axis else places, layout.key, LARGEST, found.place)
    places[np.isnan(places).any(axis=2)] = np.nan
    doubts, rate = layout.doubts, _rate(found)
    count = places.shape[1]
    if not np.isfinite(places).any():
        raise CaptureError("no place is known in any frame", place=found.place, wanted=_WANTED)
    names = _text(found, NAMES, (count,))
    if names is None:
        order = order_of(places)
        if order is None:
            orders = " or ".join(f"{len(it.names)} ({it.title})" for it in ORDERS)
            raise CaptureError(
                f"{count} joints without names, in no order that is known",
                place=found.place,
                wanted=f"names of the joints, or {orders} whose bones keep their lengths",
                remedy="Save their names with them: numpy.savez(path, joints=..., joint_names=...)",
            )
        names = list(order.names)
        rate, assumed = _assumed(rate, order, options)
        doubts += assumed
    hertz, unsteady = rate_by(options, found.place, rate)
    return Points(tuple(names), places, hertz, _declared(found), doubts=(*doubts, *unsteady))


def _assumed(rate: str, order: Order, options: Reading) -> tuple[str, tuple[str, ...]]:
    """Return the rate, where nobody tells it that of such files, and a doubt where it is."""
    if rate or not order.rate or options.rate is not None:
        return rate, ()
    assumed = f"no rate in it: {order.rate} frames a second assumed, as {order.title} has it"
    return order.rate, (f"{assumed}. If that is wrong, give --fps",)


def _from_features(found: Arrays, layout: MovementArray, options: Reading) -> Points:
    """Return the points of features."""
    values = found[layout.key]
    title, many = features.TITLES[values.shape[1]], features.used(values.shape[1])
    values = _sound(values[:, :many], layout.key, LARGEST, found.place, known=True)
    places = features.placed(values)
    order = order_of(places)
    if order is None:
        raise CaptureError(
            f"features of {title} in which bones keep no lengths",
            place=found.place,
            wanted="features as they were computed",
            remedy="If they are normalised, multiply them by Std.npy and add Mean.npy.",
        )
    rate, doubts = _assumed(_rate(found), order, options)
    hertz, unsteady = rate_by(options, found.place, rate)
    return Points(
        order.names, places, hertz, _declared(found, None, "y"), doubts=(*doubts, *unsteady)
    )


def _from_turns(found: Arrays, layout: MovementArray, options: Reading) -> Points:
    """Return the points of poses of SMPL."""
    hertz, doubts = rate_by(options, found.place, _rate(found))
    poses = np.concatenate(
        [_sound(found[name][:, : 3 * smpl.TURNED], name, _TURNS, found.place, known=True)
         for name in _PARTS[layout.key]], axis=1
    )  # fmt: skip
    shift = _sound(found["trans"], "trans", LARGEST, found.place, known=True)
    places, turns = smpl.placed(poses, shift)
    declared = _declared(found, "m", "z")
    return Points(SMPL, places, hertz, declared, smpl.PARENTS, smpl.OFFSETS, turns, doubts)


def _sound(
    values: NDArray[Any], name: str, largest: float, place: str, known: bool = False
) -> NDArray[np.float32]:
    """Return numbers as float32; refuse absurd ones, and unknown ones where all must be known."""
    result = np.empty(values.shape, np.float32)
    with np.errstate(invalid="ignore"):  # of all that is no number, some signals
        for start in range(0, len(values), smpl.BLOCK):
            block = values[start : start + smpl.BLOCK].astype(np.float64)
            bad = ~(np.abs(block) <= largest) if known else np.abs(block) > largest
            if bad.any():
                at = tuple(np.argwhere(bad)[0].tolist())
                found = f"{name or 'array'}: frame {start + at[0]} has {block[at]}"
                raise CaptureError(found, place=place, wanted=f"numbers up to {largest:g}")
            result[start : start + smpl.BLOCK] = block
    return result


_NEVER = ("betas", "shape", "fps")


def cutter(file: File, options: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of arrays, which are looked through once.

    Kinds, orders and packing are the source's; numbers are its numbers, byte for byte.
    """
    found = arrays(file)
    layout = movement_of(found)
    if "" in found.headers:
        return lambda span: _cut(found, "", layout.axis, span)
    return lambda span: _members(file, found, layout, span)


def _members(file: File, found: Arrays, layout: MovementArray, span: Span) -> bytes:
    """Return the ZIP with its arrays cut."""
    clip, packed = io.BytesIO(), archive(file)
    with zipfile.ZipFile(clip, "w") as out:
        for info in packed.infolist():
            name = info.filename.removesuffix(SUFFIX)
            header = found.headers.get(name)
            if header and name != info.filename and _follows(name, header, layout):
                data = _cut(found, name, layout.axis if name == layout.key else 0, span)
            else:
                data = unpacked(file.name, packed, info, 0, info.file_size)
            copy = zipfile.ZipInfo(info.filename, info.date_time)
            copy.compress_type = info.compress_type
            out.writestr(copy, data)
    return clip.getvalue()


def _follows(name: str, header: Header, layout: MovementArray) -> bool:
    """Tell whether an array has a frame for each of the movement's."""
    if name == layout.key:
        return True
    shape = header.shape
    numbers = header.kind.kind in "fiub" and name not in _NEVER
    return numbers and bool(shape) and shape[0] == layout.frames


def _cut(found: Arrays, name: str, axis: int, span: Span) -> bytes:
    """Return an array's file with some of its frames."""
    array = found[name]
    some = array[:, span.start : span.stop] if axis else array[span.start : span.stop]
    if found.headers[name].fortran:
        some = np.asfortranarray(some)
    clip = io.BytesIO()
    np.lib.format.write_array(clip, some, allow_pickle=False)
    return clip.getvalue()


def write(motion: Motion) -> bytes:
    """Write a motion as ``.npz``: metres, y up.

    Keys: ``joints`` (T, J, 3) float32, NaN where unknown; ``joint_names`` (J); ``fps``; ``unit``,
    ``m``; ``up``, ``y``; of a motion that has markers ``markers`` (T, M, 3) and ``marker_names``
    (M) too.
    """
    arrays: dict[str, Any] = {
        "joints": motion.positions / np.float32(1000),
        "joint_names": np.array(motion.skeleton.names),
        "fps": np.array(float(motion.rate)),
        "unit": np.array("m"),
        "up": np.array("y"),
    }
    if motion.markers is not None:
        arrays["markers"] = motion.markers.positions / np.float32(1000)
        arrays["marker_names"] = np.array(motion.markers.names)
    file = io.BytesIO()
    np.savez_compressed(file, allow_pickle=False, **arrays)
    return file.getvalue()
