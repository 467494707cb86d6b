"""Reading a long capture takes at most three times its size in memory."""

import tracemalloc
from itertools import product

import numpy as np
import pytest
from effort import thinned
from made_c3d import c3d, standing
from made_gltf import BODY, Made, body

from lanindex import formats


def integers(frames: int) -> bytes:
    """Return a C3D of markers in integers of 16 bits, the smallest that there is."""
    points = np.resize(standing(1000, 1.0), (frames, 28, 4))
    points[frames // 2 : frames // 2 + 50, 3, 3] = -1
    return c3d(points, scale=1.0, more={"POINT:LONG_FRAMES": float(frames)})


def turns(frames: int) -> bytes:
    """Return a GLB in which every joint turns in every frame, and nothing else is told."""
    made = Made()
    nodes = body(made)
    times, take = made.accessor(np.arange(frames) / 120), made.animation()
    for number, name in enumerate(BODY):
        half = 0.05 * np.sin(np.arange(frames) / (50 + number))
        keys = np.stack([np.sin(half), 0 * half, 0 * half, np.cos(half)], axis=1)
        made.track(take, nodes[name], "rotation", times, made.accessor(keys))
    return made.glb()


FORMATS = [("x.c3d", integers, 0), ("x.glb", turns, 1)]  # a GLB's tracks are the file's own bytes


@pytest.mark.slow
@pytest.mark.parametrize(("form", "body_only"), thinned(product(FORMATS, [False, True]), 3))
def test_a_long_capture(form, body_only):
    name, make, held = form
    data = make(120_000)
    formats.read(name, data=make(5))
    tracemalloc.start()
    motion = formats.read(name, data=data, body_only=body_only)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(motion) == 120_000
    assert held + peak / len(data) < 3
