"""Where the skeleton of an AMC file is found: a file of its own, ASF."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from functools import lru_cache
from pathlib import PurePath

from lanindex.errors import CaptureError
from lanindex.formats import archives
from lanindex.formats.file import File, opened, siblings
from lanindex.model import Reading

_ENDING = ".asf"
_MOST_STEMS = 8


def skeleton_of(file: File, told: Reading) -> tuple[File, tuple[str, ...]]:
    """Return the skeleton of a motion, and what is doubtful about it."""
    if told.skeleton is not None:
        return opened(told.skeleton), ()
    stems = _stems(PurePath(file.name).stem)
    any_name = os.path.join(os.path.dirname(file.name), "_")
    found = _skeletons(any_name, _changed(any_name))
    for stem in stems:
        path = found.get(stem) or found.get(stem.lower())
        if path:
            return opened(path), ()
    others = sorted(set(found.values()))
    if len(others) == 1:
        doubt = f"its skeleton is taken to be {PurePath(others[0]).name}, the only one beside it"
        return opened(others[0]), (doubt,)
    raise CaptureError(
        f"{len(others)} skeletons beside it" if others else "no skeleton beside it",
        place=file.name,
        wanted=" or ".join(stem + _ENDING for stem in stems) + ", or a single .asf in its folder",
        remedy="Name it with --skeleton FILE.",
    )


def companions(file: File, told: Reading) -> tuple[File, ...]:
    """Return the skeleton of a motion."""
    return (skeleton_of(file, told)[0],)


def _stems(stem: str) -> list[str]:
    """Return what a skeleton may be called: as its motion, or that up to an underscore."""
    words = stem.split("_")
    begun = ("_".join(words[:count]) for count in range(len(words) - 1, 0, -1))
    return [stem, *[name for name in begun if name][:_MOST_STEMS]]


def _changed(path: str) -> int:
    """Return when what holds a file was changed: its folder, or its archive."""
    with suppress(OSError, ValueError):
        return os.stat(archives.split(path)[0] or os.path.dirname(path) or ".").st_mtime_ns
    return 0


@lru_cache(maxsize=64)
def _skeletons(path: str, changed: int) -> Mapping[str, str]:
    """Return the skeletons beside a file, by name: looked for once, however many files ask."""
    paths = siblings(path, _ENDING)
    names = [(PurePath(path).stem, path) for path in paths]
    return {**{name.lower(): path for name, path in reversed(names)}, **dict(names)}
