"""Where the skeleton of an AMC file is found: a file of its own, ASF."""

from __future__ import annotations

import os
from functools import lru_cache
from pathlib import Path

from lanindex.errors import CaptureError
from lanindex.formats.file import File, opened
from lanindex.model import Reading

_ENDINGS = (".asf", ".ASF", ".Asf")
_MOST_STEMS = 8


def skeleton_of(file: File, told: Reading) -> tuple[File, tuple[str, ...]]:
    """Return the skeleton of a motion, and what is doubtful about it.

    Parameters
    ----------
    file : File
        AMC.
    told : Reading
        May name the skeleton.

    Returns
    -------
    tuple of File and tuple of str
        For ``01_01.amc`` it is ``01.asf``, else ``01_01.asf``, else the only one of its folder;
        the ending may be in capital letters.

    Raises
    ------
    CaptureError
        It is not there, or there are several and none has the name.
    """
    named = told.skeleton
    if named is not None:
        return opened(named), ()
    folder, stems = Path(file.name).parent, _stems(Path(file.name).stem)
    for path in (folder / (stem + ending) for stem in stems for ending in _ENDINGS):
        if os.path.exists(path):
            return opened(path), ()
    others = _skeletons(str(folder), _changed(folder))
    if len(others) == 1:
        doubt = f"its skeleton is taken to be {others[0]}, the only one in its folder"
        return opened(folder / others[0]), (doubt,)
    raise CaptureError(
        f"{len(others)} skeletons beside it" if others else "no skeleton beside it",
        place=file.name,
        wanted=" or ".join(f"{stem}.asf" for stem in stems) + " or a single .asf in its folder",
        remedy="Name it with --skeleton FILE.",
    )


def _stems(stem: str) -> list[str]:
    """Return what a skeleton may be called: the name up to an underscore, or all of it."""
    words = stem.split("_")
    begun = ("_".join(words[:count]) for count in range(len(words) - 1, 0, -1))
    return [*[name for name in begun if name][:_MOST_STEMS], stem]


def _changed(folder: Path) -> int:
    try:
        return os.stat(folder).st_mtime_ns
    except (OSError, ValueError):
        return 0


@lru_cache(maxsize=64)
def _skeletons(folder: str, changed: int) -> tuple[str, ...]:
    """Return the skeletons in a folder: it is looked through once, until it changes."""
    try:
        return tuple(name for name in os.listdir(folder) if name.lower().endswith(".asf"))
    except (OSError, ValueError):
        return ()
