"""How much a search tries: counted, not timed."""

import pytest
from query_cases import recordings_of

from lanindex.errors import LanindexError
from lanindex.search.language import parse
from lanindex.search.plain import beside, find, walk


def found(tracks: str, pattern: str, **options) -> list[tuple[int, int]]:
    (recording,) = recordings_of(f"fps 10 frames 100; {tracks}")
    hits = find(parse(pattern), [(recording.capture, recording.tracks)], **options)
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
    monkeypatch.setattr(walk, "MOST_NODES", 50_000)
    assert found(f"{WAVE}; {WAVE.replace('r_arm', 'l_arm')}", pattern)


@pytest.mark.parametrize(
    "pattern",
    [
        "(r_arm any ... any) x3+ without arm high",
        "a: r_arm any ... b: any ... c: any ... d: any ... e: any where a.start > e.end "
        "and b.start > c.end and d.start > e.end",
        "r_arm any ... any with b: l_arm any ... c: any with d: head any ... e: any "
        "where b.end > e.end and c.end > d.end",
    ],
)
def test_what_cannot_be_tried_is_said(pattern, monkeypatch):
    monkeypatch.setattr(walk, "MOST_NODES", 20_000)
    monkeypatch.setattr(beside, "MOST_WAYS", 20_000)
    wave = WAVE.replace("low", "high")
    with pytest.raises(LanindexError, match=r"1\.lnd: the pattern fits in more than 20000 ways"):
        found(f"{wave}; {wave.replace('r_arm', 'l_arm')}; {wave.replace('r_arm', 'head')}", pattern)


@pytest.mark.parametrize(
    "pattern",
    [
        "r_arm left ... right with l_arm low",
        "r_arm left ... right ... high with l_arm any",
        "r_arm left ... right -> any with l_arm low -> any",
    ],
)
def test_a_line_stops_at_the_first_end_that_nothing_can_beat(pattern, monkeypatch):
    ends = []
    hulls = beside.Company._hulls

    def counted(*arguments):
        ends.append(arguments)
        return hulls(*arguments)

    monkeypatch.setattr(beside.Company, "_hulls", counted)
    starts = found(f"{WAVE}; {WAVE.replace('r_arm', 'l_arm')}", pattern, overlaps="all")
    assert len(starts) > 20
    assert len(ends) <= 3 * len(starts)
