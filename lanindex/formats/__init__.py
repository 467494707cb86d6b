"""Capture files ↔ Motion: a table of formats, each known by a file's content.

A format is a module with

- ``read(file, options, wanted) -> Motion``,
- ``cutter(file, options) -> Cutter``, if clips can be cut out of its bytes, and
  ``beside(file, options)`` if a second file belongs to each,
- ``frames(wanted, count)``, if some frames can be read without all others: those that its motion
  has then, (T,) rising; more than are wanted where these alone do not tell what they are of,
- ``held(file)``, if it may hold more than a motion,
- ``subjects(file)``, if it may hold several people,
- ``companions(file, options)``, if it may be read with other files,
- ``write(motion) -> bytes``, if motions can be written in it,

and a line in `FORMATS`. Nothing else knows one format from another.
"""

from __future__ import annotations

import importlib
import os
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from lanindex import locations
from lanindex.errors import CaptureError
from lanindex.formats import archives, sniff
from lanindex.formats.file import SUBJECT
from lanindex.formats.file import File as File
from lanindex.formats.file import Wanted as Wanted
from lanindex.formats.file import opened as opened
from lanindex.formats.sniff import UNREAD, WITHOUT_PLACES, beginning, unread
from lanindex.notation import is_printed

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from lanindex.model import Motion, Reading, Span

Cutter = Callable[["Span"], bytes]
"""Gives the bytes of a clip: a stretch of one file, in its own format."""

COMPOSE = ("parent", "child")
"""Whose turn stands first."""

_HEAD = 4096
_TABLES = (".csv", ".tsv", ".txt")


@dataclass(frozen=True, slots=True)
class Format:
    """One kind of capture file."""

    name: str  # as the library and ``--format`` say it
    title: str  # as people say it
    suffixes: tuple[str, ...]  # endings by which a folder is searched, in small letters
    # whether a file's first bytes are of this format; None: it is known by its name alone
    sniff: Callable[[bytes], bool] | None
    module: str  # where in this folder it is read, cut and written; imported when needed
    # whether a file of such an ending is meant as a capture; else a folder's is looked into
    certain: bool = True
    # whether a file may hold several people: its module has ``subjects(file)``, their names
    several: bool = False
    # whether it may be read with other files: its module has ``companions(file, options)``
    joined: bool = False
    # whether a clip is cut without going through all of a file
    sought: bool = False

    def holds(self, name: str, head: bytes) -> bool:
        """Tell whether a file is of this format, by its name and its first bytes."""
        return self.sniff(head) if self.sniff else name.lower().endswith(self.suffixes)

    @property
    def does(self) -> Any:
        """The module, imported."""
        return importlib.import_module(f"lanindex.formats.{self.module}")


FORMATS: tuple[Format, ...] = (
    Format("bvh", "BVH", (".bvh",), sniff.bvh, "bvh"),
    Format("amc", "AMC", (".amc",), sniff.amc, "amc", joined=True),
    Format("c3d", "C3D", (".c3d",), sniff.c3d, "c3d", several=True, sought=True),
    Format("trc", "TRC", (".trc",), sniff.trc, "trc"),
    Format("mvnx", "MVNX", (".mvnx",), sniff.mvnx, "mvnx", several=True),
    Format("bids", "Motion-BIDS", ("_motion.tsv",), None, "bids", joined=True),
    Format("csv", "a table of points", _TABLES, sniff.table, "point_tables", False, True),
    Format("npy", "a NumPy array", (".npy",), sniff.npy, "npy", certain=False, sought=True),
    Format("npz", "NumPy arrays", (".npz",), sniff.npz, "npy", certain=False, sought=True),
    Format("gltf", "glTF", (".glb", ".gltf"), sniff.gltf, "gltf", several=True, joined=True),
    Format("fbx", "FBX", (".fbx",), sniff.fbx, "fbx", several=True),
)
"""All formats that are read."""

_ENDINGS = tuple(suffix for form in FORMATS for suffix in form.suffixes)
_SEVERAL = tuple(suffix for form in FORMATS if form.several for suffix in form.suffixes)


def known(file: File) -> Format:
    """Return the format that a file's content is of."""
    head = file.content[:_HEAD]
    if archives.is_archive(file.name) and locations.is_file(file.name):
        inside = archives.members(file.name)
        one = next((it for it in inside if it.lower().endswith(_ENDINGS)), next(iter(inside), ""))
        remedy = f"Name what is in it: {file.name}{archives.MARK}{one}" if one else ""
        raise CaptureError(
            f"an archive of {len(inside)} files", place=file.name, wanted="a capture", remedy=remedy
        )
    for form in FORMATS:
        if form.holds(file.name, head):
            return form
    *titles, last = dict.fromkeys(form.title for form in FORMATS)
    suffix = unread(file.name)
    found = f"its format, {UNREAD[suffix]}, is not read yet" if suffix else beginning(head)
    remedy = "If it is a table of points, say what its columns are with --columns."
    remedy = remedy if file.name.lower().endswith(_TABLES) else ""
    if suffix in WITHOUT_PLACES:
        found = f"{UNREAD[suffix]} holds angles, which tell no places without their model"
        remedy = "Read the TRC of the same take."
    if is_printed(file.name):
        found = "a picture or a PDF, which has no movement"
        remedy = f"If it is a printed score, read that: lanindex read-score {file.name}"
    wanted = f"{', '.join(titles)} or {last}"
    raise CaptureError(found, place=file.name, wanted=wanted, remedy=remedy)


def is_capture(path: str) -> bool:
    """Tell whether a file begins as one of a format that is read; one that cannot be opened may."""
    try:
        whole = locations.is_file(path)
        head = locations.head(path, _HEAD) if whole else opened(path).content[:_HEAD]
    except (OSError, CaptureError):
        return True
    return any(form.holds(path, head) for form in FORMATS)


def captures_in(path: str) -> tuple[str, ...]:
    """Return the captures in a file: the path itself, or one for each of several people in it."""
    names = names_in(opened(path)) if path.lower().endswith(_SEVERAL) else ()
    return tuple(path + SUBJECT + name for name in names) or (path,)


def names_in(file: File, options: Reading | None = None) -> tuple[str, ...]:
    """Return the names of the people in a file, where there are several and none is meant."""
    if not file.name.lower().endswith(_SEVERAL) or (options and options.columns):
        return ()
    form = known(file)
    names: tuple[str, ...] = form.does.subjects(file) if form.several and not file.subject else ()
    return names if len(names) > 1 else ()


def companions(file: File, options: Reading) -> tuple[File, ...]:
    """Return the other files that are read with one: a skeleton, buffers, those of the options."""
    form = _format_of(file, options)
    own: tuple[File, ...] = form.does.companions(file, options) if form.joined else ()
    files = (options.body, options.columns, options.tempo)
    return (*own, *(opened(it) for it in files if it and os.path.isfile(it)))


def parted(path: str) -> tuple[str, str]:
    """Return a capture's file and whom of several people in it is meant, by the name alone."""
    file, _, subject = path.rpartition(SUBJECT)
    return (file, subject) if file.lower().endswith(_SEVERAL) else (path, "")


def read(
    path: str | os.PathLike[str],
    *,
    unit: str | None = None,
    up: str | None = None,
    rate: Fraction | float | str | None = None,
    compose: str | None = None,
    skeleton: str | None = None,
    body: str | None = None,
    columns: str | None = None,
    take: str | None = None,
    data: bytes | None = None,
    body_only: bool = False,
) -> Motion:
    """Read a capture.

    Parameters
    ----------
    path : str or path
        The file.
    unit : str, optional
        ``mm``, ``cm``, ``m``, ``inch``, ``inch/0.45``; else found from the size of the body.
    up : str, optional
        The vertical axis, ``y``, ``z``, ``x``, ``-y``, ``-z``, ``-x``; else found from the body.
    rate : Fraction, float or str, optional
        Frames a second, instead of what the file says.
    compose : str, optional
        ``parent``: a joint's turn follows its parent's, as BVH has it. ``child``: it precedes it,
        as one exporter has it. Else found from the names of the joints.
    skeleton : str, optional
        The ASF of an AMC file that has none beside it.
    body : str, optional
        A file that says which joints or markers play the body (`body.mapping.read_body_file`).
    columns : str, optional
        A file that says what the columns of a table are.
    take : str, optional
        Which of several takes.
    data : bytes, optional
        The file's content, where it is at hand.
    body_only : bool
        Leave out the joints that play no part in the body: half of the memory.

    Returns
    -------
    Motion
        Millimetres, y up.

    Raises
    ------
    CaptureError
        The file cannot be read; says where and why.
    BodyError
        It holds no human skeleton.
    UsageError
        An option is not understood.

    Examples
    --------
    >>> import lanindex
    >>> motion = lanindex.read("corpus/compass.bvh")
    >>> motion
    <Motion corpus/compass.bvh: 840 frames at 30 Hz, 28.00 s, 28 joints>
    >>> lanindex.read("corpus/compass.bvh", rate=60).seconds
    14.0
    """
    from lanindex.model import Reading

    file = opened(path) if data is None else File(locations.plain(path), data)
    options = Reading(unit, up, rate, compose, skeleton, body, columns, take)
    return read_file(file, options, Wanted(body_only))


def check(options: Reading) -> None:
    """Refuse options of reading that no reader would understand, before any file is read."""
    from pathlib import Path

    from lanindex.body import calibration
    from lanindex.body.mapping import read_body_file
    from lanindex.errors import UsageError
    from lanindex.formats.rates import given_rate
    from lanindex.notation import beats

    if options.unit is not None:
        calibration.unit_named(options.unit)
    if options.up is not None:
        calibration.up_axis_named(options.up)
    if options.rate is not None:
        given_rate(options.rate)
    if options.body is not None:
        read_body_file(options.body)
    if options.tempo not in (None, beats.AUTO):
        beats.read(Path(options.tempo))
    if options.compose not in (None, *COMPOSE):
        raise UsageError(f"compose {options.compose!r}", wanted=" or ".join(COMPOSE))


def read_file(file: File, options: Reading, wanted: Wanted) -> Motion:
    """Read a capture: see `read`."""
    check(options)
    motion: Motion = _format_of(file, options).does.read(file, options, wanted)
    return motion


def _format_of(file: File, options: Reading | None) -> Format:
    """Return the format of a file; one whose columns are given is a table."""
    tables = (form for form in FORMATS if form.name == "csv")
    return next(tables) if options and options.columns else known(file)


def ranged(file: File, options: Reading) -> Callable[[Wanted, int], NDArray[np.int64]] | None:
    """Return what tells which frames a motion has where some are wanted; None: it has all."""
    return getattr(_format_of(file, options).does, "frames", None)


def is_sought(form: str) -> bool:
    """Return whether clips of a format are cut without going through all of a file."""
    return any(it.sought for it in FORMATS if it.name == form)


def cutter(file: File, options: Reading | None = None) -> Cutter | None:
    """Return what cuts clips out of a file, looked through once; None: this format has no clips."""
    does = _format_of(file, options).does
    cut: Cutter | None = does.cutter(file, options) if hasattr(does, "cutter") else None
    return cut


def unkept(file: File, options: Reading, kept: Motion | File) -> Counter[str]:
    """Return what a file holds that is not in its motion or in a clip: analog channels, events."""
    does = _format_of(file, options).does
    if not hasattr(does, "held"):
        return Counter()
    if isinstance(kept, File):
        return Counter(does.held(file) - does.held(kept))
    return Counter(does.held(file) - Counter(point=len((kept.markers or kept.skeleton).names)))


def beside(file: File, options: Reading) -> tuple[tuple[str, bytes], ...]:
    """Return what has to lie beside a clip of a file, each with its ending: a skeleton."""
    does = _format_of(file, options).does
    return tuple(does.beside(file, options)) if hasattr(does, "beside") else ()
