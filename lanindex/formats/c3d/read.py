"""C3D: points and what the file says of itself → Motion."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np

from lanindex.body.markers import making_of
from lanindex.body.understand import Stated
from lanindex.errors import CaptureError, quoted
from lanindex.formats.c3d.layout import Layout, scan
from lanindex.formats.c3d.people import names_of, people
from lanindex.formats.c3d.places import places
from lanindex.formats.file import File, Wanted
from lanindex.formats.points import Points, motion_of
from lanindex.formats.rates import nearest_rate, told_rate
from lanindex.model import Motion, Reading

_SLOWEST = 1


def read(file: File, told: Reading, wanted: Wanted) -> Motion:
    """Read a C3D file: see `lanindex.formats.read_file`.

    Points that are no places, as a model's angles and forces are, are left out. Of several
    subjects the one is read that the file's name tells behind ``#``, else the first that makes a
    body.

    Joints made of markers or, where the points are joints, these; of a file that has only
    the rotations of segments, these where each begins.
    """
    layout = file.once(scan)
    rate = _rate(file, layout, told)
    names, doubts = _chosen(file, layout)
    used = _needed(names) if wanted.body_only and not told.body else names
    if len(used) < layout.points or layout.segments:
        there = places(file.content, layout, np.array(list(used), np.int64))
    else:
        there = places(file.content, layout)
    doubts = (*layout.doubts, *layout.parameters.doubts, *doubts)
    points = Points(tuple(used.values()), there, rate, _stated(layout), doubts=doubts)
    motion = motion_of(points, file, "c3d", told, wanted)
    if used is names:
        return motion
    return replace(motion, source=replace(motion.source, joints=tuple(names.values())))


def _rate(file: File, layout: Layout, told: Reading) -> Fraction:
    if told.rate is not None:
        return told_rate(told.rate)
    if layout.rate is None or not _SLOWEST <= layout.rate <= 1e6:
        raise CaptureError(
            "says no rate" if layout.rate is None else f"a rate of {layout.rate:g}",
            place=file.name,
            wanted=f"{_SLOWEST} or more frames a second",
            remedy="Give the rate with --fps.",
        )
    return nearest_rate(Fraction(layout.rate).limit_denominator(10**6))


def _chosen(file: File, layout: Layout) -> tuple[dict[int, str], tuple[str, ...]]:
    """Return the points of one subject by their numbers, and who else there is."""
    names = names_of(layout)
    found = people(layout, names)
    if file.subject:
        if file.subject not in found:
            raise CaptureError(
                f"has no subject {quoted(file.subject)} that makes a body",
                place=file.name,
                wanted=" or ".join(filter(None, found)) or "none: its subjects have no names",
            )
        return found[file.subject], ()
    if len(found) < 2:
        return next(iter(found.values()), names), ()
    first, *others = found
    doubt = f"{first or 'the first subject'} is read; it holds also {', '.join(others)}"
    return found[first], (doubt,)


def _needed(names: dict[int, str]) -> dict[int, str]:
    """Return the points that the joints of the body are made of; all where it is not made."""
    numbers = list(names)
    made = making_of(tuple(names.values()))
    if made is None:
        return names
    used = {numbers[it]: names[numbers[it]] for it in sorted(made.used)}
    again = making_of(tuple(used.values()))
    same = again is not None and again.told(tuple(used.values())) == made.told(
        tuple(names.values())
    )
    return used if same else names


def _stated(layout: Layout) -> Stated:
    """Return unit and vertical axis, as far as the file tells them."""
    told = layout.parameters
    unit = next(iter(told.texts("POINT:UNITS")), "") or None
    screen = next(iter(told.texts("POINT:Y_SCREEN")), "").lower()
    up = screen.removeprefix("+") if screen.strip("+-") in ("x", "y", "z") else None
    return Stated(unit, up)
