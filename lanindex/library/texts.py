"""What a library can keep as text: whatever has a place in UTF-8."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from lanindex.errors import UsageError


def check_text(place: str, texts: Iterable[str]) -> None:
    """Refuse text that came from bytes that are no UTF-8.

    Raises
    ------
    UsageError
        With the text, made printable.
    """
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
    """Refuse what a user says of a capture where it is no text.

    Raises
    ------
    UsageError
        As `check_text`.
    """
    check_text(place, [label or "", *(metadata or {}), *(metadata or {}).values()])


def printable(text: str) -> str:
    """Return a text with a backslash's notation for what has no place in UTF-8."""
    return text.encode("utf-8", "backslashreplace").decode()
