from dataclasses import replace
from fractions import Fraction

import pytest
from query_cases import track

from lanindex.model import Capture
from lanindex.search.hits import Hits
from lanindex.search.language import parse
from lanindex.search.plain import find

CAPTURE = Capture(1, "wave.bvh", "bvh", "0" * 64, "", Fraction(10), 100)
ROWS = ", ".join(f"{'right' if k % 2 else 'left'} mid {k} {k + 1}" for k in range(1, 23))


def hits(count: int, captures: int = 1) -> Hits:
    recordings = [
        (replace(CAPTURE, id=number), {"r_arm": track("r_arm", f"place low 0 0, {ROWS}", 100)})
        for number in range(1, captures + 1)
    ]
    found = list(find(parse("r_arm right"), recordings))
    return Hits(found[:count], "r_arm right")


@pytest.mark.parametrize(
    ("count", "captures", "counted"),
    [
        (0, 1, "<0 hits in 0 captures: r_arm right>"),
        (1, 1, "<1 hit in 1 capture: r_arm right>"),
        (10, 1, "<10 hits in 1 capture: r_arm right>"),
        (13, 2, "<13 hits in 2 captures: r_arm right>"),
    ],
)
def test_hits_print_the_first_ten(count: int, captures: int, counted: str):
    lines = repr(hits(count, captures)).splitlines()
    assert lines[0] == counted
    assert lines[1:2] == ["  wave.bvh  [1, 2)  0.10-0.20 s  fit 1.00"][:count]
    assert len(lines) == 1 + min(count, 10) + (count > 10)
    assert (lines[-1] == "  ... 3 more") == (count == 13)


def test_hits_are_a_sequence():
    found = hits(3)
    assert [hit.span.start for hit in found[1:]] == [3, 5]
    assert isinstance(found[1:], Hits)
    assert found[-1].span.stop == 6


def test_the_clearest_first_and_ties_as_they_were():
    one, two, three = hits(3)
    mixed = Hits([replace(one, fit=0.5), two, replace(three, fit=0.5)], "")
    assert [hit.span.start for hit in mixed.by_fit()] == [3, 1, 5]


def test_hits_as_an_array():
    rows = hits(2).numpy()
    assert rows.tolist() == [(1, 1, 2, 1.0), (1, 3, 4, 1.0)]
    assert rows.dtype.names == ("capture_id", "start", "stop", "fit")
