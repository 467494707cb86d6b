"""The standard body that carries out scores, read from ``figure.toml``."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINTS
from lanindex.model import Skeleton

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Limb:
    """An arm or a leg of two equal bones, and how it folds."""

    bones: tuple[str, str]  # Upper and lower, without their side
    # (3,) forward, up, out: directions of the folded limb's end and of its middle joint
    toward: Floats
    bend: Floats
    near: float  # How far the folded limb's end lies, of the limb's length


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """The skeleton of the standard body, and which bone moves each joint."""

    skeleton: Skeleton  # (J) joints at rest: facing +z, y up, left +x
    bones: tuple[str, ...]  # (J) the bone that turns each joint's offset, or the empty string
    limbs: dict[str, Limb]  # By group: ``arm``, ``leg``
    standing_foot: Floats  # (3,) where a foot points, in the body frame, when the shank is upright
    sole: float  # Height of the lowest joint at rest, mm


@cache
def standard(palms: frozenset[str] = frozenset()) -> Body:
    """Return the standard body."""
    table = tomllib.loads(files("lanindex.perform").joinpath("figure.toml").read_text("utf-8"))
    joints = [it for it in table["joints"] if it["bone"][1:] != "_palm" or it["bone"] in palms]
    names = [joint["name"] for joint in joints]
    plays = [joint["plays"] for joint in joints]
    skeleton = Skeleton(
        tuple(names),
        np.array([names.index(j["parent"]) if j["parent"] else -1 for j in joints], np.int16),
        np.array([joint["offset"] for joint in joints], np.float32),
        np.array([plays.index(joint) for joint in JOINTS], np.int16),
    )
    limbs = {
        name: Limb(
            tuple(limb["bones"]), np.array(limb["toward"]), np.array(limb["bend"]), limb["near"]
        )
        for name, limb in table["limbs"].items()
    }
    left, height, front = joints[names.index("RightToeBase")]["offset"]
    foot = np.array([front, height, -left], np.float64)
    return Body(
        skeleton,
        tuple(joint["bone"] for joint in joints),
        limbs,
        foot / np.linalg.norm(foot),
        table["sole"],
    )
