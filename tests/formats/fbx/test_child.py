"""Limits of the child process that reads FBX."""

import sys
from array import array
from types import SimpleNamespace as Thing

import numpy as np
import pytest

from lanindex.errors import CaptureError
from lanindex.formats import fbx, fbx_child
from lanindex.formats.file import File

MOVES = {1, 2}


def transform() -> Thing:
    vector = Thing(x=0.0, y=0.0, z=0.0, w=1.0)
    return Thing(translation=vector, rotation=vector, scale=vector)


def answer(monkeypatch, begin: float, end: float, rate: float, most: int):
    """Return what is told of a file of three nodes, of which two move, and how many rows."""
    kinds = {"is_scale_helper": False, "is_geometry_transform_helper": False, "bone": object()}
    kinds |= dict.fromkeys(("mesh", "light", "camera", "parent"))
    nodes = [Thing(name=str(it), local_transform=transform(), **kinds) for it in range(3)]
    curves = [Thing(min_time=1.0, max_time=1.5, keyframes=[0]),
              Thing(min_time=0.5, max_time=1.0, keyframes=[0]),
              Thing(min_time=0.0, max_time=9.0, keyframes=[])]  # fmt: skip
    take = Thing(name="take", time_begin=begin, time_end=end, layers=[object()], anim=None)
    scene = Thing(
        nodes=nodes,
        anim_stacks=[take],
        anim_curves=curves,
        settings=Thing(frames_per_second=rate, unit_meters=1.0, axes=Thing(right=0, up=2, front=4)),
    )
    library = Thing(
        InheritModeHandling=Thing(HELPER_NODES=0),
        load_memory=lambda data, **options: scene,
        find_anim_prop=lambda layer, node, name: nodes.index(node) in MOVES,
        evaluate_transform=lambda anim, node, moment: transform(),
    )
    monkeypatch.setitem(sys.modules, "ufbx", library)
    numbers = array("d")
    told = fbx_child._answer(b"", {"take": None, "most": most}, numbers)
    return told["count"], len(numbers) // fbx.WIDTH


def test_frames_from_the_first_to_the_last(monkeypatch):
    assert answer(monkeypatch, 1.0, 2.0, 8.0, 1000) == (9, 3 + 2 * 9)


@pytest.mark.parametrize(("begin", "end"), [(0.0, 0.0), (2.0, 1.0)])
def test_a_take_without_a_time_is_as_long_as_its_keys(monkeypatch, begin, end):
    assert answer(monkeypatch, begin, end, 8.0, 1000)[0] == 9


def test_as_many_places_as_may_be(monkeypatch):
    assert answer(monkeypatch, 0.0, 1.0, 8.0, 18) == (9, 21)
    assert answer(monkeypatch, 0.0, 1.0, 8.0, 17) == (-1, 0)


def test_as_long_as_may_be(monkeypatch):
    # a take of as many frames as places is refused before its frames are counted
    assert answer(monkeypatch, 0.0, 2.0**40, 8.0, 2**43) == (-1, 0)
    assert answer(monkeypatch, 0.0, 0.125, 8.0, 4) == (2, 7)


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan")])
def test_a_rate_that_is_none(monkeypatch, rate):
    assert answer(monkeypatch, 0.0, 1.0, rate, 1000) == (-1, 0)


def test_numbers_that_are_places():
    told = {"count": 1, "moved": [], "nodes": [["a", -1, "bone"]]}
    rows = np.full((1, fbx.WIDTH), 1e12)
    assert fbx._scene(told, np.nextafter(rows, 0), File("a.fbx", b"")).moving == {}
    for damaged in (rows, rows * np.nan, np.zeros((2, fbx.WIDTH))):
        with pytest.raises(CaptureError, match="places that are not finite"):
            fbx._scene(told, damaged, File("a.fbx", b""))
