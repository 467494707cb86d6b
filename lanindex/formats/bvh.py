"""BVH (BioVision Hierarchy): read, cut byte for byte, write.

The hierarchy is read word by word, with a stack instead of recursion, so that neither layout nor
depth matters. Frames are the lines that are there: the ``Frames:`` count is not trusted.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES
from lanindex.body import body_of, map_body, sampled
from lanindex.body.axes import measured_palms
from lanindex.body.calibration import BEGINNING
from lanindex.body.kinematics import Plan, aimed, plan
from lanindex.body.kinematics import positions as positions_of
from lanindex.body.recognition import exporter_of
from lanindex.errors import CaptureError, ExportError
from lanindex.formats.animation import axes_at_rest, rest_of_axes, turn_to_axes
from lanindex.formats.decimals import LARGEST
from lanindex.formats.file import Content, File, Wanted, clip, holding, line_of, text_of
from lanindex.formats.points import END
from lanindex.formats.rates import rate_doubt, rate_of
from lanindex.formats.text_rows import fault, number_rows
from lanindex.model import Motion, Reading, Skeleton, Source, Span
from lanindex.rotation import euler, rotations

Floats = NDArray[np.float64]
Places = NDArray[np.int64]

# by code: code < 3 moves along axis `code`, the others turn about axis `code - 3`
CHANNELS = ("xposition", "yposition", "zposition", "xrotation", "yrotation", "zrotation")
MOST_JOINTS = 32_000  # what an int16 index can hold
BLOCK = 4096  # frames whose numbers are held at a time
SEARCHED = 1 << 20  # bytes in which line ends are looked for at a time
HEADER = 1 << 20  # bytes in which a header is looked for
BEYOND = 4096  # bytes that must follow it there, lest its last line be cut

_CODES = {name.encode(): code for code, name in enumerate(CHANNELS)}
_STATEMENT = re.compile(
    rb"""\s*(?:
    OFFSET\s+(?P<x>[^\s{}]+)\s+(?P<y>[^\s{}]+)\s+(?P<offset>[^\s{}]+)
    | CHANNELS\s+(?P<count>\d{1,12})(?P<channels>(?:\s+[XYZ](?:position|rotation)\b)*)
    | (?P<close>\})
    | (?P<kind>ROOT|JOINT)[ \t]+(?P<joint>[^\s{}](?:[^\r\n{}]*[^\s{}])?)\s*\{
    | END[ \t]+(?P<end>[^\s{}]+)\s*\{
    | (?P<motion>MOTION)\b
    | (?P<other>\S|\Z)
    )""",
    re.VERBOSE | re.IGNORECASE,
)
_BEGIN = re.compile(rb"(?:\xef\xbb\xbf)?\s*HIERARCHY\b", re.IGNORECASE)
_WORD = re.compile(rb"\s*([{}]|[^\s{}]*)")
_LAST_LINE = re.compile(rb"[^\r\n]*(?:\r\n|\r|\n)?\Z")
_BLANK = re.compile(rb"\s*\Z")
_COUNT = re.compile(rb"\s*Frames[ \t]*:[ \t]*([^\s]*)[^\r\n]*", re.IGNORECASE)
_TIME = re.compile(rb"\s*(Frame[ \t]*Time[ \t]*:[ \t]*([^\s]*)[^\r\n]*)", re.IGNORECASE)
_LINE_END = re.compile(rb"\r\n|\r|\n")
_WANTED = {
    b"OFFSET": "three finite numbers behind it",
    b"CHANNELS": "how many, then as many of Xposition ... Zrotation",
    b"ROOT": "a name and { behind it",
    b"JOINT": "a name and { behind it",
    b"END": "Site and { behind it",
}


@dataclass(frozen=True, slots=True)
class Hierarchy:
    """The joints of a BVH file in file order, End Sites among them."""

    names: tuple[str, ...]  # (J) names; an End Site is called after its joint: ``Head End``
    parents: tuple[int, ...]  # (J) index of each parent, -1 for a root
    offsets: tuple[tuple[float, ...], ...]  # (J, 3) in units of the file
    channels: tuple[tuple[int, ...], ...]  # (J) codes of `CHANNELS`, in file order

    @property
    def width(self) -> int:
        """How many numbers a frame has."""
        return sum(map(len, self.channels))


@dataclass(slots=True)
class _Parser:
    """The joints that have been read, and where the statement begins that is being read."""

    data: bytes
    path: str
    at: int = 0
    names: list[str] = field(default_factory=list)
    parents: list[int] = field(default_factory=list)
    offsets: dict[int, tuple[float, ...]] = field(default_factory=dict)
    channels: dict[int, tuple[int, ...]] = field(default_factory=dict)
    ends: set[int] = field(default_factory=set)
    stack: list[int] = field(default_factory=list)
    seen: dict[str, int] = field(default_factory=dict)

    def word(self) -> re.Match[bytes]:
        """Return the next word, which may be empty."""
        word = _WORD.match(self.data, self.at)
        assert word is not None
        return word

    def error(self, found: str, wanted: str, remedy: str = "") -> CaptureError:
        """Return an error at the statement that is being read."""
        start = self.word().start(1)
        if _LAST_LINE.match(self.data, start):
            remedy = "It is the last line: the file may be cut short."
        place = f"{self.path}:{line_of(self.data, start)}"
        return CaptureError(found, place=place, wanted=wanted, remedy=remedy)

    def unknown(self, wanted: str) -> CaptureError:
        """Return the error for text that is no statement."""
        found = self.word()
        word, (start, stop) = found[1], found.span(1)
        if not word or (_BLANK.match(self.data, stop) and self.names):
            return self.error("the file ends inside the hierarchy", wanted)
        about = f" in {self.title(self.stack[-1])}" if self.stack else ""
        line = self.data[start : start + 200].splitlines()[0]
        shown = text_of(line.strip())[:60]
        return self.error(f"{shown!r}{about}", _WANTED.get(word.upper(), wanted))

    def owner(self, statement: str) -> int:
        """Return the joint that a statement is about."""
        if not self.stack:
            raise self.error(f"{statement} outside any joint", "ROOT")
        return self.stack[-1]

    def title(self, joint: int) -> str:
        """Return what to call a joint in an error."""
        return self.names[joint] or f"the End Site of {self.names[self.parents[joint]]}"

    def open(self, name: str) -> int:
        """Begin a joint and return its index."""
        joint = len(self.names)
        if joint >= MOST_JOINTS:
            raise self.error(f"more than {MOST_JOINTS} joints", "a human skeleton")
        parent = self.stack[-1] if self.stack else -1
        if parent in self.ends:
            raise self.error("a joint inside an End Site", "only an OFFSET there")
        self.names.append(name)
        self.parents.append(parent)
        self.stack.append(joint)
        return joint

    def read(self, statement: re.Match[bytes]) -> None:
        """Read a statement."""
        match statement.lastgroup:
            case "offset":
                joint = self.owner("OFFSET")
                self.offsets[joint] = self._offset(joint, statement)
            case "channels":
                joint, codes = self.owner("CHANNELS"), _codes(statement["channels"])
                if len(codes) != int(statement["count"]):
                    said = f"says {int(statement['count'])} and names {len(codes)}"
                    raise self.error(
                        f"CHANNELS of {self.title(joint)} {said}",
                        "as many of Xposition ... Zrotation as the number says",
                    )
                self.channels[joint] = codes
            case "close":
                joint = self.owner("}")
                if joint not in self.offsets:
                    raise self.error(f"{self.title(joint)} has no OFFSET", "one a joint")
                self.stack.pop()
            case "joint":
                self._joint(statement["kind"].upper().decode(), text_of(statement["joint"]))
            case "end":
                self.owner("End Site")
                self.ends.add(self.open(""))
            case _:
                raise self.unknown("OFFSET, CHANNELS, JOINT, End Site, } or MOTION")

    def _offset(self, joint: int, statement: re.Match[bytes]) -> tuple[float, ...]:
        words = statement.group("x", "y", "offset")
        try:
            values = tuple(map(float, words))
        except ValueError:
            values = (math.nan,)
        if not math.hypot(*values) <= LARGEST or b"_" in statement[0]:
            numbers = text_of(b" ".join(words))[:60]
            said = f"OFFSET of {self.title(joint)} is {numbers!r}"
            raise self.error(said, "three finite numbers")
        return values

    def _joint(self, kind: str, name: str) -> None:
        if bool(self.stack) != (kind == "JOINT"):
            where = "inside a joint" if self.stack else "outside any ROOT"
            raise self.error(f"{kind} {where}", "JOINT inside the braces of a ROOT")
        if name in self.seen:
            raise self.error(
                f"a second joint named {name!r}, the first is joint {self.seen[name] + 1}",
                "every joint a name of its own",
                "Rename one of them.",
            )
        self.seen[name] = self.open(name)

    def finished(self) -> Hierarchy:
        """Return all joints, End Sites named."""
        taken = set(self.seen)
        for end in sorted(self.ends):
            name = stem = self.names[self.parents[end]] + END
            number = 1
            while name in taken:
                number += 1
                name = f"{stem} {number}"
            taken.add(name)
            self.names[end] = name
        joints = range(len(self.names))
        return Hierarchy(
            tuple(self.names),
            tuple(self.parents),
            tuple([self.offsets[joint] for joint in joints]),
            tuple([self.channels.get(joint, ()) for joint in joints]),
        )


@lru_cache(maxsize=256)
def _codes(names: bytes) -> tuple[int, ...]:
    return tuple(_CODES[name.lower()] for name in names.split())


def parse(data: bytes, path: str = "") -> tuple[Hierarchy, int]:
    """Read the hierarchy; return it, and the byte behind ``MOTION``."""
    parser = _Parser(data, path)
    begin = _BEGIN.match(data)
    if begin is None:
        raise parser.unknown("HIERARCHY")
    for found in _STATEMENT.finditer(data, begin.end()):
        parser.at = found.start()
        if found.lastgroup == "motion":
            break
        parser.read(found)
    if parser.stack:
        raise parser.error(f"MOTION before the }} of {parser.title(parser.stack[-1])}", "a }")
    if not parser.names:
        raise parser.error("a hierarchy without joints", "ROOT")
    return parser.finished(), found.end()


@dataclass(frozen=True, slots=True, eq=False)
class BvhLayout:
    """The bytes of a BVH file.

    A clip is ``data[: count[0]]``, its own number of frames, ``data[count[1] : first]``, and
    ``data[frames[i, 0] : ends[i]]`` for each frame i.
    """

    hierarchy: Hierarchy  # the joints
    # first byte of the number behind ``Frames:``, and the one after its last
    count: tuple[int, int]
    declared: int  # that number
    time: str | None  # what stands behind ``Frame Time:``; None: there is no such line
    time_line: tuple[int, int]  # bytes of that line, without its end; empty where there is none
    first: int  # the byte behind the header: the line after ``Frame Time:``
    # (T, 2) int64, first byte of each frame's line and the one after its last, without line end
    frames: Places = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    ends: Places = field(default_factory=lambda: np.zeros(0, np.int64))  # (T,) behind line ends


def scan(data: Content, path: str = "") -> BvhLayout:
    """Find the frames of a BVH file without reading their numbers."""
    header = _header(data, path)
    width = header.hierarchy.width
    frames, ends = _lines(data, header.first, width)
    if not len(frames):
        place = f"{path}:{line_of(data, header.first)}"
        wanted = f"lines of {width} numbers behind MOTION"
        raise CaptureError("no frames", place=place, wanted=wanted)
    return replace(header, frames=frames, ends=ends)


def _header(data: Content, path: str) -> BvhLayout:
    """Read what stands before the frames, of a large file as little as tells it for certain."""
    size = HEADER
    while size < len(data):
        head = data[:size]
        with suppress(CaptureError):  # it may be we who cut it short
            found = _parse_header(head, path)
            if len(head[found.first :].lstrip()) > BEYOND:
                return found
        size *= 8
    return _parse_header(data[:], path)


def _parse_header(data: bytes, path: str) -> BvhLayout:
    """Return the layout of what stands before the frames, which it does not look for."""
    hierarchy, motion = parse(data, path)
    if not hierarchy.width:
        raise CaptureError(
            "no joint has CHANNELS, nothing can move", place=path, wanted="a ROOT with channels"
        )
    count = _COUNT.match(data, motion)
    if count is None or not re.fullmatch(rb"[+-]?\d{1,30}", count[1]):
        found = "no Frames: line" if count is None else f"Frames: {text_of(count[1])[:40]!r}"
        place = f"{path}:{line_of(data, motion if count is None else count.start(1))}"
        wanted = "Frames: and a whole number behind MOTION"
        raise CaptureError(found, place=place, wanted=wanted)
    time = _TIME.match(data, count.end())
    behind = _LINE_END.match(data, (time or count).end())
    return BvhLayout(
        hierarchy,
        count.span(1),
        int(count[1]),
        text_of(time[2]) if time else None,
        time.span(1) if time else (count.end(), count.end()),
        behind.end() if behind else len(data),
    )


def _lines(data: Content, first: int, width: int) -> tuple[Places, Places]:
    """Return the lines that are not blank, (T, 2) without their ends, and (T,) with them."""
    length = len(data)
    breaks, pairs = _breaks(data, first)
    starts = np.concatenate(([first], breaks + 1))
    stops = np.concatenate((breaks, [length]))
    ends = np.minimum(stops + 1, length)
    ends[: len(pairs)] += pairs
    del breaks, pairs
    keep = stops > starts
    if not keep.all():
        starts, stops, ends = starts[keep], stops[keep], ends[keep]
    frames = np.stack((starts, stops), axis=1)
    short = np.flatnonzero(stops - starts < 2 * width - 1)
    blank = [line for line in short.tolist() if data[starts[line] : stops[line]].isspace()]
    return (np.delete(frames, blank, axis=0), np.delete(ends, blank)) if blank else (frames, ends)


def _breaks(data: Content, first: int) -> tuple[Places, NDArray[np.bool_]]:
    """Return the bytes that end a line, and which of all but the last the next one continues."""
    breaks, returned = [np.zeros(0, np.int64)], [np.zeros(0, bool)]
    for start in range(first, len(data), SEARCHED):
        stop = min(start + SEARCHED, len(data))
        held, begin = holding(data, start, stop)
        text = np.frombuffer(held, np.uint8)[start - begin : stop - begin]
        returns = held.find(b"\r", start - begin, stop - begin) >= 0
        found = np.flatnonzero((text == 10) | (text == 13) if returns else text == 10)
        breaks.append(found + start)
        returned.append(text[found] == 13)
    places, carriage = np.concatenate(breaks), np.concatenate(returned)
    return places, carriage[:-1] & ~carriage[1:] & (np.diff(places) == 1)


def cutter(file: File, options: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of a BVH file, which is looked through once."""
    data, layout = file.content, scan(file.content, file.name)
    before, after = layout.count

    def cut(span: Span) -> bytes:
        starts = layout.frames[span.start : span.stop, 0]
        ends = layout.ends[span.start : span.stop]
        gaps = np.flatnonzero(starts[1:] != ends[:-1])  # blank lines, which are left out
        runs = zip(starts[[0, *(gaps + 1)]].tolist(), ends[[*gaps, -1]].tolist(), strict=True)
        count = str(len(span)).encode()
        return clip(data, ((0, before), count, (after, layout.first), *runs))

    return cut


def read(file: File, options: Reading, wanted: Wanted) -> Motion:
    """Read a BVH file: every joint and End Site, or those of the body."""
    path, layout = file.name, file.once(_scanned)
    place = f"{path}:{line_of(file.content, layout.time_line[0])}"
    rate = rate_of(layout.time, place, options.rate)
    order, reason = _order(options.compose, layout.hierarchy.names)
    joints = layout.hierarchy
    work = plan(joints.parents, joints.offsets, joints.channels, order == "child")
    frames = _Frames(file, layout, work)
    values, poses, first = frames.looked_at()
    found = map_body(joints.names, joints.parents, poses, first, rate, options, path)
    if hands := _turned_hands(joints, found.body, values):
        ends, body = list(joints.offsets), found.body.copy()
        for name, (end, offset) in hands.items():
            ends[end], body[JOINT_CODES[name]] = offset, end
        joints, found = replace(joints, offsets=tuple(ends)), replace(found, body=body)
        frames.follow(plan(joints.parents, joints.offsets, joints.channels, order == "child"))
    offsets = found.oriented(np.array(joints.offsets, np.float64))
    skeleton = Skeleton(joints.names, np.array(joints.parents, np.int16), offsets, found.body)
    kept = None
    if wanted.body_only:
        kept, skeleton = body_of(skeleton)
    begin, end = wanted.frames or (0, len(layout.frames))
    end = min(max(end, found.first + 1), len(layout.frames))
    positions = np.empty((end - begin, len(skeleton.names), 3), np.float32)
    turning = _axis_plans(work, joints, values, poses, found.body)
    axes = {name: np.empty((len(positions), 2, 3), np.float32) for name in turning}
    for start, values, places in frames.blocks(begin, end):
        part = slice(start - begin, start - begin + len(places))
        found.oriented(places, positions[part], kept)
        for name, own in turning.items():
            axes[name][part] = found.turned(positions_of(own, values)[:, -2:])
    composed = f"{order} first ({reason})"
    about = ("bvh", found.unit, found.scale, found.up)
    source = Source(path, *about, compose=composed, joints=joints.names)
    axes, made_up = measured_palms(axes, positions, skeleton.body)
    count, declared = len(layout.frames), layout.declared
    miscounted = (f"Frames: says {declared}, the file has {count}",) * (declared != count)
    doubts = (*miscounted, *rate_doubt(rate), *found.doubts, *made_up)
    moves = max(found.first - begin, 0)
    return Motion(skeleton, rate, positions, source, moves, doubts, axes=axes)


def frames(wanted: Wanted, count: int) -> NDArray[np.int64]:
    """Return which frames a motion has: see `lanindex.formats`."""
    return np.arange(count)[slice(*wanted.frames or (None,))]


def _scanned(file: File) -> BvhLayout:
    return scan(file.content, file.name)


HAND = 0.35
"""Of a forearm: how long a hand is that turns at its wrist, and has an End Site without length."""


def _turned_hands(
    joints: Hierarchy, body: NDArray[np.int16], values: Floats
) -> dict[str, tuple[int, tuple[float, ...]]]:
    """Return the End Sites of no length behind wrists that turn, and where they lie as hands.

    `values` (S, C) are the numbers of some frames; a hand goes on from the forearm.
    """
    begins = np.cumsum([0, *map(len, joints.channels)]).tolist()
    found = {}
    for side in "RL":
        wrist, hand = (int(body[JOINT_CODES[side + it]]) for it in ("Wrist", "Hand"))
        if wrist < 0 or hand >= 0:
            continue
        turns = [
            values[:, begins[wrist] + place]
            for place, code in enumerate(joints.channels[wrist])
            if code >= 3
        ]
        ends = [end for end, parent in enumerate(joints.parents) if parent == wrist]
        turning = bool(turns) and np.ptp(turns, axis=1).any()
        if turning and len(ends) == 1 and not any(joints.offsets[ends[0]]):
            found[side + "Hand"] = ends[0], tuple(HAND * it for it in joints.offsets[wrist])
    return found


def _axis_plans(
    work: Plan, joints: Hierarchy, values: Floats, poses: Floats, body: NDArray[np.int16]
) -> dict[str, Plan]:
    """Return what tells the axes of joints, if at rest or as seen in some poses they are known."""
    if exporter_of(joints.names).get("turns") == "bones":
        return {}

    def turned(joint: int) -> Floats:
        own = aimed(work, joints.channels, joint, np.eye(3))
        return np.swapaxes(positions_of(own, values)[:, -3:], 1, 2)

    known = axes_at_rest(joints.names, joints.parents, joints.offsets, body, poses, turned)
    return {name: aimed(work, joints.channels, *it) for name, it in known.items()}


def _order(compose: str | None, names: tuple[str, ...]) -> tuple[str, str]:
    """Return whose turn stands first, a joint's parent's or its own, and who says so."""
    if compose:
        return compose, "as told"
    exporter = exporter_of(names)
    if "compose" in exporter:
        return exporter["compose"], f"its joints are named as {exporter['name']} names them"
    return "parent", "as BVH has it"


@dataclass(slots=True)
class _Frames:
    """The numbers of a file as places of its joints, block by block."""

    file: File  # the file
    layout: BvhLayout  # where its frames lie
    work: Plan  # what leads from channels to places
    # (T, C) and (T, J, 3) float64: of a short file everything, read once
    all_numbers: tuple[Floats, Floats] | None = None

    def looked_at(self) -> tuple[Floats, Floats, Floats]:
        """Return numbers and poses that tell the body, (S, C), (S, J, 3), and the first frames."""
        count = len(self.layout.frames)
        if count <= BLOCK:
            self.all_numbers = self._places(0, count)
            values, places = (some[sampled(count)] for some in self.all_numbers)
            return values, places, self.all_numbers[1][:BEGINNING]
        chosen = np.unique(np.append(sampled(count), np.arange(BEGINNING)))
        pieces = [self.file.content[a:b] for a, b in self.layout.frames[chosen].tolist()]
        stops = np.cumsum([len(piece) for piece in pieces])
        side_by_side = np.stack((np.append(0, stops[:-1]), stops), axis=1)
        values, bad = number_rows(b"".join(pieces), side_by_side, self.layout.hierarchy.width)
        if bad is not None:
            for _ in self.blocks(0, count):  # says which frame is the first that is damaged
                pass
        places, those = positions_of(self.work, values), np.searchsorted(chosen, sampled(count))
        return values[those], places[those], places[:BEGINNING]

    def follow(self, work: Plan) -> None:
        """Tell places by another plan."""
        self.work = work
        if self.all_numbers is not None:
            self.all_numbers = self.all_numbers[0], positions_of(work, self.all_numbers[0])

    def blocks(self, begin: int, end: int) -> Iterator[tuple[int, Floats, Floats]]:
        """Yield blocks: the first frame, the numbers (T, C), and the places (T, J, 3) they tell."""
        if self.all_numbers is not None:
            values, places = self.all_numbers
            yield begin, values[begin:end], places[begin:end]
            return
        for start in range(begin, end, BLOCK):
            yield start, *self._places(start, min(start + BLOCK, end))

    def _places(self, start: int, stop: int) -> tuple[Floats, Floats]:
        """Read some frames, or say which of them is damaged and how."""
        lines = self.layout.frames[start:stop]
        data, begin = holding(self.file.content, int(lines[0, 0]), int(lines[-1, 1]))
        width = self.layout.hierarchy.width
        values, bad = number_rows(data, lines - begin, width)
        if bad is None:
            return values, positions_of(self.work, values)
        first, last = lines[bad].tolist()
        line = data[first - begin : last - begin]
        found, wanted = fault(line, width)
        cut = start + bad == len(self.layout.frames) - 1 and bool(line.strip())
        short = len(line.split()) <= width
        raise CaptureError(
            f"frame {start + bad} {found}",
            place=f"{self.file.name}:{line_of(self.file.content, first)}",
            wanted=wanted,
            remedy="It is the last line: the file may be cut short." if cut and short else "",
        )


UNIT = 10.0  # millimetres in the file's unit, a centimetre
RIGID = 0.02  # millimetres: what bones may change their lengths by in a file of rotations alone
DEEPEST = 200  # joints that hang on each other; each is written a step further to the right
ROTATIONS = "Zrotation Xrotation Yrotation"
POSITIONS = "Xposition Yposition Zposition"


def write(motion: Motion) -> bytes:
    """Write a motion as BVH, in centimetres, from the skeleton's rest pose.

    Where bones change their lengths, every joint but End Sites has position channels, too.
    """
    skeleton, points = motion.skeleton, motion.positions.astype(np.float64)
    _check(motion, points)
    turns = rotations(points, skeleton.offsets.astype(float), skeleton.parents.astype(int))
    if motion.axes:
        rest = rest_of_axes(motion, skeleton.offsets, turns[sampled(len(motion))])
        turn_to_axes(rest, motion.axes, slice(None), turns)
    places, angles = _channels(points, turns, skeleton.parents.astype(int))
    stiff = bool(np.abs(places[:, 1:] - skeleton.offsets[1:]).max(initial=0) <= RIGID)
    hierarchy, joints = _hierarchy(skeleton, stiff)
    columns = [
        values[:, joint]
        for joint in joints
        for values in ((angles,) if stiff and joint else (places / UNIT, angles))
    ]
    lines = chain(
        ["HIERARCHY", *hierarchy],
        ["MOTION", f"Frames: {len(motion)}", f"Frame Time: {float(1 / motion.rate):.9g}"],
        (" ".join(map(_short, row)) for row in np.concatenate(columns, axis=1).tolist()),
    )
    return ("\n".join(lines) + "\n").encode()


def _channels(points: Floats, turns: Floats, parents: NDArray[np.int_]) -> tuple[Floats, Floats]:
    """Return each joint's place as its parent sees it, mm, and its own angles, degrees."""
    world = np.broadcast_to(np.eye(3), (len(points), 1, 3, 3))
    above = np.concatenate([world, turns], axis=1)[:, parents + 1]
    places = points.copy()
    places[:, 1:] -= points[:, parents[1:]]
    places = np.einsum("tjki,tjk->tji", above, places)
    return places, euler(np.swapaxes(above, 2, 3) @ turns)


def _check(motion: Motion, points: Floats) -> None:
    place, names = motion.source.path, motion.skeleton.names
    roots = [name for name, up in zip(names, motion.skeleton.parents, strict=True) if up < 0]
    if roots != [names[0]]:
        raise ExportError(
            f"the roots {', '.join(roots)}", place=place, wanted="one, the first joint"
        )
    deep = [0] * len(names)
    for joint, parent in enumerate(motion.skeleton.parents.tolist()):
        deep[joint] = deep[parent] + 1 if parent >= 0 else 1
    if max(deep) > DEEPEST:
        found = f"{max(deep)} joints, each on the one before"
        raise ExportError(found, place=place, wanted=f"{DEEPEST} at most in a BVH file")
    unknown = np.argwhere(~np.isfinite(points))
    if len(unknown):
        found = f"{names[unknown[0][1]]} is unknown in frame {unknown[0][0]}"
        raise ExportError(found, place=place, wanted="every joint in every frame")


def _hierarchy(skeleton: Skeleton, stiff: bool) -> tuple[list[str], list[int]]:
    """Return the lines of the joints, and the joints that have channels in their order."""
    names, lines, joints = skeleton.names, list[str](), list[int]()
    children = [np.flatnonzero(skeleton.parents == joint).tolist() for joint in range(len(names))]
    offsets = [" ".join(_short(value / UNIT) for value in it) for it in skeleton.offsets.tolist()]

    def add(joint: int, tab: str) -> None:
        joints.append(joint)
        lines.extend(
            (
                f"{tab}JOINT {names[joint]}" if joint else f"ROOT {names[joint]}",
                f"{tab}{{",
                f"{tab}\tOFFSET {offsets[joint] if joint else '0 0 0'}",
                f"{tab}\tCHANNELS "
                + (f"3 {ROTATIONS}" if stiff and joint else f"6 {POSITIONS} {ROTATIONS}"),
            )
        )
        below = children[joint]
        ended = len(below) == 1 and not children[below[0]] and names[below[0]].endswith(END)
        if ended or not below:
            offset = offsets[below[0]] if ended else "0 0 0"
            end = ("\tEnd Site", "\t{", f"\t\tOFFSET {offset}", "\t}")
            lines.extend(tab + line for line in end)
        else:
            for child in below:
                add(child, f"{tab}\t")
        lines.append(f"{tab}}}")

    add(0, "")
    return lines, joints


def _short(value: float) -> str:
    """Write a number with four places at most."""
    text = f"{value:.4f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
