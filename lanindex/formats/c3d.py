"""C3D (Coordinate 3D): read, cut in its own numbers, write.

A file is a header, parameters (groups, names, values), and frames of points and analog numbers,
written as one of three processors does. Header and parameters say the same things twice or more,
and not always the same: what fills the file is believed.

Sources: *The C3D File Format, User Guide*, Motion Lab Systems (c3d.org), "The header section", "The
parameter section", "The 3D/analog data section", "Processor types", "EVENT:TIMES"; *C3D rotations*,
c3d.org, "ROTATION group"; *VAX Architecture Reference Manual* (1987), F_floating.
"""

from __future__ import annotations

import math
import struct
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.body.mapping import Declared
from lanindex.body.markers import marker_set_of
from lanindex.errors import CaptureError, shown
from lanindex.formats.file import PIECE, Content, File, Wanted, holding, text_of
from lanindex.formats.people import named, subject_points
from lanindex.formats.points import Points, gathered, motion_of, spread
from lanindex.formats.rates import rate_by
from lanindex.formats.text_rows import points_of
from lanindex.model import Motion, Reading, Span

BLOCK = 512  # bytes in which a file counts
FULL = 0xFFFF  # the most that one integer of a file counts
TEXT, BYTE, INT, FLOAT = -1, 1, 2, 4  # kinds of parameters: the bytes of one value
TURN = 17  # floats of one rotation: a 4 x 4 matrix, column by column, and how well it is known
LARGEST = 1e7  # units of the file: nobody is farther away, and damaged numbers are mostly larger
INTEL = 84
# lists of POINT that name points which are no places, but what a model tells of the body
NO_PLACES = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS")
TURNED = "_4X4"  # ends the name of a segment

_CODES = {BYTE: "u1", INT: "i2", FLOAT: "f4"}
_PADDING = 2 * BLOCK  # less than this may stand behind the last frame
_ALIKE = 1e-3  # of a rate: what header and parameters may differ by
_TRANSLATION = 12  # where it begins in a matrix
_END = "TRIAL:ACTUAL_END_FIELD"
_PLACES = {"MODELED_MARKER", "MARKER", "VIRTUAL_MARKER"}
_EVENTS = (300, 304, 376)  # in the header: how many events, and where their times begin and end
_NAMED = 396  # and where their names of four letters begin
# parameters of the group EVENT that have a value for each
_EACH = ("TIMES", "LABELS", "CONTEXTS", "DESCRIPTIONS", "SUBJECTS", "ICON_IDS", "GENERIC_FLAGS")
_LIST = 255  # texts in one parameter
_WIDEST = 127  # bytes of a text
_FLOATS = -1.0  # a scale below 0: numbers are floats
_UNKNOWN = -1.0
_NEXT_TO_ZERO = 1e-6  # millimetres: where a point at zero is put, which would be taken as unknown


@dataclass(frozen=True, slots=True)
class Processor:
    """How one kind of processor writes numbers."""

    name: str  # as people call it
    order: str  # ``<``, the low byte first, or ``>``
    # whether its floats are those of the VAX: halves exchanged, exponents greater by two
    dec: bool = False

    def numbers(self, data: Any, kind: int, count: int = -1, offset: int = 0) -> NDArray[Any]:
        """Return numbers of a parameter's kind: a view unless they are DEC's floats."""
        if kind == FLOAT and self.dec:
            return from_dec(np.frombuffer(data, "<u4", count, offset))
        return np.frombuffer(data, self.order + _CODES[kind], count, offset)

    def written(self, values: Any, kind: int) -> bytes:
        """Return numbers of a parameter's kind as bytes."""
        array = np.asarray(values)
        if kind == FLOAT and self.dec:
            return to_dec(array.astype(np.float32)).tobytes()
        if kind == INT:
            array = array.astype(np.int64).astype(np.uint16).view(np.int16)
        return array.astype(self.order + _CODES[kind]).tobytes()


PROCESSORS: Mapping[int, Processor] = {
    INTEL: Processor("Intel", "<"),
    85: Processor("DEC", "<", dec=True),
    86: Processor("MIPS", ">"),
}
"""By the fourth byte of the parameters."""


def from_dec(words: NDArray[np.uint32]) -> NDArray[np.float32]:
    """Return VAX F floats, the halves of each exchanged, as numbers."""
    values = ((words >> np.uint32(16)) | (words << np.uint32(16))).view(np.float32)
    with np.errstate(invalid="ignore"):  # of damaged files
        values *= np.float32(0.25)
    return values


def to_dec(values: NDArray[np.float32]) -> NDArray[np.uint32]:
    """Return numbers as VAX F floats."""
    words = (np.ascontiguousarray(values, np.float32) * np.float32(4)).view(np.uint32)
    exchanged: NDArray[np.uint32] = (words >> np.uint32(16)) | (words << np.uint32(16))
    return exchanged.astype("<u4")


@dataclass(frozen=True, slots=True)
class Parameter:
    """Where a parameter's values lie."""

    kind: int  # `TEXT`, `BYTE`, `INT` or `FLOAT`
    # of its dimensions, the first running fastest; of text the first is its width
    sizes: tuple[int, ...]
    at: int  # the first byte, in the section

    @property
    def count(self) -> int:
        """How many values or, of text, characters."""
        return math.prod(self.sizes)


class Parameters:
    """All parameters of a file, each known by ``GROUP:NAME``."""

    def __init__(self, data: bytes, processor: Processor) -> None:
        self.data, self.processor = data, processor
        self.doubts: list[str] = []
        self._groups: dict[str, int] = {}
        self._links: dict[tuple[int, bytes], int] = {}
        self._follow()

    def _follow(self) -> None:
        """Go through the chain; a broken one is followed as far as it goes."""
        data, stop = self.data, len(self.data) - 4
        low, high = (0, 1) if self.processor.order == "<" else (1, 0)
        at = 4
        while at < stop and (length := data[at]):
            length = min(length, 256 - length)  # below 0: locked
            number, link = data[at + 1], at + 2 + length
            name = data[at + 2 : link]
            if link > stop:
                self.doubts.append(f"its parameters break off at {shown(text(name))!r}")
                break
            if number > 127:
                self._groups.setdefault(text(name).upper(), number)
            else:
                self._links.setdefault((256 - number, name.upper()), link)
            onwards = data[link + low] + 256 * data[link + high]
            at = link + onwards if onwards else stop

    def find(self, key: str) -> Parameter | None:
        """Return where a parameter's values lie; None where there is none, or it is damaged."""
        group, _, name = key.partition(":")
        link = self._links.get((self._groups.get(group, 0), name.encode()))
        if link is None:
            return None
        first = link + 4 + self.data[link + 3]
        kind = (self.data[link + 2] ^ 128) - 128
        one = Parameter(kind, tuple(self.data[link + 4 : first]), first)
        if kind in (TEXT, *_CODES) and first + one.count * abs(kind) <= len(self.data):
            return one
        if (doubt := f"its parameter {key} is damaged") not in self.doubts:
            self.doubts.append(doubt)
        return None

    def numbers(self, key: str) -> tuple[float, ...]:
        """Return the numbers of a parameter; none where there is none, or it is text."""
        one = self.find(key)
        if one is None or one.kind == TEXT or not one.count:
            return ()
        return tuple(self.processor.numbers(self.data, one.kind, one.count, one.at).tolist())

    def count(self, key: str) -> int | None:
        """Return a number of things, of 32 bits where two integers of 16 tell it; else None."""
        values = self.numbers(key)
        if not values or not abs(values[0]) < 2**31:
            return None
        if isinstance(values[0], float):
            return int(values[0]) if values[0] >= 0 else None
        low, high = (int(value) & 0xFFFF for value in (*values, 0)[:2])
        return low + (high << 16)

    def texts(self, key: str) -> tuple[str, ...]:
        """Return the texts of a parameter and of those that carry it on: LABELS, LABELS2 ..."""
        found: list[str] = []
        for number in range(1, 257):
            one = self.find(f"{key}{number}" if number > 1 else key)
            if one is None or one.kind != TEXT:
                break
            width, stop = (one.sizes[0] if one.sizes else 1), one.at + one.count
            found += (text(self.data[at : at + width]) for at in range(one.at, stop, width or 1))
        return tuple(found)

    def put(self, data: bytearray, key: str, values: Sequence[float]) -> None:
        """Write numbers over the first ones of a parameter, if there is one, in a copy."""
        one = self.find(key)
        if one is not None and one.kind != TEXT:
            written = self.processor.written(values[: one.count], one.kind)
            data[one.at : one.at + len(written)] = written

    def put_count(self, data: bytearray, key: str, count: int) -> None:
        """Write a number of things as `count` reads it; 65,535 where a larger one has no room."""
        one = self.find(key)
        if one is not None:
            halves = (count & 0xFFFF, count >> 16) if one.count > 1 else (min(count, FULL),)
            self.put(data, key, (float(count),) if one.kind == FLOAT else halves)


def text(data: bytes) -> str:
    """Return a text without the blanks that fill it up."""
    return text_of(data.partition(b"\0")[0].strip())


@dataclass(frozen=True, slots=True)
class C3dLayout:
    """Where the numbers of a file lie."""

    parameters: Parameters  # what it says of itself
    section: int  # the first byte of the parameters
    start: int  # the first byte of the data
    points: int  # in a frame
    analog: int  # numbers in a frame behind its points
    scale: float  # units of the file in one step of an integer; below 0: floats
    frames: int  # how many there are
    first: int  # the number of the first one
    rate: float | None  # frames a second
    turns: Turns | None  # rotations of segments, which lie behind the frames
    doubts: list[str]  # what was contradicted or corrected

    @property
    def kind(self) -> int:
        """Of its numbers: how many bytes each has."""
        return FLOAT if self.scale < 0 else INT

    @property
    def segments(self) -> Turns | None:
        """The rotations of a file that has no points."""
        return None if self.points else self.turns

    @property
    def frame(self) -> int:
        """Bytes of a frame."""
        return (4 * self.points + self.analog) * self.kind


@dataclass(frozen=True, slots=True)
class Turns:
    """Where the rotations lie."""

    start: int  # their first byte
    count: int  # of segments
    ratio: int  # how many of each there are in a frame

    @property
    def frame(self) -> int:
        """Bytes in a frame."""
        return self.ratio * self.count * TURN * 4


def scan(file: File) -> C3dLayout:
    """Find out where the numbers of a file lie."""
    size = len(file.content)
    section, processor = _section(file)
    head = file.content[:BLOCK]
    words = [word & FULL for word in processor.numbers(head, INT, 12).tolist()]
    scale, rate = (float(processor.numbers(head, FLOAT, 1, at)[0]) for at in (12, 20))
    blocks = max(file.content[section + 2 : section + 3][0], words[8] - section // BLOCK - 1)
    parameters = Parameters(file.content[section : section + BLOCK * blocks], processor)
    channels = parameters.count("ANALOG:USED")
    begins = (_byte(words[8]), _byte(parameters.count("POINT:DATA_START")))
    scales = (*parameters.numbers("POINT:SCALE")[:1], scale)
    options = {
        "that its data begin at byte": _choices(at for at in begins if section < at <= size),
        "points in a frame": _choices((words[1], parameters.count("POINT:USED"))),
        "analog numbers in a frame": _choices((words[2], channels and channels * words[9])),
        "a scale": _choices(max(it, -1.0) for it in scales if it and math.isfinite(it)),
    }
    for what, choices in options.items():
        if not choices:
            raise _error(file, f"does not say {what}")
    turns = _turns(parameters, size)
    first, said, vague = _declared_counts(words, parameters)
    counts = list(said.values())
    believed, frames = _best_fit(list(options.values()), counts, vague, turns, size)
    doubts = [
        f"says {what} {' or '.join(f'{it:g}' for it in choices)}: {chosen:g} believed"
        for (what, choices), chosen in zip(options.items(), believed, strict=True)
        if len(choices) > 1
    ]
    if {*counts, frames} != {frames}:
        sayers = ", ".join(f"{who}: {count}" for who, count in said.items())
        doubts.append(f"says different numbers of frames ({sayers}): {frames} believed")
    rates = [it for it in (*parameters.numbers("POINT:RATE")[:1], rate) if 0 < it < math.inf]
    if len(rates) > 1 and abs(rates[0] - rates[1]) > _ALIKE * rates[0]:
        twice = f"POINT:RATE says {rates[0]:g} frames a second, the header {rates[1]:g}"
        doubts.append(f"{twice}: the first believed")
    start, points, analog, step = believed
    layout = C3dLayout(
        *(parameters, section, int(start), int(points), int(analog), step, frames, first),
        *(rates[0] if rates else None, turns, doubts),
    )
    if not (points or turns):
        raise _error(file, "has no points")
    if not frames:
        raise _error(file, "ends before its first frame does")
    rest = size - layout.start - frames * layout.frame
    if not turns and rest >= max(layout.frame, _PADDING):
        doubts.append(f"{rest} bytes behind its last frame are not read")
    return layout


def _section(file: File) -> tuple[int, Processor]:
    """Return where the parameters begin, and how the file's numbers are written."""
    head = file.content[:BLOCK]
    if len(head) == BLOCK:
        for block in (head[0], 2):  # where they nearly always are
            at = _byte(block)
            kind = file.content[at + 3 : at + 4] if at > 0 else b""
            if kind and kind[0] in PROCESSORS:
                return at, PROCESSORS[kind[0]]
    raise _error(file, "has no parameters where it says that they begin")


def _byte(block: int | None) -> int:
    """Return where a block begins, counted from 1."""
    return ((block or 0) - 1) * BLOCK


def _choices(values: Iterable[float | None]) -> list[float]:
    """Return what is said, each once."""
    return list(dict.fromkeys(value for value in values if value is not None))


def _declared_counts(
    words: list[int], parameters: Parameters
) -> tuple[int, dict[str, int], list[int]]:
    """Return the first frame's number, counts by who says them, and counts that are minima."""
    first, last = words[3:5]
    counts = {who: parameters.count(f"POINT:{who}") or 0 for who in ("LONG_FRAMES", "FRAMES")}
    start, stop = (parameters.count(f"TRIAL:ACTUAL_{end}_FIELD") for end in ("START", "END"))
    said, vague = {"POINT:LONG_FRAMES": counts["LONG_FRAMES"]}, []
    if start is not None and stop is not None and stop >= start:
        first, said = start, {"TRIAL": stop - start + 1, **said}
    for who, count, most in (
        ("POINT:FRAMES", counts["FRAMES"], counts["FRAMES"]),
        ("header", last - words[3] + 1, last),
    ):
        if most == FULL:
            vague.append(count)
        else:
            said[who] = count
    return first, {who: count for who, count in said.items() if count > 0}, vague


def _best_fit(
    options: list[list[float]],
    counts: Sequence[int],
    vague: Sequence[int],
    turns: Turns | None,
    size: int,
) -> tuple[tuple[float, ...], int]:
    """Return the layout that fills the file best of all that are declared, and how many frames."""

    def room(one: tuple[float, ...]) -> tuple[float, float]:
        """Return how many bytes are there, and how many a frame takes."""
        start, points, analog, step = one
        stop = turns.start if turns and turns.start > start else size
        return stop - start, (4 * points + analog) * (4 if step < 0 else 2)

    turned = (size - turns.start) // turns.frame if turns else 0
    fitting = []
    for one, count in product(product(*options), (*counts, *vague)):
        there, frame = room(one)
        rest = there - count * frame
        if 0 <= rest < (math.inf if count in counts else _PADDING):
            fitting.append((rest, one, min(count, turned) if turns and not one[1] else count))
    if fitting:
        return min(fitting, key=itemgetter(0))[1:]
    one = tuple(choices[0] for choices in options)
    there, frame = room(one)
    return one, int(there // frame) if frame else turned


def _turns(parameters: Parameters, size: int) -> Turns | None:
    """Return where rotations lie, if there are any."""
    start, count = _byte(parameters.count("ROTATION:DATA_START")), parameters.count("ROTATION:USED")
    turns = Turns(start, count or 0, max(parameters.count("ROTATION:RATIO") or 1, 1))
    return turns if start > 0 and turns.frame and start + turns.frame <= size else None


frames = spread


def _error(file: File, found: str) -> CaptureError:
    return CaptureError(found, place=file.name, wanted="a whole C3D file")


def read(file: File, options: Reading, wanted: Wanted) -> Motion:
    """Read a C3D file: joints of its markers, points that are joints, or origins of segments."""
    layout = file.once(scan)
    rate, _ = rate_by(options, file.name, "" if layout.rate is None else str(layout.rate))
    every = names_of(layout)
    names, doubts = subject_points(file, people(layout, every), every)
    used = _points_of_body(names) if wanted.body_only and not options.body else names
    chosen = None
    if len(used) < layout.points or layout.segments:
        chosen = np.array(list(used), np.int64)
    there = places(file.content, layout, chosen, frames(wanted, layout.frames))
    doubts = (*layout.doubts, *layout.parameters.doubts, *doubts)
    points = Points(tuple(used.values()), there, rate, _declared(layout), doubts=doubts)
    motion = motion_of(points, file, "c3d", options, wanted)
    if used is names:
        return motion
    return replace(motion, source=replace(motion.source, joints=tuple(names.values())))


def _points_of_body(names: dict[int, str]) -> dict[int, str]:
    """Return the points that the joints of the body are made of; all where it is not made."""
    numbers = list(names)
    made = marker_set_of(tuple(names.values()))
    if made is None:
        return names
    used = {numbers[it]: names[numbers[it]] for it in sorted(made.used)}
    alone = tuple(used.values())
    again = marker_set_of(alone)
    same = again is not None and again.sources(alone) == made.sources(tuple(names.values()))
    return used if same else names


def _declared(layout: C3dLayout) -> Declared:
    """Return unit and vertical axis, as far as the file tells them."""
    parameters = layout.parameters
    unit = next(iter(parameters.texts("POINT:UNITS")), "") or None
    screen = next(iter(parameters.texts("POINT:Y_SCREEN")), "").lower()
    up = screen.removeprefix("+") if screen.strip("+-") in ("x", "y", "z") else None
    return Declared(unit, up)


def names_of(layout: C3dLayout) -> dict[int, str]:
    """Return the names of points or segments by their number in a frame, but of model outputs."""
    parameters = layout.parameters
    if layout.segments:
        labels = parameters.texts("ROTATION:LABELS")
        return {number: name.removesuffix(TURNED)
                for number, name in enumerate(_names(labels, layout.segments.count))}  # fmt: skip
    groups = parameters.texts("POINT:TYPE_GROUPS")
    listed = [group.upper() for group, kind in zip(groups[::2], groups[1::2], strict=False)
              if kind.upper() not in _PLACES]  # fmt: skip
    lists = dict.fromkeys((*NO_PLACES, *listed))
    outputs = {name for one in lists for name in parameters.texts(f"POINT:{one}")}
    points = _names(parameters.texts("POINT:LABELS"), layout.points)
    return {number: name for number, name in enumerate(points) if name not in outputs}


def _names(names: tuple[str, ...], count: int) -> list[str]:
    """Return as many names as there are points: what is named beyond them is not stored."""
    named = [name or f"*{number}" for number, name in enumerate(names[:count], 1)]
    return named + [f"*{number}" for number in range(len(named) + 1, count + 1)]


def people(layout: C3dLayout, names: Mapping[int, str]) -> dict[str, dict[int, str]]:
    """Return the points of each subject that makes a body."""
    parameters = layout.parameters
    called = parameters.texts("SUBJECTS:NAMES")
    before = parameters.texts("SUBJECTS:LABEL_PREFIXES")
    subject = {prefix: name for prefix, name in zip(before, called, strict=False) if prefix}
    groups = dict[str, dict[int, str]]()
    for number, name in names.items():
        colon = name[: name.rfind(":") + 1]
        prefix = next((it for it in subject if name.startswith(it)), colon)
        groups.setdefault(prefix, {})[number] = name
    found: dict[str, dict[int, str]] = {}
    for prefix, points in groups.items():
        bare = {number: name.removeprefix(prefix) for number, name in points.items()}
        if marker_set_of(tuple(bare.values())):
            alone = called[0] if not prefix and len(called) == 1 else ""
            name = subject.get(prefix, prefix.rstrip(":")) or alone
            name = f"{name} {len(found) + 1}".strip() if name in found else name
            found[name] = points if prefix.endswith(":") else bare
    return named(found)


def subjects(file: File) -> tuple[str, ...]:
    """Return the names of the people that a file holds; none where nobody is named."""
    layout = file.once(scan)
    return tuple(name for name in people(layout, names_of(layout)) if name)


def places(
    content: Content,
    layout: C3dLayout,
    chosen: NDArray[np.int64] | None = None,
    numbers: NDArray[np.int64] | None = None,
) -> NDArray[np.float32]:
    """Return where points are, (T, K, 3): all, or those that are chosen, (K,), in some frames."""
    turns, points = layout.segments, layout.points
    kind, column = (FLOAT, _TRANSLATION) if turns else (layout.kind, 0)
    start, size = (turns.start, turns.frame) if turns else (layout.start, layout.frame)
    width = turns.count if turns else points
    numbers = np.arange(layout.frames) if numbers is None else numbers
    there = np.empty((len(numbers), width if chosen is None else len(chosen), 3), np.float32)
    step = max(1, PIECE // size)
    for first in range(0, len(numbers), step):
        out, some = there[first : first + step], numbers[first : first + step]
        count = len(out)
        begin = start + int(some[0]) * size
        if some[-1] - some[0] < count:
            data, offset = holding(content, begin, begin + count * size)
        else:
            edges = start + np.stack((some, some + 1), axis=1) * size
            (data, _), offset = gathered(content, edges), begin
        processor = layout.parameters.processor
        values = processor.numbers(data, kind, count * size // kind, begin - offset)
        if turns:  # of several in a frame, the first
            rows = values.reshape(count, turns.ratio, turns.count, TURN)[:, 0]
        else:
            rows = values.reshape(count, -1)[:, : 4 * points].reshape(count, points, 4)
        rows = rows if chosen is None else rows.take(chosen, axis=1)
        behind = rows[..., -1]
        with np.errstate(invalid="ignore", over="ignore"):  # of damaged files
            for axis in range(3):  # one after the other: five times as fast as three at a time
                if kind == INT:
                    np.multiply(rows[..., axis], np.float32(layout.scale), out=out[..., axis])
                else:
                    out[..., axis] = rows[..., column + axis]
            if not (out.max(initial=0) <= LARGEST and out.min(initial=0) >= -LARGEST):
                _take_out(out, np.asarray(~(np.abs(out) <= LARGEST).all(axis=2)))
            _take_out(out, behind < 0)
        nothing = (behind == 0) & (out[..., 0] == 0)
        if not turns and nothing.any():
            _take_out(out, nothing & (out[..., 1] == 0) & (out[..., 2] == 0))
    return there


def _take_out(out: NDArray[np.float32], unknown: NDArray[np.bool_]) -> None:
    if unknown.any():
        out[unknown] = np.nan


def cutter(file: File, options: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of a C3D file, whose header is looked through once.

    Frames keep their numbers, so that times of events, which count from the trial's frame 1, stay
    as they are; events outside a clip are left out. Only if a number beyond 65,535 has no room (no
    ACTUAL_END_FIELD) do frames begin with 1, and the times of events with them.
    """
    content, layout = file.content, scan(file)

    def cut(span: Span) -> bytes:
        frames, begin = _frames(content, layout.start, layout.frame, span), 0
        turns = layout.turns
        if turns:
            end = layout.start + math.ceil(layout.frames * layout.frame / BLOCK) * BLOCK
            frames += content[end : turns.start]
            begin = math.ceil((layout.start + len(frames)) / BLOCK) + 1
            frames += bytes(-(layout.start + len(frames)) % BLOCK)
            frames += _frames(content, turns.start, turns.frame, span)
        return _head(content, layout, span, begin) + frames

    return cut


def _head(content: Content, layout: C3dLayout, span: Span, begin: int) -> bytes:
    """Return header and parameters of a clip, whose rotations begin in a block."""
    parameters, write = layout.parameters, layout.parameters.processor.written
    start, frames = layout.start // BLOCK + 1, len(span)
    first = layout.first + span.start
    later = 0
    room = parameters.find(_END)
    if first + frames - 1 > FULL and (room is None or (room.count < 2 and room.kind != FLOAT)):
        first, later = 1, first - 1
    last = first + frames - 1
    head = bytearray(content[: layout.start])
    counts = (layout.points, layout.analog, min(first, FULL), min(last, FULL))
    head[2:10] = write(counts, INT)
    head[16:18] = write([start], INT)
    data = bytearray(parameters.data[: layout.start - layout.section])
    for key, count in {
        "POINT:USED": layout.points,
        "POINT:DATA_START": start,
        "POINT:FRAMES": frames,
        "POINT:LONG_FRAMES": frames,
        "TRIAL:ACTUAL_START_FIELD": first,
        _END: last,
        "ROTATION:DATA_START": begin,
    }.items():
        parameters.put_count(data, key, count)
    if max(parameters.processor.numbers(head, FLOAT, 1, 12)[0], -1.0) != layout.scale:
        head[12:16] = write([layout.scale], FLOAT)
    if any(max(it, -1.0) != layout.scale for it in parameters.numbers("POINT:SCALE")):
        parameters.put(data, "POINT:SCALE", [layout.scale])
    if later and layout.rate:
        _move_events(layout, later / layout.rate, head, data)
    if layout.rate and frames < layout.frames:
        _keep_events(layout, (first - 1) / layout.rate, last / layout.rate, head, data)
    head[layout.section : layout.section + len(data)] = data
    return bytes(head[: layout.start])


def _move_events(layout: C3dLayout, seconds: float, head: bytearray, data: bytearray) -> None:
    """Count the times of events from a later frame on."""
    parameters = layout.parameters
    times = parameters.numbers("EVENT:TIMES")
    moved = [
        it
        for minutes, rest in zip(times[::2], times[1::2], strict=False)
        for it in (0.0, 60 * minutes + rest - seconds)
    ]
    parameters.put(data, "EVENT:TIMES", moved)
    count, start, stop = _EVENTS
    number = min(int(parameters.processor.numbers(head, INT, 1, count)[0]), (stop - start) // 4)
    if number > 0:
        earlier = parameters.processor.numbers(head, FLOAT, number, start) - seconds
        head[start : start + 4 * number] = parameters.processor.written(earlier, FLOAT)


def _keep_events(
    layout: C3dLayout, begin: float, end: float, head: bytearray, data: bytearray
) -> None:
    """Leave out the events before and after some seconds; blanks fill their room."""
    parameters, numbers = layout.parameters, layout.parameters.processor.numbers
    used, times = parameters.count("EVENT:USED") or 0, parameters.find("EVENT:TIMES")
    fits = times is not None and times.count >= 2 * used and times.at + 8 * used <= len(data)
    if used and times is not None and times.kind == FLOAT and fits:
        minutes, rest = numbers(data, FLOAT, 2 * used, times.at).reshape(-1, 2).T
        kept = _inside(60 * minutes + rest, begin, end)
        for one in filter(None, (parameters.find(f"EVENT:{name}") for name in _EACH)):
            if one.sizes and one.sizes[-1] >= used:
                size = one.count // one.sizes[-1] * abs(one.kind)
                _keep_rows(data, one.at, size, used, kept, b" " if one.kind == TEXT else b"\0")
        parameters.put_count(data, "EVENT:USED", len(kept))
    count, start, stop = _EVENTS
    used = int(numbers(head, INT, 1, count)[0])
    if 0 < used <= (stop - start) // 4:
        kept = _inside(numbers(head, FLOAT, used, start), begin, end)
        for at, size in ((start, 4), (stop, 1), (_NAMED, 4)):
            _keep_rows(head, at, size, used, kept, b"\0")
        head[count : count + 2] = parameters.processor.written([len(kept)], INT)


def _inside(times: NDArray[Any], begin: float, end: float) -> list[int]:
    return np.flatnonzero((times > begin - _ALIKE) & (times < end - _ALIKE)).tolist()


def _keep_rows(
    data: bytearray, at: int, size: int, count: int, kept: Sequence[int], blank: bytes
) -> None:
    rows = [bytes(data[at + size * row : at + size * (row + 1)]) for row in kept]
    data[at : at + size * count] = b"".join(rows).ljust(size * count, blank)


def held(file: File) -> Counter[str]:
    """Return how much of what there is in a file."""
    layout = file.once(scan)
    count = layout.parameters.count
    counts = count("ANALOG:USED") or 0, count("EVENT:USED") or 0, layout.points
    return Counter(dict(zip(("analog channel", "event", "point"), counts, strict=True)))


def _frames(content: Content, start: int, size: int, span: Span) -> bytes:
    """Return some frames, the last block filled up but where readers count many frames by it."""
    data = content[start + span.start * size : start + span.stop * size]
    return data + bytes(-len(data) % BLOCK if len(span) <= FULL else 0)


def write(motion: Motion) -> bytes:
    """Write a motion as C3D, Intel floats, mm, y up: its markers, or else its joints."""
    names, places = points_of(motion)
    section = _parameters(motion, names, len(places), 0)
    start = 2 + len(section) // BLOCK
    table = np.zeros((len(places), len(names), 4), "<f4")
    table[..., :3] = places
    table[(places == 0).all(axis=2), 1] = _NEXT_TO_ZERO
    unknown = ~np.isfinite(places).all(axis=2)
    table[unknown] = (0, 0, 0, _UNKNOWN)
    head = bytearray(BLOCK)
    head[:24] = struct.pack(
        "<BB5HfHHf",
        *(2, 0x50, len(names), 0, 1, min(len(places), FULL), 0, _FLOATS, start, 1),
        float(motion.rate),
    )
    data = table.tobytes()
    rest = -len(data) % BLOCK if len(places) <= FULL else 0  # else some count by the file's end
    return b"".join((head, _parameters(motion, names, len(places), start), data, bytes(rest)))


def _parameters(motion: Motion, names: Sequence[str], frames: int, start: int) -> bytes:
    """Return the parameters, in whole blocks; the data begin in a block."""
    rate = float(motion.rate)
    groups: dict[str, dict[str, float | Sequence[str] | NDArray[Any]]] = {
        "POINT": {
            "USED": len(names),
            "SCALE": _FLOATS,
            "RATE": rate,
            "DATA_START": start,
            "FRAMES": min(frames, FULL),
            "LONG_FRAMES": float(frames),
            **_lists("LABELS", names),
            **_lists("DESCRIPTIONS", [""] * len(names)),
            "UNITS": ["mm"],
            "X_SCREEN": ["+X"],
            "Y_SCREEN": ["+Y"],
        },
        "ANALOG": {
            "USED": 0,
            "LABELS": [],
            "DESCRIPTIONS": [],
            "GEN_SCALE": 1.0,
            "SCALE": np.array([], float),
            "OFFSET": np.array([], int),
            "UNITS": [],
            "RATE": rate,
        },
        "FORCE_PLATFORM": {"USED": 0},
        "TRIAL": {
            "ACTUAL_START_FIELD": np.array([1, 0]),
            "ACTUAL_END_FIELD": np.array([frames & FULL, frames >> 16]),
        },
    }
    chain = [
        piece
        for number, (group, values) in enumerate(groups.items(), 1)
        for piece in (
            _entry(group, -number, b"\0"),
            *(_entry(name, number, _value(value)) for name, value in values.items()),
        )
    ]
    size = 4 + sum(map(len, chain)) + 2
    blocks = math.ceil(size / BLOCK)
    section = bytes((0, 0, min(blocks, 255), INTEL)) + b"".join(chain)
    return section.ljust(blocks * BLOCK, b"\0")


def _lists(name: str, texts: Sequence[str]) -> dict[str, Sequence[str]]:
    """Return a list of texts by its parameters: LABELS, LABELS2 ..."""
    pieces = [list(texts[at : at + _LIST]) for at in range(0, len(texts), _LIST)] or [[]]
    return {name + ("" if it == 1 else str(it)): piece for it, piece in enumerate(pieces, 1)}


def _entry(name: str, number: int, body: bytes) -> bytes:
    """Return a link of the chain."""
    link = struct.pack("<bb", len(name), number) + name.encode()
    return link + struct.pack("<H", len(body) + 2) + body


def _value(value: float | Sequence[str] | NDArray[Any]) -> bytes:
    """Return numbers, or texts, as the value of a parameter: kind, sizes, bytes."""
    if isinstance(value, list):
        texts = [it.encode()[:_WIDEST].decode(errors="ignore").encode() for it in value]
        width = max(map(len, texts), default=0)
        kind, sizes = TEXT, (width, len(texts))
        data = b"".join(text.ljust(width) for text in texts)
    else:
        array = np.asarray(value)
        kind, sizes = (FLOAT if array.dtype.kind == "f" else INT), array.shape
        data = PROCESSORS[INTEL].written(array, kind)
    return struct.pack("<bB", kind, len(sizes)) + bytes(sizes) + data + b"\0"
