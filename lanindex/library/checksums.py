"""Checksums, and what to say where one does not fit.

All are CRC-32, enough to notice whatever happens to a file by accident or by hand, as whole
numbers with a sign, which take four bytes in a library.
"""

from __future__ import annotations

import shlex
import zlib
from typing import Any

from lanindex.errors import LibraryError
from lanindex.library.texts import printable


def of_values(*values: Any) -> int:
    """Return the checksum of what a row holds: numbers, texts, bytes, nothing, tuples of them.

    The type counts: 1, 1.0 and "1" differ.
    """
    return of_bytes(ascii(values).encode())


def of_bytes(*values: bytes | memoryview) -> int:
    """Return the checksum of bytes, one after the other."""
    found = 0
    for value in values:
        found = zlib.crc32(value, found)
    return found - ((found >> 31) << 32)


def damaged(number: object, path: object, what: str) -> LibraryError:
    """Return the error that says what of a capture is not what was stored, and the remedy."""
    shown = printable(path) if isinstance(path, str) else f"capture {number}"
    return LibraryError(
        f"capture {number} is damaged in the library: {what}",
        place=shown,
        wanted="what was stored",
        remedy=f"Write it down anew: lanindex ingest --force {shlex.quote(shown)}",
    )
