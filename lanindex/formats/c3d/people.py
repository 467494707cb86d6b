"""Whose points a C3D file holds: subjects, told by what stands before the names of points."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from lanindex.body.markers import making_of
from lanindex.formats.c3d.layout import Layout, scan
from lanindex.formats.people import named

if TYPE_CHECKING:
    from lanindex.formats.file import File

NO_PLACES = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS")
"""Lists of POINT that name points which are no places, but what a model tells of the body."""

_PLACES = {"MODELED_MARKER", "MARKER", "VIRTUAL_MARKER"}
TURNED = "_4X4"
"""Ends the name of a segment."""


def names_of(layout: Layout) -> dict[int, str]:
    """Return the names of the points that are places, by their number in a frame.

    A point that has no name is called by its number, a segment without what ends its name.
    """
    told = layout.parameters
    if layout.segments:
        called = told.texts("ROTATION:LABELS")
        return {number: name.removesuffix(TURNED)
                for number, name in enumerate(_all(called, layout.segments.count))}  # fmt: skip
    groups = told.texts("POINT:TYPE_GROUPS")
    listed = [group.upper() for group, kind in zip(groups[::2], groups[1::2], strict=False)
              if kind.upper() not in _PLACES]  # fmt: skip
    lists = dict.fromkeys((*NO_PLACES, *listed))
    outputs = {name for one in lists for name in told.texts(f"POINT:{one}")}
    points = _all(told.texts("POINT:LABELS"), layout.points)
    return {number: name for number, name in enumerate(points) if name not in outputs}


def _all(called: tuple[str, ...], count: int) -> list[str]:
    """Return as many names as there are points: what is named beyond them is not stored."""
    named = [name or f"*{number}" for number, name in enumerate(called[:count], 1)]
    return named + [f"*{number}" for number in range(len(named) + 1, count + 1)]


def people(layout: Layout, names: Mapping[int, str]) -> dict[str, dict[int, str]]:
    """Return the points of each subject that makes a body."""
    told = layout.parameters
    called = told.texts("SUBJECTS:NAMES")
    before = told.texts("SUBJECTS:LABEL_PREFIXES")
    subject = {prefix: name for prefix, name in zip(before, called, strict=False) if prefix}
    groups: dict[str, dict[int, str]] = {}
    for number, name in names.items():
        prefix = next((it for it in subject if name.startswith(it)), None)
        if prefix is None:
            prefix = name[: name.rfind(":") + 1]
        groups.setdefault(prefix, {})[number] = name
    found: dict[str, dict[int, str]] = {}
    for prefix, points in groups.items():
        bare = {number: name.removeprefix(prefix) for number, name in points.items()}
        if making_of(tuple(bare.values())):
            alone = called[0] if not prefix and len(called) == 1 else ""
            name = subject.get(prefix, prefix.rstrip(":")) or alone
            name = f"{name} {len(found) + 1}".strip() if name in found else name
            found[name] = points if prefix.endswith(":") else bare
    return named(found)


def subjects(file: File) -> tuple[str, ...]:
    """Return the names of the people that a file holds; none where nobody is named."""
    layout = file.once(scan)
    return tuple(name for name in people(layout, names_of(layout)) if name)
