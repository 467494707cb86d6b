"""NumPy arrays, alone (``.npy``) or several (``.npz``): joints, or how the joints of SMPL turn.

Nothing in a file is trusted: no pickle is opened, no size believed unchecked. An array of places is
(T, J, 3). What it lacks, others say, by these names:

- names of the joints: ``joint_names``, ``names`` ...; else their number and their bones tell the
  order (`smpl.ORDERS`);
- frames a second: ``fps``, ``rate``, ``mocap_framerate`` ...; else HumanML3D's and KIT-ML's own
  are assumed, and said;
- ``unit`` and ``up``; else the body tells them.

``poses``, or ``root_orient`` and ``pose_body``, with ``trans`` are AMASS. Rows of 263 or 251
numbers are features of HumanML3D or KIT-ML.

Source: *numpy.lib.format*, versions 1 to 3; PKWARE *APPNOTE* (ZIP).
"""

import ast
import io
import math
import re
import zipfile
import zlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.body import Declared
from lanindex.errors import CaptureError, quoted
from lanindex.formats import smpl
from lanindex.formats.file import Content, File, Wanted
from lanindex.formats.points import Points, gathered, motion_of, spread
from lanindex.formats.rates import rate_by
from lanindex.model import Motion, Reading, Span

SUFFIX = ".npy"
# how many times its packed size a member may have, and bytes besides: motion packs by 2 or 3
RATIO, SPARE = 200, 1 << 20
PLACES = ("joints", "positions", "keypoints", "xyz", "joint_positions", "joints3d", "joints_3d",
          "keypoints3d", "keypoints_3d", "poses3d", "motion", "")  # fmt: skip
NAMES = ("joint_names", "names", "joints_names", "keypoint_names", "labels")
RATES = ("fps", "rate", "mocap_framerate", "mocap_frame_rate", "framerate", "frame_rate")
LARGEST = 1e9  # places are no further away, in any unit
NEVER = ("betas", "shape", "fps")  # arrays that have no frames, whatever their lengths

_MAGIC = re.compile(rb"\x93NUMPY([\1-\3])[\0-\xff]", re.DOTALL)
_HEADER = 1 << 14  # bytes in which a header ends
_KINDS = re.compile(r"[<>=|]?(?:f[248]|[iu][1248]|b1|[US]\d{1,6})")
_UNPACKING = (
    zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError, RuntimeError, KeyError,
    NotImplementedError, OverflowError, IndexError,
)  # fmt: skip
_TURNS = 1e3  # radians
_PARTS = {"poses": ("poses",), "pose_body": ("root_orient", "pose_body")}  # of a pose, by its key
_REMEDY = "Save its joints as (T, J, 3): numpy.savez(path, joints=..., joint_names=..., fps=...)."
_WANTED = "places of joints, (T, J, 3)"


@dataclass(frozen=True, slots=True)
class Header:
    """What stands before the numbers of an array."""

    kind: np.dtype[Any]  # of its numbers
    shape: tuple[int, ...]  # how many
    fortran: bool  # whether the first axis changes fastest
    first: int  # the byte behind the header

    @property
    def size(self) -> int:
        """Bytes of its numbers."""
        return math.prod(self.shape) * self.kind.itemsize


@dataclass(frozen=True, slots=True)
class Arrays:
    """The arrays of a file, read when they are asked for."""

    place: str  # the file, for errors
    headers: dict[str, Header]  # by name; of a file of one array the name is empty
    # from name and (N, 2) stretches, rising, to these bytes of a member, end to end
    fetch: Callable[[str, NDArray[np.int64]], bytes]
    refused: dict[str, str]  # names of what cannot be read, and why

    def __getitem__(self, name: str) -> NDArray[Any]:
        header = self.headers[name]
        data = self.fetch(name, header.first + np.array([[0, header.size]]))
        order = "F" if header.fortran else "C"
        return np.frombuffer(data, header.kind).reshape(header.shape, order=order)  # type: ignore[call-overload,no-any-return]

    def frames(self, name: str, axis: int, some: NDArray[np.int64]) -> NDArray[Any]:
        """Return some frames of an array, rising: where these lie alone, no others are read."""
        header = self.headers[name]
        shape = header.shape
        if header.fortran or math.prod(shape[:axis]) != 1:
            return self[name].take(some, axis)
        edges = np.stack((some, some + 1), axis=1) * (header.size // shape[axis])
        data = self.fetch(name, header.first + edges)
        return np.frombuffer(data, header.kind).reshape(*shape[:axis], -1, *shape[axis + 1 :])


def header_of(head: bytes, there: int, place: str) -> Header:
    """Return the header of an array."""
    found = _MAGIC.match(head)
    wanted = "a NumPy array of version 1, 2 or 3"
    if not found:
        raise CaptureError(f"begins with {quoted(head[:8])}", place=place, wanted=wanted)
    wide = 2 if found[1] == b"\1" else 4
    first = 8 + wide + int.from_bytes(head[8 : 8 + wide], "little")
    if first > min(len(head), _HEADER):
        raise CaptureError(f"a header of {first} bytes", place=place, wanted=wanted)
    kind, shape, fortran = _parse_header(head[8 + wide : first], place)
    header = Header(kind, shape, fortran, first)
    if header.size > there - first:
        found_size = f"an array {shape} of {header.size} bytes, of which {there - first} are there"
        raise CaptureError(
            found_size, place=place, wanted="all of it", remedy="The file may be cut short."
        )
    return header


def _parse_header(text: bytes, place: str) -> tuple[np.dtype[Any], tuple[int, ...], bool]:
    """Return kind, shape and order as a header says them."""
    try:
        said = ast.literal_eval(text.decode("latin-1").strip())
        kind, shape, fortran = said["descr"], said["shape"], said["fortran_order"]
    except (ValueError, SyntaxError, TypeError, KeyError, MemoryError, RecursionError):
        found, wanted = f"the header {quoted(text[:60])}", "descr, fortran_order and shape"
        raise CaptureError(found, place=place, wanted=wanted) from None
    if isinstance(kind, str) and "O" in kind:
        raise CaptureError(
            "holds Python objects (a pickle), which can run any program when they are opened",
            place=place,
            wanted="arrays of numbers",
            remedy="Save its joints alone: numpy.savez(path, joints=..., fps=...).",
        )
    if not isinstance(kind, str) or not _KINDS.fullmatch(kind):
        raise CaptureError(f"numbers of the kind {quoted(kind)}", place=place, wanted="f4 or f8")
    sizes = isinstance(shape, tuple) and all(type(n) is int and 0 <= n < 1 << 40 for n in shape)
    if not sizes or len(shape) > 8:
        found, wanted = f"the shape {quoted(shape)}", "a few whole numbers"
        raise CaptureError(found, place=place, wanted=wanted)
    return np.dtype(kind), shape, bool(fortran)


def arrays(file: File) -> Arrays:
    """Return the arrays of a file."""
    content = file.content
    if content[:2] != b"PK":
        header = header_of(content[:_HEADER], len(content), file.name)
        return Arrays(file.name, {"": header}, lambda _, pieces: gathered(content, pieces)[0], {})
    packed = archive(file)
    headers, refused = {}, {}
    for info in packed.infolist():
        name = info.filename.removesuffix(SUFFIX)
        if name == info.filename:
            continue
        try:
            head = unpacked(file, packed, info, np.array([[0, _HEADER]]))
            headers[name] = header_of(head, info.file_size, f"{file.name}: {quoted(name)}")
        except CaptureError as error:
            refused[name] = error.found

    def fetch(name: str, pieces: NDArray[np.int64]) -> bytes:
        return unpacked(file, packed, packed.getinfo(name + SUFFIX), pieces)

    return Arrays(file.name, headers, fetch, refused)


def archive(file: File) -> zipfile.ZipFile:
    """Open the ZIP that a file is."""
    try:
        return zipfile.ZipFile(_stream(file.content))
    except _UNPACKING as error:
        raise CaptureError(
            f"a damaged ZIP ({error})",
            place=file.name,
            wanted="NumPy arrays",
            remedy="The file may be cut short.",
        ) from error


def unpacked(
    file: File, packed: zipfile.ZipFile, info: zipfile.ZipInfo, pieces: NDArray[np.int64]
) -> bytes:
    """Return stretches of a member of a ZIP, (N, 2) and rising, end to end."""
    if info.file_size > RATIO * info.compress_size + SPARE:
        found = f"{quoted(info.filename)} unpacks to {info.file_size} bytes"
        wanted = f"at most {RATIO} times its packed size of {info.compress_size}"
        raise CaptureError(found, place=file.name, wanted=wanted)
    pieces = np.minimum(pieces, info.file_size)
    first, stop, size = int(pieces[0, 0]), int(pieces[-1, 1]), int(np.diff(pieces).sum())
    try:
        with packed.open(info) as member:
            # what is read to its end is checked; what is sought would be read up to there
            sought = stop < info.file_size or size < stop - first
            if sought and info.compress_type == zipfile.ZIP_STORED:
                data, _ = gathered(file.content, _begin(file.content, info.header_offset) + pieces)
            else:
                member.seek(first)
                data, _ = gathered(member.read(stop - first), pieces - first)
    except _UNPACKING as error:
        found = f"{quoted(info.filename)} cannot be unpacked ({error})"
        raise CaptureError(found, place=file.name, wanted="a sound ZIP") from error
    if len(data) < size:
        found = f"{quoted(info.filename)} ends early"
        raise CaptureError(found, place=file.name, wanted="all of it")
    return data


def _begin(content: Content, header: int) -> int:
    """Return the first byte of a member that is not packed, behind its header, a name and more."""
    sizes = content[header + 26 : header + 30]
    name, more = int.from_bytes(sizes[:2], "little"), int.from_bytes(sizes[2:], "little")
    return header + 30 + name + more


class _Stream(io.RawIOBase):
    """Content as a stream, for what reads nothing else."""

    def __init__(self, content: Content) -> None:
        super().__init__()
        self._content, self._at = content, 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = 0) -> int:
        self._at = max((0, self._at, len(self._content))[whence] + offset, 0)
        return self._at

    def readinto(self, buffer: Any) -> int:
        data = self._content[self._at : self._at + len(buffer)]
        buffer[: len(data)] = data
        self._at += len(data)
        return len(data)


def _stream(content: Content) -> Any:
    return (
        io.BytesIO(content) if isinstance(content, bytes) else io.BufferedReader(_Stream(content))
    )


@dataclass(frozen=True, slots=True)
class MovementArray:
    """Which array holds the movement."""

    key: str  # its name
    axis: int  # its axis of frames
    frames: int  # how many
    kind: str = "places"  # ``places``, ``turns`` (poses of SMPL) or ``features``
    doubts: tuple[str, ...] = ()  # what was guessed


frames = spread


def read(file: File, options: Reading, wanted: Wanted) -> Motion:
    """Read an array, or a file of arrays: every joint, with its rotations in AMASS."""
    found = arrays(file)
    movement = movement_of(found)
    form = "npz" if file.content[:2] == b"PK" else "npy"
    kinds = {"places": _from_places, "turns": _from_turns, "features": _from_features}
    points = kinds[movement.kind](found, movement, options, frames(wanted, movement.frames))
    return motion_of(points, file, form, options, wanted)


def movement_of(arrays: Arrays) -> MovementArray:
    """Return where the movement is."""
    movement = _movement(arrays)
    if not movement.frames:
        raise CaptureError("no frames", place=arrays.place, wanted=_WANTED)
    return movement


def _movement(arrays: Arrays) -> MovementArray:
    shapes = {name: header.shape for name, header in arrays.headers.items() if _number(header)}
    many = [name for name, shape in shapes.items() if _axis(shape) is not None]
    named = next((name for name in PLACES if name in many), None)
    doubts: tuple[str, ...] = ()
    if named is None:
        poses, root, body, shift = (
            shapes.get(name, ()) for name in ("poses", "root_orient", "pose_body", "trans")
        )
        frames = shift[0] if shift[1:] == (3,) else None
        if frames is not None and poses in [(frames, width) for width in smpl.WIDTHS]:
            return MovementArray("poses", 0, frames, "turns")
        if frames is not None and (root, body) == ((frames, 3), (frames, 63)):
            return MovementArray("pose_body", 0, frames, "turns")
        rows = [name for name, it in shapes.items() if len(it) == 2 and it[1] in smpl.TITLES]
        if not many and len(rows) == 1:
            return MovementArray(rows[0], 0, shapes[rows[0]][0], "features")
        if len(many) != 1:
            there = _listed_arrays(arrays, shapes, many)
            raise CaptureError(there, place=arrays.place, wanted=_WANTED, remedy=_REMEDY)
        named = many[0]
        doubts = (f"its array {quoted(named)} is taken for places of joints",)
    axis = _axis(shapes[named]) or 0
    return MovementArray(named, axis, shapes[named][axis], doubts=doubts)


def _number(header: Header) -> bool:
    return header.kind.kind in "fiu"


def _axis(shape: tuple[int, ...]) -> int | None:
    """Return the axis of frames of places; None where they are no places of one person."""
    if len(shape) == 3 and shape[2] == 3 and shape[1] > 3:
        return 0
    return 1 if len(shape) == 4 and shape[0] == 1 and _axis(shape[1:]) == 0 else None


def _listed_arrays(arrays: Arrays, shapes: dict[str, tuple[int, ...]], many: Iterable[str]) -> str:
    """Say what a file holds that has no movement."""
    if many:
        return f"several arrays that may be places of joints: {', '.join(map(quoted, many))}"
    for shape in shapes.values():
        if len(shape) == 4 and _axis((1, *shape[1:])) is not None:
            return f"places of {shape[0]} people {shape}"
        if len(shape) == 3 and shape[2] == 2:
            return f"points in a picture {shape}"
    refused = [f"{quoted(name)} {why}" for name, why in arrays.refused.items()]
    there = [f"{quoted(name)} {shape}" if name else f"an array {shape}"
             for name, shape in shapes.items()]  # fmt: skip
    listed = [*refused, *there]
    return "; ".join(listed[:6]) if listed else "no array of numbers"


def _text(arrays: Arrays, keys: Iterable[str], sizes: Iterable[int]) -> list[str] | None:
    """Return the texts of the first of some arrays that is there in one of these sizes."""
    for name in keys:
        header = arrays.headers.get(name)
        if header and header.kind.kind in "US" and header.size // header.kind.itemsize in sizes:
            words = arrays[name].ravel().tolist()
            return [word.decode("utf-8", "replace") if isinstance(word, bytes) else word
                    for word in words]  # fmt: skip
    return None


def _rate(arrays: Arrays) -> str:
    """Return what the file says of its rate; empty if nothing."""
    for name in RATES:
        header = arrays.headers.get(name)
        if header and _number(header) and header.size == header.kind.itemsize:
            return repr(float(arrays[name].ravel()[0]))
    return ""


def _declared(arrays: Arrays, unit: str | None = None, up: str | None = None) -> Declared:
    words = {name: _text(arrays, (name, f"{name}s"), (1,)) for name in ("unit", "up")}
    said = {name: word[0] for name, word in words.items() if word}
    return Declared(said.get("unit", unit), said.get("up", up))


def _from_places(
    arrays: Arrays, movement: MovementArray, options: Reading, some: NDArray[np.int64]
) -> Points:
    """Return the points of an array of places in some frames."""
    places = arrays.frames(movement.key, movement.axis, some)
    places = _checked_numbers(
        places[0] if movement.axis else places, movement.key, LARGEST, arrays.place
    )
    places[np.isnan(places).any(axis=2)] = np.nan
    doubts, rate = movement.doubts, _rate(arrays)
    count = places.shape[1]
    if not np.isfinite(places).any():
        raise CaptureError("no place is known in any frame", place=arrays.place, wanted=_WANTED)
    names = _text(arrays, NAMES, (count,))
    if names is None:
        order = smpl.order_of(places)
        if order is None:
            orders = " or ".join(f"{len(it.names)} ({it.title})" for it in smpl.ORDERS)
            raise CaptureError(
                f"{count} joints without names, in no order that is known",
                place=arrays.place,
                wanted=f"names of the joints, or {orders} whose bones keep their lengths",
                remedy="Save their names with them: numpy.savez(path, joints=..., joint_names=...)",
            )
        names = list(order.names)
        rate, assumed = _assumed_rate(rate, order, options)
        doubts += assumed
    hertz, unsteady = rate_by(options, arrays.place, rate)
    return Points(tuple(names), places, hertz, _declared(arrays), doubts=(*doubts, *unsteady))


def _assumed_rate(rate: str, order: smpl.Order, options: Reading) -> tuple[str, tuple[str, ...]]:
    """Return the rate, where nobody tells it that of such files, and a doubt where it is."""
    if rate or not order.rate or options.rate is not None:
        return rate, ()
    assumed = f"no rate in it: {order.rate} frames a second assumed, as {order.title} has it"
    return order.rate, (f"{assumed}. If that is wrong, give --fps",)


def _from_features(
    arrays: Arrays, movement: MovementArray, options: Reading, some: NDArray[np.int64]
) -> Points:
    """Return the points of features in some frames: each tells how it goes on from the last."""
    values = arrays[movement.key]
    title, many = smpl.TITLES[values.shape[1]], smpl.used(values.shape[1])
    values = _checked_numbers(values[:, :many], movement.key, LARGEST, arrays.place, known=True)
    places = smpl.placed(values)[some]
    order = smpl.order_of(places)
    if order is None:
        raise CaptureError(
            f"features of {title} in which bones keep no lengths",
            place=arrays.place,
            wanted="features as they were computed",
            remedy="If they are normalised, multiply them by Std.npy and add Mean.npy.",
        )
    rate, doubts = _assumed_rate(_rate(arrays), order, options)
    hertz, unsteady = rate_by(options, arrays.place, rate)
    return Points(
        order.names, places, hertz, _declared(arrays, None, "y"), doubts=(*doubts, *unsteady)
    )


def _from_turns(
    arrays: Arrays, movement: MovementArray, options: Reading, some: NDArray[np.int64]
) -> Points:
    """Return the points of poses of SMPL in some frames."""
    place = arrays.place
    hertz, doubts = rate_by(options, place, _rate(arrays))
    poses = np.concatenate(
        [_checked_numbers(held[:, : 3 * smpl.TURNED], name, _TURNS, place, known=True)
         for name in _PARTS[movement.key] for held in [arrays.frames(name, 0, some)]], axis=1
    )  # fmt: skip
    held = arrays.frames("trans", 0, some)
    shift = _checked_numbers(held, "trans", LARGEST, place, known=True)
    places, turns = smpl.posed(poses, shift)
    declared = _declared(arrays, "m", "z")
    return Points(smpl.SMPL, places, hertz, declared, smpl.PARENTS, smpl.OFFSETS, turns, doubts)


def _checked_numbers(
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


def cutter(file: File, options: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of arrays: kinds, orders, packing and numbers are the source's."""
    found = arrays(file)
    movement = movement_of(found)
    if "" in found.headers:
        return lambda span: _cut_array(found, "", movement.axis, span)

    def cut(span: Span) -> bytes:
        clip, packed = io.BytesIO(), archive(file)
        with zipfile.ZipFile(clip, "w") as out:
            for info in packed.infolist():
                name = info.filename.removesuffix(SUFFIX)
                header = found.headers.get(name)
                if header and name != info.filename and _has_frames_of(name, header, movement):
                    data = _cut_array(
                        found, name, movement.axis if name == movement.key else 0, span
                    )
                else:
                    data = unpacked(file, packed, info, np.array([[0, info.file_size]]))
                copy = zipfile.ZipInfo(info.filename, info.date_time)
                copy.compress_type = info.compress_type
                out.writestr(copy, data)
        return clip.getvalue()

    return cut


def _has_frames_of(name: str, header: Header, movement: MovementArray) -> bool:
    """Tell whether an array has a frame for each of the movement's."""
    if name == movement.key:
        return True
    shape = header.shape
    numbers = header.kind.kind in "fiub" and name not in NEVER
    return numbers and bool(shape) and shape[0] == movement.frames


def _cut_array(arrays: Arrays, name: str, axis: int, span: Span) -> bytes:
    """Return an array's file with some of its frames."""
    some = arrays.frames(name, axis, np.arange(span.start, span.stop))
    if arrays.headers[name].fortran:
        some = np.asfortranarray(some)
    clip = io.BytesIO()
    np.lib.format.write_array(clip, some, allow_pickle=False)
    return clip.getvalue()


def write(motion: Motion) -> bytes:
    """Write a motion as ``.npz``: m, y up.

    Keys: ``joints`` (T, J, 3) float32, NaN where unknown; ``joint_names`` (J); ``fps``; ``unit``;
    ``up``; of a motion with markers ``markers`` (T, M, 3) and ``marker_names`` (M), too.
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
