"""The work of a search, counted and not timed."""

import numpy as np
import pytest
from fast_search import find_fast
from query_cases import recordings_of

from lanindex.errors import LanindexError
from lanindex.search import limits
from lanindex.search.language import parse
from lanindex.search.match import arrays, backward, join, relations, walk


def found(tracks: str, pattern: str, **options) -> list[tuple[int, int]]:
    (recording,) = recordings_of(f"fps 10 frames 100; {tracks}")
    hits = find_fast(parse(pattern), [(recording.capture, recording.tracks)], **options)
    return [(hit.span.start, hit.span.stop) for hit in hits]


WAVE = "r_arm: place low 0 0, " + ", ".join(
    f"{'right' if k % 2 else 'left'} {'high' if k % 3 else 'low'} {2 * k} {2 * k + 2}"
    for k in range(49)
)


@pytest.mark.parametrize(
    "pattern",
    [
        "(r_arm any -> any) x3+",
        "((r_arm any x1+) x1+) x1+",
        "(r_arm left ... right) x3+",
        "(r_arm low? ... high x1+) x2+ ... low",
        "r_arm any ... any ... any ... any ... any ... high",
        "(r_arm any with l_arm any) x3+ -> end",
        "(r_arm left x0..20 -> right x0..20 -> any) x3+",
    ],
)
def test_repeats_and_gaps_do_not_blow_up(pattern, monkeypatch):
    monkeypatch.setattr(limits, "most_rows", lambda size: 50_000 if size == walk.MATCH else 1 << 20)
    assert found(f"{WAVE}; {WAVE.replace('r_arm', 'l_arm')}", pattern)


@pytest.mark.parametrize(
    "pattern",
    [
        "(r_arm any ... any) x3+ without arm high",
        "a: r_arm any ... b: any ... c: any ... d: any ... e: any where a.start + e.end > 99s "
        "and b.start + e.end > 99s and c.start + e.end > 99s",
        "r_arm any ... any with b: l_arm any ... c: any with d: head any ... e: any "
        "where b.end > e.end and c.end > d.end",
    ],
)
def test_what_cannot_be_tried_is_said(pattern, monkeypatch):
    monkeypatch.setattr(limits, "MOST_TRIED", 50)
    wave = WAVE.replace("low", "high")
    with pytest.raises(LanindexError, match=r"1\.lnd: the pattern fits in too many ways"):
        found(f"{wave}; {wave.replace('r_arm', 'l_arm')}; {wave.replace('r_arm', 'head')}", pattern)


@pytest.fixture
def pairs(monkeypatch):
    """Return how many pairs are made at once, again and again."""
    made = []

    def counted(low, high):
        found = spread(low, high)
        made.append(len(found[0]))
        return found

    spread = arrays.spread
    for module in (arrays, join, relations, walk, backward):
        monkeypatch.setattr(module, "spread", counted, raising=False)
    return made


LONG_WAVE = "place low 0 0, " + ", ".join(
    f"{'right' if k % 2 else 'left'} high {2 * k} {2 * k + 2}" for k in range(400)
)


@pytest.mark.parametrize(
    "pattern", ["r_arm any x3+ with l_arm any x3+", "r_arm any x1+ with l_arm any x1+"]
)
def test_lines_that_both_run_on_are_not_paired(pattern, pairs):
    """Each of them shares frames with all of the other: those are not listed."""
    (recording,) = recordings_of(f"fps 10 frames 900; r_arm: {LONG_WAVE}; l_arm: {LONG_WAVE}")
    assert find_fast(parse(pattern), [(recording.capture, recording.tracks)])
    assert sum(pairs) < 20 * 400


def test_a_capture_that_is_refused_is_not_followed_any_further(pairs, monkeypatch):
    monkeypatch.setattr(limits, "MOST_TRIED", 1000)
    monkeypatch.setattr(arrays, "MOST_AT_ONCE", 500)
    (recording,) = recordings_of(f"fps 10 frames 900; r_arm: {LONG_WAVE}; l_arm: {LONG_WAVE}")
    pattern = parse("r_arm any ... any with l_arm any ... any")
    with pytest.raises(LanindexError, match="too many ways"):
        find_fast(pattern, [(recording.capture, recording.tracks)])
    assert sum(pairs) < 5000


def test_who_waits_is_told_with_each_piece_of_pairs(monkeypatch):
    monkeypatch.setattr(arrays, "MOST_AT_ONCE", 10)
    told = []
    with limits.running(None, lambda: told.append(1)):
        pieces = list(arrays.in_pieces(np.full(30, 5)))
    assert len(told) == len(pieces) == 16


def test_who_waits_is_told_with_each_column_that_is_sorted():
    told = []
    columns = (*np.random.default_rng(1).integers(0, 1 << 40, (4, 50)), np.arange(50) // 7)
    columns[0][:] = 3
    with limits.running(None, lambda: told.append(1)):
        order, which = arrays.grouped(columns)
    assert len(told) > 2 * len(columns)  # too large to be packed: each is sorted by
    rows = list(zip(*(it.tolist() for it in columns), strict=True))
    assert [rows[it] for it in order] == sorted(set(rows))
    assert [rows[order[it]] for it in which] == rows
