"""What feet do, plain and compiled: equal flags, levels and stands, whatever they do."""

import numpy as np
import pytest

from lanindex.encoding import ground, steps
from lanindex.encoding.ground import Feet

RATE = 60.0


def feet(seed: int) -> tuple[np.ndarray, np.ndarray, Feet]:
    """Return joints of feet that rest and go, some numbers equal, knees that are lost, and feet."""
    random = np.random.default_rng(seed)
    count, kinds = int(random.integers(1, 400)), int(random.integers(1, 3))
    pieces = np.sort(random.integers(0, count, 12))
    rests = np.searchsorted(pieces, np.arange(count)) % 2
    speed = np.abs(random.normal(0, 0.4, (2, count))) * rests + random.choice([0.0, 0.1, 0.3])
    points = random.normal(0, 1, (2, kinds, count, 3)).astype(np.float32)
    points[..., 1] *= random.choice([0.02, 0.1, 1])
    points[..., 1] = np.round(points[..., 1], 2)
    bent = random.uniform(0, 90, (2, count)).astype(np.float32)
    bent[:, random.random(count) < 0.05] = np.nan
    slow = np.repeat(speed[:, None] < random.choice([0.0, ground.STANDS]), kinds, axis=1)
    pace = np.abs(random.normal(0, 2, count)).astype(np.float32)
    return points, bent, Feet(pace, points[..., 1], speed, slow)


@pytest.mark.parametrize("seed", range(60))
def test_compiled_feet_go_as_plain_ones(seed):
    fast = pytest.importorskip("lanindex.encoding.ground_fast")
    (points, bent, some), random = feet(seed), np.random.default_rng(seed)
    for least in (1, 5.0, 15.0):
        told = points[:, -1], some.speed, least
        assert fast.stood(*told).tolist() == ground.stood(*told).tolist()
    heights = some.heights
    carries, uneven = ground.carried(some, heights, RATE)
    others, other = fast.carried(some, heights, RATE)
    assert (others.tobytes(), other) == (carries.tobytes(), uneven)
    frames = np.sort(random.integers(0, carries.shape[1], 20)).tolist()
    for usual in (0.05, None) if heights.shape[1] > 1 else (None,):
        for foot in range(2):
            told = frames, carries[foot], bent[foot], heights[foot], usual, RATE
            assert fast.levels(*told) == steps.levels(*told)
