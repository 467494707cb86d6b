"""A hit to look at: its poses, its staff and what is played of it."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from motions import swung
from sample_hits import BODY, SCORE, hit_of, shot_of

import lanindex
from lanindex.alphabet import JOINT_CODES
from lanindex.draw import draw, svg
from lanindex.draw.picture import Circle, Label, Polyline
from lanindex.film.figure import figure
from lanindex.film.hits import FRAMES, KINDS, LEAST, POSES, RATE, UNKNOWN, different, preview_of
from lanindex.model import Capture, Hit, Span


@pytest.mark.parametrize("rate", [24, 60, 120])
def test_what_is_played_lies_where_the_body_was(rate: int) -> None:
    body = swung(1, rate * 4, Fraction(rate), 0.0)
    score = replace(SCORE, rate=Fraction(rate), frames=rate * 4)
    played = shot_of(hit_of(score, Span(rate, 3 * rate)), body, score, rate).played
    assert (played.start, played.seconds, played.hit) == (1.0, 2.0, (0.0, 2.0))
    assert len(played.places) == 2 * min(rate, RATE)
    each = rate // min(rate, RATE)
    seen = body[rate : 3 * rate : each]
    origin = seen[0, JOINT_CODES["Pelvis"]] * (1, 0, 1) + (0, seen[..., 1].min(), 0)
    assert np.abs(played.places - (seen - origin)).max() <= 0.51
    assert [place for *_, place in played.bones if place not in KINDS] == []


def test_what_is_short_lasts_a_second_and_what_is_long_has_fewer_frames() -> None:
    played = shot_of(hit_of(SCORE, Span(120, 126), "r_arm")).played
    assert played.seconds == pytest.approx(LEAST)
    assert played.start + played.hit[0] == pytest.approx(2.0)
    assert played.hit[1] - played.hit[0] == pytest.approx(0.1)
    first = shot_of(hit_of(SCORE, Span(0, 6), "r_arm")).played
    assert (first.start, first.seconds, first.hit) == (0.0, 1.0, (0.0, 0.1))
    whole = replace(SCORE, frames=30)
    short = shot_of(hit_of(whole, Span(3, 30)), BODY[:30], whole).played
    assert (short.start, short.seconds, len(short.places)) == (0.0, 0.5, 15)
    body = np.repeat(BODY, 20, axis=0)
    long = replace(SCORE, frames=len(body))
    assert len(shot_of(hit_of(long, Span(0, len(body))), body, long).played.places) == FRAMES


def test_what_matched_is_in_colour() -> None:
    shot = shot_of(hit_of(SCORE, Span(30, 120), "r_arm"))
    lit = {bone[:2] for bone in shot.played.bones if bone[2].startswith("lit")}
    names = [*JOINT_CODES]
    assert {(names[a], names[b]) for a, b in lit} == {("RShoulder", "RElbow"), ("RElbow", "RWrist")}
    coloured = [mark for mark in shot.poses.marks if mark.style == "litbone"]
    assert len(coloured) == POSES
    assert {mark.style for mark in shot.poses.marks} == {"light", "bone", "far", "litbone"}


def test_poses_stand_inside_their_frames_on_one_floor() -> None:
    shot = shot_of(hit_of(SCORE, Span(0, 240), "r_arm"))
    picture = shot.poses
    for mark in picture.marks:
        if isinstance(mark, Polyline):
            for x, y in (point for line in mark.lines for point in line):
                assert 0 <= mark.x + x <= picture.width
                assert 0 <= mark.y + y <= picture.height
        if isinstance(mark, Circle):
            assert mark.radius <= mark.y <= picture.height


def test_a_gap_is_left_out_and_what_is_never_seen_is_said() -> None:
    body = BODY.copy()
    body[60:120, JOINT_CODES["RWrist"]] = np.nan
    hit = hit_of(SCORE, Span(60, 120), "r_arm")
    shot = shot_of(hit, body)
    assert "nan" not in svg.write(shot.poses).lower()
    forearms = [len(mark.lines) for mark in shot.poses.marks if mark.style == "litbone"]
    assert forearms == [1] * POSES
    wrist = [*JOINT_CODES].index("RWrist")
    assert (shot.played.places[:, wrist] == UNKNOWN).all()
    body[60:120] = np.nan
    gone = shot_of(hit, body)
    assert (gone.poses, gone.played) == (None, None)
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
    assert (shot.staff, shot.poses, shot.played, shot.trouble) == (None, None, None, "is gone")


def test_what_is_only_passed_is_shown_on_its_way() -> None:
    score = lanindex.encode(lanindex.read("corpus/jumping_jacks.bvh"))
    passed = next(it for it in score.symbols("r_arm") if it.passing)
    span = Span(passed.start, passed.stop)
    capture = Capture(1, "jacks.bvh", "bvh", "0" * 64, "", score.rate, score.frames)
    staff = preview_of(score, Hit(capture, span, 1.0, ((passed,),)), None).staff
    assert staff.marks[0].style == "band"


def test_poses_of_a_movement_that_returns_differ() -> None:
    jacks = figure(lanindex.read("corpus/jumping_jacks.bvh"))
    chosen = different(jacks, np.arange(0, 360, 2))
    hands = jacks.places[chosen, JOINT_CODES["RHand"], 1]
    assert len(chosen) == POSES
    assert (np.diff(np.sort(hands))[1:] > 100).all()  # mm; the first pose and the last are the same
    still = replace(jacks, places=np.repeat(jacks.places[:1], 101, axis=0))
    assert different(still, np.arange(101)).tolist() == [0, 25, 50, 75, 100]
