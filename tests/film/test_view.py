"""From where a figure is seen."""

from fractions import Fraction

import numpy as np
import pytest
from conftest import REPOSITORY
from motions import motion_of

import lanindex
from lanindex.alphabet import JOINT_CODES
from lanindex.film.figure import SAMPLES, View, faced, figure, view

FRAMES = 60


def standing(frames: int = FRAMES) -> np.ndarray:
    """Return a body that faces +z and stands still."""
    motion = lanindex.animate(lanindex.read_lnd(REPOSITORY / "corpus" / "jumping_jacks.lnd"))
    places = figure(motion).places[0].astype(float)
    return np.repeat(places[None], frames, axis=0)


def turned(places: np.ndarray, *tracks: str) -> float:
    """Return from how many degrees about the front a body is seen."""
    body = figure(motion_of(places[:, :20], Fraction(30)))
    return view([(faced(body, np.arange(len(body))), tracks)]).turn


def swinging(joint: str, way: tuple[float, float, float], frames: int = FRAMES) -> np.ndarray:
    places = standing(frames)
    wave = np.sin(np.linspace(0, 6 * np.pi, frames))[:, None]
    places[:, JOINT_CODES[joint]] += 300 * wave * np.array(way)
    return places


def test_projection_keeps_up_and_right() -> None:
    front = View(0, 0).axes()[:2].T
    assert np.allclose(front, [[1, 0], [0, 1], [0, 0]], atol=1e-6)
    side = View(90, 0).axes()[:2].T
    assert np.allclose(side, [[0, 0], [0, 1], [-1, 0]], atol=1e-6)
    above = View(0, 90).axes()[:2].T
    assert np.allclose(above, [[1, 0], [0, 0], [0, -1]], atol=1e-6)
    axes = View(37, 12).axes()
    assert np.allclose(axes @ axes.T, np.eye(3))


@pytest.mark.parametrize(
    ("joint", "track", "way", "turn"),
    [
        ("RWrist", "r_arm", (1, 0, 0), 0),  # sideways: from the front
        ("RWrist", "r_arm", (0, 0, 1), -90),  # forward: from the right
        ("LWrist", "l_arm", (0, 0, 1), 90),  # of the left: from the left
        ("RWrist", "r_arm", (0, 1, 0), 0),  # up and down: from the front
        ("RWrist", "r_arm", (1, 0, 1), -45),  # to the left and forward: over the right shoulder
        ("RWrist", None, (0, 0, 1), -90),
        ("RWrist", "l_arm", (0, 0, 1), 0),  # what does not move is seen from the front
        ("RAnkle", "r_support", (0, 0, 1), -90),
    ],
)
def test_a_movement_is_seen_across(
    joint: str, track: str | None, way: tuple[float, float, float], turn: float
) -> None:
    tracks = () if track is None else (track,)
    assert turned(swinging(joint, way), *tracks) == pytest.approx(turn, abs=2)


@pytest.mark.parametrize("degrees", [0, 30, 90, 179, 250])
def test_a_turned_body_is_seen_from_a_turned_eye(degrees: float) -> None:
    angle = np.radians(degrees)
    about = np.array(
        [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    )
    for way, turn in (((0, 0, 1), -90), ((1, 0, 0), 0)):
        assert turned(swinging("RWrist", way) @ about.T, "r_arm") == pytest.approx(turn, abs=2)


def test_a_limb_is_seen_apart_from_the_way_of_the_body() -> None:
    places = swinging("RWrist", (1, 0, 0))
    places[..., 2] += np.linspace(0, 3000, FRAMES)[:, None]
    assert turned(places, "r_arm") == pytest.approx(0, abs=2)
    assert turned(places) == pytest.approx(-90, abs=2)


def test_many_bodies_are_seen_from_one_side() -> None:
    ways = [swinging("RWrist", (1, 0, 0)), 2 * swinging("RWrist", (0, 0, 1))]
    bodies = [figure(motion_of(it[:, :20], Fraction(30))) for it in ways]
    both = [(faced(it, np.arange(FRAMES)), ("r_arm",)) for it in bodies]
    assert view(both).turn == pytest.approx(-90, abs=2)  # what is larger decides
    assert view(both[:1]).turn == pytest.approx(0, abs=2)
    assert view([]).turn == 0


def test_gaps_and_absent_joints_do_no_harm() -> None:
    places = swinging("RWrist", (0, 0, 1))
    places[10:30, JOINT_CODES["RWrist"]] = np.nan
    places[:, JOINT_CODES["LHip"]] = np.nan
    assert turned(places, "r_arm") == pytest.approx(-90, abs=2)
    places[:, JOINT_CODES["RShoulder"]] = np.nan  # nothing tells the front, nor the arm's way
    assert turned(places, "r_arm") == 0


def test_long_captures_are_looked_at_here_and_there() -> None:
    few, many = (turned(swinging("RWrist", (1, 0, 2), it)) for it in (600, 20 * SAMPLES))
    assert few == pytest.approx(many, abs=1)
