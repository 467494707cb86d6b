"""What may stand at a position of a pattern, as the parser itself tells it."""

from collections.abc import Iterator
from random import Random
from time import process_time

from effort import slow
from generated_patterns import random_pattern

from lanindex.errors import PatternError
from lanindex.search.language import parse
from lanindex.search.language.completion import Completion, complete
from lanindex.search.language.lexer import tokens
from lanindex.search.language.words import COUNT, THINGS

WHOLE_BODY = ("r_arm", "l_arm", "head", "step", "jump", "body_turn", "other_support", "hands_touch")
PARTS = (("r_arm", "l_arm", "head"), WHOLE_BODY, ("r_leg_bend", "l_leg_bend", "r_hand_touch"))


def texts(text: str, position: int | None = None) -> list[str]:
    return [it.text for it in complete(text, position)]


def parses(text: str) -> bool:
    try:
        parse(text)
    except PatternError:
        return False
    return True


def own_spelling(word: str) -> str:
    return next((known[word][1] for known in THINGS.values() if word in known), word)


def is_offered(offered: list[Completion], text: str) -> bool:
    """Return whether the token that stands behind a completion's start is one of those offered."""
    for it in offered:
        (first, *_), (next_token, *_) = tokens(it.text), tokens(text[it.start :])
        same_kind = it.kind in ("number", "text", "name") and first.kind == next_token.kind
        count = it.kind == "count" and COUNT.fullmatch(next_token.text)
        if first.text == next_token.text == "@":
            return it.text[1:] == tokens(text[it.start :])[1].text
        if own_spelling(first.text) == own_spelling(next_token.text) or same_kind or count:
            return True
    return False


def patterns(count: int, more: dict[str, float] | None = None) -> list[str]:
    random = Random(7)
    return [
        random_pattern(random, parts=random.choice(PARTS), more={**(more or {}), "lnd": 0.1})
        for _ in range(count)
    ]


def test_the_next_token_of_a_pattern_is_among_what_is_expected() -> None:
    for text in patterns(60 if slow() else 20):
        for token in tokens(text)[:-1]:
            if token.start and text[token.start - 1] == "@":
                continue  # the name is offered with its mark
            assert is_offered(complete(text, token.start), text), (text, token)


def walk(random: Random) -> Iterator[str]:
    """Yield ever longer beginnings of a pattern, each a random completion longer."""
    text = ""
    for _ in range(12):
        offered = [it for it in complete(text) if it.stop == len(text)]
        if not offered:
            return
        it = random.choice(offered)
        text = f"{text[: it.start]}{it.text}"
        if it.kind != "field" and (random.random() < 0.9 or text[-1].isalnum()):
            text += " "
        yield text


def test_every_completion_can_go_on() -> None:
    """A walk by completions is refused nowhere before its end, and comes to whole patterns."""
    random, whole = Random(1), 0
    for _ in range(60):
        for text in walk(random):
            if parses(text):
                whole += 1
            else:
                assert complete(text), text
    assert whole > 100


def test_a_word_that_is_begun_is_replaced() -> None:
    (first, *_) = complete("r_arm hi -> low", 8)
    assert (first.text, first.kind, first.start, first.stop) == ("high", "level", 6, 8)
    (first, *_) = complete("r_a low", 2)  # all of the word under the cursor
    assert (first.text, first.start, first.stop) == ("r_arm", 0, 3)
    assert texts("2s", 0)[0] == "r_arm"
    assert complete("r_arm hgih")[0].text == "high"  # misspelt
    assert complete("wav")[0].text == "@wave"


def test_what_cannot_stand_is_not_offered() -> None:
    assert "still" not in texts("jump ")
    assert "at" not in texts("hands_touch ")
    assert "rising" not in texts("r_arm at ")
    assert "mid" not in texts("r_arm high ")
    assert {"mid", "low"} <= {*texts("r_arm high/")}
    assert "high" not in texts("r_arm high/")
    assert "[" not in texts("r_arm during")
    assert {"a.", "match."} < {*texts("a: r_arm where ")}
    assert "level" not in texts("a: r_arm -> b: low where a.start < b.")
    assert "rhythm" not in texts("r_arm high ")
    assert "count" not in texts("r_arm | count | ")
    assert not complete("r_arm // ")
    assert not complete("blah blah ")


def test_the_parts_and_words_of_a_library() -> None:
    assert {it.text for it in complete("", parts=["head"]) if it.kind == "part"} == {"head"}


def test_meanings() -> None:
    meant = {it.text: it.meaning for it in complete("arm ")} | {
        it.text: it.meaning for it in complete("arm")
    }
    assert meant["high"] == ""
    assert meant["side"] == "to its own side"
    assert meant["->"] == "next"
    assert meant["arm"] == "either of r_arm and l_arm"
    assert all(it.meaning for it in complete("@wal") if it.kind == "movement")


def test_a_long_pattern_takes_no_time() -> None:
    text = " -> ".join(["(r_arm right mid with l_arm left/right <1s) x2", "body_turn >90deg"] * 3)
    assert 180 < len(text) < 250
    took = []
    for position in range(0, len(text), 20):
        begun = process_time()
        complete(text, position)
        took.append(process_time() - begun)
    assert sorted(took)[len(took) // 2] < 0.01  # seconds, of the median
