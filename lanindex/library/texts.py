"""What a library can keep as text: whatever has a place in UTF-8."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping

from lanindex.errors import UsageError

_BYTES = re.compile("[\udc80-\udcff]")
"""How Python reads the bytes of a file's name that are no UTF-8."""


def check_text(place: str, texts: Iterable[str]) -> None:
    """Refuse text that came from bytes that are no UTF-8."""
    for text in texts:
        try:
            text.encode()
        except UnicodeEncodeError as error:
            raise UsageError(
                f"{printable(text)} has bytes that are no UTF-8",
                place=printable(place),
                remedy="Rename the file, or save the table of labels as UTF-8.",
            ) from error


def check_said(place: str, label: str | None, metadata: Mapping[str, str] | None) -> None:
    """Refuse what a user says of a capture where it is no text."""
    check_text(place, [label or "", *(metadata or {}), *(metadata or {}).values()])


def printable(text: str) -> str:
    r"""Return a text that UTF-8 can spell: of a byte of a file's name that is no UTF-8, ``\xff``.

    `lanindex.formats.archives.native` finds the file again.
    """
    escaped = _BYTES.sub(lambda found: f"\\x{ord(found[0]) - 0xDC00:02x}", text)
    return escaped.encode("utf-8", "backslashreplace").decode()


def absolute(path: str | os.PathLike[str]) -> str:
    """Return a path made absolute, as a library keeps it."""
    return printable(os.path.abspath(path))
