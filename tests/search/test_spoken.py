"""Spoken forms of words find their entry of the dictionary."""

import pytest

from lanindex.alphabet import TRACKS
from lanindex.errors import PatternError
from lanindex.pipeline.search import entry_of_query
from lanindex.search.dictionary import entry_named, load
from lanindex.search.language import parse


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


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("walk wildly", '"@walk"?'),
        ("sit wildly", " other support seat/other 1s+"),
        (
            "r_arm high with punch",
            "with r_arm forward/across_forward/side_forward mid straight either side",
        ),
    ],
)
def test_a_word_among_others_is_answered_where_it_stands(text, meant):
    with pytest.raises(PatternError) as caught:
        parse(text)
    assert caught.value.found.endswith(meant)
    assert caught.value.found.count("Did you mean") == 1


@pytest.mark.parametrize(
    ("text", "pattern"),
    [
        ("walk backwards", "travel back with step back x2+"),
        ("a person walks to the left", "travel not place with step left/l_forward without turn"),
        ("look left", "head turn left"),
        ("left hand touches head", "l_hand touch head"),
        ("touches his chin with the left hand", "l_hand touch head"),
        ("sit down", "other support seat/other 1s+"),
        ("turn around", "turn >150deg"),
        ("turns around to the left", "turn left >150deg"),
        ("looks back", "head turn left/right >60deg"),
        ("shakes her head", "head turn left ...[<1s] right ...[<1s] left either side"),
        ("lying on the floor", "other support trunk 1s+"),
        ("point forward", "arm forward mid -> hold 0.6s+"),
        ("arms crossed", "forearms at across 0.5s+"),
        ("arms crossed in front of the chest", "forearms at across 0.5s+"),
        ("walks slowly", "travel slow with step x2+"),
        ("pointing with the right arm", "r_arm mid -> hold 0.6s+"),
    ],
)
def test_what_people_type_leads_to_one_pattern_and_nothing_else(text, pattern):
    with pytest.raises(PatternError) as caught:
        parse(text, TRACKS)
    assert caught.value.found.endswith(f" Did you mean:  {pattern}")
    assert parse(pattern)


@pytest.mark.parametrize("text", ["catch", "pick something up", "dance"])
def test_a_word_that_begins_otherwise_is_no_other_one_misspelt(text):
    with pytest.raises(PatternError) as caught:
        parse(text, TRACKS)
    assert "Did you mean" not in caught.value.found


def test_a_word_with_a_meaning_is_no_other_one_misspelt():
    with pytest.raises(PatternError) as caught:
        parse("punch")
    assert "pinch" not in caught.value.found
    assert "Did you mean:  r_arm_bend bent 3+ -> stretch" in caught.value.found


def test_a_word_that_nobody_knows_names_few_parts():
    with pytest.raises(PatternError) as caught:
        parse("yodel", TRACKS)
    assert caught.value.found.endswith(
        "The parts are: head torso r_arm l_arm r_arm_bend l_arm_bend …"
    )


@pytest.mark.parametrize("text", ["kneel", "kneel down", "kneeling on the floor"])
def test_who_kneels_is_found_by_the_dictionary(text):
    assert entry_of_query(text).name == "kneel"


def test_ones_own_words_are_found_too(tmp_path):
    own = tmp_path / "own.toml"
    own.write_text('salute = {pattern = "r_arm high"}\n')
    entry = entry_of_query("the dancer salutes", own)
    assert entry is not None
    assert entry.pattern == "r_arm high"
