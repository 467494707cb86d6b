"""Notations ↔ Score: a table of them, each known by a file's ending.

A notation is a line in `NOTATIONS` and a module with

- ``read(content, place) -> Score``, or of a table ``rows(content, place)``, and
- ``write(score) -> str or bytes``, or of a table ``save(rows, file) -> int``; a printed score is
  only read.

Nothing else knows one from another. Beside them stand borders (LPD) and rules (LDD), which are
only read.

Source: ``encoding/METHOD.md``, "Formats"; ``NOTATIONS.md``.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lanindex.alphabet import KINDS
from lanindex.data import shipped
from lanindex.errors import NotationError
from lanindex.locations import local

if TYPE_CHECKING:
    from lanindex.model import Score


@dataclass(frozen=True, slots=True)
class Notation:
    """A kind of file that holds a score."""

    name: str  # In the library and for ``--to``: the ending in small letters
    title: str  # For people
    suffix: str  # The ending as it is written; it is read in any case
    ingested: bool = False  # Whether ingest looks for it in folders
    written: bool = True  # Whether scores can be written in it
    module: str = ""  # Of this package, or with all its name elsewhere; by default its name
    text: bool = True  # Whether people can read it
    parts: bool = False  # Whether it has room for the ``PARTS`` of its module only
    table: str = ""  # Of a table: the end of the names of its functions in `tables`

    def member(self, name: str) -> Any:
        """Return a function or constant of its module, imported when it is first needed."""
        module = self.module or ("tables" if self.table else self.name)
        name = f"{name}_{self.table}" if self.table else name
        whole = module if "." in module else f"lanindex.notation.{module}"
        return getattr(importlib.import_module(whole), name)


NOTATIONS = {it["name"]: Notation(**it) for it in shipped("notation/notations.toml")["notations"]}
"""Every notation of scores, by name."""

TABLES = {it.table: it for it in NOTATIONS.values() if it.table}  # the tables, by their last ending
WRITTEN = tuple(name for name, it in NOTATIONS.items() if it.written)
"""Those that scores are written in: all but pictures."""


def notation_of(path: str) -> Notation | None:
    """Return the notation that a file's ending stands for, or None."""
    name = Path(path).name.lower()
    return next((it for it in NOTATIONS.values() if name.endswith(f".{it.name}")), None)


def is_printed(path: str) -> bool:
    """Tell whether a file is a picture, which may be of a printed score."""
    form = notation_of(path)
    return form is not None and not form.written


def read(path: str, content: bytes | None = None) -> Score:
    """Read a score from a file in any notation."""
    form = notation_of(path) or NOTATIONS["lnd"]
    content = content_of(path) if content is None else content
    if form.table:
        from lanindex.notation.tables import score_of

        return score_of(form.member("rows")(content, path), path)
    score: Score = form.member("read")(content, place=path)
    return score


def content_of(path: str) -> bytes:
    """Return the content of a file."""
    try:
        return Path(local(path)).read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise NotationError(f"cannot be read: {reason.lower()}", place=path) from error


def write(score: Score, name: str) -> bytes:
    """Write a score in a notation."""
    form = NOTATIONS[name]
    if form.table:
        from lanindex.notation.tables import rows_of

        file = BytesIO()
        form.member("save")(rows_of(score), file)
        return file.getvalue()
    text: str | bytes = form.member("write")(score)
    return text.encode() if isinstance(text, str) else text


def left_out(score: Score, name: str) -> list[str]:
    """Return the parts of a score that a notation has no room for."""
    form = NOTATIONS[name]
    own = [part for part, track in score.tracks.items() if KINDS[track.kind].keyword and len(track)]
    return [part for part in own if part not in form.member("PARTS")] if form.parts else []
