"""A person made of named points, for formats that hold nothing else."""

import numpy as np

JOINTS = {
    "pelvis": (0, 950, 0),
    "neck": (0, 1480, 0),
    "head": (0, 1600, 20),
    "left_shoulder": (180, 1420, 0),
    "left_elbow": (230, 1140, 0),
    "left_wrist": (250, 890, 20),
    "right_shoulder": (-180, 1420, 0),
    "right_elbow": (-230, 1140, 0),
    "right_wrist": (-250, 890, 20),
    "left_hip": (95, 920, 0),
    "left_knee": (100, 500, 20),
    "left_ankle": (100, 90, 0),
    "right_hip": (-95, 920, 0),
    "right_knee": (-100, 500, 20),
    "right_ankle": (-100, 90, 0),
}
"""Millimetres, y up, facing +z: its left is +x."""

NAMES = tuple(JOINTS)


def person(frames: int = 20) -> np.ndarray:
    """Return (T, 15, 3) mm: a right arm that rises, a body that sways."""
    places = np.tile(np.array(list(JOINTS.values()), float), (frames, 1, 1))
    ways = np.linspace(0, 1, frames)[:, None]
    angle = 2.6 * ways[:, 0]
    shoulder = np.array(JOINTS["right_shoulder"], float)
    for name in ("right_elbow", "right_wrist"):
        x, y, z = np.subtract(JOINTS[name], shoulder)
        turned = (x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle))
        places[:, NAMES.index(name)] = shoulder + np.stack((*turned, np.full(frames, z)), axis=1)
    places[..., 0] += 12.25 * ways
    return places
