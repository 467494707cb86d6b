"""Frame times of an animation, at the edges of each rule."""

from fractions import Fraction

import numpy as np
import pytest
from made_gltf import Made, body, waving

from lanindex import formats
from lanindex.errors import CaptureError
from lanindex.formats import gltf_scene
from lanindex.formats.gltf_scene import MOST_BETWEEN, Clock, Track, clock


def keys(*steps: float) -> np.ndarray:
    return np.cumsum([0.0, *steps])


def test_fifteen_keys_a_second_are_enough():
    found = clock([np.arange(16) / 15], "a.glb")
    assert (found.rate, found.pace, found.count, found.doubts) == (15, 15.0, 16, ())
    slower = clock([np.arange(15) / 14], "a.glb")
    assert slower.rate == 42
    assert "it is read at 42 frames a second" in slower.doubts[0]


def test_a_key_as_far_from_a_frame_as_may_be_is_on_it():
    found = Clock(Fraction(8), 8.0, 0.0, 9, 0.125)
    assert found.frames(np.array([1.125, 0.875, 1.1875]) / 8).tolist() == [1, 1, 1.1875]


def test_keys_as_uneven_as_may_be(monkeypatch):
    monkeypatch.setattr(gltf_scene, "ON_GRID", 0.125)
    found = clock([keys(1.125 / 16, 0.875 / 16)], "a.glb")
    assert (found.rate, found.count, found.doubts) == (16, 3, ())
    found = clock([keys(1.1875 / 16, 0.8125 / 16)], "a.glb")
    assert "uneven times" in found.doubts[0]


def test_two_keys_at_one_time_are_no_step():
    found = clock([keys(0, 1 / 16, 1 / 16, 0)], "a.glb")
    assert (found.rate, found.count, found.doubts) == (16, 3, ())


def test_a_key_stands_for_so_many_frames_at_most():
    dense = keys(1 / 32, 1 / 32)
    last = MOST_BETWEEN * len(dense) / 32
    assert clock([dense, np.array([0, last])], "a.glb").count == MOST_BETWEEN * len(dense) + 1
    with pytest.raises(CaptureError, match="wanted keys that stand for 10000 frames at most"):
        clock([dense, np.array([0, last + 1 / 32])], "a.glb")


def test_a_day_is_too_long():
    assert clock([250.0 * np.arange(400)], "a.glb").count == 399 * 7500 + 1
    with pytest.raises(CaptureError, match="in a day"):
        clock([250.0 * np.arange(401)], "a.glb")


@pytest.mark.parametrize("kind", ["LINEAR", "STEP"])
def test_of_two_keys_at_one_time_the_second_holds(kind):
    times = np.array([0.0, 2, 2, 4])
    values = np.array([[0.0], [2], [8], [10]])
    track = Track(0, "scale", kind, times, values, times)
    found = track.at(np.arange(-1, 6))[:, 0].tolist()
    assert found == ([0, 0, 1, 8, 9, 10, 10] if kind == "LINEAR" else [0, 0, 0, 8, 8, 10, 10])


def test_times_may_stand_still_but_not_go_back():
    def moved(times: list[float]) -> bytes:
        made = Made()
        nodes = body(made)
        waving(made, nodes)
        take = made.json["animations"][0]
        ways = np.tile([0.0, 0.95, 0.0], (len(times), 1))
        made.track(take, nodes["Head"], "scale", made.accessor(np.array(times)),
                   made.accessor(ways + 1))  # fmt: skip
        return made.glb()

    assert len(formats.read("a.glb", data=moved([0, 0.1, 0.1, 0.2]))) == 10
    with pytest.raises(CaptureError, match="go back at key 2"):
        formats.read("a.glb", data=moved([0, 0.1, 0.05, 0.2]))
