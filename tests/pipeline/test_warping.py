"""Warping of joint positions against its plain twin, and its laws."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from effort import examples
from hypothesis import given
from hypothesis import strategies as st
from plain_example import warped as plainly

import lanindex
from lanindex.alphabet import JOINT_CODES
from lanindex.errors import UsageError
from lanindex.pipeline import warping
from lanindex.pipeline.motion import motion
from lanindex.pipeline.warping import cheapest_way, normalised, warped


def body(seed, frames):
    return np.random.default_rng(seed).normal(0, 400, (frames, 20, 3)).astype(np.float32)


@examples(40)
@given(st.integers(0, 99), st.integers(1, 7), st.integers(1, 7))
def test_it_is_what_the_plain_one_says(seed, one, two) -> None:
    a, b = body(seed, one) / 400, body(seed + 100, two) / 400
    assert warped(a, b) == pytest.approx(plainly(a, b), rel=1e-5)
    assert warped(a, a) == pytest.approx(0, abs=1e-3)
    assert warped(a, b) == pytest.approx(warped(b, a), rel=1e-5)


@examples(40)
@given(st.integers(0, 99), st.integers(1, 7), st.integers(1, 7))
def test_the_cheapest_way_costs_what_is_told(seed, one, two) -> None:
    a, b = body(seed, one) / 400, body(seed + 100, two) / 400
    way = cheapest_way(a, b)
    steps = np.diff(way, axis=0, prepend=[[-1, -1]])
    assert way[[0, -1]].tolist() == [[0, 0], [one - 1, two - 1]]
    assert ((steps >= 0) & (steps <= 1)).all()
    apart = np.linalg.norm(a[way[:, 0]] - b[way[:, 1]], axis=2).mean(axis=1)
    cost = (apart * steps.sum(axis=1)).sum() / (one + two)
    assert cost == pytest.approx(warped(a, b), rel=1e-5)


CORPUS = Path(__file__).parents[2] / "corpus"


@pytest.mark.parametrize("name", ["radio_gymnastics", "port_de_bras", "conductor_three"])
def test_a_copy_that_is_now_faster_now_slower_comes_into_step(name, tmp_path) -> None:
    head, _, rows = (CORPUS / f"{name}.bvh").read_text().partition("Frame Time:")
    time, *frames = rows.strip().splitlines()
    frames = frames[:600]
    # 1.5 times as long, now half and now twice as fast as that
    pace = np.exp(0.7 * np.sin(np.linspace(0, 14, round(1.5 * len(frames)))))
    taken = np.round((np.cumsum(pace) - pace[0]) / (pace.sum() - pace[0]) * (len(frames) - 1))
    for file, own in (("one", np.arange(len(frames))), ("two", taken.astype(int))):
        text = f"{head.rpartition('Frames:')[0]}Frames: {len(own)}\nFrame Time: {time}\n"
        (tmp_path / f"{file}.bvh").write_text(text + "\n".join(frames[it] for it in own) + "\n")
    with lanindex.open_library(tmp_path / "own.db", create=True) as library:
        library.ingest(tmp_path)
        seconds = library.in_step(1, 2)
        joints = normalised(library.motion(1).places[:, :20], 30)
    assert (np.diff(seconds, axis=0) >= 0).all()
    assert seconds[-1] == pytest.approx([len(frames) / 30, len(taken) / 30], rel=1e-4)
    wanted = np.interp(seconds[:-1, 0] * 30, taken, np.arange(len(taken)))
    moves = np.linalg.norm(np.gradient(joints, axis=0), axis=2).max(axis=1) > 0.01
    apart = abs(seconds[:-1, 1] * 30 - wanted)[moves[:-1]]
    assert apart.max() <= 2  # frames: where it moves, all is where it belongs


def test_gaps_are_passed_over_and_a_body_without_legs_is_refused(tmp_path, monkeypatch) -> None:
    unseen: dict[str, slice] = {}

    def seen(*given, **options):
        body = motion(*given, **options)
        places = body.places.copy()
        for joint, frames in unseen.items():
            places[frames, JOINT_CODES[joint]] = np.nan
        return replace(body, places=places)

    monkeypatch.setattr(warping, "motion", seen)
    with lanindex.open_library(tmp_path / "own.db", create=True) as library:
        library.ingest(*(CORPUS / f"conductor_{it}.bvh" for it in ("three", "four")))
        whole = library.in_step(1, 2)
        unseen |= {"RHip": slice(100, 130), "LWrist": slice(0, 20), "Head": slice(9, None)}
        assert abs(library.in_step(1, 2) - whole).mean() < 0.1
        unseen |= {"RKnee": slice(None), "LKnee": slice(None)}
        with pytest.raises(UsageError, match="no joint is known well enough"):
            library.in_step(1, 2)


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
