"""Which capture format a file is of: known by its first bytes, or by an ending that is not read."""

import re
from collections.abc import Callable
from pathlib import PurePath

from lanindex.data import shipped

_AMC = re.compile(rb":(FULLY-SPECIFIED|DEGREES|RADIANS|SAMPLES-PER-SECOND)\b", re.IGNORECASE)
_TRIPLE = re.compile(rb"[^,;\t]x\b[^,;\t]*[,;\t].*y\b", re.IGNORECASE)
_POINTS = 3  # at least, for a limb
_LINES = 40  # in which a header is looked for
KINECT_COLUMNS = 101
SEPARATORS = (b"\t", b";", b",")
"""Separators of cells: a line has the first of those that occur in it most often."""

_PROGRAMS = re.compile(
    rb"(trajectories|model outputs|devices|joints|segments|no_of_frames|file_version"
    rb"|format version)"
    rb"[ \t]*[,;\t\r\n]",
    re.IGNORECASE,
)
_NEXUS_BLOCK = re.compile(
    rb"^\"?(trajectories|model outputs|devices|joints|segments)\"?[ \t,;]*\r?\n"
    rb"\"?[0-9][0-9.]*\"?[ \t,;]*\r?$",
    re.IGNORECASE | re.MULTILINE,
)
_TEXT = rb"(?:\xef\xbb\xbf)?\s*"  # the mark of an encoding and blanks, before a text


def begins(pattern: bytes) -> Callable[[bytes], bool]:
    """Return what tells whether a file's first bytes match a pattern."""
    compiled = re.compile(pattern, re.DOTALL)
    return lambda head: compiled.match(head) is not None


bvh = begins(_TEXT + rb"(?i:HIERARCHY)")
c3d = begins(rb"(?!\x89PNG)[^\0]\x50.{510}")  # where its parameters begin, then its key
trc = begins(_TEXT + rb"(?i:PathFileType)")
mvnx = begins(_TEXT + rb"(?=<).*?<mvnx")
npy = begins(rb"\x93NUMPY")
gltf = begins(rb"glTF|" + _TEXT + rb'\{.*?"(?:asset|accessors|scenes|nodes|buffers)"')
fbx = begins(rb"Kaydara FBX Binary|" + _TEXT + rb"; FBX|.*?FBXHeaderExtension")


def text(head: bytes) -> bytes:
    """Return the beginning of a text without the mark of its encoding and blanks before it."""
    return head.removeprefix(b"\xef\xbb\xbf").lstrip()


def amc(head: bytes) -> bool:
    """Tell an AMC file: keywords before the first frame, comments aside."""
    lines = (line.strip() for line in text(head).splitlines())
    first = next((line for line in lines if line and not line.startswith(b"#")), b"")
    return bool(_AMC.match(first))


def table(head: bytes) -> bool:
    """Tell a table of points: a known program's, or one whose header names triples x, y, z."""
    begun = text(head)
    if _PROGRAMS.match(begun) or nexus(begun):
        return True
    lines = begun.splitlines()[:_LINES]
    if lines and kinect(lines[0]):
        return True
    if b"\0" in head or not any(_TRIPLE.search(line) for line in lines):
        return False
    from lanindex.formats.text_rows import triples

    named = (line.decode("latin-1").split(separator_of(line).decode()) for line in lines)
    return any(len(triples([cell.strip(" \"'") for cell in row])[0]) >= _POINTS for row in named)


def separator_of(line: bytes) -> bytes:
    """Return what separates the cells of a line."""
    return max(SEPARATORS, key=line.count)


def kinect(line: bytes) -> bool:
    """Tell a row of LabanotationSuite's tables: 101 numbers, perhaps with decimal commas."""
    separator = separator_of(line)
    cells = line.strip().rstrip(separator).split(separator)
    return len(cells) == KINECT_COLUMNS and all(map(_is_number, cells))


def nexus(head: bytes) -> bool:
    """Tell a table of Vicon Nexus by a block's title alone in a line, its rate in the next."""
    begun = b"\n".join(head.splitlines()[:_LINES])
    return _NEXUS_BLOCK.search(begun) is not None


def npz(head: bytes) -> bool:
    """Tell a file of NumPy arrays: a ZIP whose first member is one."""
    size = int.from_bytes(head[26:28], "little")
    return head[:4] == b"PK\x03\x04" and head[30 : 30 + size].endswith(b".npy")


def _is_number(cell: bytes) -> bool:
    try:
        float(cell.replace(b",", b"."))
    except ValueError:
        return False
    return True


UNREAD: dict[str, str] = shipped("formats/unread.toml")
"""By ending in small letters, what the format is called. What is read has no line here."""


WITHOUT_PLACES = (".mot", ".sto")
"""Endings of files of angles, which tell no places without the OpenSim model that they are of."""

COMPANIONS = (".mtl", ".xcp", ".vsk", ".system")
"""Endings of files that lie beside captures and are never read: nobody misses them."""


def unread(path: str) -> str:
    """Return the ending by which a file is in `UNREAD`; empty: it is not."""
    suffixes = [suffix.lower() for suffix in PurePath(path).suffixes]
    endings = ("".join(suffixes[-2:]), *suffixes[-1:])
    return next((ending for ending in endings if ending in UNREAD), "")


def beginning(head: bytes) -> str:
    """Describe the first bytes of a file that no reader knows."""
    if not head:
        return "the file is empty"
    if head[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "begins as UTF-16 text: save it as UTF-8"
    if b"\0" in head:
        return f"binary data that begins with {head[:8].hex(' ')}"
    line = head.lstrip().split(b"\n")[0].strip()[:40].decode("utf-8", "replace")
    return f"begins with {line!r}" if line else "holds nothing but blanks"
