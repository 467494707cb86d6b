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
    ".laban": "the Laban files of other programs",
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
