"""The HIERARCHY of a BVH file: joints, offsets, channels.

The text is read word by word, with a stack instead of recursion, so that neither layout nor depth
matters.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache

from lanindex.errors import CaptureError
from lanindex.formats.decimals import LARGEST
from lanindex.formats.file import line_of, text_of

CHANNELS = ("xposition", "yposition", "zposition", "xrotation", "yrotation", "zrotation")
"""Channels by code: code < 3 moves along axis `code`, the others turn about axis `code - 3`."""

MOST_JOINTS = 32_000
"""What an int16 index can hold."""

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
    ends: frozenset[int]  # the indices that are End Sites

    @property
    def width(self) -> int:
        """How many numbers a frame has."""
        return sum(map(len, self.channels))


@dataclass(slots=True)
class _Builder:
    """What has been read so far, and where the reading stands."""

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

    def error(self, found: str, wanted: str = "", remedy: str = "") -> CaptureError:
        """Return an error at the statement that is being read."""
        word = _WORD.match(self.data, self.at)
        start = word.start(1) if word else self.at
        if _LAST_LINE.match(self.data, start):
            remedy = "It is the last line: the file may be cut short."
        place = f"{self.path}:{line_of(self.data, start)}"
        return CaptureError(found, place=place, wanted=wanted, remedy=remedy)

    def owner(self, statement: str) -> int:
        """Return the joint that a statement is about."""
        if not self.stack:
            raise self.error(f"{statement} outside any joint", "ROOT")
        return self.stack[-1]

    def called(self, joint: int) -> str:
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


def _joint(build: _Builder, found: re.Match[bytes]) -> None:
    kind = found["kind"].upper().decode()
    if bool(build.stack) != (kind == "JOINT"):
        where = "inside a joint" if build.stack else "outside any ROOT"
        raise build.error(f"{kind} {where}", "JOINT inside the braces of a ROOT")
    name = text_of(found["joint"])
    if name in build.seen:
        raise build.error(
            f"a second joint named {name!r}, the first is joint {build.seen[name] + 1}",
            "every joint a name of its own",
            "Rename one of them.",
        )
    build.seen[name] = build.open(name)


def _end(build: _Builder, found: re.Match[bytes]) -> None:
    build.owner("End Site")
    build.ends.add(build.open(""))


def _offset(build: _Builder, found: re.Match[bytes]) -> None:
    joint = build.owner("OFFSET")
    words = found.group("x", "y", "offset")
    try:
        values = tuple(map(float, words))
    except ValueError:
        values = (math.nan,)
    if not math.hypot(*values) <= LARGEST or b"_" in found[0]:
        numbers = text_of(b" ".join(words))[:60]
        raise build.error(f"OFFSET of {build.called(joint)} is {numbers!r}", "three finite numbers")
    build.offsets[joint] = values


@lru_cache(maxsize=256)
def _codes(names: bytes) -> tuple[int, ...]:
    return tuple(_CODES[name.lower()] for name in names.split())


def _channels(build: _Builder, found: re.Match[bytes]) -> None:
    joint = build.owner("CHANNELS")
    codes = _codes(found["channels"])
    if len(codes) != int(found["count"]):
        raise build.error(
            f"CHANNELS of {build.called(joint)} says {int(found['count'])} and names {len(codes)}",
            "as many of Xposition ... Zrotation as the number says",
        )
    build.channels[joint] = codes


def _close(build: _Builder, found: re.Match[bytes]) -> None:
    joint = build.owner("}")
    if joint not in build.offsets:
        raise build.error(f"{build.called(joint)} has no OFFSET", "one a joint")
    build.stack.pop()


def _other(build: _Builder, found: re.Match[bytes]) -> None:
    raise _unknown(build, "OFFSET, CHANNELS, JOINT, End Site, } or MOTION")


_STATEMENTS: dict[str | None, Callable[[_Builder, re.Match[bytes]], None]] = {
    "offset": _offset,
    "channels": _channels,
    "close": _close,
    "joint": _joint,
    "end": _end,
    "other": _other,
}


def parse(data: bytes, path: str = "") -> tuple[Hierarchy, int]:
    """Read the hierarchy."""
    build = _Builder(data, path)
    begin = _BEGIN.match(data)
    if begin is None:
        raise _unknown(build, "HIERARCHY")
    for found in _STATEMENT.finditer(data, begin.end()):
        build.at = found.start()
        if found.lastgroup == "motion":
            break
        _STATEMENTS[found.lastgroup](build, found)
    if build.stack:
        raise build.error(f"MOTION before the }} of {build.called(build.stack[-1])}", "a }")
    if not build.names:
        raise build.error("a hierarchy without joints", "ROOT")
    return _finished(build), found.end()


def _unknown(build: _Builder, wanted: str) -> CaptureError:
    """Return the error for text that is no statement."""
    data = build.data
    found = _WORD.match(data, build.at)
    word = found.group(1) if found else b""
    start = found.start(1) if found else build.at
    line = data[start : start + 200].splitlines()[:1]
    if not word or (_BLANK.match(data, found.end() if found else build.at) and build.names):
        return build.error("the file ends inside the hierarchy", wanted)
    about = f" in {build.called(build.stack[-1])}" if build.stack else ""
    shown = text_of(line[0].strip())[:60] if line else ""
    return build.error(f"{shown!r}{about}", _WANTED.get(word.upper(), wanted))


def _finished(build: _Builder) -> Hierarchy:
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
    joints = range(len(build.names))
    return Hierarchy(
        tuple(build.names),
        tuple(build.parents),
        tuple([build.offsets[joint] for joint in joints]),
        tuple([build.channels.get(joint, ()) for joint in joints]),
        frozenset(build.ends),
    )
