"""A hit to look at: its poses, its staff and what is played of it."""

from collections import Counter
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from motions import motion_of, swung
from sample_hits import BODY, SCORE, hit_of, shot_of

import lanindex
from lanindex.alphabet import JOINT_CODES
from lanindex.draw import draw, svg
from lanindex.draw.picture import Label, Polyline
from lanindex.film.figure import View, figure
from lanindex.film.hits import (
    FRAMES,
    LEAST,
    POSES,
    RATE,
    different,
    playback,
    poses,
    preview_of,
    seen_from,
)
from lanindex.model import Capture, Hit, Span
from lanindex.pipeline.search import matched


@pytest.mark.parametrize("rate", [24, 60, 120])
def test_what_is_played_lies_where_the_body_was(rate: int) -> None:
    body = swung(1, rate * 4, Fraction(rate), 0.0)
    score = replace(SCORE, rate=Fraction(rate), frames=rate * 4)
    played = shot_of(hit_of(score, Span(rate, 3 * rate)), body, score, rate).played
    assert (played.start, played.seconds, played.hit) == (1.0, 2.0, (0.0, 2.0))
    assert len(played.body) == 2 * min(rate, RATE)
    each = rate // min(rate, RATE)
    seen = body[rate : 3 * rate : each]
    origin = seen[0, JOINT_CODES["Pelvis"]] * (1, 0, 1) + (0, seen[..., 1].min(), 0)
    fronts = figure(motion_of(body, Fraction(rate))).fronts[rate : 3 * rate : each]
    axes = View(float(np.degrees(np.angle(np.exp(1j * fronts).mean()))), 0).axes()
    assert np.abs(played.body.places[:, :20] - (seen - origin) @ axes.T).max() < 0.01


def test_what_is_short_lasts_a_second_and_what_is_long_has_fewer_frames() -> None:
    played = shot_of(hit_of(SCORE, Span(120, 126), "r_arm")).played
    assert played.seconds == pytest.approx(LEAST)
    assert played.start + played.hit[0] == pytest.approx(2.0)
    assert played.hit[1] - played.hit[0] == pytest.approx(0.1)
    first = shot_of(hit_of(SCORE, Span(0, 6), "r_arm")).played
    assert (first.start, first.seconds, first.hit) == (0.0, 1.0, (0.0, 0.1))
    whole = replace(SCORE, frames=30)
    short = shot_of(hit_of(whole, Span(3, 30)), BODY[:30], whole).played
    assert (short.start, short.seconds, len(short.body)) == (0.0, 0.5, 15)
    body = np.repeat(BODY, 20, axis=0)
    long = replace(SCORE, frames=len(body))
    assert len(shot_of(hit_of(long, Span(0, len(body))), body, long).played.body) == FRAMES


def drawn(shot):
    """Return the strokes of a hit's poses."""
    picture = poses(shot.played, seen_from([shot.played]), shot.path)
    return picture, [mark for mark in picture.marks if mark.style != "light"]


def test_what_matched_is_in_colour() -> None:
    _, strokes = drawn(shot_of(hit_of(SCORE, Span(30, 120), "r_arm")))
    tally = Counter(mark.style for mark in strokes for _ in mark.lines)
    arms, legs, trunk = 3, 3, 7  # bones of a limb; the nose is one of the trunk's
    assert tally == {
        "lit": 2 * POSES,  # upper arm and forearm
        "head": POSES,
        "bone": (trunk + 1) * POSES,
        **dict.fromkeys(("right", "left"), (arms + legs) * POSES),
    }


def test_poses_stand_inside_their_frames_on_one_floor() -> None:
    picture, strokes = drawn(shot_of(hit_of(SCORE, Span(0, 240), "r_arm")))
    for mark in strokes:
        for x, y in (point for way in mark.lines for point in way):
            assert mark.width / 2 <= mark.x + x <= picture.width - mark.width / 2
            assert mark.width / 2 <= mark.y + y <= picture.height


def test_a_gap_is_left_out_and_what_is_never_seen_is_said() -> None:
    body = BODY.copy()
    body[60:120, JOINT_CODES["RWrist"]] = np.nan
    hit = hit_of(SCORE, Span(60, 120), "r_arm")
    shot = shot_of(hit, body)
    picture, strokes = drawn(shot)
    assert "nan" not in svg.write(picture).lower()
    assert [len(mark.lines) for mark in strokes if mark.style == "lit"] == [1] * POSES
    assert np.isnan(shot.played.body.places[:, JOINT_CODES["RWrist"]]).all()
    body[60:120] = np.nan
    gone = shot_of(hit, body)
    assert gone.played is None
    assert gone.trouble == "no joint is known meanwhile"
    assert gone.staff is not None
    body[90:] = BODY[90:]  # seen for half of it
    assert shot_of(hit, body).played is not None


def test_a_staff_says_what_the_whole_score_says() -> None:
    hit = hit_of(SCORE, Span(60, 180), "r_arm", "l_arm")
    assert {it.part for it in hit.symbols} == {"r_arm", "l_arm"}
    shot = shot_of(hit)
    whole = draw(
        SCORE,
        parts=["r_arm", "l_arm"],
        start=1.0,
        stop=3.0,
        bars=None,
        seconds=True,
        marked=hit.symbols,
        beat=shot.beat,
    )
    assert shot.staff.marks == tuple(
        it for it in whole.marks if not isinstance(it, Label) or not it.turned
    )
    ends = [it.y for it in shot.staff.marks if isinstance(it, Polyline) and it.style == "staff"]
    assert shot.base in ends
    assert shot.base - 2 * shot.beat in ends  # two seconds later


def test_what_has_no_column_has_no_staff() -> None:
    hit = hit_of(SCORE, Span(60, 120), "r_arm")
    odd = [replace(it, part="tail") for it in hit.symbols]
    shot = preview_of(SCORE, replace(hit, lines=(tuple(odd),)), None, "is gone")
    assert (shot.staff, shot.played, shot.trouble) == (None, None, "is gone")


def test_what_is_only_passed_is_shown_on_its_way() -> None:
    score = lanindex.encode(lanindex.read("corpus/jumping_jacks.bvh"))
    passed = next(it for it in score.symbols("r_arm") if it.passing)
    span = Span(passed.start, passed.stop)
    capture = Capture(1, "jacks.bvh", "bvh", "0" * 64, "", score.rate, score.frames)
    staff = preview_of(score, Hit(capture, span, 1.0, ((passed,),)), None).staff
    assert staff.marks[0].style == "band"


def test_jumping_jacks_are_five_poses() -> None:
    jacks = figure(lanindex.read("corpus/jumping_jacks.bvh"))
    score = lanindex.encode(lanindex.read("corpus/jumping_jacks.bvh"))
    hits = matched(score, "jumping_jack", None)
    assert len(hits) == 7
    for hit in hits:
        edges = min(it.start for it in hit), max(it.stop for it in hit)
        seconds = tuple(float(it / score.rate) for it in edges)
        played = playback(jacks, (), seconds, seconds)
        ends = played.body.places[played.poses][:, [JOINT_CODES[it] for it in ("RHand", "RAnkle")]]
        apart = ends[:, None, :, :2] - ends[None, :, :, :2]  # as seen from the front
        far = np.linalg.norm(apart, axis=3).max(axis=2)[np.triu_indices(POSES, 1)]
        assert far.min() > 100  # mm: none is shown twice, going up or down
    still = np.repeat(jacks.places[:1], 101, axis=0)
    assert different(still).tolist() == [0, 25, 50, 75, 100]


def test_hits_of_one_search_are_seen_from_one_side() -> None:
    """A body that faces elsewhere is drawn alike."""
    turn = View(130, 0).axes()
    hit = hit_of(SCORE, Span(30, 120), "r_arm")
    shots = [shot_of(hit, body) for body in (BODY, BODY @ turn + (3000, 0, 500))]
    eye = seen_from(it.played for it in shots)
    one, other = (
        np.array([way for it in poses(shot.played, eye, "").marks for way in it.lines])
        for shot in shots
    )
    assert np.abs(one - other).max() <= 1  # unit: they are rounded
