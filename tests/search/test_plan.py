"""The plan of a query as text."""

import pytest

from lanindex.search.explain.english import planned
from lanindex.search.language import parse


def rows(pattern: str) -> list[str]:
    return [" ".join(line.split()) for line in planned(parse(pattern)).splitlines()]


def test_states_edges_and_what_is_left_out_are_shown() -> None:
    assert rows("r_arm low -> high with l_arm mid without head") == [
        "line 1",
        "state 0 r_arm low begins",
        "state 1 r_arm high ends",
        "edge 0 -> 1",
        "prefilter captures with r_arm low, r_arm high, l_arm mid",
        "ends all ends from each beginning are tried",
        "with join with line 2; all ends from each beginning are tried",
        "without anti-join with line 3; the last end from each beginning is enough",
        "drop matches as soon as they share a frame with line 3",
        "line 2",
        "state 0 l_arm mid begins, ends",
        "line 3",
        "state 0 head begins, ends",
    ]


@pytest.mark.parametrize(
    ("pattern", "row"),
    [
        ("r_arm high -> any x2+", "ends runs on: the longest match from each beginning is enough"),
        ("r_arm high -> low", "best end looked up from states 0, 1"),
        ("r_arm high during l_arm", "during semi-join with line 2; the last end from each"),
        ("r_arm high with r_arm any", "with cannot be there: a part makes one movement at a time"),
        ("r_arm high ... low with r_arm", "claims another line could want the symbols of states 0"),
        ("(r_arm high with l_arm) x2+", "horizon 1/2 s, then 8 times as far, until all of the"),
        ("(r_arm high with l_arm) x2+", "walk from all beginnings at once in captures of at most"),
        ("r_arm at high 2s+", "state 0 r_arm at high 2s+ begins, ends"),
        (
            "a: r_arm any x3+ with b: l_arm any x3+ where a mirrors b",
            "runs of symbols that mirror each other are counted",
        ),
    ],
)
def test_a_rewrite_is_shown(pattern: str, row: str) -> None:
    assert any(found.startswith(row) for found in rows(pattern)), "\n".join(rows(pattern))


@pytest.mark.parametrize(
    ("pattern", "alike"),
    [
        ("((r_arm low -> high))", "r_arm low -> high"),
        ("((r_arm low) with (l_arm mid))", "r_arm low with l_arm mid"),
        ("head without ((l_arm with r_arm))", "head without (l_arm with r_arm)"),
    ],
)
def test_brackets_around_all_of_a_line_say_nothing(pattern: str, alike: str) -> None:
    assert rows(pattern) == rows(alike)


def test_each_side_and_alternative_is_a_line() -> None:
    assert sum(row.startswith("line") for row in rows("arm high or head left")) == 3
