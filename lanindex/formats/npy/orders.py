"""In which order joints stand that have no names: known by their number, and by their bones.

Sources: Loper et al. (2015), *SMPL*, and its extensions SMPL-H and SMPL-X, whose first 22 joints
HumanML3D takes (Guo et al. 2022); KIT-ML as HumanML3D orders it; Human3.6M as Martinez et al.
(2017) reduce it; COCO's keypoints; OpenPose's BODY_25; Kinect v2's JointType, as NTU RGB+D has it;
MediaPipe's pose landmarks, which FreeMoCap puts before hands and face.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.body import sampled


def _words(text: str) -> tuple[str, ...]:
    return tuple(text.split())


SMPL = _words(
    "pelvis left_hip right_hip spine1 left_knee right_knee spine2 left_ankle right_ankle spine3 "
    "left_foot right_foot neck left_collar right_collar head left_shoulder right_shoulder "
    "left_elbow right_elbow left_wrist right_wrist left_hand right_hand"
)
"""The joints of SMPL; the first 22 are those of SMPL-H, SMPL-X and HumanML3D too."""

_FINGERS = tuple(
    f"{side}_{finger}{part}"
    for side in ("left", "right")
    for finger in ("index", "middle", "pinky", "ring", "thumb")
    for part in (1, 2, 3)
)
_KIT = _words(
    "pelvis spine chest neck head right_shoulder right_elbow right_wrist left_shoulder "
    "left_elbow left_wrist right_hip right_knee right_ankle right_heel right_foot left_hip "
    "left_knee left_ankle left_heel left_foot"
)
_H36M = _words(
    "pelvis right_hip right_knee right_ankle left_hip left_knee left_ankle spine neck nose head "
    "left_shoulder left_elbow left_wrist right_shoulder right_elbow right_wrist"
)
_COCO = _words(
    "nose left_eye right_eye left_ear right_ear left_shoulder right_shoulder left_elbow "
    "right_elbow left_wrist right_wrist left_hip right_hip left_knee right_knee left_ankle "
    "right_ankle"
)
_BODY_25 = _words(
    "nose neck right_shoulder right_elbow right_wrist left_shoulder left_elbow left_wrist mid_hip "
    "right_hip right_knee right_ankle left_hip left_knee left_ankle right_eye left_eye right_ear "
    "left_ear left_big_toe left_small_toe left_heel right_big_toe right_small_toe right_heel"
)
_KINECT = _words(
    "spine_base spine_mid neck head left_shoulder left_elbow left_wrist left_hand right_shoulder "
    "right_elbow right_wrist right_hand left_hip left_knee left_ankle left_foot right_hip "
    "right_knee right_ankle right_foot spine_shoulder left_hand_tip left_thumb right_hand_tip "
    "right_thumb"
)
_MEDIAPIPE = _words(
    "nose left_eye_inner left_eye left_eye_outer right_eye_inner right_eye right_eye_outer "
    "left_ear right_ear mouth_left mouth_right left_shoulder right_shoulder left_elbow "
    "right_elbow left_wrist right_wrist left_pinky right_pinky left_index right_index left_thumb "
    "right_thumb left_hip right_hip left_knee right_knee left_ankle right_ankle left_heel "
    "right_heel left_foot_index right_foot_index"
)


def _with_face(face: int) -> tuple[str, ...]:
    """Return MediaPipe's landmarks of body, hands and face."""
    hands = (f"{side}_hand_{number}" for side in ("right", "left") for number in range(21))
    return (*_MEDIAPIPE, *hands, *(f"face_{number}" for number in range(face)))


_BONES = (("shoulder", "elbow"), ("elbow", "wrist"), ("hip", "knee"), ("knee", "ankle"))
_STEADY = 0.2  # of its length: what a bone may change by, middle half of the poses
_EVEN = 1.5  # how many times as long a bone may be on one side as on the other
_NEXT = 2.3  # how many times as long it may be as the one next to it


@dataclass(frozen=True, slots=True)
class Order:
    """One order of joints."""

    title: str  # as people call it
    names: tuple[str, ...]  # (J) the joints
    rate: str = ""  # frames a second that its files have, where none is given; empty: unknown


ORDERS = (
    Order("HumanML3D", SMPL[:22], "20"),
    Order("SMPL", SMPL),
    Order("SMPL-H", SMPL[:22] + _FINGERS),
    Order("SMPL-X", (*SMPL[:22], "jaw", "left_eye", "right_eye", *_FINGERS)),
    Order("KIT-ML", _KIT, "12.5"),
    Order("Human3.6M", _H36M),
    Order("COCO", _COCO),
    Order("OpenPose", _BODY_25),
    Order("Kinect v2, NTU RGB+D", _KINECT, "30"),
    Order("MediaPipe", _MEDIAPIPE),
    Order("FreeMoCap", _with_face(468)),
    Order("FreeMoCap", _with_face(478)),
)
"""All orders that are known."""


def order_of(places: NDArray[Any]) -> Order | None:
    """Return the one order in which places make a body.

    Takes `places` (T, J, 3).
    """
    poses = places[sampled(len(places))].astype(np.float64)
    fitting = [one for one in ORDERS if len(one.names) == places.shape[1] and _fits(one, poses)]
    return fitting[0] if len(fitting) == 1 else None


def _fits(order: Order, poses: NDArray[np.float64]) -> bool:
    """Return whether the bones of an order are bones."""
    ends = [[order.names.index(f"{side}_{end}") for end in bone]
            for bone in _BONES for side in ("left", "right")]  # fmt: skip
    bones = poses[:, [first for first, _ in ends]] - poses[:, [last for _, last in ends]]
    lengths = np.sqrt((bones * bones).sum(axis=2))
    lengths = lengths[np.isfinite(lengths).all(axis=1)]
    if not len(lengths):
        return False
    low, usual, high = np.percentile(lengths, (25, 50, 75), axis=0)
    steady = (high - low <= _STEADY * usual).all() and (usual > 0).all()
    return bool(
        steady
        and _alike(usual[0::2], usual[1::2], _EVEN)
        and _alike(usual[0::4], usual[2::4], _NEXT)
    )


def _alike(one: NDArray[np.float64], other: NDArray[np.float64], most: float) -> bool:
    return bool((np.maximum(one, other) <= most * np.minimum(one, other)).all())
