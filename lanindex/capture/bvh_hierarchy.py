"""The HIERARCHY of a BVH file: joints, offsets, channels.

The text is read word by word, with a stack instead of recursion, so that neither layout nor depth
matters.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from lanindex.errors import CaptureError

CHANNELS = ("xposition", "yposition", "zposition", "xrotation", "yrotation", "zrotation")
"""Channels by code: code < 3 moves along axis `code`, the others turn about axis `code - 3`."""

LARGEST = 1e9
"""Numbers beyond this are taken for damage."""

MOST_JOINTS = 32_000
"""What an int16 index can hold."""

_CODES = {name.encode(): code for code, name in enumerate(CHANNELS)}
_WORD = re.compile(rb"[{}]|[^\s{}]+")
_MOTION = re.compile(rb"\}\s*MOTION\b", re.IGNORECASE)
_KEYWORDS = frozenset((b"ROOT", b"JOINT", b"END", b"OFFSET", b"CHANNELS", b"MOTION", b"{", b"}"))


@dataclass(frozen=True, slots=True)
class Hierarchy:
    """The joints of a BVH file in file order, End Sites among them.

    Attributes
    ----------
    names : tuple of str
        (J) names; an End Site is called after its joint: ``Head End``.
    parents : tuple of int
        (J) index of each parent, -1 for a root.
    offsets : tuple of tuple of float
        (J, 3) in units of the file.
    channels : tuple of tuple of int
        (J) codes of `CHANNELS`, in file order.
    ends : frozenset of int
        The indices that are End Sites.
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: tuple[tuple[float, ...], ...]
    channels: tuple[tuple[int, ...], ...]
    ends: frozenset[int]

    @property
    def width(self) -> int:
        """How many numbers a frame has."""
        return sum(map(len, self.channels))


def line_of(data: bytes, offset: int) -> int:
    """Return the line, counted from 1, that holds a byte; any of the three line ends counts."""
    ends = data.count(b"\n", 0, offset) + data.count(b"\r", 0, offset)
    return ends - data.count(b"\r\n", 0, offset) + 1


def text_of(word: bytes) -> str:
    """Return a name or a damaged word as text that can be printed."""
    try:
        return word.decode()
    except UnicodeDecodeError:
        return word.decode("latin-1")


@dataclass(slots=True)
class _Builder:
    """What has been read so far, and where the reading stands."""

    data: bytes
    path: str
    words: Iterator[re.Match[bytes]]
    last: re.Match[bytes] | None = None
    names: list[str] = field(default_factory=list)
    parents: list[int] = field(default_factory=list)
    offsets: list[tuple[float, ...] | None] = field(default_factory=list)
    channels: list[tuple[int, ...]] = field(default_factory=list)
    ends: set[int] = field(default_factory=set)
    stack: list[int] = field(default_factory=list)
    seen: dict[str, int] = field(default_factory=dict)

    def take(self, wanted: str) -> bytes:
        """Return the next word."""
        self.last = next(self.words, None)
        if self.last is None:
            raise CaptureError(
                "the file ends inside the hierarchy",
                place=f"{self.path}:{line_of(self.data, len(self.data))}",
                wanted=wanted,
                remedy="It was cut short: copy or export it again.",
            )
        return self.last.group()

    def error(self, found: str, wanted: str = "", remedy: str = "") -> CaptureError:
        """Return an error at the word that was taken last."""
        offset = self.last.start() if self.last else 0
        place = f"{self.path}:{line_of(self.data, offset)}"
        return CaptureError(found, place=place, wanted=wanted, remedy=remedy)

    def number(self, owner: str) -> float:
        """Return the next word as a number."""
        word = self.take(f"three numbers after OFFSET of {owner}")
        try:
            value = float("nan" if b"_" in word else word)
        except ValueError:
            value = float("nan")
        if not abs(value) <= LARGEST:
            raise self.error(f"OFFSET of {owner} has {text_of(word)!r}", "three finite numbers")
        return value

    def open(self, name: str) -> None:
        """Begin a joint."""
        if len(self.names) >= MOST_JOINTS:
            raise self.error(f"more than {MOST_JOINTS} joints", "a human skeleton")
        self.names.append(name)
        self.parents.append(self.stack[-1] if self.stack else -1)
        self.offsets.append(None)
        self.channels.append(())
        self.stack.append(len(self.names) - 1)

    def name(self, kind: str) -> str:
        """Return the words up to the opening brace as a name."""
        words: list[str] = []
        while (word := self.take(f"a name and {{ after {kind}")) != b"{":
            if word.upper() in _KEYWORDS and (words or word == b"}"):
                break
            words.append(text_of(word))
        if word != b"{" or not words:
            raise self.error(f"{kind} is followed by {text_of(word)!r}", "a name and {")
        return " ".join(words)


def _joint(build: _Builder, kind: str) -> None:
    if bool(build.stack) != (kind == "JOINT"):
        place = "inside a joint" if build.stack else "outside any ROOT"
        raise build.error(f"{kind} {place}", "JOINT inside the braces of a ROOT")
    if build.stack and build.stack[-1] in build.ends:
        raise build.error("a JOINT inside an End Site", "only an OFFSET there")
    name = build.name(kind)
    line = build.seen.get(name)
    if line is not None:
        raise build.error(
            f"a second joint named {name!r}, the first is joint {line + 1} of the file",
            "every joint a name of its own",
            "Rename one of them.",
        )
    build.seen[name] = len(build.names)
    build.open(name)


def _end(build: _Builder) -> None:
    if not build.stack:
        raise build.error("End Site outside any joint", "ROOT")
    build.name("End")
    build.ends.add(len(build.names))
    build.open("")


def _offset(build: _Builder) -> None:
    owner = _owner(build, "OFFSET")
    build.offsets[build.stack[-1]] = tuple(build.number(owner) for _ in range(3))


def _channels(build: _Builder) -> None:
    owner = _owner(build, "CHANNELS")
    count = build.take("the number of channels")
    codes = []
    for _ in range(int(count) if count.isdigit() and len(count) < 4 else 0):
        word = build.take("the channels' names")
        code = _CODES.get(word.lower())
        if code is None:
            raise build.error(
                f"CHANNELS {text_of(count)} of {owner} names {text_of(word)!r}",
                "Xposition ... Zrotation, as many as the number says",
            )
        codes.append(code)
    if len(codes) != (int(count) if count.isdigit() else -1):
        raise build.error(f"CHANNELS {text_of(count)!r} of {owner}", "a number from 0 to 999")
    build.channels[build.stack[-1]] = tuple(codes)


def _owner(build: _Builder, word: str) -> str:
    if not build.stack:
        raise build.error(f"{word} outside any joint", "ROOT")
    return build.names[build.stack[-1]] or "an End Site"


def _close(build: _Builder) -> None:
    if not build.stack:
        raise build.error("} without a {", "ROOT or MOTION")
    joint = build.stack.pop()
    if build.offsets[joint] is None:
        raise build.error(f"{build.names[joint] or 'an End Site'} has no OFFSET", "one a joint")


_STATEMENTS: dict[bytes, Callable[[_Builder], None]] = {
    b"ROOT": lambda build: _joint(build, "ROOT"),
    b"JOINT": lambda build: _joint(build, "JOINT"),
    b"END": _end,
    b"OFFSET": _offset,
    b"CHANNELS": _channels,
    b"}": _close,
}


def parse(data: bytes, path: str = "") -> tuple[Hierarchy, int]:
    """Read the hierarchy.

    Parameters
    ----------
    data : bytes
        The file.
    path : str
        Its name, for errors.

    Returns
    -------
    tuple of Hierarchy and int
        The joints, and the byte behind the word MOTION.

    Raises
    ------
    CaptureError
        Where the text is no hierarchy, names its line.
    """
    motion = _MOTION.search(data)
    limit = motion.end() if motion else len(data)
    build = _Builder(data, path, _WORD.finditer(data, 0, limit))
    first = build.take("HIERARCHY")
    if first.removeprefix(b"\xef\xbb\xbf").upper() != b"HIERARCHY":
        raise build.error(f"begins with {text_of(first)[:40]!r}", "HIERARCHY")
    while (word := build.take("MOTION").upper()) != b"MOTION":
        statement = _STATEMENTS.get(word)
        if statement is None:
            raise build.error(
                f"{text_of(word)[:40]!r} in the hierarchy",
                "OFFSET, CHANNELS, JOINT, End Site or }",
            )
        statement(build)
    if build.stack:
        owner = build.names[build.stack[-1]] or "an End Site"
        raise build.error(f"MOTION before the }} of {owner}", "every { closed")
    return _finished(build), limit


def _finished(build: _Builder) -> Hierarchy:
    if not build.names:
        raise build.error("a hierarchy without joints", "ROOT")
    taken = set(build.seen)
    for end in sorted(build.ends):
        parent = build.names[build.parents[end]]
        name = stem = f"{parent} End"
        number = 1
        while name in taken:
            number += 1
            name = f"{stem} {number}"
        taken.add(name)
        build.names[end] = name
    return Hierarchy(
        tuple(build.names),
        tuple(build.parents),
        tuple(offset for offset in build.offsets if offset is not None),
        tuple(build.channels),
        frozenset(build.ends),
    )
