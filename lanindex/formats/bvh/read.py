"""BVH: hierarchy and channels → Motion, a block of frames at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES
from lanindex.body import body_of, map_body, sampled
from lanindex.body.by_name import exporter_of
from lanindex.body.calibration import BEGINNING
from lanindex.body.facing import TURNING, rest_axes, seen_axes
from lanindex.body.kinematics import Plan, aimed, plan
from lanindex.body.kinematics import positions as positions_of
from lanindex.body.palms import measured, rest_palms
from lanindex.errors import CaptureError
from lanindex.formats.bvh.layout import BvhLayout, scan
from lanindex.formats.file import File, Wanted, holding, line_of
from lanindex.formats.rates import rate_doubt, rate_of
from lanindex.formats.tables import fault, number_rows
from lanindex.model import Motion, Reading, Skeleton, Source

BLOCK = 4096
"""Frames whose numbers are held at a time."""

Floats = NDArray[np.float64]


def read(file: File, options: Reading, wanted: Wanted) -> Motion:
    """Read a BVH file: see `lanindex.formats.read_file`.

    Every joint and End Site, or those of the body.
    """
    path, layout = file.name, scan(file.content, file.name)
    place = f"{path}:{line_of(file.content, layout.time_line[0])}"
    rate = rate_of(layout.time, place, options.rate)
    joints = layout.hierarchy
    order, reason = _order(options.compose, joints.names)
    work = plan(joints.parents, joints.offsets, joints.channels, order == "child")
    frames = _Frames(file, layout, work)
    values, poses, first = frames.looked_at()
    found = map_body(joints.names, joints.parents, poses, first, rate, options, path)
    offsets = found.oriented(np.array(joints.offsets, np.float64))
    skeleton = Skeleton(joints.names, np.array(joints.parents, np.int16), offsets, found.body)
    kept = None
    if wanted.body_only:
        kept, skeleton = body_of(skeleton)
    positions = np.empty((len(layout.frames), len(skeleton.names), 3), np.float32)
    turning = _turning(frames, values, poses, found.body)
    axes = {name: np.empty((len(positions), 2, 3), np.float32) for name in turning}
    for start, values, places in frames.blocks():
        part = slice(start, start + len(places))
        found.oriented(places, positions[part], kept)
        for name, own in turning.items():
            axes[name][part] = found.turned(positions_of(own, values)[:, -2:])
    source = Source(
        path,
        "bvh",
        found.unit,
        found.scale,
        found.up,
        compose=f"{order} first ({reason})",
        joints=joints.names,
    )
    axes, made_up = measured(axes, positions, skeleton.body)
    doubts = (*_count_doubt(layout), *rate_doubt(rate), *found.doubts, *made_up)
    return Motion(skeleton, rate, positions, source, found.first, doubts, axes=axes)


def _turning(
    frames: _Frames, values: Floats, poses: Floats, body: NDArray[np.int16]
) -> dict[str, Plan]:
    """Return what tells the axes of joints, if at rest or as seen in some poses they are known."""
    work, joints = frames.work, frames.layout.hierarchy
    if exporter_of(joints.names).get("turns") == "bones":
        return {}

    def turned(joint: int) -> Floats:
        own = aimed(work, joints.channels, joint, np.eye(3))
        return np.swapaxes(positions_of(own, values)[:, -3:], 1, 2)

    known = rest_palms(joints.names, joints.parents, joints.offsets, body)
    played = {name: int(body[JOINT_CODES[name]]) for name in TURNING}
    if min(played.values()) >= 0:
        rest = rest_axes(joints.parents, joints.offsets, body)
        if rest is None:
            rest = seen_axes(joints.parents, body, poses, turned)
        known |= {name: (joint, rest) for name, joint in played.items() if rest is not None}
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
    kept: tuple[Floats, Floats] | None = None

    def looked_at(self) -> tuple[Floats, Floats, Floats]:
        """Return numbers and poses that tell the body, (S, C), (S, J, 3), and the first frames."""
        count = len(self.layout.frames)
        if count <= BLOCK:
            self.kept = self._places(0, count)
            values, places = (some[sampled(count)] for some in self.kept)
            return values, places, self.kept[1][:BEGINNING]
        chosen = np.unique(np.append(sampled(count), np.arange(BEGINNING)))
        lines = self.layout.frames[chosen]
        values, bad = self._numbers(
            b"".join(self.file.content[first:stop] for first, stop in lines.tolist()),
            _side_by_side(lines),
        )
        if bad is not None:
            for _ in self.blocks():  # says which frame is the first that is damaged
                pass
        places, those = positions_of(self.work, values), sampled(count)
        those = np.searchsorted(chosen, those)
        return values[those], places[those], places[:BEGINNING]

    def blocks(self) -> Iterator[tuple[int, Floats, Floats]]:
        """Yield blocks: the first frame, the numbers (T, C), and the places (T, J, 3) they tell."""
        if self.kept is not None:
            yield 0, *self.kept
            return
        for start in range(0, len(self.layout.frames), BLOCK):
            yield start, *self._places(start, start + BLOCK)

    def _places(self, start: int, stop: int) -> tuple[Floats, Floats]:
        """Read some frames, or say which of them is damaged and how."""
        lines = self.layout.frames[start:stop]
        data, begin = holding(self.file.content, int(lines[0, 0]), int(lines[-1, 1]))
        values, bad = self._numbers(data, lines - begin)
        if bad is None:
            return values, positions_of(self.work, values)
        first, last = lines[bad].tolist()
        line, width = data[first - begin : last - begin], self.layout.hierarchy.width
        found, wanted = fault(line, width)
        cut = start + bad == len(self.layout.frames) - 1 and bool(line.strip())
        short = len(line.split()) <= width
        raise CaptureError(
            f"frame {start + bad} {found}",
            place=f"{self.file.name}:{line_of(self.file.content, first)}",
            wanted=wanted,
            remedy="It is the last line: the file may be cut short." if cut and short else "",
        )

    def _numbers(self, data: bytes, lines: NDArray[np.int64]) -> tuple[Floats, int | None]:
        return number_rows(data, lines, self.layout.hierarchy.width)


def _side_by_side(lines: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return where lines (T, 2) lie once they are put together without their ends."""
    stops = np.cumsum(lines[:, 1] - lines[:, 0])
    return np.stack((np.append(0, stops[:-1]), stops), axis=1)


def _count_doubt(layout: BvhLayout) -> tuple[str, ...]:
    if layout.declared == len(layout.frames):
        return ()
    return (f"Frames: says {layout.declared}, the file has {len(layout.frames)}",)
