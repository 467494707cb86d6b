"""Kinds of file that hold captures and are not read yet: to be named instead of passed over."""

from __future__ import annotations

from pathlib import PurePath

UNREAD: dict[str, str] = {
    ".mot": "MOT",
    ".sto": "STO",
    ".mvn": "MVN",
    ".htr": "HTR",
    ".bip": "BIP",
    ".vmd": "VMD",
    ".vrm": "VRM",
    ".vrma": "VRM animation",
    ".dae": "COLLADA",
    ".usd": "USD",
    ".usda": "USD",
    ".usdc": "USD",
    ".usdz": "USD",
    ".pkl": "pickle",
    ".7z": "7z",
    ".rar": "RAR",
    ".gz": "gzip",
}
"""By ending in small letters, what the format is called. What is read has no line here."""


WITHOUT_PLACES = (".mot", ".sto")
"""Endings of files of angles, which tell no places without the OpenSim model that they are of."""

COMPANIONS = (".mtl", ".xcp", ".vsk", ".system")
"""Endings of files that lie beside captures and are never read: not to be told as left out."""


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
