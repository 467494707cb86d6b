"""TRC (Track Row Column): markers by name, as OpenSim and the programs around it write them.

Five lines tell what follows, then a line is a frame: its number, its time, and x, y, z of each
marker. Real files leave cells blank, pad lines, part cells by commas and miscount their frames;
they are read by what stands in them.

Source: OpenSim documentation, *Marker (.trc) Files*.
"""

import re
from collections.abc import Callable
from itertools import islice
from pathlib import PurePath

from lanindex.body import Declared
from lanindex.errors import CaptureError
from lanindex.formats import text_rows
from lanindex.formats.file import File, Wanted, text_of
from lanindex.formats.points import spread
from lanindex.formats.text_rows import Layout, count_doubt, header_lines, table_of, twice
from lanindex.model import Motion, Reading, Span

_WORD = re.compile(rb"[^\s,;]+")
_MARKER = re.compile(rb"[xX]\d*")
_FIRST = 2  # columns before the markers: number and time


def read(file: File, options: Reading, wanted: Wanted) -> Motion:
    """Read a TRC file: see `lanindex.formats.read_file`."""
    return text_rows.read_motion(file, file.once(scan), "trc", options, wanted)


frames = spread


def cutter(file: File, options: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of a TRC file: its own bytes, but for ``NumFrames``."""
    return text_rows.cutter(file, scan(file))


def scan(file: File) -> Layout:
    """Find the frames of a TRC file without reading their numbers."""
    filled = (line for line in header_lines(file) if line.text.strip(text_rows.NOTHING))
    above = [(line.text, line.first) for line in islice(filled, 5)]
    if len(above) < 4:
        found = "the file ends in its header"
        raise CaptureError(found, place=file.name, wanted="five lines, then frames")
    (keys, _), (values, at), (named, names_at) = above[1:4]
    separator = max(b"\t,;", key=named.count).to_bytes(1, "big")
    header, count = _header(keys, values, at)
    cells = [cell.strip() for cell in named.split(separator)]
    behind, many = names_at + len(named), 0
    first = _WORD.search(above[4][0]) if len(above) > 4 else None
    if first and _MARKER.fullmatch(first.group()):
        axes, axes_at = above[4]
        behind, many = axes_at + len(axes), len(_WORD.findall(axes)) // 3
    names = _names(cells[_FIRST:], many, f"{file.name}:4")
    width = _FIRST + 3 * len(names)
    table = table_of(file, behind, separator, width, (0, 1), range(_FIRST, width))
    doubts = count_doubt(header.get("numframes", ""), len(table.lines), "frames")
    doubts += count_doubt(header.get("nummarkers", ""), len(names), "markers")
    doubts += twice(names, "markers")
    rate, declared = header.get("datarate", ""), Declared(header.get("units"))
    return Layout(names, table, 1, 1.0, rate, declared, doubts, rate_line=":3", count=count)


def _header(keys: bytes, values: bytes, at: int) -> tuple[dict[str, str], tuple[int, int]]:
    """Return what the header says by key, and the bytes of the number of frames."""
    names = [text_of(word.group()).lower() for word in _WORD.finditer(keys)]
    words = list(_WORD.finditer(values))
    header = dict(zip(names, (text_of(word.group()) for word in words), strict=False))
    if "numframes" not in header or not header["numframes"].isdecimal():
        return header, (at, at)
    start, stop = words[names.index("numframes")].span()
    return header, (at + start, at + stop)


def _names(cells: list[bytes], many: int, place: str) -> tuple[str, ...]:
    """Return the names of the markers, of which each stands over three columns."""
    named = [number for number, cell in enumerate(cells) if cell]
    if all(number % 3 == 0 for number in named):
        many = max(many, named[-1] // 3 + 1 if named else 0)
        words = [cells[3 * k] if 3 * k < len(cells) else b"" for k in range(many)]
    else:
        words = [cells[number] for number in named]
    if not words or (many and len(words) != many):
        found = f"{len(words)} names over {many} markers"
        raise CaptureError(found, place=place, wanted="a name over every third column")
    return tuple(text_of(word) or f"marker {number}" for number, word in enumerate(words, 1))


def write(motion: Motion) -> bytes:
    """Write a motion as TRC: millimetres, y up; its markers, or else its joints."""
    names, places = text_rows.points_of(motion)
    names = tuple(re.sub(r"[\t\r\n]+", " ", name).strip() or "marker" for name in names)
    title = re.sub(r"\s+", " ", PurePath(motion.source.path).with_suffix(".trc").name)
    many, count = len(names), len(motion)
    rate = f"{float(motion.rate):.9g}"
    keys = (
        "DataRate CameraRate NumFrames NumMarkers Units OrigDataRate OrigDataStartFrame "
        "OrigNumFrames"
    )
    values = (rate, rate, count, many, "mm", rate, 1, count)
    axes = (f"{axis}{number}" for number in range(1, many + 1) for axis in "XYZ")
    head = (
        ("PathFileType", "4", "(X/Y/Z)", title),
        keys.split(),
        values,
        ("Frame#", "Time", *(cell for name in names for cell in (name, "", ""))),
        ("", "", *axes),
        ("",),
    )
    lines = "".join("\t".join(map(str, line)) + "\n" for line in head)
    end = "\t\n"  # else OpenSim misses a last blank cell
    return (lines + text_rows.written(motion, places, "\t", 1, end)).encode()
