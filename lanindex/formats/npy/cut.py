"""A stretch of arrays: those that have a frame for each of the movement's are cut, others stay."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable

import numpy as np

from lanindex.formats.file import File
from lanindex.formats.npy.arrays import SUFFIX, Arrays, Header, archive, arrays, unpacked
from lanindex.formats.npy.read import Layout, laid
from lanindex.model import Reading, Span

_NEVER = ("betas", "shape", "fps")


def cutter(file: File, told: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of arrays, which are looked through once.

    Kinds, orders and packing are the source's; numbers are its numbers, byte for byte.
    """
    found = arrays(file)
    layout = laid(found)
    if "" in found.headers:
        return lambda span: _cut(found, "", layout.axis, span)
    return lambda span: _members(file, found, layout, span)


def _members(file: File, found: Arrays, layout: Layout, span: Span) -> bytes:
    """Return the ZIP with its arrays cut."""
    clip, packed = io.BytesIO(), archive(file)
    with zipfile.ZipFile(clip, "w") as out:
        for info in packed.infolist():
            name = info.filename.removesuffix(SUFFIX)
            header = found.headers.get(name)
            if header and name != info.filename and _follows(name, header, layout):
                data = _cut(found, name, layout.axis if name == layout.key else 0, span)
            else:
                data = unpacked(file.name, packed, info, 0, info.file_size)
            copy = zipfile.ZipInfo(info.filename, info.date_time)
            copy.compress_type = info.compress_type
            out.writestr(copy, data)
    return clip.getvalue()


def _follows(name: str, header: Header, layout: Layout) -> bool:
    """Tell whether an array has a frame for each of the movement's."""
    if name == layout.key:
        return True
    shape = header.shape
    numbers = header.kind.kind in "fiub" and name not in _NEVER
    return numbers and bool(shape) and shape[0] == layout.frames


def _cut(found: Arrays, name: str, axis: int, span: Span) -> bytes:
    """Return an array's file with some of its frames."""
    array = found[name]
    some = array[:, span.start : span.stop] if axis else array[span.start : span.stop]
    if found.headers[name].fortran:
        some = np.asfortranarray(some)
    clip = io.BytesIO()
    np.lib.format.write_array(clip, some, allow_pickle=False)
    return clip.getvalue()
