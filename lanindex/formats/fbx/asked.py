"""What `child` tells of an FBX file."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import CaptureError
from lanindex.formats.file import File
from lanindex.formats.people import others

MOST = 20_000_000
"""Nodes times frames that are looked at."""

PATIENCE = 600
"""Seconds that a file may take."""

WIDTH = 10
"""Numbers of a node: shift, turn (w, x, y, z), scale."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """An FBX file in one of its takes."""

    told: Mapping[str, Any]  # what `child` says in words
    still: Floats  # (N, 10), the nodes while nothing moves them
    moving: Mapping[int, Floats]  # (T, 10) by node, those that move

    @property
    def parents(self) -> list[int]:
        """The node that each is in, -1 for the root."""
        return [parent for _, parent, _ in self.told["nodes"]]


def asked(file: File, take: str | None) -> Scene:
    """Have an FBX file read."""
    if find_spec("ufbx") is None:
        raise CaptureError(
            "FBX is read by a package that is not installed",
            place=file.name,
            wanted="ufbx",
            remedy="Install it: pip install 'lanindex[fbx]'",
        )
    question = json.dumps({"take": take, "most": max(MOST, len(file.content) // 4)})
    command = [sys.executable, "-P", str(Path(__file__).with_name("child.py"))]
    try:
        done = subprocess.run(
            command,
            input=b"%s\n%b" % (question.encode(), file.content[:]),
            capture_output=True,
            timeout=PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise _unread(file, f"took ufbx more than {PATIENCE} seconds") from None
    line, _, numbers = done.stdout.partition(b"\n")
    if done.returncode or not line:
        raise _unread(file, f"ended ufbx ({done.returncode})")
    told = json.loads(line)
    if "error" in told:
        raise _unread(file, f"ufbx says {told['error']}")
    if told["take"] < 0:
        _no_take(file, told, take)
    return _scene(told, np.frombuffer(numbers).reshape(-1, WIDTH), file)


def _unread(file: File, found: str) -> CaptureError:
    return CaptureError(
        found,
        place=file.name,
        wanted="an FBX file of version 6 or later that is whole",
        remedy="Export it again, or as BVH or GLB.",
    )


def _no_take(file: File, told: Mapping[str, Any], take: str | None) -> None:
    if told.get("count", 0) < 0:
        found, wanted = "has more frames than such a file can hold", "frames of an hour or so"
    elif not told["takes"]:
        found, wanted = "has no animation", "an animation of a skeleton"
    elif take is None:
        found, wanted = "no take moves anything", "one that moves a skeleton"
    else:
        found, wanted = f"has no take {take!r}", others(told["takes"])
    raise CaptureError(found, place=file.name, wanted=wanted)


def _scene(told: Mapping[str, Any], numbers: Floats, file: File) -> Scene:
    """Share the numbers out among the nodes."""
    count, moved = told["count"], set(told["moved"])
    still = np.empty((len(told["nodes"]), WIDTH))
    moving = dict[int, Floats]()
    at = 0
    for node in range(len(still)):
        still[node] = numbers[at]
        at += 1
        if node in moved:
            moving[node] = numbers[at : at + count]
            at += count
    if at != len(numbers) or not (np.abs(numbers) < 1e12).all():
        raise _unread(file, "has places that are not finite")
    return Scene(told, still, moving)
