"""Capture files → Motion: the reader is picked by content."""

from __future__ import annotations

import importlib
import os
import stat
from collections.abc import Callable
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from lanindex.errors import CaptureError

if TYPE_CHECKING:
    from lanindex.capture.bvh_layout import Layout
    from lanindex.model import Motion

SUFFIXES = {".bvh": "bvh"}
"""File name suffixes (small letters) of captures, and their formats."""


def _is_bvh(head: bytes) -> bool:
    return head.removeprefix(b"\xef\xbb\xbf").lstrip()[:9].upper() == b"HIERARCHY"


_READERS: tuple[tuple[Callable[[bytes], bool], str], ...] = ((_is_bvh, "lanindex.capture.bvh"),)
_HEAD = 4096


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


def read(
    path: str | os.PathLike[str],
    *,
    unit: str | None = None,
    up: str | None = None,
    rate: Fraction | float | str | None = None,
    compose: str | None = None,
    data: bytes | None = None,
) -> Motion:
    """Read a capture.

    Parameters
    ----------
    path : str or path
        The file.
    unit : str, optional
        ``mm``, ``cm``, ``m``, ``inch``, ``inch/0.45``; else told from the size of the body.
    up : str, optional
        The vertical axis, ``y``, ``z``, ``x``, ``-y``, ``-z``, ``-x``; else told from the body.
    rate : Fraction, float or str, optional
        Frames a second, instead of what the file says.
    compose : str, optional
        ``parent``: a joint's turn follows its parent's, as BVH has it. ``child``: it precedes it,
        as one exporter has it. Else told from the names of the joints.
    data : bytes, optional
        The file's content, where it is at hand.

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
    """
    name = os.fspath(path)
    if data is None:
        data = load(name)
    motion: Motion = _reader(data, name).read(
        data, name, unit=unit, up=up, rate=rate, compose=compose
    )
    return motion


def scan(data: bytes, path: str = "") -> Layout:
    """Find each frame's bytes without reading numbers: see `lanindex.capture.bvh_layout.Layout`."""
    layout: Layout = _reader(data, path).scan(data, path)
    return layout


def _reader(data: bytes, path: str) -> Any:
    head = data[:_HEAD]
    for sniff, module in _READERS:
        if sniff(head):
            return importlib.import_module(module)
    raise CaptureError(_found(head), place=path, wanted="BVH, which begins with the word HIERARCHY")


def _found(head: bytes) -> str:
    """Describe the first bytes of a file that no reader knows."""
    if not head:
        return "the file is empty"
    if head[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "begins as UTF-16 text: save it as UTF-8"
    if b"\0" in head:
        return f"binary data that begins with {head[:8].hex(' ')}"
    line = head.lstrip().split(b"\n")[0].strip()[:40].decode("utf-8", "replace")
    return f"begins with {line!r}" if line else "holds nothing but blanks"
