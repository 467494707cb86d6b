"""A motion in another format than it came in."""

import importlib
from dataclasses import replace
from pathlib import Path, PurePath

import numpy as np
from numpy.typing import NDArray

from lanindex import formats
from lanindex.errors import UsageError, shown
from lanindex.model import Markers, Motion, Reading, Score, Span
from lanindex.notation import WRITTEN, content_of, notation_of, read, write

TARGETS = {
    "bvh": "bvh",
    "glb": "gltf",
    "c3d": "c3d",
    "trc": "trc",
    "csv": "point_tables",
    "npz": "npy",
}
"""Formats that any motion can be written in, and where each is written in `lanindex.formats`."""

BIDS = "bids"
"""The format that is written in several files: `lanindex.formats.bids.files`."""

ANIMATED = ("bvh", "glb")
"""Those that hold one skeleton, and no unknown places."""


_NEAREST = {"npy": "npz", "gltf": "glb", "bids": "csv"}


def nearest(form: str) -> str:
    """Return the format in which a motion that came in some other is written anew."""
    found = _NEAREST.get(form, form)
    return found if found in TARGETS else "bvh"


def target_of(path: str, format_given: str | None = None) -> str:
    """Return the format that a file is to be written in, by its ending."""
    notation = notation_of(path)
    ending = notation.name if notation else PurePath(path).suffix.lower().removeprefix(".")
    form = format_given or (BIDS if path.lower().endswith("_motion.tsv") else ending)
    if form not in (*TARGETS, BIDS, *WRITTEN):
        raise UsageError(
            f'"{shown(form)}" of {shown(path)}' if form else f"{shown(path)} has no ending",
            wanted=f"one of {', '.join((*TARGETS, BIDS, *WRITTEN))}",
        )
    return form


def motion_of(
    file: str, reading: Reading, *, origin: bool = False, body_only: bool = False
) -> Motion:
    """Read a capture, as it is or from the floor's origin on."""
    if notation_of(file):
        wanted = f"one of {', '.join(WRITTEN)}"
        remedy = f"Let it be carried out: lanindex animate {file}"
        raise UsageError("a score", place=file, wanted=wanted, remedy=remedy)
    motion = formats.read_file(formats.opened(file), reading, formats.Wanted(body_only=body_only))
    return from_origin(motion) if origin else motion


def score_of(file: str, reading: Reading, profile: str, *, origin: bool = False) -> Score:
    """Read a score, or write a capture down; its warnings are those of both."""
    if notation_of(file):
        if reading.tempo is not None:
            raise UsageError("beats for a score", place="--tempo", wanted="a capture")
        return read(file)
    from lanindex.encoding import encode

    motion = motion_of(file, reading, origin=origin, body_only=True)
    score = encode(motion, profile, tempo=reading.tempo)
    return replace(score, warnings=(*motion.warnings, *score.warnings))


def files_of(
    motion: Motion, form: str, target: Path
) -> tuple[list[tuple[Path, bytes]], tuple[str, ...]]:
    """Return the files that a motion is written in, and what there is to say of them."""
    if form == BIDS:
        from lanindex.formats import bids

        return list(bids.files(motion, target)), ()
    content, warnings = file_content(motion, form)
    return [(target, content)], warnings


def file_content(motion: Motion, form: str) -> tuple[bytes, tuple[str, ...]]:
    """Return a motion as a file, and what there is to say of it."""
    warnings: tuple[str, ...] = ()
    if form in ANIMATED:
        from lanindex.formats.animation import complete

        made = complete(motion)
        warnings, motion = made.warnings[len(motion.warnings) :], made
    content: bytes = importlib.import_module(f"lanindex.formats.{TARGETS[form]}").write(motion)
    return content, warnings


def notated(
    score: Score,
    form: str,
    into: Path | None = None,
    *,
    force: bool = False,
    media: Path | None = None,
) -> bytes:
    """Return a score as a file, or a file with a score more."""
    if form != "eaf":
        if into or media:
            place = "--into" if into else "--media"
            raise UsageError(f"a score in {form}", place=place, wanted="--to eaf")
        return write(score, form)
    from lanindex.notation import eaf

    content = content_of(str(into)) if into else None
    return eaf.write(score, into=content, place=str(into), force=force, media=media)


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

    The turn is that of the hips in the first frame (``encoding/METHOD.md``, stage 1).
    """
    from lanindex.encoding.joints import body
    from lanindex.encoding.limbs import heading

    joints = body(motion)
    middle = next(
        (joints[name] for name in ("Pelvis", "Chest", "Neck") if _is_known(joints[name]).any()),
        joints.places[:, 0],
    )
    known = np.flatnonzero(_is_known(middle)[motion.first :])
    first = motion.first + (int(known[0]) if len(known) else 0)
    turn = -float(heading(motion, motion.rate)[first]) - np.pi / 2
    cos, sin = np.cos(turn), np.sin(turn)
    ring = np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])
    start = np.array([middle[first, 0], np.nanmin(joints.places[..., 1]), middle[first, 2]])

    def moved(places: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.asarray((places - start) @ ring.T, np.float32)

    markers = motion.markers
    return replace(
        motion,
        positions=moved(motion.positions),
        rotations=None if motion.rotations is None else _turn_rotations(motion.rotations, turn),
        markers=None if markers is None else Markers(markers.names, moved(markers.positions)),
        axes={joint: (it @ ring.T).astype(np.float32) for joint, it in motion.axes.items()},
    )


def _is_known(places: NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.asarray(np.isfinite(places).all(axis=1))


def _turn_rotations(rotations: NDArray[np.float32], turn: float) -> NDArray[np.float32]:
    """Return rotations after a turn about the vertical, in radians."""
    w, x, y, z = np.moveaxis(rotations, -1, 0)
    cos, sin = np.cos(turn / 2), np.sin(turn / 2)
    turned = (cos * w - sin * y, cos * x + sin * z, cos * y + sin * w, cos * z - sin * x)
    return np.stack(turned, axis=-1).astype(np.float32)
