"""The tree of a pattern as it is written: its places, and back to text."""

import json
from collections.abc import Iterator
from random import Random
from typing import Any

import pytest
from effort import slow
from generated_patterns import random_pattern

import lanindex
from lanindex import pattern_text, pattern_tree
from lanindex.errors import PatternError, UsageError
from lanindex.search.dictionary import load
from lanindex.search.language import parse

WHOLE_BODY = ("r_arm", "l_arm", "head", "step", "jump", "body_turn", "other_support", "hands_touch")
PARTS = (("r_arm", "l_arm", "head"), WHOLE_BODY, ("r_leg_bend", "l_leg_bend", "r_hand_touch"))
WRITTEN = (
    "a: arms high 1s+ x2 or start ->[<1s] mirror ( r_arm RIGHT -> low ) x2+ ... end either side",
    "let up = r_arm low -> high; @up x3 with[0.5s] @Wave either side where match.length > 1s",
    "direction r_arm right mid 0 1\n  direction r_arm left mid 1 2  with[1s] head",
    "(direction r_arm right mid 0 1 direction l_arm left mid 0 1)",
    "Right ARM high → r_arm bend 3 then stretch",
    "body turn left 90deg..180deg <2s then any rhythm 1:2 | sort by match.start | first 3",
    'r_arm low ...[<=2] high // a comment\n where clip.label = "a | b" | count by clip.label',
    "((r_arm high))",
)


def nodes(tree: Any) -> Iterator[dict[str, Any]]:
    """Yield a node and all nodes inside."""
    if isinstance(tree, dict):
        yield tree
        for value in tree.values():
            yield from nodes(value)
    elif isinstance(tree, list):
        for value in tree:
            yield from nodes(value)


def assert_places(text: str) -> None:
    """Assert that each node is where its place says: written anew there, it is the same."""
    query = parse(text)
    for node in nodes(pattern_tree(text)):
        start, stop = node["at"]
        assert text[start:stop] == node["text"]
        assert node["text"].strip() == node["text"] or node["kind"] == "query"
        again = f"{text[:start]}{pattern_text(node)}{text[stop:]}"
        assert parse(again) == query, (node["kind"], again)


@pytest.mark.parametrize("text", WRITTEN)
def test_a_pattern_comes_back(text: str) -> None:
    tree = json.loads(json.dumps(pattern_tree(text)))
    assert parse(pattern_text(tree)) == parse(text)
    assert_places(text)


def test_random_patterns_come_back() -> None:
    random, kinds = Random(3), set()
    for number in range(400 if slow() else 150):
        text = random_pattern(random, parts=random.choice(PARTS), more={"lnd": 0.1, "let": 0.3})
        tree = pattern_tree(text)
        assert parse(pattern_text(tree)) == parse(text), text
        kinds |= {node["kind"] for node in nodes(tree)}
        if number % 8 == 0:
            assert_places(text)
    assert kinds >= {
        "query",
        "let",
        "choice",
        "lines",
        "beside",
        "line",
        "arrow",
        "length",
        "skips",
    }
    assert kinds >= {"step", "word", "bracket", "mirror", "named", "score", "repeat"}
    assert kinds >= {"either side", "rhythm", "where", "condition", "stage"}


def test_the_dictionary_comes_back() -> None:
    for entry in load().values():
        assert parse(pattern_text(pattern_tree(entry.pattern))) == parse(entry.pattern)


def test_names_stay_names() -> None:
    tree = pattern_tree("let up = r_arm low -> high; @up x2 or @wave")
    assert pattern_text(tree) == "let up = r_arm low -> high; @up x2 or @wave"
    (let,) = tree["lets"]
    assert (let["name"], let["text"]) == ("up", "let up = r_arm low -> high;")


def test_the_keys_of_a_step() -> None:
    tree = pattern_tree("a: arms bend 3 -> hold 1s x2")
    first, second = tree["pattern"]["alternatives"][0]["first"]["steps"]
    (word,) = first.pop("words")
    assert first == {
        **{"kind": "step", "at": [0, 14], "text": "a: arms bend 3"},
        **{"part": "arms", "parts": ["r_arm_bend", "l_arm_bend"], "form": "both", "written": True},
        **{"manner": "move", "label": "a", "length": None, "repeat": None},
    }
    assert word == {
        **{"kind": "word", "at": [8, 14], "text": "bend 3"},
        **{"of": "bend", "values": ["bend 3"], "negated": False},
    }
    assert (second["manner"], second["written"], second["label"]) == ("hold", False, "")
    assert second["length"] == {"kind": "length", "at": [23, 25], "text": "1s"}
    assert second["repeat"] == {"kind": "repeat", "at": [26, 28], "text": "x2"}


def test_a_tree_that_was_made() -> None:
    step = {"kind": "step", "part": "r_arm", "words": [{"kind": "word", "values": ["high"]}]}
    lines = {"kind": "lines", "first": {"kind": "line", "steps": [step]}}
    made = {"kind": "query", "pattern": {"kind": "choice", "alternatives": [lines]}}
    assert pattern_text(made) == "r_arm high"


@pytest.mark.parametrize("wrong", [{}, {"kind": "step"}, {"kind": "choice", "alternatives": 3}, []])
def test_no_tree(wrong: Any) -> None:
    with pytest.raises(UsageError, match="wrong node"):
        pattern_text(wrong)


def test_the_error_is_that_of_the_parser() -> None:
    with pytest.raises(PatternError) as caught:
        lanindex.pattern_tree("r_arm hgih")
    assert (caught.value.start, caught.value.stop) == (6, 10)
