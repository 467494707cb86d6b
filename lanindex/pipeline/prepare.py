"""A file read and written down, not yet stored: what each process of an ingest does.

It is opened once, however many people are in it, and only opened if all of them are held.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from lanindex import compiled, formats
from lanindex.errors import LanindexError, OutOfMemoryError
from lanindex.formats.file import SUBJECT, together
from lanindex.library.rows import Encoding
from lanindex.model.motion import Reading
from lanindex.notation import notation_of, read
from lanindex.notation.beats import AUTO, describe_tempo

if TYPE_CHECKING:
    from lanindex.encoding.profile import Profile
    from lanindex.model import Score

_FILES = ("skeleton", "body", "columns", "tempo")
"""What of a `Reading` is a file, unless it is a word."""

Held = Mapping[str, tuple[str, Encoding]]
"""What a library holds of a file: sha256 and encoding by person, of all of it by the empty text."""


@dataclass(frozen=True, slots=True)
class Task:
    """One file to ingest."""

    path: str
    profile: Profile
    reading: Reading = field(default_factory=Reading)
    held: Held = field(default_factory=dict)
    only_look: bool = False
    total: int = 0


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a file."""

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
    beside: tuple[str, ...] = ()
    tempo: str = ""
    score: Score | None = field(default=None, repr=False)
    format: str = ""
    sha256: str = ""
    encoding: Encoding = field(default_factory=Encoding)


def prepare(task: Task) -> tuple[Outcome, ...]:
    """Read a file and write down who is in it, unstored; never raises a `LanindexError`."""
    compiled.expect(task.total)
    try:
        file = formats.opened(task.path)
        sha256, beside = file.sha256(), companions(task, file)
        encoding = encoding_of(task, beside)
        same = {name: one.people for name, (digest, one) in task.held.items()
                if (digest, one) == (sha256, encoding)}  # fmt: skip
        if _all_held(same):
            found = [_unchanged(_one(file, name), sha256, encoding) for name in same]
        elif task.only_look:
            return ()
        else:
            names = () if _is_notated(task) else formats.names_in(file, task.reading)
            encoding = replace(encoding, people=len(names))
            found = [
                _unchanged(_one(file, name), sha256, encoding)
                if same.get(name) == len(names)
                else _prepared(task, _one(file, name), sha256, encoding)
                for name in names or ("",)
            ]
    except LanindexError as error:
        return (Outcome(task.path, "failed", error=str(error)),)
    except MemoryError:
        return (Outcome(task.path, "failed", error=_too_large(task.path)),)
    paths = tuple(one.name for one in beside)
    return tuple(replace(outcome, beside=paths) for outcome in found)


def _one(file: formats.File, name: str) -> formats.File:
    """Return the file as one of the people in it."""
    return replace(file, name=file.name + SUBJECT + name, subject=name) if name else file


def _all_held(same: Mapping[str, int]) -> bool:
    """Return whether nobody is missing of those that a library holds of a file, as it is."""
    return "" in same or (len(same) > 1 and set(same.values()) == {len(same)})


def prepare_one(task: Task) -> Outcome:
    """Read a file and write down whom its path means, else the first of the people in it."""
    try:
        file = formats.opened(task.path)
        return _prepared(task, file, file.sha256(), encoding_of(task, companions(task, file)))
    except LanindexError as error:
        return Outcome(task.path, "failed", error=str(error))
    except MemoryError:
        return Outcome(task.path, "failed", error=_too_large(task.path))


def _too_large(path: str) -> str:
    """Return the error of a file for which there is not enough memory."""
    remedy = "Ingest it by itself (--jobs 1), or cut it into shorter files."
    return str(OutOfMemoryError("not enough memory to read it", place=path, remedy=remedy))


def _is_notated(task: Task) -> bool:
    return notation_of(task.path) is not None


def companions(task: Task, file: formats.File) -> tuple[formats.File, ...]:
    """Return the other files that are read with one."""
    return () if _is_notated(task) else formats.companions(file, task.reading)


def encoding_of(task: Task, beside: Iterable[formats.File]) -> Encoding:
    """Return how a file is going to be written down, with what lies beside it."""
    if _is_notated(task):
        return Encoding()
    given = task.reading.given()
    named = (name for name in _FILES if given.get(name, AUTO) != AUTO)
    given |= {name: os.path.abspath(given[name]) for name in named}
    return Encoding(task.profile.name, task.profile.digest, given, together(beside))


def as_ingested(file: formats.File, sha256: str, encoding: Encoding) -> bool:
    """Return whether a file is as it was, and what it was read with, as far as that was noted."""
    if file.sha256() != sha256:
        return False
    reading = Reading(**encoding.options)
    return encoding.beside in ("", together(formats.companions(file, reading)))


def _unchanged(file: formats.File, sha256: str, encoding: Encoding) -> Outcome:
    return Outcome(file.name, "unchanged", sha256=sha256, encoding=encoding)


def _prepared(task: Task, file: formats.File, sha256: str, encoding: Encoding) -> Outcome:
    try:
        score, form, warnings = (_notated if _is_notated(task) else _written_down)(task, file)
    except LanindexError as error:
        return Outcome(file.name, "failed", error=str(error))
    return Outcome(
        file.name,
        "added",
        score.frames,
        sum(len(track) for track in score.tracks.values()),
        warnings,
        seconds=float(score.frames / score.rate),
        division=score.meter.division,
        tempo=describe_tempo(score.meter, score.other) if task.reading.tempo else "",
        score=score,
        format=form,
        sha256=sha256,
        encoding=encoding,
    )


def _notated(task: Task, file: formats.File) -> tuple[Score, str, tuple[str, ...]]:
    form = notation_of(task.path)
    score = read(task.path, file.content[:])
    return score, form.name if form else "", score.warnings


def _written_down(task: Task, file: formats.File) -> tuple[Score, str, tuple[str, ...]]:
    from lanindex.encoding import encode

    motion = formats.read_file(file, task.reading, formats.Wanted(body_only=True))
    score = encode(motion, task.profile, tempo=task.reading.tempo)
    return score, motion.source.format, (*motion.warnings, *score.warnings)
