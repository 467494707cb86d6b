"""Bytes with a name, from wherever they come."""

from __future__ import annotations

import os
import stat
from dataclasses import dataclass
from pathlib import Path

from lanindex.errors import CaptureError


@dataclass(frozen=True, slots=True)
class File:
    """A capture file's bytes, and its name: on a disk, in an archive, from a network.

    Attributes
    ----------
    name : str
        A path, as given; messages show it.
    content : bytes
        All of it.
    """

    name: str
    content: bytes

    def beside(self, suffix: str) -> File:
        """Return a second file that a format needs, of the same name with another ending.

        Raises
        ------
        CaptureError
            There is none.
        """
        return opened(Path(self.name).with_suffix(suffix))


def opened(path: str | os.PathLike[str]) -> File:
    """Return a file of the disk.

    Raises
    ------
    CaptureError
        It is not there, or no file, or may not be read.
    """
    return File(os.fspath(path), load(path))


def load(path: str | os.PathLike[str]) -> bytes:
    """Return a file's bytes.

    Raises
    ------
    CaptureError
        It is not there, or no file, or may not be read.
    """
    try:
        mode = os.stat(path).st_mode
        if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):  # a pipe might never end
            raise ValueError("is no regular file")
        with open(path, "rb") as file:
            return file.read()
    except (OSError, ValueError) as error:
        raise CaptureError(
            _unreadable(os.fspath(path), error),
            place=os.fspath(path),
            wanted="a file that can be read",
        ) from error


def _unreadable(path: str, error: OSError | ValueError) -> str:
    if isinstance(error, FileNotFoundError):
        return "a link that leads nowhere" if os.path.islink(path) else "there is no such file"
    if isinstance(error, IsADirectoryError):
        return "is a folder"
    return getattr(error, "strerror", None) or str(error)
