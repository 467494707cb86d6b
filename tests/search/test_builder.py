"""Patterns built in Python print as the text that they could have been written as."""

from random import Random

import pytest
from generated_patterns import random_pattern

from lanindex import part
from lanindex.errors import PatternError, UsageError
from lanindex.search.language import parse
from lanindex.search.language.builder import Pattern

right, left, head = part("r_arm"), part("l_arm"), part("head")

BUILT: list[tuple[Pattern, str]] = [
    (right, "r_arm"),
    (right.to("right", "mid"), "r_arm right mid"),
    (right.to(direction="right", level="mid"), "r_arm right mid"),
    (right.to("right", "mid").then(level="high"), "r_arm right mid -> high"),
    (right.to("not low").to("right/left"), "r_arm not low -> right/left"),
    (right.then("high"), "r_arm -> high"),
    (right.at("place", "high").lasting(">3s"), "r_arm at place high >3s"),
    (right.to("right").hold().lasting("2s+"), "r_arm right -> hold 2s+"),
    (right.to("low").via("right").then("high"), "r_arm low -> via right -> high"),
    (right.to("low").later("high", within="<2s"), "r_arm low ...[<2s] high"),
    (right.to("low").later("high", within="<=2"), "r_arm low ...[<=2] high"),
    (right.to("low").then("high", within="1s"), "r_arm low ->[1s] high"),
    (right.to("high").then("l_arm low"), "r_arm high -> l_arm low"),
    (right.to("high").then(left.to("low")), "r_arm high -> l_arm low"),
    (right.to("high").then(left.to("low").then("high")), "r_arm high -> (l_arm low -> high)"),
    (right.to("rising").times(2), "r_arm rising x2"),
    (right.to("rising").times("2..4").then("low"), "r_arm rising x2..4 -> low"),
    (right.to("low").then("mid").optional().then("high"), "r_arm low -> mid? -> high"),
    (right.to("left").then("right").group().times("3+"), "(r_arm left -> right) x3+"),
    (right.to("left").times(2).group().lasting("<1s"), "(r_arm left x2) <1s"),
    (right.to("high").from_start(), "start -> r_arm high"),
    (right.to("high").to_end(), "r_arm high -> end"),
    (right.to("right").mirrored(), "(l_arm left)"),
    (right.to("high").with_(left.to("high")), "r_arm high with l_arm high"),
    (right.to("high").with_(left.to("high"), within="1s"), "r_arm high with[1s] l_arm high"),
    (right.to("high").without(head).during(left), "r_arm high without head during l_arm"),
    (right.to("high").after(head, within="<1s"), "r_arm high after[<1s] head"),
    (right.before(head).never(part("leg")), "r_arm before head never leg"),
    (right.overlapping(left), "r_arm overlapping l_arm"),
    (right.starting_with(left), "r_arm starting with l_arm"),
    (right.ending_with(left), "r_arm ending with l_arm"),
    (right.exactly_with(left), "r_arm exactly with l_arm"),
    (right.without(head, within="1s"), "r_arm without[1s] head"),
    (right.to("high").with_(left | head), "r_arm high with (l_arm or head)"),
    (right.to("high").with_(left.with_(head)), "r_arm high with (l_arm with head)"),
    (right.with_(left).then("r_arm low"), "(r_arm with l_arm) -> r_arm low"),
    (right | left, "r_arm or l_arm"),
    ((right | left).with_(head), "(r_arm or l_arm) with head"),
    (right.to("high").either_side(), "r_arm high either side"),
    (right.to("low").either_side().then("high"), "r_arm low -> high either side"),
    (right.to("low").then("high").rhythm(1, 1.5), "r_arm low -> high rhythm 1:1.5"),
    (
        right.to("low").labelled("a").then("high").labelled("b").where("a.length < b.length"),
        "a: r_arm low -> b: high where a.length < b.length",
    ),
    (
        right.where("match.start > 1s").where('clip.label = "wave"').either_side(),
        'r_arm either side where match.start > 1s and clip.label = "wave"',
    ),
    (right.sort_by("match.length").first(3), "r_arm | sort by match.length | first 3"),
    (right.count("clip.label"), "r_arm | count by clip.label"),
    (right.count(), "r_arm | count"),
]


@pytest.mark.parametrize(("built", "text"), BUILT, ids=lambda it: str(it))
def test_it_prints_as_text(built: Pattern, text: str):
    assert str(built) == text
    assert built.query == parse(text)
    assert repr(built) == f"<Pattern {text}>"


def test_what_is_wrong_is_said_where_it_is_built():
    with pytest.raises(PatternError, match='Did you mean "r_arm"'):
        part("r_amr")
    with pytest.raises(PatternError, match='Did you mean "high"'):
        right.to("hihg")
    with pytest.raises(PatternError, match="One movement has one level"):
        right.to("high", "low")
    with pytest.raises(PatternError, match="bracket it"):
        right.to("high").times(2).lasting("<1s")
    with pytest.raises(PatternError, match='no label "a"'):
        right.where("a.start > 1s")


def test_what_speaks_of_the_whole_is_refused_in_a_part():
    with pytest.raises(UsageError, match='"either side" in a part of a pattern'):
        right.with_(left.either_side())
    with pytest.raises(UsageError, match="count"):
        right.count() | left
    with pytest.raises(UsageError, match="first 1"):
        right.then(left.first(1))


def test_a_pattern_is_a_value():
    assert right.to("high") == part("r_arm").to(level="high")
    assert len({right.to("high"), part("r_arm").to(level="high")}) == 1


def test_any_pattern_can_be_built_upon():
    random = Random(3)
    for _ in range(60):
        query = parse(random_pattern(random, avoid={"where", "stages", "rhythm", "either side"}))
        built = Pattern(query).group().with_(part("torso"))
        assert str(built) == f"({query}) with torso"
