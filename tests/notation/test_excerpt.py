from fractions import Fraction
from math import floor

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from random_scores import scores

from lanindex.alphabet import BODY
from lanindex.model import Meter, Score, Span, Track
from lanindex.model.symbol import blank
from lanindex.notation import lnd
from lanindex.notation.excerpt import excerpt

Cell = tuple[int, int]

SAID = ("direction", "level", "amount")
"""What a symbol says."""


def state(track: Track, frame: int) -> tuple[Cell | None, Cell | None, bool] | None:
    """Tell plainly what a part does in a frame: arrived at, on the way to, whether it starts."""
    if not any(one.start <= frame < one.stop for one in track.known):
        return None
    arrived = heading = None
    begins = False
    for row in track.symbols:
        cell = int(row["direction"]), int(row["level"])
        if row["stop"] <= frame:
            arrived = cell
        elif row["start"] <= frame:
            heading, begins = cell, bool(row["start"] == frame)
    return arrived, heading, begins


@given(scores(), st.data())
def test_every_frame_stays_what_it_was(score: Score, data: st.DataObject) -> None:
    start = data.draw(st.integers(0, score.frames - 1))
    stop = data.draw(st.integers(start + 1, score.frames))
    cut = excerpt(score, Span(start, stop))
    assert (cut.frames, cut.rate) == (stop - start, score.rate)
    for part, track in score.tracks.items():
        for frame in range(start, stop):
            before, after = state(track, frame), state(cut.tracks[part], frame - start)
            if frame == start and before and after and before[1]:
                before, after = before[:2], after[:2]  # it may have begun before the cut
            assert before == after


@given(scores(("r_arm", *(part for part in BODY if part != "step"))), st.data())
def test_an_excerpt_of_lnd_is_lnd(score: Score, data: st.DataObject) -> None:
    start = data.draw(st.integers(0, score.frames - 1))
    stop = data.draw(st.integers(start + 1, score.frames))
    cut = excerpt(score, Span(start, stop))
    again = lnd.read(lnd.write(cut))
    for part, track in cut.tracks.items():
        rows = again.tracks[part].symbols if len(track) else track.symbols
        assert [[row[name] for name in SAID] for row in track.symbols] == [
            [row[name] for name in SAID] for row in rows
        ]


def test_what_is_over_does_not_stand_at_the_beginning_of_an_excerpt() -> None:
    score = lnd.read(
        "#unit1\nsupport r_support forward low 0 1\njump jump place hop 1 2\n"
        "rotation body_turn left 90 0 1\ntravel body_travel left 0 0 2\n"
        "travel body_travel back 50 2 4\n"
    )
    cut = excerpt(score, Span(16, 32))
    assert [str(symbol) for symbol in cut.symbols()] == [
        "r_support forward low [0, 0)",
        "body_travel back 50deg [0, 16)",
    ]


@st.composite
def captures(draw: st.DrawFn) -> Score:
    """Draw the score of a capture: frames at 60 Hz, ticks rounded to eighths of a second."""
    lengths = draw(st.lists(st.integers(8, 40), min_size=1, max_size=8))
    rows = blank(len(lengths) + 1)
    rows["start"][1:] = np.cumsum([0, *lengths])[:-1]
    rows["stop"][1:] = np.cumsum(lengths)
    rows["direction"], rows["level"] = np.arange(len(rows)) % 9, 0
    rows["tick"] = np.round(rows["start"] * 8 / 60)
    rows["ticks"] = np.round(rows["stop"] * 8 / 60) - rows["tick"]
    frames = sum(lengths) + draw(st.integers(0, 9))
    track = Track("r_arm", rows, (Span(0, frames),))
    heading = np.arange(frames, dtype=np.float32)
    return Score(Fraction(60), frames, Meter(), {"r_arm": track}, heading)


def test_what_begins_with_the_excerpt_begins_in_its_first_tick() -> None:
    """Also where its tick was rounded away from its frame, as beside a neighbour."""
    rows = blank(2)
    rows["start"], rows["stop"] = [0, 11], [0, 40]
    rows["tick"], rows["ticks"] = [0, 2], [0, 3]
    score = Score(Fraction(60), 60, Meter(), {"head": Track("head", rows, (Span(0, 60),))})
    symbols = excerpt(score, Span(11, 60)).tracks["head"].symbols
    assert [(row["tick"], row["start"]) for row in symbols] == [(0, 0), (0, 0)]


@given(captures(), st.data())
def test_no_symbol_of_a_capture_is_lost(score: Score, data: st.DataObject) -> None:
    start = data.draw(st.integers(0, score.frames - 1))
    stop = data.draw(st.integers(start + 1, min(score.frames, start + 30)))
    cut = excerpt(score, Span(start, stop))
    rows = score.tracks["r_arm"].symbols[1:]
    met = rows[(rows["stop"] > start) & (rows["start"] < stop)]
    kept = cut.tracks["r_arm"].symbols[1:]
    assert list(kept["direction"]) == list(met["direction"])
    assert (kept["ticks"] > 0).all()
    assert (kept["tick"][1:] >= (kept["tick"] + kept["ticks"])[:-1]).all()
    room = cut.meter.tick_rate * (stop - start) / 60
    quantum = cut.meter.tick_rate / Meter().tick_rate
    assert all(kept["tick"] + kept["ticks"] <= room + quantum)
    assert list(cut.heading) == list(range(start, stop))


@given(captures(), st.data())
def test_ticks_stay_where_they_were(score: Score, data: st.DataObject) -> None:
    """The edge is rounded to half a quantum; a symbol cut to less than one pushes by one."""
    start = data.draw(st.integers(0, score.frames - 1))
    cut = excerpt(score, Span(start, score.frames))
    assume(cut.meter == score.meter and len(cut.tracks["r_arm"]) > 2)
    last, mine = score.tracks["r_arm"].symbols[-1], cut.tracks["r_arm"].symbols[-1]
    assert abs(int(last["tick"]) - start * 8 / 60 - int(mine["tick"])) <= 1.5
    assert abs(int(last["ticks"]) - int(mine["ticks"])) <= 1


@pytest.mark.parametrize("rate", [25, 30, 60, 100, Fraction(30000, 1001)])
def test_the_heading_is_that_of_a_capture_of_its_length(rate: Fraction) -> None:
    """Each value tells its own time here, in seconds from the beginning of the whole."""
    frames = 200
    heading = np.arange(floor((frames - 1) * 60 / Fraction(rate)) + 1, dtype=np.float32) / 60
    score = Score(Fraction(rate), frames, Meter(), {}, heading)
    for start, stop in ((0, 1), (1, 2), (7, 40), (33, 180), (50, 50)):
        cut = excerpt(score, Span(start, stop)).heading
        alone = floor((stop - start - 1) * 60 / Fraction(rate)) + 1 if stop > start else 0
        assert len(cut) == alone
        wanted = start / float(rate) + np.arange(alone) / 60
        assert cut == pytest.approx(wanted, abs=0.5 / 60 + 1e-6)


RAISE = """\
// a raise
#speed=60
#unit0
direction r_arm place low 0 0
#unit1
hold head 0 2
direction r_arm right mid 0 2
direction r_arm place high 3 5
#unit3
direction r_arm place low 1 2
"""


def test_cut_at_both_edges() -> None:
    """Beats 1 to 4 of the raise: half of the first symbol, half of the second."""
    assert lnd.write(excerpt(lnd.read(RAISE), Span(8, 32))) == (
        "// a raise\n#speed=60\n#rhythm 4/4\n#unit_per_line 4\n#unit_total 1\n"
        "#unit0\ndirection r_arm place low 0 0\n"
        "#unit1\ndirection r_arm right mid 0 1\ndirection r_arm place high 2 3\n"
    )


def test_the_direction_in_force_is_the_last_that_was_reached() -> None:
    assert lnd.write(excerpt(lnd.read(RAISE), Span(16, 24))).endswith(
        "#unit0\ndirection r_arm right mid 0 0\n"
    )


def test_all_of_it_is_itself() -> None:
    score = lnd.read(RAISE)
    assert excerpt(score, Span(0, score.frames)) is score
    assert excerpt(score, Span(-5, 10_000)) is score


def test_a_part_not_seen_is_left_out() -> None:
    rows = blank(1)
    rows["start"] = rows["stop"] = rows["tick"] = 40
    tracks = {"r_arm": Track("r_arm", rows, (Span(40, 60),))}
    score = Score(Fraction(60), 60, Meter(), tracks)
    assert not excerpt(score, Span(0, 40)).tracks
    assert excerpt(score, Span(0, 41)).tracks["r_arm"].known == (Span(40, 41),)
    assert not excerpt(score, Span(30, 30)).tracks
