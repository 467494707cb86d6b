"""Every entry of the dictionary is valid and finds its movement in the corpus."""

from pathlib import Path

import pytest
from plain_matcher import find

from lanindex.encoding import encode
from lanindex.errors import UsageError
from lanindex.formats import read
from lanindex.model import Capture, Track
from lanindex.search import dictionary
from lanindex.search.dictionary import (
    Entry,
    Measured,
    absent,
    entries,
    entry_named,
    inside,
    load,
    mirror_image,
    mirrored,
    spelled,
)
from lanindex.search.language import parse
from lanindex.search.language.words import LANGUAGE, VALUES, Vocabulary

WORDS = load()
RAISING = ("conductor_four", "conductor_three", "jumping_jacks", "radio_gymnastics", "semaphore")
Recording = tuple[Capture, dict[str, Track]]


@pytest.fixture(scope="module")
def corpus() -> list[Recording]:
    folder = Path(__file__).parents[2] / "corpus"
    recordings = []
    for number, path in enumerate(sorted(folder.glob("*.bvh"))):
        score = encode(read(path))
        capture = Capture(number, str(path), "bvh", "", path.stem, score.rate, score.frames)
        recordings.append((capture, dict(score.tracks)))
    return recordings


def found(word: str, recordings: list[Recording]) -> set[str]:
    return {hit.capture.label for hit in find(parse(WORDS[word].pattern), recordings)}


@pytest.fixture
def own(tmp_path: Path):
    def write(text: str) -> Path:
        path = tmp_path / "own.toml"
        path.write_text(text)
        return path

    return write


@pytest.mark.parametrize("entry", entries(WORDS), ids=lambda entry: entry.name)
class TestEveryEntry:
    def test_is_understood_and_prints(self, entry: Entry) -> None:
        query = parse(entry.pattern)
        assert parse(str(query)) == query

    def test_is_a_sentence(self, entry: Entry) -> None:
        assert entry.sentence[0].isupper()
        assert entry.sentence.endswith(".")

    def test_is_no_word_of_the_language(self, entry: Entry) -> None:
        for name in (entry.name, *entry.names):
            assert name == spelled(name)
            assert name.isidentifier()
            assert name not in LANGUAGE
            assert name not in VALUES
            assert Vocabulary().mover(name) is None

    def test_is_found_by_all_its_names(self, entry: Entry) -> None:
        for name in (entry.name, *entry.names):
            assert WORDS[name] is entry

    def test_may_stand_in_another(self, entry: Entry, corpus: list[Recording]) -> None:
        names = {entry.name: inside(entry.pattern)}
        whole = find(parse(entry.pattern), corpus, overlaps="all")
        named = find(parse(f"@{entry.name}", names=names), corpus, overlaps="all")
        assert {(hit.capture.id, hit.span) for hit in named} == {
            (hit.capture.id, hit.span) for hit in whole
        }
        parse(f"mirror (@{entry.name}) with head", names=names)

    def test_has_a_mirror_image_that_is_one(self, entry: Entry) -> None:
        name = mirror_image(entry, WORDS)
        other = entry if name == "itself" else WORDS[name]
        assert mirror_image(other, WORDS) in (entry.name, "itself")
        assert mirrored(mirrored(entry.pattern)) == entry.pattern
        if not entry.pattern.endswith("either side"):
            image = parse(f"mirror ({entry.pattern})")
            assert image == parse(f"({mirrored(entry.pattern)})")

    def test_has_earned_its_place(self, entry: Entry) -> None:
        counts = entry.measured
        assert counts is not None
        assert entry.labels
        assert (counts.precision is None) == (counts.recall is None) == (not counts.tells)
        if counts.tells:
            assert counts.precision >= 0.75
            assert counts.recall >= 0.6


@pytest.mark.parametrize(
    ("right", "missed", "collections", "recall"),
    [(9, 1, 2, 0.9), (9, 0, 2, None), (30, 0, 1, None)],
)
def test_a_word_that_was_seen_seldom_has_no_figure(right, missed, collections, recall) -> None:
    assert Measured(right, 1, missed, 99, collections).recall == recall


def test_names_are_given_once() -> None:
    names = [name for entry in entries(WORDS) for name in (entry.name, *entry.names)]
    assert len(names) == len(set(names))


def test_sided_words_are_each_other_in_the_mirror() -> None:
    assert mirror_image(WORDS["wave_right"], WORDS) == "wave_left"
    assert mirror_image(WORDS["raise_left"], WORDS) == "raise_right"
    assert mirror_image(WORDS["kick"], WORDS) == "itself"
    alone = Entry("salute", "r_arm right high")
    assert mirror_image(alone, {"salute": alone}) == ""
    assert mirrored("r_arm left/r_forward mid -> right_forward") == (
        "l_arm right/l_forward mid -> left_forward"
    )


@pytest.mark.parametrize(
    ("word", "labels"),
    [
        ("jumping_jack", {"jumping_jacks"}),
        ("bow", {"greetings", "radio_gymnastics"}),
        ("wave_right", {"greetings", "traffic_police"}),
        ("wave_left", {"traffic_police"}),
        ("hands_up", {"conductor_three", "jumping_jacks", "radio_gymnastics"}),
        ("raise_left", {"traffic_police", *RAISING}),  # where it has hung for long before
        ("walk", set()),
        ("run", set()),
        ("kick", set()),
        ("clap", set()),
    ],
)
def test_words_find_what_we_made(word: str, labels: set[str], corpus: list[Recording]) -> None:
    assert found(word, corpus) == labels


@pytest.mark.parametrize("text", ["hands_up", "Hands up", "@hands_up", " hands-up "])
def test_names_may_be_spelled_in_several_ways(text: str) -> None:
    assert spelled(text) == "hands_up"


class TestOwnWords:
    def test_stand_beside_the_others(self, own) -> None:
        words = load(own('"Right salute" = {pattern = "r_arm right\\nhigh // so", names = ["Hi"]}'))
        salute = words["right_salute"]
        assert salute == Entry("right_salute", "r_arm right high", names=("hi",))
        assert words["hi"] is salute
        assert words["walk"] == WORDS["walk"]

    def test_count_where_both_have_a_name(self, own) -> None:
        words = load(own('walk = {pattern = "leg forward"}\nrun = {pattern = "leg back"}'))
        assert words["walk"].pattern == "leg forward"
        assert [entry.name for entry in entries(words)].count("walk") == 1

    def test_other_names_never_hide_a_name(self, own) -> None:
        words = load(own('salute = {pattern = "r_arm high", names = ["walk"]}'))
        assert words["walk"].name == "walk"

    @pytest.mark.parametrize(
        ("text", "said"),
        [
            ("walk = ", "own.toml: "),
            ('walk = "r_arm high"', "walk = 'r_arm high', wanted name = {pattern"),
            ('walk = {sentence = "So."}', "wanted name = {pattern"),
            ('walk = {pattern = "r_arm high", color = "red"}', "wanted name = {pattern"),
            ('walk = {pattern = "r_arm high", names = [3]}', "names = [3], wanted texts"),
            ('walk = {pattern = "r_arm high", measured = {right = 1}}', "wanted whole numbers"),
            ('arms = {pattern = "r_arm high"}', '"arms" is a word of the language already. Call'),
            ('with = {pattern = "r_arm high"}', '"with" is a word of the language already'),
            ('up = {pattern = "r_arm high", names = ["any"]}', '"any" is a word of the language'),
            ('"u/p" = {pattern = "r_arm high"}', '"u/p", wanted a name of letters'),
            ('up = {pattern = "r_arm hihg"}', "own.toml: up: the pattern is not understood\nr_arm"),
        ],
    )
    def test_a_broken_file_says_what_is_wrong(self, own, text: str, said: str) -> None:
        with pytest.raises(UsageError) as error:
            load(own(text))
        assert "own.toml" in str(error.value)
        assert said in str(error.value)

    def test_a_missing_file_says_so(self, tmp_path: Path) -> None:
        with pytest.raises(UsageError, match=r"none\.toml"):
            load(tmp_path / "none.toml")


def test_what_may_be_asked_in_place_of_an_absent_word_is_understood() -> None:
    known = {word.name: inside(word.pattern) for word in entries(WORDS)}
    for words, entry in dictionary._absent().items():
        assert entry_named(" ".join(words), WORDS) is None
        assert parse(entry.instead, names=known)


def test_nothing_is_said_of_a_word_that_nobody_thought_of() -> None:
    assert absent("yodel") is None


def test_hops_and_leaps_are_jumps_of_their_kind() -> None:
    asked = {text: absent(text) for text in ("hopping", "leap", "jumping")}
    said = {text: it and it.instead for text, it in asked.items()}
    assert said == {"hopping": "jump hop", "leap": "jump leap", "jumping": "jump"}
