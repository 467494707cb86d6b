"""From named joints to a body: who plays what, in which unit, which way up.

Source: ``encoding/METHOD.md``, stage 0.
"""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, JOINTS
from lanindex.body import calibration
from lanindex.body.recognition import Rig, find_body
from lanindex.errors import BodyError, UsageError
from lanindex.model import Reading, Skeleton

Floats = NDArray[np.float64]

POSES = 32
"""How many poses of a capture are looked at."""

LONGEST_GAP = Fraction(1, 5)
"""Seconds that a joint may be unknown and is filled; longer gaps stay open."""

_BODY_FILE = 1 << 20  # bytes that a user's file has at most


@dataclass(frozen=True, slots=True, eq=False)
class BodyMapping:
    """How the joints of a file are to be read as a body."""

    # (20,) int16, index of the joint that plays each of ``alphabet.JOINTS``, -1: absent
    body: NDArray[np.int16]
    # Name of the unit, with ``(detected)`` where the file does not state it, ``(guessed)`` where no
    # unit gives the body a usual size
    unit: str
    scale: float  # Millimetres in one unit of the file
    up: str  # The file's vertical axis
    first: int  # The first frame that is movement: behind a calibration pose, if there is one
    doubts: tuple[str, ...]  # What a person should look at

    def oriented(
        self,
        places: Floats,
        out: NDArray[np.float32] | None = None,
        kept: NDArray[np.int64] | None = None,
    ) -> NDArray[np.float32]:
        """Return places (..., 3) of the file as float32 mm with y up, in `out` if given.

        `kept` (K,) int64: which joints of (..., J, 3) places; None: all.
        """
        if kept is not None:
            places = places.take(kept, axis=-2)
        result = np.empty(places.shape, np.float32) if out is None else out
        for axis, (source, sign) in enumerate(calibration.AXES[self.up]):
            factor = sign * self.scale
            np.multiply(places[..., source], factor, out=result[..., axis], casting="same_kind")
        return result

    def turned(self, axes: NDArray[Any]) -> NDArray[np.float32]:
        """Turn the axes of rotations, (..., 3) of any length, to y up."""
        turned: NDArray[np.float32] = self.oriented(axes) / np.float32(self.scale)
        return turned


@dataclass(frozen=True, slots=True, eq=False)
class Declared:
    """What a file says of itself, each None where it does not."""

    unit: str | None = None  # Of its lengths
    up: str | None = None  # Its vertical axis
    # (20,) int16: which of its joints play the body, where the format leaves no doubt
    body: NDArray[np.int16] | None = None


_NOTHING = Declared()


def sampled(frames: int) -> NDArray[np.int64]:
    """Return the frames whose poses tell the body: spread over the capture, at most `POSES`."""
    return np.linspace(0, frames - 1, min(frames, POSES)).astype(np.int64)


def map_body(
    names: tuple[str, ...],
    parents: Sequence[int] | None,
    poses: Floats,
    beginning: Floats,
    rate: Fraction,
    reading: Reading,
    path: str = "",
    declared: Declared = _NOTHING,
) -> BodyMapping:
    """Find the body among named joints.

    `names` (J); `parents` (J) parents before children, -1 for a root; None without a hierarchy;
    `poses` (S, J, 3) of `sampled` frames; `beginning` (N, J, 3) of the first `BEGINNING` frames.
    """
    if declared.body is None:
        user_joints = joints_by_user(reading, names, path)
        body, doubts = find_body(Rig(names, parents, poses), path, user_joints)
    else:
        body, doubts = declared.body, ()
    seen = np.where((body >= 0)[:, None], poses[:, body], np.nan)
    lengths, four_legs = calibration.body_lengths(seen), calibration.on_four_legs(seen)
    unit, scale, unit_doubts = calibration.unit_of(lengths, reading.unit, declared.unit)
    up, up_doubts = calibration.up_of(seen, reading.up, declared.up, four_legs)
    shape_doubts = calibration.facing_doubt(seen, up) + calibration.uneven_doubt(seen, scale)
    shape_doubts += calibration.shape_doubts(seen, lengths, four_legs)
    if min(body[JOINT_CODES[ankle]] for ankle in ("RAnkle", "LAnkle")) < 0:
        shape_doubts += ("no two feet: neither steps and jumps nor what carries are told",)
    found = BodyMapping(body, unit, scale, up, 0, ())
    wrists = [int(body[JOINT_CODES[name]]) for name in ("RWrist", "LWrist")]
    ways = found.oriented(beginning[:, [index for index in wrists if index >= 0]])
    first = calibration.first_frame(ways.tolist(), rate)
    posed: tuple[str, ...] = ()
    if first == 1:
        posed = ("frame 0 is a calibration pose: frame 1 stands in for it",)
    elif first:
        before = f"frames 0 to {first - 1} are a calibration pose and the fall from it"
        posed = (f"{before}: frame {first} stands in for them",)
    doubts = (*doubts, *unit_doubts, *up_doubts, *shape_doubts, *posed)
    return replace(found, first=first, doubts=doubts)


def body_of(skeleton: Skeleton) -> tuple[NDArray[np.int64], Skeleton]:
    """Return the joints (K,) that play a part in the body, in their order, and their skeleton."""
    kept = np.unique(skeleton.body[skeleton.body >= 0]).astype(np.int64)
    return kept, skeleton_of(skeleton, kept)


def skeleton_of(skeleton: Skeleton, joints: NDArray[np.int64]) -> Skeleton:
    """Return the skeleton of some joints (K,), each joined to the nearest above it that is kept."""
    place = np.full(len(skeleton.names) + 1, -1, np.int16)  # the last one stands for -1: none
    place[joints] = np.arange(len(joints))
    offsets = skeleton.offsets.copy()
    parents = skeleton.parents.copy()
    for joint in range(len(parents)):  # parents stand before children
        parent = parents[joint]
        if parent >= 0 and place[parent] < 0:
            offsets[joint] += offsets[parent]
            parents[joint] = parents[parent]
    names = tuple(skeleton.names[joint] for joint in joints.tolist())
    return Skeleton(names, place[parents[joints]], offsets[joints], place[skeleton.body])


def read_body_file(path: str) -> Mapping[str, tuple[str, ...]]:
    """Read a user's file of joints or markers that play the body: see ``guide/formats.md``."""
    try:
        with open(path, "rb") as file:
            table = tomllib.loads(file.read(_BODY_FILE).decode())
    except (OSError, ValueError, RecursionError) as error:
        raise UsageError(
            f"cannot be read ({error})", place=path, wanted='lines such as RWrist = "hand_r"'
        ) from error
    body = {joint: tuple([names] if isinstance(names, str) else _listed(names, joint, path))
            for joint, names in table.items()}  # fmt: skip
    strange = [joint for joint in body if joint not in JOINTS]
    if strange or not body:
        found = f'"{strange[0]}"' if strange else "nothing"
        raise UsageError(found, place=path, wanted=f"one of {', '.join(JOINTS)}")
    return body


def _listed(names: object, joint: str, path: str) -> list[str]:
    if isinstance(names, list) and names and all(isinstance(name, str) for name in names):
        return names
    raise UsageError(
        f"{joint} = {names!r}"[:60], place=path, wanted="a name in quotes, or a list of names"
    )


def joints_by_user(reading: Reading, names: tuple[str, ...], path: str) -> dict[str, int]:
    """Return which of some joints the user says play the body, by ``alphabet.JOINTS``."""
    found = {}
    for joint, (name, *more) in read_body_file(reading.body).items() if reading.body else ():
        if name not in names or more:
            raise BodyError(
                f'{joint} is said to be "{name}"{" and others" if more else ""}',
                place=path,
                wanted=f"one of its joints: {', '.join(names)[:200]}",
            )
        found[joint] = names.index(name)
    return found
