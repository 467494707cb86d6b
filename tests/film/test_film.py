"""Films: as long as the movement, the figure where the view says, coloured where it matched."""

import sys
from dataclasses import replace
from fractions import Fraction
from itertools import islice, pairwise
from pathlib import Path

import numpy as np
import pytest
from conftest import REPOSITORY
from film_frames import seen

import lanindex
from lanindex.alphabet import JOINT_CODES
from lanindex.app.options import ending
from lanindex.draw.picture import PIXEL, Label
from lanindex.draw.svg import rendered
from lanindex.errors import ExportError, UsageError
from lanindex.film.figure import LEAST, PALETTE, PAPER, Figure, View, figure, scene
from lanindex.film.film import FORMS, RATES, SIZE, Film, FilmStaff, film_bytes
from lanindex.model import Motion, Score

SMALL = (320, 240)
INK, LEFT, RIGHT, LIT = (PALETTE[kind] for kind in ("bone", "left", "right", "lit"))
NEAR = 40  # of 255: how far MP4 may blur a colour


@pytest.fixture(scope="module")
def jacks() -> tuple[Motion, Score]:
    score = lanindex.read_lnd(REPOSITORY / "corpus" / "jumping_jacks.lnd")
    return lanindex.animate(score, rate=25), score


def film_of(motion: Motion, score: Score, **how) -> Film:
    return Film(figure(motion), score, **how)


def is_like(pixels: np.ndarray, color: tuple[int, int, int], near: int = NEAR) -> np.ndarray:
    return (abs(np.subtract(pixels, color, dtype=np.int16)) <= near).all(axis=-1)


def moved(motion: Motion, way: np.ndarray) -> Motion:
    """Return a motion that goes somewhere: (T, 3) mm."""
    return replace(motion, positions=(motion.positions + way[:, None]).astype(np.float32))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("rate", [None, "30000/1001"])
def test_a_film_lasts_as_long_as_the_movement(jacks, form: str, rate: str | None) -> None:
    speed = Fraction(rate) if rate else RATES.get(form, Fraction(25))
    film = film_of(*jacks, start=1, stop=3.5, rate=speed, size=SMALL)
    played = seen(film.written(form), form)
    assert played.size == SMALL
    assert len(played.frames) == len(film) == round(2.5 * speed)
    assert played.seconds == pytest.approx(len(film) / float(speed), abs=0.011)


@pytest.mark.parametrize("form", FORMS)
def test_what_is_played_is_what_was_drawn(jacks, form: str) -> None:
    film = film_of(*jacks, start=2, stop=3, rate=20)
    played = seen(film.written(form), form).frames
    for drawn, shown in zip(film.pictures(), played, strict=True):
        off = abs(np.asarray(drawn).astype(int) - shown)
        assert (off > NEAR).mean() < {"mp4": 0.02, "webp": 1e-9, "gif": 1e-9}[form]
        assert is_like(shown[0, 0], PAPER, 1)


def test_a_film_shows_the_motion_in_real_time(jacks) -> None:
    film = film_of(*jacks, start=2, stop=4, rate=10)
    assert film.frames.tolist() == [50 + 5 * number // 2 for number in range(20)]


def test_the_figure_is_where_the_view_says(jacks) -> None:
    film = film_of(*jacks, start=2, stop=6, rate=5, view="front")
    for number, picture in enumerate(film.pictures()):
        pixels = np.asarray(picture)
        for joint, color in (
            ("RWrist", RIGHT),
            ("LWrist", LEFT),
            ("RKnee", RIGHT),
            ("LKnee", LEFT),
        ):
            x, y = film.scene.points[number, JOINT_CODES[joint]].round().astype(int)
            around = pixels[y - 2 : y + 3, x - 2 : x + 3]
            assert is_like(around, color).any(), (number, joint)
    right, left = (film.scene.points[:, JOINT_CODES[side + "Hip"], 0] for side in "RL")
    assert (right < left).all()  # it faces us


def test_a_place_is_drawn_to_scale(jacks) -> None:
    motion, score = jacks
    film = film_of(motion, score, view="front")
    places = motion.positions[:, motion.skeleton.body].astype(float)  # it faces +z
    seen = (places @ film.scene.view.axes()[:2].T)[film.frames]
    ways = film.scene.points[:, :20] - seen * [1, -1] * film.scene.scale
    assert np.ptp(ways, axis=(0, 1)) == pytest.approx(0, abs=0.02)  # one shift for all


def test_what_matched_is_coloured_while_it_lasts(jacks) -> None:
    motion, score = jacks
    marked = [it for it in score.symbols("r_arm") if it.words == "right high"]
    film = film_of(motion, score, rate=10, marked=marked)
    lit = [
        bool(is_like(np.asarray(picture)[60:, : film.scene.size[0]], LIT).any())
        for picture in film.pictures()
    ]
    rate = float(score.rate)
    told = [any(it.start / rate <= time < it.stop / rate for it in marked) for time in film.times]
    assert lit == told
    assert any(lit)
    assert not all(lit)


def test_a_moment_is_coloured_long_enough_to_be_seen(jacks) -> None:
    motion, score = jacks
    first = score.symbols("r_arm")[0]
    assert first.start == first.stop
    film = film_of(motion, score, rate=20, marked=[first])
    assert film.painter.lit.any(axis=1).sum() == 4


def test_the_line_goes_up_with_time(jacks) -> None:
    staff = FilmStaff(jacks[1], 0, 12, (300, 500), seconds=True)
    assert staff.edges == [0, 6]
    pages, downs = zip(*(staff.at(second) for second in range(12)), strict=True)
    assert [page is pages[0] for page in pages] == [True] * 6 + [False] * 6
    assert len({id(page) for page in pages}) == 2
    steps = np.diff(downs)
    assert np.delete(steps, 5) == pytest.approx(steps[0])
    assert steps[0] < 0
    assert downs[6] == pytest.approx(downs[0])


@pytest.mark.parametrize(("seconds", "edges"), [(5, [0]), (6.1, [0, 3]), (11.9, [0, 6])])
def test_no_page_is_a_stub(jacks, seconds: float, edges: list[float]) -> None:
    staff = FilmStaff(jacks[1], 0, seconds, (300, 500))
    assert staff.edges == edges
    assert staff.at(seconds - 0.01)[1] < staff.at(edges[-1])[1]


def test_who_goes_far_is_followed_and_never_lost(jacks) -> None:
    motion, score = jacks
    time = np.arange(len(motion)) / 25
    way = np.stack([6000 * np.sin(time), 0 * time, 9000 * np.cos(time / 2)], axis=1)
    film = film_of(moved(motion, way), score, view="front")
    assert not film.painter.still
    size = np.array(film.scene.size)
    points = film.scene.points
    assert (points > 0).all()
    assert (points < size).all()
    still = film_of(motion, score, view="front")
    assert still.painter.still
    assert film.scene.scale == pytest.approx(still.scene.scale, rel=0.3)


def test_a_gap_is_a_gap(jacks) -> None:
    motion, score = jacks
    places = motion.positions.copy()
    arm = motion.skeleton.body[[JOINT_CODES[it] for it in ("RElbow", "RWrist", "RHand")]]
    places[50:75, arm] = np.nan
    places[100:125] = np.nan
    film = film_of(replace(motion, positions=places), score, view="front")
    ink = [
        int(is_like(np.asarray(it)[60:, : film.scene.size[0]], RIGHT).sum())
        for it in islice(film.pictures(), 125)
    ]
    assert max(ink[100:125]) == 0
    assert 0 < max(ink[51:74]) < min(ink[40:50])


def test_a_body_that_is_never_seen_is_refused(jacks) -> None:
    motion, score = jacks
    places = motion.positions.copy()
    places[:100] = np.nan
    with pytest.raises(ExportError, match="no joint is known"):
        film_of(replace(motion, positions=places), score, stop=3.9)


def test_a_joint_that_flies_away_makes_nobody_small(jacks) -> None:
    motion, score = jacks
    places = motion.positions.copy()
    places[60, motion.skeleton.body[JOINT_CODES["RWrist"]]] = 1e7
    scales = [
        film_of(replace(motion, positions=it), score, view="front").scene.scale
        for it in (motion.positions, places)
    ]
    assert scales[1] > 0.7 * scales[0]


def test_a_floor_needs_feet(jacks) -> None:
    motion, score = jacks
    places = motion.positions.copy()
    feet = [side + joint for side in "RL" for joint in ("Ankle", "Toe")]
    places[:, motion.skeleton.body[[JOINT_CODES[it] for it in feet]]] = np.nan
    film = film_of(replace(motion, positions=places), score)
    assert film.scene.floor is None
    assert film.scene.lines(0) == []


def test_the_floor_stays_on_its_side(jacks) -> None:
    motion, score = jacks
    time = np.arange(len(motion)) / 25
    way = np.stack([900 * time, 0 * time, 4000 * np.sin(time)], axis=1)
    film = film_of(moved(motion, way), score, rate=2)
    width, height = film.scene.size
    for number in range(len(film)):
        lines = film.scene.lines(number)
        assert len(lines) > 4
        for x, y, a, b in lines:
            assert x == a or y == b
            assert 0 <= x <= a < width
            assert 0 <= y <= b < height
    for time, picture in zip(film.times.tolist(), film.pictures(), strict=True):
        page, line = film.staff.at(time)
        beside = np.asarray(picture)[:, width:]
        rows = np.ones(height, bool)
        rows[int(line) - 2 : int(line) + 2] = False
        assert (beside == np.asarray(page))[rows].all()


def test_tiny_bodies_are_not_blown_up() -> None:
    places = np.full((3, 21, 3), np.nan, np.float32)
    places[:, :2] = [[0, 0, 0], [0, 10, 0]]
    tiny = Figure(places, np.array([[0, 1]]), ("torso",), Fraction(30), np.zeros(3))
    assert scene(tiny, View(0), (300, 300), 25).scale <= 300 / LEAST


@pytest.mark.parametrize(
    ("how", "found"),
    [
        ({"start": 5, "stop": 5}, "nothing from 5 s to 5 s"),
        ({"start": 50}, "nothing from 50 s to 12 s"),
        ({"size": (641, 480)}, "641x480"),
        ({"size": (64, 48)}, "64x48"),
        ({"view": "above"}, 'the view "above"'),
        ({"view": "nan"}, 'the view "nan"'),
        ({"parts": ["r_foot"]}, 'no part "r_foot"'),
    ],
)
def test_what_makes_no_sense_is_refused(jacks, how: dict, found: str) -> None:
    with pytest.raises(UsageError, match=found):
        list(film_of(*jacks, **how).pictures())


def test_one_frame_is_no_film(jacks) -> None:
    motion, score = jacks
    with pytest.raises(ExportError, match="one frame"):
        film_of(replace(motion, positions=motion.positions[:1]), score)


def test_endings_tell_forms() -> None:
    assert [ending(Path(f"a.{form.upper()}"), FORMS) for form in FORMS] == list(FORMS)
    for name in ("walk.avi", "walk", "webp"):
        with pytest.raises(UsageError, match="an ending of mp4"):
            ending(Path(name), FORMS)
    with pytest.raises(UsageError, match="50 at most"):
        film_bytes([], "gif", SIZE, Fraction(60))


@pytest.mark.parametrize(("form", "lib"), [("mp4", "av"), ("gif", "PIL")])
def test_what_is_not_installed_is_named(
    jacks, form: str, lib: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in [it for it in sys.modules if it.split(".")[0] == lib]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, lib, None)
    with pytest.raises(ExportError, match=rf"{lib} is not installed.*|import of {lib}") as caught:
        film_of(*jacks, stop=1).written(form)
    assert "lanindex[film]" in caught.value.remedy


def test_paper_is_white(jacks) -> None:
    picture = np.asarray(next(film_of(*jacks).pictures()))
    assert is_like(picture, PAPER, 0).mean() > 0.8


@pytest.mark.parametrize("way", [(1, 0, 0), (0, 0, 1), (0, 0, 0)])
def test_a_figure_fills_its_half(jacks, way: tuple[int, int, int]) -> None:
    """Across the floor and towards the eye as well as on the spot."""
    motion, score = jacks
    time = np.arange(len(motion))[:, None] / 25
    film = film_of(moved(motion, 1200 * time * np.array(way)), score, view="front", rate=5)
    points = film.scene.points
    high = np.ptp(points[..., 1], axis=1).max()
    wide = np.ptp(points[..., 0], axis=1).max()
    width, height = film.scene.size
    assert max(high / height, wide / width) > 0.75


def test_only_columns_that_move_are_beside_the_figure(jacks) -> None:
    _, score = jacks
    assert {"r_arm", "l_arm"} <= {*FilmStaff(score, 0, 12, (320, 480)).parts}
    rows = score.tracks["l_arm"].symbols
    still = replace(score.tracks["l_arm"], symbols=rows[rows["start"] == rows["stop"]][:1])
    tracks = {**score.tracks, "l_arm": still}
    staff = FilmStaff(replace(score, tracks=tracks), 0, 12, (320, 480))
    assert "r_arm" in staff.parts
    assert "l_arm" not in staff.parts
    named = FilmStaff(replace(score, tracks=tracks), 0, 12, (320, 480), parts=["l_arm"])
    assert named.parts == ["l_arm"]


@pytest.mark.parametrize("size", [(640, 480), (1280, 720)])
def test_letters_of_a_staff_can_be_read(
    jacks, size: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn = []
    monkeypatch.setattr(
        "lanindex.film.film.rendered", lambda *it: drawn.append(it) or rendered(*it)
    )
    next(film_of(*jacks, size=size).pictures())
    ((picture, _, scale),) = drawn
    marks = [it for mark in picture.marks for it in getattr(mark, "marks", [mark])]
    letters = [it for it in marks if isinstance(it, Label)]
    assert min(it.size * scale / PIXEL for it in letters) > 11.9
    names = [it for it in letters if it.turned]
    assert all(it.y + 0.6 * it.size * len(it.text) <= picture.height for it in names)
    assert picture.height * scale / PIXEL <= size[1] + 1


def test_a_film_tells_its_name_and_the_time(jacks) -> None:
    film = film_of(*jacks, title="jacks", stop=2, rate=5)
    above = [np.asarray(it)[:24, : film.scene.size[0]].min(axis=2) < 128 for it in film.pictures()]
    names = [it[:, :60] for it in above]
    clocks = [it[:, -60:] for it in above]
    assert names[0].any()
    assert all((it == names[0]).all() for it in names)
    assert all((one != two).any() for one, two in pairwise(clocks))
    assert not film_of(*jacks, stop=2).painter.lit.any()
    long = np.asarray(next(film_of(*jacks, title="jacks " * 40, stop=2).pictures()))
    assert (long[:24, film.scene.size[0] - 60 : film.scene.size[0]].min(axis=2) < 128).any()


def test_a_film_without_room_for_its_name_has_none(jacks) -> None:
    assert next(film_of(*jacks, title="jacks", size=(120, 120), stop=2).pictures()).size == (
        120,
        120,
    )
