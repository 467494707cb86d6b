"""Where the numbers of a C3D file lie: header, parameters, and which of them is to be believed.

Header and parameters say the same things twice or more, and not always the same. What is believed
is what fills the file.

Source: *The C3D File Format, User Guide*, Motion Lab Systems (c3d.org), "The header section", "The
3D/analog data section"; *C3D rotations*, c3d.org, "ROTATION group".
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from operator import itemgetter

from lanindex.errors import CaptureError
from lanindex.formats.c3d.parameters import FULL, PROCESSORS, Parameters, Processor
from lanindex.formats.file import File

BLOCK = 512
"""Bytes in which a C3D file counts."""

TURN = 17
"""Floats of one rotation: a matrix of 4 x 4, column by column, and how well it is known."""

_PADDING = 2 * BLOCK  # less than this may stand behind the last frame
_ALIKE = 1e-3


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
    def number(self) -> int:
        """Bytes of a number."""
        return 4 if self.scale < 0 else 2

    @property
    def segments(self) -> Turns | None:
        """The rotations of a file that has no points."""
        return None if self.points else self.turns

    @property
    def frame(self) -> int:
        """Bytes of a frame."""
        return (4 * self.points + self.analog) * self.number


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
    words = [word & FULL for word in processor.ints(head, 12).tolist()]
    scale, rate = (processor.floats(head, 1, at).tolist()[0] for at in (12, 20))
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
    first, said, vague = _said(words, parameters)
    counts = list(said.values())
    believed, frames = _believed(list(options.values()), counts, vague, turns, size)
    doubts = _contradictions(options, believed, said, frames)
    seconds = _rate(parameters, rate, doubts)
    start, points, analog, step = believed
    layout = C3dLayout(
        *(parameters, section, int(start), int(points), int(analog), step, frames, first),
        *(seconds, turns, doubts),
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


def _said(words: list[int], parameters: Parameters) -> tuple[int, dict[str, int], list[int]]:
    """Return the number of the first frame, and how many there are by whoever says it.

    Last come the counts that may mean as many or more, for there is no room for more.
    """
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


def _believed(
    options: list[list[float]],
    said: Sequence[int],
    vague: Sequence[int],
    turns: Turns | None,
    size: int,
) -> tuple[tuple[float, ...], int]:
    """Return of all that is said what fills the file best; and how many frames."""

    def room(one: tuple[float, ...]) -> tuple[float, float]:
        """Return how many bytes are there, and how many a frame takes."""
        start, points, analog, step = one
        stop = turns.start if turns and turns.start > start else size
        return stop - start, (4 * points + analog) * (4 if step < 0 else 2)

    turned = (size - turns.start) // turns.frame if turns else 0
    fitting = []
    for one, count in product(product(*options), (*said, *vague)):
        there, frame = room(one)
        rest = there - count * frame
        if 0 <= rest < (math.inf if count in said else _PADDING):
            fitting.append((rest, one, min(count, turned) if turns and not one[1] else count))
    if fitting:
        return min(fitting, key=itemgetter(0))[1:]
    one = tuple(choices[0] for choices in options)
    there, frame = room(one)
    return one, int(there // frame) if frame else turned


def _contradictions(
    options: Mapping[str, list[float]],
    believed: tuple[float, ...],
    said: Mapping[str, int],
    frames: int,
) -> list[str]:
    """Return what the file says in two ways, and which of them was believed."""
    doubts = [
        f"says {what} {' or '.join(f'{it:g}' for it in choices)}: {chosen:g} believed"
        for (what, choices), chosen in zip(options.items(), believed, strict=True)
        if len(choices) > 1
    ]
    if {*said.values(), frames} != {frames}:
        sayers = ", ".join(f"{who}: {count}" for who, count in said.items())
        doubts.append(f"says different numbers of frames ({sayers}): {frames} believed")
    return doubts


def _turns(parameters: Parameters, size: int) -> Turns | None:
    """Return where rotations lie, if there are any."""
    start, count = _byte(parameters.count("ROTATION:DATA_START")), parameters.count("ROTATION:USED")
    turns = Turns(start, count or 0, max(parameters.count("ROTATION:RATIO") or 1, 1))
    return turns if start > 0 and turns.frame and start + turns.frame <= size else None


def _rate(parameters: Parameters, header: float, doubts: list[str]) -> float | None:
    """Return the frames a second, which the parameters tell better than the header."""
    rates = [
        rate
        for rate in (*parameters.numbers("POINT:RATE")[:1], header)
        if math.isfinite(rate) and rate > 0
    ]
    if len(rates) > 1 and abs(rates[0] - rates[1]) > _ALIKE * rates[0]:
        said = f"POINT:RATE says {rates[0]:g} frames a second, the header {rates[1]:g}"
        doubts.append(f"{said}: the first believed")
    return rates[0] if rates else None


def _error(file: File, found: str) -> CaptureError:
    return CaptureError(found, place=file.name, wanted="a whole C3D file")
