"""Motion → the arrays that `lanindex.formats.npy.read` reads without a guess."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from lanindex.model import Motion


def write(motion: Motion) -> bytes:
    """Write a motion as ``.npz``: metres, y up.

    Keys: ``joints`` (T, J, 3) float32, NaN where unknown; ``joint_names`` (J); ``fps``; ``unit``,
    ``m``; ``up``, ``y``; of a motion that has markers ``markers`` (T, M, 3) and ``marker_names``
    (M) too.
    """
    arrays: dict[str, Any] = {
        "joints": motion.positions / np.float32(1000),
        "joint_names": np.array(motion.skeleton.names),
        "fps": np.array(float(motion.rate)),
        "unit": np.array("m"),
        "up": np.array("y"),
    }
    if motion.markers is not None:
        arrays["markers"] = motion.markers.positions / np.float32(1000)
        arrays["marker_names"] = np.array(motion.markers.names)
    file = io.BytesIO()
    np.savez_compressed(file, allow_pickle=False, **arrays)
    return file.getvalue()
