"""AMC, how an Acclaim skeleton moves, with the skeleton beside it, ASF: read, cut byte for byte.

A bone turns about axes of its own, fixed to its parent: those of the world at rest, turned by the
angles of its skeleton. (Written with matrices: parent · C · M · C⁻¹.) Where all frames name the
bones in one order, the names are blanked out and the numbers are read as BVH's are; else line by
line, which also says what is wrong.

Source: J. Lander, "Working with motion capture file formats", *Game Developer*, January 1998;
the captures of mocap.cs.cmu.edu.
"""

import math
import os
import re
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache, partial
from pathlib import PurePath
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex import locations
from lanindex.body import Declared
from lanindex.body.calibration import UNITS
from lanindex.errors import CaptureError
from lanindex.formats import archives
from lanindex.formats.decimals import LARGEST
from lanindex.formats.file import (
    PIECE,
    Content,
    File,
    Wanted,
    clip,
    holding,
    line_of,
    opened,
    siblings,
    text_of,
)
from lanindex.formats.points import END, Points, motion_of
from lanindex.formats.rates import given_rate, nearest_rate
from lanindex.formats.text_rows import fault, number_rows
from lanindex.formats.turning import UNSCALED, UNTURNED, place, product
from lanindex.model import Motion, Reading, Span

Floats = NDArray[np.float64]
Places = NDArray[np.int64]
Vector = tuple[float, ...]

ROOT = b"root"
MOST_BONES = 1000  # more than any body has
LARGEST_FILE = 16 << 20  # bytes; a skeleton has a few thousand
BLOCK = 2048  # frames whose numbers are held at a time
USUAL_RATE = Fraction(120)  # of the public collections in this format, which mostly do not tell it
MANY_PLACES = 100_000  # of joints that do not move: so many cost nothing

_ENDING = ".asf"
_MOST_STEMS = 8
_NUMBER = 64  # bytes that the number of a frame, and what surrounds it, is shorter than
_DIGITS = 15
_INCH = 25.4
_SAME = 0.01  # of a unit: two of its names
_RATE = re.compile(rb"\s*:SAMPLES-PER-SECOND\s+(?![\d.]{13})(\d+\.?\d*|\.\d+)\s*", re.IGNORECASE)
_TURNS = {"RX": 0, "RY": 1, "RZ": 2}
_CHANNELS = {**_TURNS, "TX": 3, "TY": 4, "TZ": 5}
_AXES = {"X": 0, "Y": 1, "Z": 2}
_TURNED = "the root of its skeleton is turned at rest: taken for the axes that it turns about"


@dataclass(slots=True)
class Bone:
    """A bone, or the root, which has no length."""

    name: bytes  # as AMC calls it
    shift: Vector  # from its beginning to its end, units of the file; of the root: where it stands
    axis: Vector  # angles of its own axes, about x, y and z
    # about which axis those angles turn first, next and last; the axes do not turn with it
    order: tuple[int, ...]
    dof: tuple[int, ...]  # its numbers in AMC: 0 to 2 turn about x, y, z, 3 to 5 move along them
    parent: int = -1  # -1 for the root


@dataclass(frozen=True, slots=True)
class Bones:
    """What an ASF file tells."""

    bones: tuple[Bone, ...]  # parents before children, the root first
    inches: float  # in one inch, so many of its units; 0: it does not say
    degrees: bool  # whether its angles are degrees; else radians
    doubts: tuple[str, ...]  # what is unusual in it


class _Line(NamedTuple):
    """The words of a line, and where it stands."""

    place: str
    words: list[bytes]

    def error(self, wanted: str) -> CaptureError:
        text = text_of(b" ".join(self.words))
        return CaptureError(f"{text[:40]!r}", place=self.place, wanted=wanted)

    def numbers(self, count: int) -> Vector:
        """Return the numbers behind the first word."""
        try:
            found = tuple(float(word) for word in self.words[1 : count + 1] if b"_" not in word)
        except ValueError:
            found = ()
        if len(found) < count or not all(abs(number) <= LARGEST for number in found):
            wanted = "a number" if count == 1 else f"{count} numbers"
            raise self.error(f"{wanted} behind {text_of(self.words[0])[:20]}")
        return found

    def codes(self, known: Mapping[str, int], words: list[str]) -> tuple[int, ...]:
        """Return what words mean, each of them once."""
        codes = tuple(known.get(word.upper(), -1) for word in words)
        if -1 in codes or len(set(codes)) < len(codes):
            raise self.error(f"each of {' '.join(known)} once at most")
        return codes

    def rest(self, start: int) -> list[str]:
        return [text_of(word) for word in self.words[start:]]


Fields = dict[bytes, _Line]


def parse(file: File) -> Bones:
    """Read a skeleton."""
    if len(file.content) > LARGEST_FILE:
        found = f"a skeleton of {len(file.content)} bytes"
        raise CaptureError(found, place=file.name, wanted=f"at most {LARGEST_FILE}")
    units, root, each, hierarchy = _sections(file)
    degrees = True
    if b"angle" in units:
        unit = "".join(units[b"angle"].rest(1)).lower()[:3]
        if unit not in ("deg", "rad"):
            raise units[b"angle"].error("angle deg or angle rad")
        degrees = unit == "deg"
    top = _root(root)
    bones = {ROOT: top}
    for fields in each:
        bone = _bone(fields)
        if bone.name in bones:
            raise fields[b"name"].error("a name of its own")
        bones[bone.name] = bone
    ordered = _in_order(bones, hierarchy, file.name)
    inches = units[b"length"].numbers(1)[0] if b"length" in units else 0.0
    return Bones(ordered, inches, degrees, (_TURNED,) if any(top.axis) else ())


def _sections(file: File) -> tuple[Fields, Fields, list[Fields], list[_Line]]:
    """Return the lines of units, root, bones and hierarchy; a colon begins a section."""
    data = file.content[:].removeprefix(b"\xef\xbb\xbf")
    fields: dict[bytes, Fields] = {b":units": {}, b":root": {}}
    bones, hierarchy = list[Fields](), list[_Line]()
    section, line = b"", _Line(f"{file.name}:1", [])
    for number, text in enumerate(data.splitlines(), 1):
        words = text.split()
        if not words or words[0].startswith(b"#"):
            continue
        line = _Line(f"{file.name}:{number}", words)
        key = words[0].lower()
        if key.startswith(b":"):
            section = key
        elif section in fields:
            fields[section][key] = line
        elif section == b":hierarchy" and key not in (b"begin", b"end"):
            hierarchy.append(line)
        elif section == b":bonedata" and key == b"begin":
            bones.append({key: line})
        elif section == b":bonedata" and bones:
            bones[-1][key] = line
        elif not section:
            raise line.error("an ASF file, which begins with :version")
    if not bones or not hierarchy:
        found = f"ends without {':hierarchy' if bones else ':bonedata'}"
        wanted = ":root, :bonedata and :hierarchy"
        raise CaptureError(found, place=line.place, wanted=wanted)
    if len(bones) > MOST_BONES:
        found, wanted = f"{len(bones)} bones", f"at most {MOST_BONES}, a body's"
        raise CaptureError(found, place=file.name, wanted=wanted)
    return fields[b":units"], fields[b":root"], bones, hierarchy


def _root(fields: Fields) -> Bone:
    order = fields.get(b"order")
    return Bone(
        ROOT,
        fields[b"position"].numbers(3) if b"position" in fields else (0.0,) * 3,
        fields[b"orientation"].numbers(3) if b"orientation" in fields else (0.0,) * 3,
        _order(fields[b"axis"], 1) if b"axis" in fields else (0, 1, 2),
        order.codes(_CHANNELS, order.rest(1)) if order else (),
    )


def _bone(fields: Fields) -> Bone:
    for key in (b"name", b"direction", b"length"):
        if key not in fields:
            raise fields[b"begin"].error(f"a bone with its {key.decode()}")
    name, axis, dof = fields[b"name"], fields.get(b"axis"), fields.get(b"dof")
    if len(name.words) != 2:
        raise name.error("one word behind name")
    length = fields[b"length"].numbers(1)[0]
    return Bone(
        name.words[1],
        tuple(length * part for part in fields[b"direction"].numbers(3)),
        axis.numbers(3) if axis else (0.0,) * 3,
        _order(axis, 4) if axis else (0, 1, 2),
        dof.codes(_TURNS, dof.rest(1)) if dof else (),
    )


def _order(line: _Line, place: int) -> tuple[int, ...]:
    """Return the order of axes that is written as XYZ."""
    order = line.codes(_AXES, list("".join(line.rest(place)[:1])))
    if len(order) not in (0, 3):
        raise line.error("XYZ in some order at its end")
    return order or (0, 1, 2)


def _in_order(bones: dict[bytes, Bone], lines: list[_Line], path: str) -> tuple[Bone, ...]:
    """Return bones, parents before children, as the hierarchy hangs them."""
    children: dict[bytes, list[bytes]] = {}
    below: set[bytes] = set()
    for line in lines:
        parent, *names = line.words
        for name in line.words:
            if name not in bones:
                raise line.error(f"bones of :bonedata, {text_of(name)[:40]!r} is none")
        for name in names:
            if name in below or name == ROOT:
                raise line.error(f"{text_of(name)[:40]} below one other")
            below.add(name)
        children.setdefault(parent, []).extend(names)
    ordered: list[Bone] = []
    waiting = [(ROOT, -1)]
    while waiting:
        name, parent_index = waiting.pop()
        bones[name].parent = parent_index
        waiting += [(child, len(ordered)) for child in reversed(children.get(name, []))]
        ordered.append(bones[name])
    reached = {bone.name for bone in ordered}
    loose = [name for name in bones if name not in reached]
    if loose:
        found = f"{text_of(loose[0])[:40]!r} hangs on nothing"
        raise CaptureError(found, place=path, wanted="all bones below root")
    return tuple(ordered)


def skeleton_of(file: File, options: Reading) -> tuple[File, tuple[str, ...]]:
    """Return the skeleton of a motion, and what is doubtful about it."""
    if options.skeleton is not None:
        return opened(options.skeleton), ()
    words = PurePath(file.name).stem.split("_")
    begun = ("_".join(words[:count]) for count in range(len(words) - 1, 0, -1))
    # as its motion is called, or that up to an underscore
    stems = [PurePath(file.name).stem, *[name for name in begun if name][:_MOST_STEMS]]
    any_name = locations.beside(file.name, "_")
    found = _skeletons(any_name, _last_change(any_name))
    for stem in stems:
        path = found.get(stem) or found.get(stem.lower())
        if path:
            return opened(path), ()
    others = sorted(set(found.values()))
    if len(others) == 1:
        doubt = f"its skeleton is taken to be {PurePath(others[0]).name}, the only one beside it"
        return opened(others[0]), (doubt,)
    raise CaptureError(
        f"{len(others)} skeletons beside it" if others else "no skeleton beside it",
        place=file.name,
        wanted=" or ".join(stem + _ENDING for stem in stems) + ", or a single .asf in its folder",
        remedy="Name it with --skeleton FILE.",
    )


def companions(file: File, options: Reading) -> tuple[File, ...]:
    """Return the skeleton of a motion."""
    return (skeleton_of(file, options)[0],)


def _last_change(path: str) -> Hashable:
    """Return what changes when what holds a file does: its folder, or its archive."""
    with suppress(OSError, ValueError, CaptureError):
        archive = archives.split(path)[0]
        if locations.is_url(path) and not archive:
            return tuple(locations.siblings(path))
        return locations.mark(archive or os.path.dirname(path) or ".")
    return 0


@lru_cache(maxsize=64)
def _skeletons(path: str, changed: Hashable) -> Mapping[str, str]:
    """Return the skeletons beside a file, by name: looked for once, however many files ask."""
    paths = siblings(path, _ENDING)
    names = [(PurePath(path).stem, path) for path in paths]
    return {**{name.lower(): path for name, path in reversed(names)}, **dict(names)}


@dataclass(frozen=True, slots=True, eq=False)
class AmcLayout:
    """The bytes of an AMC file."""

    header: bytes  # what stands before the first frame
    stops: Places  # (T,) int64, the byte behind the number of each frame
    ends: Places  # (T,) int64, the byte behind each frame
    numbers: Places  # (T,) int64, the frames' own numbers


def scan(data: Content, path: str) -> AmcLayout:
    """Find the frames of an AMC file without reading their numbers."""
    rows: list[tuple[int, int, int]] = []
    for start in range(0, len(data), PIECE):
        piece = data[start : start + PIECE + _NUMBER]
        for at in _numbered_lines(piece, start == 0):
            line = piece[at : at + _NUMBER].partition(b"\n")[0]
            word = line.strip()
            if not word.isdigit() or len(word) > _DIGITS:
                raise CaptureError(
                    f"{text_of(line.strip())[:40]!r}",
                    place=f"{path}:{line_of(data, start + at)}",
                    wanted="the number of a frame alone on its line",
                )
            begin = start + at + len(line) - len(line.lstrip())
            rows.append((begin, begin + len(word), int(word)))
    if not rows:
        alone = b"\r" in data[:PIECE] and b"\n" not in data[:PIECE]
        remedy = "Its lines end in carriage returns alone: save it with line feeds." * alone
        wanted = "lines that are a frame's number"
        raise CaptureError("no frames", place=path, wanted=wanted, remedy=remedy)
    starts, stops, numbers = np.array(rows, np.int64).T
    ends = np.append(starts[1:], len(data))
    return AmcLayout(data[: rows[0][0]], stops, ends, numbers)


def _numbered_lines(piece: bytes, first: bool) -> list[int]:
    """Return where the lines begin that begin with a digit, blanks aside."""
    text = np.frombuffer(piece, np.uint8)
    lines = np.flatnonzero(text[:PIECE] == 10) + 1
    if first:
        lines = np.append(0, lines)
    lines = lines[lines < len(text)]
    begun = text[lines]
    digit = (begun >= ord("0")) & (begun <= ord("9"))
    for index in np.flatnonzero((begun == ord(" ")) | (begun == ord("\t"))).tolist():
        at = int(lines[index])
        digit[index] = piece[at : at + _NUMBER].lstrip(b" \t")[:1].isdigit()
    places: list[int] = lines[digit].tolist()
    return places


class Numbers:
    """Reads the numbers of frames."""

    def __init__(self, bones: Sequence[Bone]) -> None:
        self._stiff = {bone.name for bone in bones if not bone.dof}
        self.columns: dict[bytes, slice] = {}
        self.width = 0
        for bone in bones:
            if bone.dof:
                self.columns[bone.name] = slice(self.width, self.width + len(bone.dof))
                self.width += len(bone.dof)

    def read(self, data: bytes, stops: Places, ends: Places, place: Callable[[int], str]) -> Floats:
        """Return the numbers (T, W) of frames that lie between `stops` and `ends`, (T,)."""
        values = self._read_alike(data, stops, ends)
        return self._read_each(data, stops, ends, place) if values is None else values

    def _read_alike(self, data: bytes, stops: Places, ends: Places) -> Floats | None:
        """Read frames that are all written alike; None: they are not, or something is wrong."""
        first, last = int(stops[0]), int(ends[-1])
        begun = [line.split() for line in data[first : int(ends[0])].split(b"\n")[1:]]
        names = [words[0] for words in begun if words]
        if not names or len(names) != len(self.columns) or set(names) != self.columns.keys():
            return None
        text = np.frombuffer(data, np.uint8)[first:last].copy()
        breaks = np.flatnonzero(text == ord("\n")) + 1
        if text[-1] != ord("\n"):
            breaks = np.append(breaks, len(text))
        if len(breaks) != len(stops) * (len(names) + 1):
            return None
        lines = breaks.reshape(len(stops), -1)  # of a frame: its bones, and the next frame
        if (lines[:, -1] != ends - first).any():
            return None
        blank = text <= ord(" ")
        words = np.flatnonzero(blank[:-1] & ~blank[1:]) + 1
        counts = np.diff(np.searchsorted(words, lines), axis=1) - 1
        widths = [self.columns[name].stop - self.columns[name].start for name in names]
        if (counts != widths).any():
            return None
        for index, name in enumerate(names):
            cells = lines[:, [index]] + np.arange(len(name))
            if (text[cells] != np.frombuffer(name, np.uint8)).any():
                return None
            text[cells] = ord(" ")
        numbers, bad = number_rows(text.tobytes(), lines[:, [0, -1]], self.width)
        order = np.concatenate([np.arange(self.width)[self.columns[name]] for name in names])
        values = np.empty_like(numbers)
        values[:, order] = numbers
        return values if bad is None else None

    def _read_each(
        self, data: bytes, stops: Places, ends: Places, place: Callable[[int], str]
    ) -> Floats:
        """Read line by line."""
        values = np.full((len(stops), self.width), np.nan)
        for row, at, end in zip(values, stops.tolist(), ends.tolist(), strict=True):
            left = set(self.columns)
            begin = at
            for line in data[at:end].split(b"\n"):
                words = line.split()
                if words and not words[0].startswith(b"#"):
                    self._bone(row, words, left, partial(place, begin))
                begin += len(line) + 1
            if left:
                missing = next(name for name in self.columns if name in left)
                raise CaptureError(
                    f"the frame lacks {text_of(missing)}",
                    place=place(at),
                    wanted=f"{len(self.columns)} bones, as its skeleton declares",
                )
        return values

    def _bone(
        self, row: Floats, words: list[bytes], left: set[bytes], place: Callable[[], str]
    ) -> None:
        """Read the line of a bone."""
        name, count = words[0], len(words) - 1
        if name in self._stiff and not count:
            return
        shown = text_of(name)[:40]
        if name not in left:
            again = name in self.columns or name in self._stiff
            found = f"a second {shown}" if again else f"the bone {shown!r}"
            raise CaptureError(found, place=place(), wanted="each bone of its skeleton once")
        columns = self.columns[name]
        width = columns.stop - columns.start
        try:
            numbers = [float(word) for word in words[1:] if b"_" not in word]
        except ValueError:
            numbers = []
        if len(numbers) != count or count != width or not all(abs(it) <= LARGEST for it in numbers):
            found, wanted = fault(b" ".join(words[1:]), width)
            raise CaptureError(f"{shown} {found}", place=place(), wanted=wanted)
        row[columns] = numbers
        left.discard(name)


def cutter(file: File, options: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of an AMC file: its own lines, with frames numbered from 1."""
    layout = scan(file.content, file.name)

    def pieces(span: Span) -> Iterator[bytes | tuple[int, int]]:
        yield layout.header
        frames = slice(span.start, span.stop)
        stops, ends = layout.stops[frames].tolist(), layout.ends[frames].tolist()
        for number, frame in enumerate(zip(stops, ends, strict=True), 1):
            yield b"%d" % number
            yield frame

    return lambda span: clip(file.content, pieces(span))


def read(file: File, options: Reading, wanted: Wanted) -> Motion:
    """Read an AMC file with the skeleton beside it: the joints of `joints_of`."""
    layout = scan(file.content, file.name)
    asf, doubts = skeleton_of(file, options)
    skeleton = parse(asf)
    rate, rate_doubts = _rate(layout, options)
    names, parents, offsets = joints_of(skeleton.bones)
    numbers, count = Numbers(skeleton.bones), len(layout.stops)
    words = layout.header.upper().split()  # where they say nothing, angles are as in the skeleton
    radians = b":RADIANS" in words or (b":DEGREES" not in words and not skeleton.degrees)
    turn, tilt = (1.0 if it else math.pi / 180 for it in (radians, not skeleton.degrees))
    axes = [_axes(bone, tilt) for bone in skeleton.bones]
    if count * len(names) > len(file.content) + MANY_PLACES:
        found = f"{len(names)} joints in {count} frames, of which few can move"
        raise CaptureError(found, place=asf.name, wanted="at most as many places as bytes")
    joints = range(len(names))
    places = np.empty((count, len(names), 3), np.float32)
    turns = np.empty((count, len(names), 4), np.float32)
    for start in range(0, count, BLOCK):
        block = slice(start, start + BLOCK)
        stops, ends = layout.stops[block], layout.ends[block]
        data, first = holding(file.content, int(stops[0]), int(ends[-1]))
        values = numbers.read(data, stops - first, ends - first, partial(_line, file, first))
        standing = partial(_local_transform, skeleton.bones, axes, offsets, values, turn)
        place(joints, joints, parents, standing, places[block], turns[block])
    doubts += (*skeleton.doubts, *_doubts(skeleton, layout), *rate_doubts)
    declared = Declared(_unit(skeleton.inches), "y")
    points = Points(names, places, rate, declared, parents, offsets, turns, doubts)
    return motion_of(points, file, "amc", options, wanted)


def beside(file: File, options: Reading | None = None) -> tuple[tuple[str, bytes], ...]:
    """Return what has to lie beside a clip: the skeleton, by the ending of its name."""
    skeleton, _ = skeleton_of(file, options or Reading())
    return ((".asf", skeleton.content[:]),)


def _line(file: File, first: int, at: int) -> str:
    """Return the line of a byte, which is counted from the first that is held."""
    return f"{file.name}:{line_of(file.content, first + at)}"


def _rate(layout: AmcLayout, options: Reading) -> tuple[Fraction, tuple[str, ...]]:
    if options.rate is not None:
        return given_rate(options.rate), ()
    rates = filter(None, map(_RATE.fullmatch, layout.header.splitlines()))
    if (said := next(rates, None)) and (rate := Fraction(said[1].decode())):
        return nearest_rate(rate), ()
    doubt = f"it does not tell its rate: {USUAL_RATE} frames a second. If that is wrong, give --fps"
    return USUAL_RATE, (doubt,)


def _unit(inches: float) -> str | None:
    """Return the unit of which an inch has so many, if it has a name."""
    if inches <= 0:
        return None
    size = _INCH / inches
    names = (name for name, length in UNITS.items() if abs(length - size) <= _SAME * size)
    return next(names, None)


def _doubts(skeleton: Bones, layout: AmcLayout) -> Iterator[str]:
    """Warn where a bone's numbers and axes differ in order, and where frames are missing."""
    for bone in skeleton.bones:
        turns = [code for code in bone.dof if code < 3]
        if [axis for axis in bone.order if axis in turns] != turns:
            name = bone.name.decode("utf-8", "replace")[:40]
            yield f"{name} turns in the order of its dof, not that of its axis"
            break
    jumps = np.flatnonzero(np.diff(layout.numbers) != 1)
    if len(jumps):
        before, behind = layout.numbers[jumps[0] : jumps[0] + 2].tolist()
        yield f"frame {behind} follows frame {before}: taken for the next"


def joints_of(bones: Sequence[Bone]) -> tuple[tuple[str, ...], tuple[int, ...], Floats]:
    """Return names, parents and offsets (J, 3) of joints: where bones begin, then last ends."""
    names = [bone.name.decode("utf-8", "replace") for bone in bones]
    above = {bone.parent for bone in bones}
    last = [index for index in range(1, len(bones)) if index not in above]
    parents = [*(bone.parent for bone in bones), *last]
    offsets = [bones[parent].shift if parent > 0 else (0.0,) * 3 for parent in parents]
    return (*names, *(names[bone] + END for bone in last)), tuple(parents), np.array(offsets)


def _local_transform(
    bones: Sequence[Bone],
    axes: Sequence[Floats],
    offsets: Floats,
    values: Floats,
    turn: float,
    joint: int,
) -> tuple[Floats, Floats, Floats]:
    """Return shift (T, 3), rotation (T, 4) and scale of a joint within its parent."""
    shift, turned = offsets[[joint]], UNTURNED
    if joint >= len(bones):
        return shift, turned, UNSCALED
    if joint == 0:
        shift = shift + bones[0].shift
    first = sum(len(bone.dof) for bone in bones[:joint])
    for column, code in reversed([*enumerate(bones[joint].dof, first)]):
        number = values[:, column]
        if code < 3:
            half = number * (turn / 2.0)
            own = np.column_stack((np.cos(half), np.outer(np.sin(half), axes[joint][:, code])))
            turned = own if turned is UNTURNED else product(turned, own)
        else:
            shift = shift + np.outer(number, np.eye(3)[code - 3])
    return shift, turned, UNSCALED


def _axes(bone: Bone, tilt: float) -> Floats:
    """Return the axes that a bone turns about, as columns."""
    axes = np.eye(3)
    for axis in bone.order:
        one, other = (axis + 1) % 3, (axis + 2) % 3
        cosine, sine = np.cos(bone.axis[axis] * tilt), np.sin(bone.axis[axis] * tilt)
        turn = np.eye(3)
        turn[one, one] = turn[other, other] = cosine
        turn[one, other], turn[other, one] = -sine, sine
        axes = turn @ axes
    return axes
