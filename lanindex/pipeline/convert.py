"""A motion in another format than it came in."""

from __future__ import annotations

import importlib
from dataclasses import replace
from pathlib import PurePath

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import UsageError, shown
from lanindex.model import Markers, Motion, Span

TARGETS = {
    "bvh": "bvh",
    "glb": "gltf",
    "c3d": "c3d",
    "trc": "trc",
    "csv": "table",
    "npz": "npy",
}
"""Formats that any motion can be written in, and where each is written in `lanindex.formats`."""

ANIMATED = ("bvh", "glb")
"""Those that hold one skeleton, and no unknown places."""


_NEAREST = {"npy": "npz", "gltf": "glb"}


def nearest(form: str) -> str:
    """Return the format in which a motion that came in some other is written anew."""
    found = _NEAREST.get(form, form)
    return found if found in TARGETS else "bvh"


def target_of(path: str, told: str | None = None) -> str:
    """Return the format that a file is to be written in, by its ending.

    Raises
    ------
    UsageError
        Nothing is written in it.

    Examples
    --------
    >>> from lanindex.pipeline.convert import target_of
    >>> target_of("walk.bvh"), target_of("walk", "c3d")
    ('bvh', 'c3d')
    """
    form = told or PurePath(path).suffix.lower().removeprefix(".")
    if form not in (*TARGETS, "lnd"):
        raise UsageError(
            f'"{shown(form)}" of {shown(path)}' if form else f"{shown(path)} has no ending",
            wanted=f"one of {', '.join((*TARGETS, 'lnd'))}",
        )
    return form


def written(motion: Motion, form: str) -> tuple[bytes, tuple[str, ...]]:
    """Return a motion as a file, and what there is to say of it.

    Parameters
    ----------
    motion : Motion
        Any.
    form : str
        Of `TARGETS`.

    Raises
    ------
    ExportError
        The format cannot hold it.
    """
    said: tuple[str, ...] = ()
    if form in ANIMATED:
        from lanindex.formats.whole import whole

        made = whole(motion)
        said, motion = made.warnings[len(motion.warnings) :], made
    content: bytes = importlib.import_module(f"lanindex.formats.{TARGETS[form]}").write(motion)
    return content, said


def stretch(motion: Motion, span: Span) -> Motion:
    """Return some frames of a motion."""
    frames = slice(span.start, span.stop)
    markers, turns = motion.markers, motion.rotations
    return replace(
        motion,
        positions=motion.positions[frames],
        first=max(motion.first - span.start, 0),
        rotations=None if turns is None else turns[frames],
        markers=None if markers is None else Markers(markers.names, markers.positions[frames]),
        axes={joint: axes[frames] for joint, axes in motion.axes.items()},
    )


def from_origin(motion: Motion) -> Motion:
    """Return a motion that begins above the floor's origin, facing +z, its lowest foot at 0.

    The turn is that of the hips in the first frame (``encode/METHOD.md``, stage 1).
    """
    from lanindex.encode.heading import heading
    from lanindex.encode.joints import body

    joints = body(motion)
    middle = next(
        (joints[name] for name in ("Pelvis", "Chest", "Neck") if _known(joints[name]).any()),
        joints.places[:, 0],
    )
    known = np.flatnonzero(_known(middle)[motion.first :])
    first = motion.first + (int(known[0]) if len(known) else 0)
    turn = -float(heading(motion, motion.rate)[first]) - np.pi / 2
    cos, sin = np.cos(turn), np.sin(turn)
    ring = np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])
    start = np.array([middle[first, 0], np.nanmin(joints.places[..., 1]), middle[first, 2]])

    def moved(places: NDArray[np.float32]) -> NDArray[np.float32]:
        found: NDArray[np.float32] = ((places - start) @ ring.T).astype(np.float32)
        return found

    markers = motion.markers
    return replace(
        motion,
        positions=moved(motion.positions),
        rotations=None if motion.rotations is None else _turned(motion.rotations, turn),
        markers=None if markers is None else Markers(markers.names, moved(markers.positions)),
        axes={joint: (it @ ring.T).astype(np.float32) for joint, it in motion.axes.items()},
    )


def _known(places: NDArray[np.float64]) -> NDArray[np.bool_]:
    known: NDArray[np.bool_] = np.asarray(np.isfinite(places).all(axis=1))
    return known


def _turned(rotations: NDArray[np.float32], turn: float) -> NDArray[np.float32]:
    """Return rotations after a turn about the vertical, in radians."""
    w, x, y, z = np.moveaxis(rotations, -1, 0)
    cos, sin = np.cos(turn / 2), np.sin(turn / 2)
    turned = (cos * w - sin * y, cos * x + sin * z, cos * y + sin * w, cos * z - sin * x)
    return np.stack(turned, axis=-1).astype(np.float32)
