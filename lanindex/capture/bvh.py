"""BVH: hierarchy and channels → Motion."""

from __future__ import annotations

import sys
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES
from lanindex.capture import calibration, floats, kinematics
from lanindex.capture.bvh_hierarchy import line_of
from lanindex.capture.bvh_layout import Layout, scan
from lanindex.capture.joint_names import exporter_of
from lanindex.capture.skeleton import Rig, find_body
from lanindex.errors import CaptureError, UsageError
from lanindex.model import Motion, Skeleton, Source

_POSES = 32
_WORTH_COMPILING = 4_000_000
"""Bytes read so far in this process; from then on numba's import (half a second) is risked."""
COMPOSE = ("parent", "child")

_bytes_read = 0


def read(
    data: bytes,
    path: str = "",
    *,
    unit: str | None = None,
    up: str | None = None,
    rate: Fraction | float | str | None = None,
    compose: str | None = None,
) -> Motion:
    """Read a BVH file.

    Parameters
    ----------
    data : bytes
        Its content.
    path : str
        Its name.
    unit, up, rate, compose
        See `lanindex.capture.read`.

    Returns
    -------
    Motion
        Every joint and End Site.

    Raises
    ------
    CaptureError
        The file is damaged; names the line.
    BodyError
        It holds no human skeleton.
    """
    if compose not in (None, *COMPOSE):
        raise UsageError(f"compose {compose!r}", wanted="parent or child")
    layout = scan(data, path)
    place = f"{path}:{line_of(data, layout.time_line[0])}"
    hertz = calibration.rate_of(layout.time, place, rate)
    joints = layout.hierarchy
    order = compose or exporter_of(joints.names).get("compose", "parent")
    reading, moving = _modules(len(data))
    values = _values(reading, data, path, layout)
    work = kinematics.plan(joints.parents, joints.offsets, joints.channels, order == "child")
    places: NDArray[np.float64] = moving.positions(work, values)

    poses = places[np.linspace(0, len(places) - 1, min(len(places), _POSES)).astype(int)]
    body, shape_doubts = find_body(Rig(joints.names, joints.parents, poses), path)
    seen = np.where((body >= 0)[:, None], poses[:, body], np.nan)
    unit_name, scale, unit_doubts = calibration.unit_of(calibration.body_lengths(seen), unit)
    axis, up_doubts = calibration.up_of(seen, up)
    positions = _oriented(places, axis, scale)
    wrists = [int(body[JOINT_CODES[name]]) for name in ("RWrist", "LWrist")]
    wrists = [index for index in wrists if index >= 0]
    first = calibration.first_frame(positions[:2, wrists].tolist(), hertz)
    skeleton = Skeleton(
        joints.names,
        np.array(joints.parents, np.int16),
        _oriented(np.array(joints.offsets, np.float64), axis, scale),
        body,
    )
    source = Source(path, "bvh", unit_name, scale, axis, layout.frames, data)
    doubts = (
        *_count_doubt(layout),
        *calibration.rate_doubt(hertz),
        *shape_doubts,
        *unit_doubts,
        *up_doubts,
        *calibration.facing_doubt(seen, axis),
        *(["frame 0 is a calibration pose: frame 1 stands in for it"] if first else []),
    )
    return Motion(skeleton, hertz, positions, source, first, doubts)


def _oriented(places: NDArray[np.float64], up: str, scale: float) -> NDArray[np.float32]:
    """Turn to y up and scale to millimetres: (..., 3)."""
    result = np.empty(places.shape, np.float32)
    for axis, (source, sign) in enumerate(calibration.AXES[up]):
        np.multiply(places[..., source], sign * scale, out=result[..., axis], casting="same_kind")
    return result


def _values(reading: ModuleType, data: bytes, path: str, layout: Layout) -> NDArray[np.float64]:
    """Read the numbers, or say which frame is damaged and how."""
    width = layout.hierarchy.width
    parse_frames: Callable[..., tuple[NDArray[np.float64], int | None]] = reading.parse
    values, bad = parse_frames(data, layout.frames, width)
    if bad is None:
        return values
    start, stop = layout.frames[bad].tolist()
    found, wanted = floats.fault(data[start:stop], width)
    cut = bad == len(layout.frames) - 1 and bool(data[start:stop].strip())
    short = len(data[start:stop].split()) <= width
    raise CaptureError(
        f"frame {bad} {found}",
        place=f"{path}:{line_of(data, start)}",
        wanted=wanted,
        remedy="It is the last line: the file may be cut short." if cut and short else "",
    )


def _count_doubt(layout: Layout) -> tuple[str, ...]:
    if layout.declared == len(layout.frames):
        return ()
    return (f"Frames: says {layout.declared}, the file has {len(layout.frames)}",)


def _modules(size: int) -> tuple[ModuleType, ModuleType]:
    """Return the compiled modules, where there is numba and the work is worth its import."""
    global _bytes_read
    _bytes_read += size
    worth = "numba" in sys.modules or _bytes_read >= _WORTH_COMPILING
    return (_compiled() if worth else None) or (floats, kinematics)


@cache
def _compiled() -> tuple[ModuleType, ModuleType] | None:
    """Return the compiled modules; without numba, or a folder for its cache, there are none."""
    try:
        from lanindex.capture import floats_fast, kinematics_fast
    except (ImportError, RuntimeError):
        return None
    return floats_fast, kinematics_fast
