"""Spoken forms of words find their entry of the dictionary."""

import pytest

from lanindex.pipeline.search import entry_of_query, hints
from lanindex.search.dictionary import entry_named, load


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("waves", "wave"),
        ("waved", "wave"),
        ("a person walks", "walk"),
        ("someone is running", "run"),
        ("clapping hands", "clap"),
        ("clap the hands", "clap"),
        ("right arm wave", "wave_right"),
        ("waves with his left hand", "wave_left"),
        ("bows", "bow"),
        ("jumping jack", "jumping_jack"),
    ],
)
def test_a_word_is_found_in_any_form(text, name):
    entry = entry_of_query(text)
    assert entry is not None
    assert entry.name == name


@pytest.mark.parametrize(
    "text",
    ["r_arm high", "walk forward", "right arm raised", "arms", "", "with", "wave -> wave", "@wavy"],
)
def test_what_says_more_or_less_is_no_word(text):
    assert entry_of_query(text) is None


def test_every_name_means_its_entry():
    words = load()
    for name, entry in words.items():
        assert entry_named(name.replace("_", " "), words) is not None
        assert entry_of_query(name) == entry


def test_words_among_others_are_pointed_out():
    assert list(hints("walk forward")) == ['"walk" is in the dictionary of movement: @walk']
    (told,) = hints("sit down")
    assert told.startswith('no word "sit" in the dictionary of movement: ')
    assert list(hints("walk")) == list(hints("r_arm high -> low")) == []


def test_ones_own_words_are_found_too(tmp_path):
    own = tmp_path / "own.toml"
    own.write_text('salute = {pattern = "r_arm high"}\n')
    entry = entry_of_query("the dancer salutes", own)
    assert entry is not None
    assert entry.pattern == "r_arm high"
