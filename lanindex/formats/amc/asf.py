"""The skeleton of an Acclaim capture: an ASF file.

Source: J. Lander, "Working with motion capture file formats", *Game Developer*, January 1998;
the captures of mocap.cs.cmu.edu.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import PurePath
from typing import NamedTuple

from lanindex.errors import CaptureError
from lanindex.formats import archives
from lanindex.formats.decimals import LARGEST
from lanindex.formats.file import File, opened, siblings, text_of
from lanindex.model import Reading

MOST_BONES = 1000
"""More than any body has."""

LARGEST_FILE = 16 << 20
"""Bytes; a skeleton has a few thousand."""

ROOT = b"root"

_TURNS = {"RX": 0, "RY": 1, "RZ": 2}
_CHANNELS = {**_TURNS, "TX": 3, "TY": 4, "TZ": 5}
_AXES = {"X": 0, "Y": 1, "Z": 2}
_TURNED = "the root of its skeleton is turned at rest: taken for the axes that it turns about"

Vector = tuple[float, ...]


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
        said = text_of(b" ".join(self.words))
        return CaptureError(f"{said[:40]!r}", place=self.place, wanted=wanted)

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


@dataclass(slots=True)
class _Sections:
    units: Fields = field(default_factory=dict)
    root: Fields = field(default_factory=dict)
    bones: list[Fields] = field(default_factory=list)
    hierarchy: list[_Line] = field(default_factory=list)


def parse(file: File) -> Bones:
    """Read a skeleton."""
    if len(file.content) > LARGEST_FILE:
        found = f"a skeleton of {len(file.content)} bytes"
        raise CaptureError(found, place=file.name, wanted=f"at most {LARGEST_FILE}")
    sections = _sections(file)
    units, root = sections.units, sections.root
    degrees = True
    if b"angle" in units:
        said = "".join(units[b"angle"].rest(1)).lower()[:3]
        if said not in ("deg", "rad"):
            raise units[b"angle"].error("angle deg or angle rad")
        degrees = said == "deg"
    top = _root(root)
    bones = {ROOT: top}
    for fields in sections.bones:
        bone = _bone(fields)
        if bone.name in bones:
            raise fields[b"name"].error("a name of its own")
        bones[bone.name] = bone
    return Bones(
        _hung(bones, sections.hierarchy, file.name),
        units[b"length"].numbers(1)[0] if b"length" in units else 0.0,
        degrees,
        (_TURNED,) if any(top.axis) else (),
    )


def _sections(file: File) -> _Sections:
    """Sort lines into what they are about; a line with a colon in front begins the next part."""
    data = file.content[:].removeprefix(b"\xef\xbb\xbf")
    sections, section, fields = _Sections(), b"", None
    line = _Line(f"{file.name}:1", [])
    for number, text in enumerate(data.splitlines(), 1):
        words = text.split()
        if not words or words[0].startswith(b"#"):
            continue
        line = _Line(f"{file.name}:{number}", words)
        key = words[0].lower()
        if key.startswith(b":"):
            section = key
        elif section == b":units":
            sections.units[key] = line
        elif section == b":root":
            sections.root[key] = line
        elif section == b":hierarchy" and key not in (b"begin", b"end"):
            sections.hierarchy.append(line)
        elif section == b":bonedata" and key == b"begin":
            fields = {key: line}
            sections.bones.append(fields)
        elif section == b":bonedata" and fields is not None:
            fields[key] = line
        elif not section:
            raise line.error("an ASF file, which begins with :version")
    if not sections.bones or not sections.hierarchy:
        part = ":hierarchy" if sections.bones else ":bonedata"
        raise CaptureError(
            f"ends without {part}", place=line.place, wanted=":root, :bonedata and :hierarchy"
        )
    if len(sections.bones) > MOST_BONES:
        found = f"{len(sections.bones)} bones"
        raise CaptureError(found, place=file.name, wanted=f"at most {MOST_BONES}, a body's")
    return sections


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


def _hung(bones: dict[bytes, Bone], lines: list[_Line], path: str) -> tuple[Bone, ...]:
    """Return bones, parents before children, as the hierarchy hangs them."""
    children: dict[bytes, list[bytes]] = {}
    above: set[bytes] = set()
    for line in lines:
        parent, *names = line.words
        for name in line.words:
            if name not in bones:
                raise line.error(f"bones of :bonedata, {text_of(name)[:40]!r} is none")
        for name in names:
            if name in above or name == ROOT:
                raise line.error(f"{text_of(name)[:40]} below one other")
            above.add(name)
        children.setdefault(parent, []).extend(names)
    ordered: list[Bone] = []
    waiting = [(ROOT, -1)]
    while waiting:
        name, parent_index = waiting.pop()
        bones[name].parent = parent_index
        waiting += [(child, len(ordered)) for child in reversed(children.get(name, []))]
        ordered.append(bones[name])
    hung = {bone.name for bone in ordered}
    loose = [name for name in bones if name not in hung]
    if loose:
        found = f"{text_of(loose[0])[:40]!r} hangs on nothing"
        raise CaptureError(found, place=path, wanted="all bones below root")
    return tuple(ordered)


_ENDING = ".asf"
_MOST_STEMS = 8


def skeleton_of(file: File, options: Reading) -> tuple[File, tuple[str, ...]]:
    """Return the skeleton of a motion, and what is doubtful about it."""
    if options.skeleton is not None:
        return opened(options.skeleton), ()
    stems = _stems(PurePath(file.name).stem)
    any_name = os.path.join(os.path.dirname(file.name), "_")
    found = _skeletons(any_name, _changed(any_name))
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


def _stems(stem: str) -> list[str]:
    """Return what a skeleton may be called: as its motion, or that up to an underscore."""
    words = stem.split("_")
    begun = ("_".join(words[:count]) for count in range(len(words) - 1, 0, -1))
    return [stem, *[name for name in begun if name][:_MOST_STEMS]]


def _changed(path: str) -> int:
    """Return when what holds a file was changed: its folder, or its archive."""
    with suppress(OSError, ValueError):
        return os.stat(archives.split(path)[0] or os.path.dirname(path) or ".").st_mtime_ns
    return 0


@lru_cache(maxsize=64)
def _skeletons(path: str, changed: int) -> Mapping[str, str]:
    """Return the skeletons beside a file, by name: looked for once, however many files ask."""
    paths = siblings(path, _ENDING)
    names = [(PurePath(path).stem, path) for path in paths]
    return {**{name.lower(): path for name, path in reversed(names)}, **dict(names)}
