"""The page of the language: it reads in a terminal, and says what runs."""

import re
from importlib.resources import files

import pytest

from lanindex.alphabet import DEGREES_BENT, LINES, TRACKS
from lanindex.errors import PatternError
from lanindex.search.language import parse
from lanindex.search.language.words import LANGUAGE, VALUES

PAGE = (files("lanindex.search") / "LANGUAGE.md").read_text(encoding="utf-8")
SECTIONS = dict(
    (title, body) for title, _, body in (it.partition("\n") for it in re.split(r"\n#+ ", PAGE))
)


def blocks(title: str) -> list[str]:
    """Return what is indented in a section, block by block."""
    found = re.findall(r"(?:^    .*\n?)+", SECTIONS[title], re.MULTILINE)
    return [re.sub(r"^    ", "", block, flags=re.MULTILINE).rstrip("\n") for block in found]


def patterns(title: str) -> list[str]:
    lines = [line for block in blocks(title) for line in block.splitlines()]
    return [re.split(r"  +", line)[0] for line in lines]


def test_it_reads_in_a_terminal():
    assert max(map(len, PAGE.splitlines())) <= 98
    assert "\t" not in PAGE
    assert not re.search(r"</|&\w+;|\]\(", PAGE)


SHOWING = [
    *("In five minutes", "Labels and conditions", "Rhythm", "Names for patterns"),
    *("What becomes of the hits", "Scores", "Examples"),
]


@pytest.mark.parametrize("text", [text for title in SHOWING for text in patterns(title)])
def test_what_it_shows_is_understood(text: str):
    assert str(parse(str(parse(text)))) == str(parse(text))


def test_all_that_it_quotes_in_the_text_is_a_pattern_or_a_piece_of_one():
    _, first, second = blocks("The grammar")[0], *blocks("The grammar")[1].splitlines()
    assert parse(first) != parse(second)
    said = re.findall(r"`([^`]+ (?:->|\.\.\.|or|with|without) [^`.…]+)`", " ".join(PAGE.split()))
    quoted = [it for it in said if it.split()[0] in ("r_arm", "arm", "start", "place")]
    assert len(quoted) > 5
    for text in quoted:
        parse(text if not text.startswith("place") else f"arm {text}")


def test_it_names_every_word():
    (parts,) = blocks("The words")
    assert set(parts.split()) == set(TRACKS)
    words = set(re.findall(r"\w+", PAGE))
    spellings = {"side_backward", "across_backward"} | {
        word for word in VALUES if re.fullmatch(r"\w+_(right|left|forward|back|backward)", word)
    }
    assert set(VALUES) - spellings - set(DEGREES_BENT) <= words
    assert {VALUES[word][1] for word in spellings} <= words
    assert set(LANGUAGE) <= words


def test_every_block_is_looked_at():
    others = {"The words", "The grammar", "When it cannot be read"}
    assert {title for title in SECTIONS if blocks(title)} == {*SHOWING, *others}


def test_the_words_of_the_grammar_are_those_of_the_language():
    grammar = set(re.findall(r'"([a-z]{2,}(?: side)?)"', blocks("The grammar")[0]))
    bends = {word for word, (kind, _) in VALUES.items() if kind == "bend"}
    known = {*LANGUAGE, *LINES, *bends, "either side", "ms", "deg"}
    assert grammar <= known
    assert set(LANGUAGE) - {"then", "or", "not", "either"} <= grammar


@pytest.mark.parametrize("block", blocks("When it cannot be read"))
def test_the_errors_it_shows(block: str):
    for shown in block.split("\n\n"):
        with pytest.raises(PatternError) as caught:
            parse(shown.splitlines()[0])
        assert str(caught.value) == shown
