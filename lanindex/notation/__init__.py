"""Notations ↔ Score: a table of them, each known by a file's ending.

A notation is a module with

- ``read(content, place) -> Score``, and
- ``write(score) -> str or bytes``, or of a table ``save(rows, file) -> int``,

and a line in `NOTATIONS`. Nothing else knows one from another. Beside them stand borders (LPD) and
rules (LDD), which are read.

Source: ``encoding/METHOD.md``, "Formats"; ``NOTATIONS.md``.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lanindex.alphabet import KINDS
from lanindex.errors import NotationError

if TYPE_CHECKING:
    from lanindex.model import Score


@dataclass(frozen=True, slots=True)
class Notation:
    """One kind of file that holds a score."""

    name: str  # As the library and ``--to`` say it: its ending in small letters
    title: str  # As people say it
    suffix: str  # Its ending, as it is written; read in small letters, too
    gathered: bool = False  # Whether folders are searched for it: others are mostly not ours
    module: str = ""  # Of this folder, imported when needed; by default of its name
    text: bool = True  # Whether people can read it
    # Whether it has room for some parts only: those that its module calls ``PARTS``
    parts: bool = False

    @property
    def does(self) -> Any:
        """The module, imported."""
        return importlib.import_module(f"lanindex.notation.{self.module or self.name}")


NOTATIONS = {
    it.name: it
    for it in (
        Notation("lnd", "LND", ".lnd", gathered=True),
        Notation("eaf", "ELAN", ".eaf"),
        Notation("textgrid", "Praat", ".TextGrid"),
        Notation("laban", "MAE", ".laban", gathered=True, parts=True),
        Notation("json", "LabanotationSuite", ".json", module="suite", parts=True),
        Notation("symbols.csv", "CSV", ".symbols.csv", module="symbols_csv"),
        Notation("symbols.jsonl", "JSON lines", ".symbols.jsonl", module="symbols_jsonl"),
        Notation(
            "symbols.parquet", "Parquet", ".symbols.parquet", module="symbols_parquet", text=False
        ),
    )
}
"""Every notation of scores, by name."""

TABLES = {it.name.partition(".")[2]: it for it in NOTATIONS.values() if "." in it.name}
"""Those that hold rows, whosever they are: by the last ending."""

WRITTEN = tuple(NOTATIONS)
"""Those that scores are written in: all."""


def notation_of(path: str) -> Notation | None:
    """Return the notation that a file's ending stands for, if it does for one."""
    name = Path(path).name.lower()
    return next((it for it in NOTATIONS.values() if name.endswith(f".{it.name}")), None)


def read(path: str, content: bytes | None = None) -> Score:
    """Read a score from a file in any notation."""
    form = notation_of(path) or NOTATIONS["lnd"]
    score: Score = form.does.read(content_of(path) if content is None else content, place=path)
    return score


def content_of(path: str) -> bytes:
    """Return what is in a file."""
    try:
        return Path(path).read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise NotationError(f"cannot be read: {reason.lower()}", place=path) from error


def write(score: Score, name: str) -> bytes:
    """Write a score in a notation."""
    form = NOTATIONS[name]
    if form in TABLES.values():
        from lanindex.notation.table import rows_of

        file = BytesIO()
        form.does.save(rows_of(score), file)
        return file.getvalue()
    text: str | bytes = form.does.write(score)
    return text.encode() if isinstance(text, str) else text


def left_out(score: Score, name: str) -> list[str]:
    """Return the parts of a score that a notation has no room for."""
    form = NOTATIONS[name]
    own = [part for part, track in score.tracks.items() if KINDS[track.kind].keyword and len(track)]
    return [part for part in own if part not in form.does.PARTS] if form.parts else []
