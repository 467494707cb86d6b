"""Warping of joint positions against its plain twin, and its laws."""

import numpy as np
import pytest
from effort import examples
from hypothesis import given
from hypothesis import strategies as st
from plain_example import warped as plainly

from lanindex.alphabet import JOINT_CODES
from lanindex.pipeline.example import normalised, warped


def body(seed, frames):
    return np.random.default_rng(seed).normal(0, 400, (frames, 20, 3)).astype(np.float32)


@examples(40)
@given(st.integers(0, 99), st.integers(1, 7), st.integers(1, 7))
def test_it_is_what_the_plain_one_says(seed, one, two) -> None:
    a, b = body(seed, one) / 400, body(seed + 100, two) / 400
    assert warped(a, b) == pytest.approx(plainly(a, b), rel=1e-5)
    assert warped(a, a) == pytest.approx(0, abs=1e-3)
    assert warped(a, b) == pytest.approx(warped(b, a), rel=1e-5)


def test_place_facing_size_and_rate_make_no_difference() -> None:
    joints = body(1, 60)
    turn = np.radians(70)
    turned = joints.copy()
    turned[..., 0] = np.cos(turn) * joints[..., 0] + np.sin(turn) * joints[..., 2]
    turned[..., 2] = np.cos(turn) * joints[..., 2] - np.sin(turn) * joints[..., 0]
    other = normalised((1.3 * turned + [500, 20, -900]).astype(np.float32), 30)
    assert other == pytest.approx(normalised(joints, 30), abs=1e-4)
    assert len(normalised(np.repeat(joints, 4, axis=0), 120)) == 60


def test_joints_that_are_unknown_do_not_count() -> None:
    one, two = normalised(body(1, 8), 30), normalised(body(2, 8), 30)
    holed = two.copy()
    holed[3, JOINT_CODES["Head"]] = np.nan
    without = np.delete(two, JOINT_CODES["Head"], axis=1)
    assert warped(one, holed) == pytest.approx(
        warped(np.delete(one, JOINT_CODES["Head"], axis=1), without)
    )
    assert warped(one, np.full_like(two, np.nan)) == np.inf
