"""MVNX, what the inertial suits of Xsens write: segments, which begin at joints; clips of them.

Source: Xsens, *MVN User Manual*, section "MVNX"; files of versions 3 and 4.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple, NoReturn
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from lanindex.body import Declared, sampled
from lanindex.data import shipped
from lanindex.errors import CaptureError, quoted
from lanindex.formats.decimals import LARGEST
from lanindex.formats.file import File, Wanted, clip
from lanindex.formats.people import plain
from lanindex.formats.points import END, Points, motion_of
from lanindex.formats.rates import rate_by
from lanindex.formats.turning import rotated
from lanindex.model import Motion, Reading, Span

Floats = NDArray[np.float64]
Rows = NDArray[np.float32]

_SEGMENTS = shipped("formats/skeletons.toml")["mvnx"]
ABOVE: dict[str, str] = _SEGMENTS["above"]
TIPS: dict[str, str] = _SEGMENTS["tips"]
UNSEEN: dict[str, list[str]] = _SEGMENTS["unseen"]
_UNIT = (0.5, 2.0)  # lengths of quaternions that tell a turn


def read(file: File, options: Reading, wanted: Wanted) -> Motion:
    """Read an MVNX file: see `lanindex.formats.read_file`."""
    people = walk(file, True)
    subject = chosen(people, file)
    rate_text = subject.attributes.get("frameRate", "").replace(",", ".")
    rate, _ = rate_by(options, f"{file.name}:{subject.line}", rate_text)
    joints, doubts = _joints(subject)
    places, turns, offsets = _poses(subject, joints)
    others = ", ".join(quoted(one.name) for one in people[:20] if one is not subject)
    if others and not file.subject:
        doubts += (f"{quoted(subject.name)} is read; it holds also {others}",)
    if subject.gap:
        doubts += (f"frame {subject.gap[1]} follows frame {subject.gap[0]}: taken for the next",)
    points = Points(
        tuple(joint.name for joint in joints),
        places,
        rate,
        Declared("m", "z"),
        tuple(joint.parent for joint in joints),
        offsets,
        turns,
        doubts,
        not subject.attributes.get("configuration", "").endswith("NoHands"),
    )
    return motion_of(points, file, "mvnx", options, wanted)


class _Joint(NamedTuple):
    """Where a segment begins, or a point on it; `parent` is another joint, by its number."""

    name: str
    segment: int
    parent: int
    point: Row | None = None


def _joints(subject: Subject) -> tuple[list[_Joint], tuple[str, ...]]:
    """Return the joints that are measured, and what is left out; parents before children."""
    configuration = subject.attributes.get("configuration", "")
    unseen = UNSEEN.get(configuration, ())
    index = {name: number for number, name in reversed(list(enumerate(subject.segments)))}
    known = [name for name in ABOVE if name in index and name not in unseen]
    known += [name for name in index if name and name not in ABOVE]
    number = {name: joint for joint, name in enumerate(known)}
    joints = []
    for name in known:
        above = ABOVE.get(name, "")
        while above and above not in number:
            above = ABOVE[above]
        joints.append(_Joint(name, index[name], number.get(above, -1)))
    handless = configuration.endswith("NoHands")
    for name, label in TIPS.items() if subject.rows["orientation"] else ():
        point = subject.points[index[name]].get(label) if name in number else None
        if point is not None and not (handless and name.endswith("Hand")):
            joints.append(_Joint(name + END, index[name], number[name], point))
    left = [name for name in subject.segments if name in unseen]
    doubt = f"{configuration}: nothing is measured at {', '.join(left)}, which are left out"
    return joints, (doubt,) if left else ()


def _poses(subject: Subject, joints: list[_Joint]) -> tuple[Rows, Rows | None, Floats | None]:
    """Return where joints are, how they are turned, and where they are at rest."""
    count = len(subject.frames)
    segments = [joint.segment for joint in joints]
    places = _stacked(subject.rows["position"]).reshape(count, -1, 3)[:, segments]
    if not subject.rows["orientation"]:
        return places, None, None
    turns = _stacked(subject.rows["orientation"]).reshape(count, -1, 4)[:, segments]
    length = np.sqrt(np.einsum("tji,tji->tj", turns, turns))[..., None]
    unit = (length > _UNIT[0]) & (length < _UNIT[1])
    turns = np.divide(turns, length, out=np.full_like(turns, np.nan), where=unit)
    few = sampled(count)
    offsets = np.zeros((len(joints), 3))
    for number, joint in enumerate(joints):
        if joint.point is not None:
            offsets[number] = joint.point
            places[:, number] += rotated(turns[:, number], joint.point)
        elif joint.parent >= 0:
            away = places[few, number] - places[few, joint.parent]
            back = turns[few, joint.parent] * np.array([1, -1, -1, -1], np.float32)
            ways = rotated(back, away)
            known = ways[np.isfinite(ways).all(axis=1)]
            offsets[number] = np.median(known, axis=0) if len(known) else 0.0
    return places, turns, offsets


def _stacked(rows: list[Row]) -> Rows:
    """Return rows as one array, and leave none of them behind."""
    array = np.array(rows)
    rows.clear()
    return array


_PARSED = 1 << 18
"""Bytes that are looked through at a time."""

LARGEST_TAG = 1 << 20
"""Bytes; also of numbers in one element."""

DEEPEST = 32
"""Elements within each other; MVNX has seven."""

MOST_SEGMENTS = 1000
"""More than any body has."""

NORMAL = "normal"
"""The type of frames that are movement; others are poses of a calibration."""

_WIDTHS = {"position": 3, "orientation": 4}

Row = NDArray[np.float32]


@dataclass(slots=True)
class Subject:
    """A person of an MVNX file."""

    name: str  # its label; where it has none, or another's, with its number
    start: int  # where its element begins, and where its closing tag does
    line: int  # where it begins
    attributes: dict[str, str]  # what its element says of it: ``frameRate``, ``configuration``
    stop: int = 0
    segments: list[str] = field(default_factory=list)  # as its frames have them
    # by segment: points on it, (3,) from its origin, not turned
    points: list[dict[str, Row]] = field(default_factory=list)
    # where each frame that is movement begins, and where its closing tag does
    frames: list[tuple[int, int]] = field(default_factory=list)
    # of each frame ``position``, (S * 3,), and ``orientation``, (S * 4,); where all have them
    rows: dict[str, list[Row]] = field(default_factory=lambda: {name: [] for name in _WIDTHS})
    # the first two frames, by their own numbers, between which some are missing
    gap: tuple[int, int] | None = None


def walk(file: File, numbers: bool) -> list[Subject]:
    """Go through an MVNX file."""
    walker = _Walker(file, numbers)
    walker.go()
    if not walker.subjects:
        raise CaptureError("has no subject", place=file.name, wanted="MVNX with a person in it")
    return walker.subjects


def chosen(subjects: list[Subject], file: File) -> Subject:
    """Return whom of several people a file's name means; the first, where it means none."""
    names = [subject.name for subject in subjects]
    if file.subject and file.subject not in names:
        found = f"has no subject {quoted(file.subject)}"
        raise CaptureError(found, place=file.name, wanted=" or ".join(names[:20]))
    subject = subjects[names.index(file.subject) if file.subject else 0]
    if not subject.frames:
        place = f"{file.name}:{subject.line}"
        raise CaptureError(
            f"{quoted(subject.name)} has no frames", place=place, wanted="frames of type normal"
        )
    return subject


class _Walker:
    """What hears of elements as they begin and end."""

    def __init__(self, file: File, numbers: bool) -> None:
        self.file, self.wanted, self.numbers = file, numbers, False
        self.subjects: list[Subject] = []
        self.names: set[str] = set()
        self.open: list[str] = []  # elements that have begun
        self.inside = False  # a subject
        self.heard: list[str] | None = None  # pieces of a text with numbers
        self.size = 0
        self.point = ""
        self.begun: int | None = None  # where the frame begins that is open, if it is movement
        self.number: int | None = None  # of the frame before
        self.begins: dict[str, Callable[[dict[str, str]], None]] = {
            "subject": self._subject,
            "segment": self._segment,
            "point": self._point,
            "frame": self._frame,
            **dict.fromkeys(("pos_b", *_WIDTHS), self._listen),
        }
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.StartDoctypeDeclHandler = self._document_type

    def go(self) -> None:
        content = self.file.content
        size = len(content)
        try:
            for start in range(0, size, _PARSED):
                piece = content[start : start + _PARSED]
                self.parser.Parse(piece, start + _PARSED >= size)
                if start + len(piece) - self.parser.CurrentByteIndex > LARGEST_TAG:
                    self._refuse("a tag without an end", f"tags of at most {LARGEST_TAG} bytes")
        except expat.ExpatError as error:
            remedy = "The file may be cut short." if self.open else ""
            self._refuse(
                f"is no sound XML: {expat.ErrorString(error.code)}", "elements that end", remedy
            )
        except (ValueError, LookupError) as error:
            self._refuse(f"is no sound XML: {error}", "UTF-8")

    def _refuse(self, found: str, wanted: str, remedy: str = "") -> NoReturn:
        place = f"{self.file.name}:{self.parser.ErrorLineNumber}"
        raise CaptureError(found, place=place, wanted=wanted, remedy=remedy)

    def _document_type(self, *_: object) -> None:
        wanted = "MVNX without one, in which nothing stands for something else"
        self._refuse("has a document type", wanted, "Take its <!DOCTYPE ...> out.")

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        self.open.append(name)
        if len(self.open) > DEEPEST:
            self._refuse(f"{len(self.open)} elements within each other", "MVNX, which has seven")
        begin = self.begins.get(name)
        if begin is not None and (self.inside or name == "subject"):
            begin(attributes)

    def _end(self, name: str) -> None:
        name = self.open.pop()
        if self.heard is not None and name in ("pos_b", *_WIDTHS):
            self.parser.CharacterDataHandler = None
            text, self.heard = "".join(self.heard), None
            self._row(name, text)
        elif name == "frame" and self.begun is not None:
            self._close(self.begun)
        elif name == "subject":
            self.inside, self.subjects[-1].stop = False, self.parser.CurrentByteIndex

    def _listen(self, _: dict[str, str]) -> None:
        of_segment = "frames" not in self.open and not self.subjects[-1].frames
        if self.numbers and (of_segment if self.open[-1] == "pos_b" else self.begun is not None):
            self.heard, self.size = [], 0
            self.parser.CharacterDataHandler = self._text

    def _text(self, text: str) -> None:
        if self.heard is not None:
            self.heard.append(text)
            self.size += len(text)
            if self.size > LARGEST_TAG:
                self._refuse("numbers without an end", f"at most {LARGEST_TAG} bytes")

    def _subject(self, attributes: dict[str, str]) -> None:
        if self.inside:
            self._refuse("a subject within another", "one behind the other")
        number = len(self.subjects) + 1
        name = plain(attributes.get("label", "")) or f"subject {number}"
        name = f"{name} {number}" if name in self.names else name
        self.names.add(name)
        meant = name == self.file.subject if self.file.subject else number == 1
        self.inside, self.numbers, self.number = True, self.wanted and meant, None
        at, line = self.parser.CurrentByteIndex, self.parser.CurrentLineNumber
        self.subjects.append(Subject(name, at, line, attributes))

    def _segment(self, attributes: dict[str, str]) -> None:
        if self.open[-2] != "segments":
            return
        subject = self.subjects[-1]
        if len(subject.segments) >= MOST_SEGMENTS or subject.frames:
            self._refuse("one more segment", f"at most {MOST_SEGMENTS}, before the frames")
        subject.segments.append(attributes.get("label", ""))
        subject.points.append({})

    def _point(self, attributes: dict[str, str]) -> None:
        self.point = attributes.get("label", "")

    def _frame(self, attributes: dict[str, str]) -> None:
        if attributes.get("type", NORMAL) != NORMAL or self.open[-2] != "frames":
            return
        subject, index, before = self.subjects[-1], attributes.get("index", ""), self.number
        number = int(index) if index.isdecimal() and len(index) < 16 else None
        if number is not None and before is not None and number != before + 1:
            subject.gap = subject.gap or (before, number)
        self.begun, self.number = self.parser.CurrentByteIndex, number

    def _close(self, begun: int) -> None:
        """End a frame: all or none of them have a row, all have a position."""
        subject, stop = self.subjects[-1], self.parser.CurrentByteIndex
        self.begun = None
        subject.frames.append((begun, stop))
        count = len(subject.frames)
        counts = {name: len(rows) for name, rows in subject.rows.items()} if self.numbers else {}
        for name, found in counts.items():
            if found not in ((count,) if name == "position" else (0, count)):
                wanted = f"<{name}> once in each"
                self._refuse(f"{found} times <{name}> in {count} frames", wanted)
        if stop == begun:
            self._refuse("an empty frame", "<position> in it")

    def _row(self, name: str, text: str) -> None:
        subject = self.subjects[-1]
        width = 3 if name == "pos_b" else _WIDTHS[name] * len(subject.segments)
        words = text.split()
        if len(words) != width:
            each = f"{_WIDTHS.get(name)} for each of {len(subject.segments)} segments"
            wanted = "3" if name == "pos_b" else each
            self._refuse(f"<{name}> has {len(words)} numbers", wanted)
        try:
            row = np.array(list(map(float, words)))
            sound = "_" not in text and not (np.abs(row) > LARGEST).any()
        except ValueError:
            sound = False
        if not sound:
            self._refuse(f"<{name}> has what is no number", f"numbers up to {LARGEST:g}")
        if name != "pos_b":
            subject.rows[name].append(row.astype(np.float32))
        elif subject.points:
            subject.points[-1][self.point] = row.astype(np.float32)


def subjects(file: File) -> tuple[str, ...]:
    """Return the names of the people in a file."""
    return tuple(subject.name for subject in walk(file, False))


def cutter(file: File, options: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of an MVNX file: frames of one person, all else as it is."""
    people = walk(file, False)
    meant = chosen(people, file)

    def kept(span: Span) -> Iterator[tuple[int, int]]:
        at = 0
        for subject in people:
            if subject is meant:
                frames = subject.frames
                yield at, frames[0][0]
                yield frames[span.start][0], frames[span.stop - 1][1]
                at = frames[-1][1]  # from one closing tag to the last
            else:
                closing = file.content[subject.stop : subject.stop + LARGEST_TAG]
                yield at, subject.start
                at = subject.stop + closing.find(b">") + 1
        yield at, len(file.content)

    return lambda span: clip(file.content, kept(span))
