"""Given beats: reading them, counting by them, keeping them in scores."""

from fractions import Fraction

import numpy as np
import pytest
from choreography import choreography
from effort import examples
from hypothesis import given
from hypothesis import strategies as st

import lanindex
from lanindex.encoding.timing import quantise
from lanindex.errors import NotationError
from lanindex.model import Meter, Score, Span
from lanindex.notation import beats, lnd
from lanindex.notation.beats import Beats
from lanindex.notation.excerpt import excerpt

TIMES = st.lists(st.floats(0.1, 2.0), min_size=2, max_size=9).map(
    lambda steps: tuple(round(sum(steps[: n + 1]), 6) for n in range(len(steps)))
)


@pytest.mark.parametrize(
    ("text", "first", "bar", "speed"),
    [
        ("0\n0.5\n1\n", 0, None, 120),
        ("0.2 // upbeat\n\n0.7\n", 4, None, 120),
        ("2.1\n2.6\n", 8, None, 120),  # more than one bar before the first beat
        ("0.4\t4\n1\t1\n1.6\t2\n2.2\t3\n2.8\t4", 3, 4, 100),
        ("0.5\t3\n1\t1\n1.5\t2\n2\t3\n", 2, 3, 120),
        ("0\t1\n1\t1\n", 0, 1, 60),
    ],
)
def test_bars_begin_units(text: str, first: int, bar: int | None, speed: int) -> None:
    found = beats.parse(text)
    assert (found.first, found.bar, found.speed) == (first, bar, speed)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "x: 0 beats, wanted two at least"),
        ("1\n", "x: 1 beats, wanted two at least"),
        ("1\n2 b\n", 'x:2: "2 b", wanted a time in seconds, and perhaps which beat'),
        ("1\nnan\n", 'x:2: "nan", wanted a time'),
        ("-1\n2\n", 'x:1: "-1", wanted a time'),
        ("1 1\n2\n", 'x:2: "2", wanted a time'),
        ("1\n2 1\n", 'x:2: "2 1", wanted a time'),
        ("1 1 1\n2\n", 'x:1: "1 1 1", wanted a time'),
        ("1\n1.04\n", "x:2: a beat at 1.04 s, wanted one at 1.05 s or later"),
        ("0 1\n1 3\n2 1\n", "x: beat 3 behind beat 1, wanted bars of 3 beats, counted from 1"),
        ("0 0\n1 1\n", "x: beat 1 behind beat 0, wanted bars of 1 beats"),
    ],
)
def test_what_is_no_beat_is_refused(text: str, said: str) -> None:
    with pytest.raises(NotationError) as caught:
        beats.parse(text, name="x")
    assert str(caught.value).startswith(said)


@given(TIMES, st.floats(-3, 20))
def test_numbers_of_beats_and_their_times_go_both_ways(times: tuple[float, ...], at: float) -> None:
    told = Beats(Fraction(3), times)
    assert told.numbers(np.array(times)) == pytest.approx(np.arange(len(times)) + 3)
    assert told.seconds(told.numbers(np.array([at])))[0] == pytest.approx(at, abs=1e-9)


@given(TIMES)
def test_a_comment_keeps_them(times: tuple[float, ...]) -> None:
    told = Beats(Fraction(7, 4), times)
    assert Beats.of(["// of a dance", told.line()]) == told


@pytest.mark.parametrize(
    "line",
    ["// beats from 1: 2", "// beats from x: 1 2", "// beats from 1: 2 1", "// beats from 1/0: 1 2",
     "// beats from 1: 1 inf", "// beats from 1: one two", "// beats from here on"],
)  # fmt: skip
def test_another_comment_is_one(line: str) -> None:
    assert Beats.of([line]) is None


def counted(seed: int, told: Beats) -> Score:
    """Return a choreography that counts by some beats."""
    score = choreography(seed, ("r_arm", "l_leg"))
    rows = {part: track.symbols.copy() for part, track in score.tracks.items()}
    wanted = Meter(told.speed)
    meter = quantise(rows.values(), score.frames, score.rate, wanted, told)
    tracks = {
        part: type(track)(part, rows[part], track.known) for part, track in score.tracks.items()
    }
    return Score(score.rate, score.frames, meter, tracks, other=(told.line(),))


UNEVEN = beats.parse("0.35\n0.8\n1.5\n1.9\n2.5\n3.4\n3.7\n4.4\n")


@examples(20)
@given(st.integers(0, 999))
def test_ticks_follow_the_beats(seed: int) -> None:
    score = counted(seed, UNEVEN)
    grid = score.meter.division / score.meter.beats
    for track in score.tracks.values():
        first, *rows = track.symbols
        assert (first["tick"], first["ticks"]) == (0, 0)
        for row in rows:
            seconds = UNEVEN.seconds(np.array([row["tick"], row["tick"] + row["ticks"]]) / grid)
            tick = 0.9 / grid + 1 / 60  # the longest beat
            assert seconds * 60 == pytest.approx([row["start"], row["stop"]], abs=60 * tick)


@examples(20)
@given(st.integers(0, 999))
def test_lnd_gives_ticks_their_times_back(seed: int) -> None:
    score = counted(seed, UNEVEN)
    text = lanindex.write_lnd(score)
    again = lanindex.read_lnd(text)
    before = float(-UNEVEN.seconds(np.zeros(1))[0])  # unit 1 begins so much earlier
    for part, track in score.tracks.items():
        mine = again.tracks[part].symbols[1:]
        rows = track.symbols[1:]
        factor = again.meter.division / score.meter.division
        assert (mine["tick"] == rows["tick"] * factor).all()
        assert (mine["stop"] > mine["start"]).all()
        seconds = mine["start"] / float(again.rate) - before
        tick = 0.9 / score.meter.division * 4 + 1 / 60
        assert seconds == pytest.approx(rows["start"] / 60, abs=tick)
    assert lanindex.write_lnd(lanindex.read_lnd(lnd.write(again))) == lnd.write(again)


@examples(20)
@given(st.integers(0, 999), st.data())
def test_an_excerpt_counts_by_them(seed: int, data: st.DataObject) -> None:
    score = counted(seed, UNEVEN)
    start = data.draw(st.integers(0, score.frames - 60))
    cut = excerpt(score, Span(start, score.frames))
    told = Beats.of(cut.other)
    assert told is not None
    rows = cut.tracks["r_arm"].symbols[1:]
    whole = rows[(rows["start"] > 0) & (rows["ticks"] > 1)]
    grid = cut.meter.division / cut.meter.beats
    seconds = told.seconds(whole["tick"] / grid)
    assert seconds == pytest.approx(whole["start"] / 60, abs=0.9 / grid + 1 / 60)


def test_a_grid_as_fine_as_it_gets_has_a_tick_for_every_track() -> None:
    """Also for those behind one that does not fit."""
    full = np.zeros(3, dtype=choreography(0, ("head",)).tracks["head"].symbols.dtype)
    full["start"], full["stop"] = [0, 0, 0], [0, 1, 1]
    last = full.copy()
    last["start"], last["stop"] = [0, 1, 2], [0, 2, 3]
    meter = quantise([full, last], 3, Fraction(10**6), Meter())
    assert (last["ticks"][1:] > 0).all()
    assert meter.division == 1 << 16
