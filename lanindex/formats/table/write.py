"""Motion → a table whose header names x, y, z of each point."""

from __future__ import annotations

import io
import re

import numpy as np

from lanindex.formats import numbers
from lanindex.model import Motion


def write(motion: Motion) -> bytes:
    """Write a motion as CSV: ``frame,time,<name>_x,<name>_y,<name>_z``, millimetres, y up.

    Frames count from 0, times are seconds; the points are its markers, or else its joints; what is
    unknown is left blank.
    """
    names, places = numbers.shown(motion)
    names = tuple(re.sub(r'[,;"\s]+', " ", name).strip() or "point" for name in names)
    out = io.StringIO()
    columns = [f"{name}_{axis}" for name in names for axis in "xyz"]
    out.write(",".join(("frame", "time", *columns)) + "\n")
    form = "%d,%.7f" + ",%.4f" * (3 * len(names)) + "\n"
    seconds = (np.arange(len(motion)) / float(motion.rate)).tolist()
    for frame, (time, row) in enumerate(zip(seconds, places, strict=True)):
        out.write((form % (frame, time, *row.ravel().tolist())).replace("nan", ""))
    return out.getvalue().encode()
