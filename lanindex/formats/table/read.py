"""Tables → Motion, whosesoever they are, and clips of them."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.body.by_name import LIMBS, candidates
from lanindex.body.markers import marker_set_of
from lanindex.formats import tables
from lanindex.formats.file import File, Wanted, clip
from lanindex.formats.people import named, subject_points
from lanindex.formats.points import Points, motion_of
from lanindex.formats.rates import rate_by
from lanindex.formats.table.kinds import given_layout, layout_of
from lanindex.formats.tables import TableLayout, twice
from lanindex.model import Motion, Reading, Span

_TICKS = (("seconds", 1.0), ("milliseconds", 1e-3), ("microseconds", 1e-6),
          ("units of 100 ns", 1e-7), ("nanoseconds", 1e-9))  # fmt: skip
_USUAL = (0.002, 0.2)  # seconds between frames


def read(file: File, options: Reading, wanted: Wanted) -> Motion:
    """Read a table of points: see `lanindex.formats.read_file`.

    Joints as the table has them, or made of its markers; of several subjects the one that is
    meant, else the first.
    """
    layout = _layout(file, options)
    every = list(range(len(layout.names)))
    chosen, whose = subject_points(file, people(layout.names), every)
    heads, places = tables.read(file, layout.table)
    places = layout.finish(places) if layout.finish else places
    if layout.states is not None:
        places[heads[:, layout.states :] == 0] = np.nan
    names = tuple(layout.names[number] for number in chosen)
    places = places if len(chosen) == len(layout.names) else places[:, chosen]
    gone, places = tables.at_origin(places, names)
    times, unsure = _seconds(layout, heads)
    rate, doubts = rate_by(options, layout.rate, times, file.name)
    unsure = unsure if options.rate is None else ()
    doubts = (*layout.doubts, *twice(names, "points"), *whose, *unsure, *doubts, *gone)
    return motion_of(
        Points(names, places, rate, layout.declared, doubts=doubts), file, "csv", options, wanted
    )


def _seconds(
    layout: TableLayout, heads: NDArray[np.float64]
) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """Return the times in seconds; where their unit is unknown, in the usual one."""
    if layout.time is None:
        return np.zeros(0), ()
    times = heads[:, layout.time]
    if layout.tick is not None:
        return times * layout.tick, ()
    steps = np.diff(times)
    steps = steps[np.isfinite(steps)]
    step = float(np.median(steps)) if len(steps) else 0.0
    for name, tick in _TICKS:
        if _USUAL[0] <= step * tick <= _USUAL[1]:
            doubt = () if tick == 1 else (f"its times are taken for {name}",)
            return (times - times[0]) * tick, doubt
    return times, ()


def people(names: tuple[str, ...]) -> dict[str, list[int]]:
    """Return the points of each subject that makes a body, by what stands before a colon."""
    groups: dict[str, list[int]] = {}
    for number, name in enumerate(names):
        groups.setdefault(name.rpartition(":")[0], []).append(number)
    found = {
        subject: points
        for subject, points in groups.items()
        if _makes_body(tuple(names[number].rpartition(":")[2] for number in points))
    }
    return named(found)


def _makes_body(names: tuple[str, ...]) -> bool:
    """Tell whether points are enough of a body: of a known set of markers, or named as limbs."""
    if marker_set_of(names):
        return True
    found: Any = candidates(names)
    return any(
        all(found["limbs", side, joint] for side in "RL" for joint in limb) for limb in LIMBS
    )


def subjects(file: File) -> tuple[str, ...]:
    """Return the names of the people that a file holds; none where nobody is named."""
    return tuple(name for name in people(file.once(layout_of).names) if name)


def _layout(file: File, options: Reading | None) -> TableLayout:
    named = options.columns if options else None
    return given_layout(file, named) if named else file.once(layout_of)


def cutter(file: File, options: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of a table, which is looked through once.

    Header and rows are the source's, byte for byte; of several blocks the one that is read.
    """
    rows = _layout(file, options).table.lines
    head = 0, int(rows[0, 0])
    return lambda span: clip(
        file.content, (head, (int(rows[span.start, 0]), int(rows[span.stop - 1, 1])))
    )


def write(motion: Motion) -> bytes:
    """Write a motion as CSV: ``frame,time,<name>_x,<name>_y,<name>_z``, millimetres, y up.

    Frames count from 0, times are seconds; the points are its markers, or else its joints; what is
    unknown is left blank.
    """
    names, places = tables.points_of(motion)
    names = tuple(re.sub(r'[,;"\s]+', " ", name).strip() or "point" for name in names)
    out = io.StringIO()
    columns = [f"{name}_{axis}" for name in names for axis in "xyz"]
    out.write(",".join(("frame", "time", *columns)) + "\n")
    form = "%d,%.7f" + ",%.4f" * (3 * len(names)) + "\n"
    seconds = (np.arange(len(motion)) / float(motion.rate)).tolist()
    for frame, (time, row) in enumerate(zip(seconds, places, strict=True)):
        out.write((form % (frame, time, *row.ravel().tolist())).replace("nan", ""))
    return out.getvalue().encode()
