"""A file read and written down, not yet stored: what each process of an ingest does."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from lanindex import formats
from lanindex.errors import LanindexError
from lanindex.library.encoding import Encoding
from lanindex.model.reading import Reading

if TYPE_CHECKING:
    from lanindex.encode.profile import Profile
    from lanindex.model import Score


@dataclass(frozen=True, slots=True)
class Task:
    """One file to ingest.

    Attributes
    ----------
    path : str
        As given, or as found in a folder.
    profile : Profile
        How to write it down.
    reading : Reading
        How to read it.
    known : tuple or None
        sha256 and encoding of what the library holds from there.
    only_look : bool
        Whether only to see if it has changed.
    total : int
        Bytes that one process is going to read, this file's among them, as far as is known.
    """

    path: str
    profile: Profile
    reading: Reading = field(default_factory=Reading)
    known: tuple[str, Encoding] | None = None
    only_look: bool = False
    total: int = 0


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a file.

    Attributes
    ----------
    path : str
        As in the task.
    status : str
        ``added``, ``unchanged`` or ``failed``.
    frames, symbols : int
        How many there are.
    warnings : tuple of str
        What was doubtful.
    error : str or None
        What went wrong.
    seconds : float
        How long the capture lasts.
    division : int
        Ticks in a unit of its score: more than the profile's where symbols found no room.
    held : bool
        Whether the library held it before.
    labelled : bool
        Whether it was unchanged and the user's words of it were not.
    moved : str
        Where it was before, if that is elsewhere; else empty.
    """

    path: str
    status: str
    frames: int = 0
    symbols: int = 0
    warnings: tuple[str, ...] = ()
    error: str | None = None
    seconds: float = 0.0
    division: int = 0
    held: bool = False
    labelled: bool = False
    moved: str = ""
    score: Score | None = field(default=None, repr=False)
    format: str = ""
    sha256: str = ""
    encoding: Encoding = field(default_factory=Encoding)


def prepare(task: Task) -> Outcome:
    """Read a file and write it down, without storing it; never raises a `LanindexError`.

    Parameters
    ----------
    task : Task
        Which file, and how.

    Returns
    -------
    Outcome
        With the score, if it is new or changed.
    """
    try:
        return _prepare(task)
    except LanindexError as error:
        return Outcome(task.path, "failed", error=str(error))


def _is_notated(task: Task) -> bool:
    return Path(task.path).suffix.lower() == ".lnd"


def encoding_of(task: Task) -> Encoding:
    """Return how a file is going to be written down."""
    if _is_notated(task):
        return Encoding()
    return Encoding(task.profile.name, task.profile.digest, task.reading.told())


def _prepare(task: Task) -> Outcome:
    file = formats.opened(task.path)
    sha256 = file.sha256()
    encoding = encoding_of(task)
    if task.known == (sha256, encoding):
        return Outcome(task.path, "unchanged", sha256=sha256, encoding=encoding)
    if task.only_look:
        return Outcome(task.path, "added")
    score, form, warnings = (_notated if _is_notated(task) else _written_down)(task, file)
    return Outcome(
        task.path,
        "added",
        score.frames,
        sum(len(track) for track in score.tracks.values()),
        warnings,
        seconds=float(score.frames / score.rate),
        division=score.meter.division,
        score=score,
        format=form,
        sha256=sha256,
        encoding=encoding,
    )


def _notated(task: Task, file: formats.File) -> tuple[Score, str, tuple[str, ...]]:
    from lanindex.notation import lnd

    return lnd.read(file.content[:], place=task.path), "lnd", ()


def _written_down(task: Task, file: formats.File) -> tuple[Score, str, tuple[str, ...]]:
    from lanindex.encode import encode

    motion = formats.read_file(file, task.reading, formats.Wanted(body_only=True, total=task.total))
    return encode(motion, task.profile), motion.source.format, motion.warnings
