"""Random patterns of the whole grammar parse, print and parse to the same pattern."""

import re
from random import Random

import pytest
from effort import slow, thinned
from generated_patterns import CONSTRUCTS, RELATIONS, random_pattern, random_patterns

from lanindex.search.language import parse

MANY = list(random_patterns(1, 1500))
"""Enough of them to meet every construct."""

SHOWN = {
    **{relation: rf"\b{relation}\b" for relation in RELATIONS},
    "with": r"(?<!ing )(?<!exactly )\bwith\b",
    **dict.fromkeys(("->", "...", "another part"), ""),
    **{word: rf"\b{word}\b" for word in ("at", "hold", "still", "via", "not", "any", "or")},
    **{word: rf"\b{word}\b" for word in ("either side", "rhythm", "where", "mirrors", "let")},
    "start": r"\bstart (->|then|→|\.\.\.|…)",
    "end": r"(->|then|→|\.\.\.|…)(\[\S+\])? end\b",
    "limit": r"(->|then|→|\.\.\.|…)\[\S*[sfb]\]",
    "skips": r"(\.\.\.|…)\[[<>=]*\d\]",
    "/": r"\w/\w",
    "changes": r"\b(rising|sinking)\b",
    "measures": r"\b(fast|slow|large|small|speed|size|straightness)\b",
    "relative": r"\b(side(?<!either side)|across)\b",
    "either": r"\barm\b",
    "both": r"\barms\b",
    "lnd": r"\bdirection \w+ \w+ \w+ \d \d",
    "bracket": r"\(",
    "mirror": r"\bmirror\(",
    "length": r"[\w)] [<>=]*[\d.]+m?[sfb]",
    "repeat": r" x\d",
    "open repeat": r" x\d\+",
    "optional": r"\?",
    "within": r"\b(with|without|after|before)\[",
    "labels": r"\bl\d: ",
    "stages": r"\|",
}


@pytest.mark.parametrize("text", thinned(MANY[:400], 4))
def test_what_is_printed_reads_the_same(text: str) -> None:
    query = parse(text)
    assert parse(str(query)) == query
    assert str(parse(str(query))) == str(query)


def test_each_construct_is_met() -> None:
    assert set(SHOWN) == set(CONSTRUCTS)
    for name, form in SHOWN.items():
        assert any(re.search(form, text) for text in MANY), name


@pytest.mark.parametrize("name", [name for name, form in SHOWN.items() if form])
def test_each_construct_can_be_avoided(name: str) -> None:
    for text in random_patterns(2, 100 if slow() else 25, avoid={name}):
        assert not re.search(SHOWN[name], text)


def test_chance_comes_from_outside_alone() -> None:
    assert random_pattern(Random(5)) == random_pattern(Random(5))
    assert len(set(MANY)) > 1200


def test_they_can_be_of_chosen_parts_and_constructs() -> None:
    for text in random_patterns(3, 50, parts=("r_leg", "l_leg"), only={"->"}, steps=4):
        assert parse(text).parts <= {"r_leg", "l_leg"}
        assert not re.search(r"[^\w →>-]", text)
        assert text.count("leg") <= 4
