"""Words of each kind of track; symbols without direction or level."""

from fractions import Fraction

import pytest
from plain_matcher import find
from plain_search import find_plainly
from query_cases import track

from lanindex import alphabet
from lanindex.errors import PatternError
from lanindex.model import Capture, Track
from lanindex.search.explain.english import sentence
from lanindex.search.language import parse, words

CAPTURE = Capture(1, "", "", "0" * 64, "", Fraction(10), 100)
PARTS = ("travel", "r_twist", "l_twist", "r_arm")


@pytest.fixture(autouse=True)
def kinds(monkeypatch):
    """Two more kinds, as lines of tables: travel has a direction, a twist its own words."""
    bend = words.WordKind("degree", {"slight": 20, "full": 90})
    monkeypatch.setitem(alphabet.KINDS, "travel", alphabet.Kind("travel", ("direction",), ()))
    monkeypatch.setitem(alphabet.KINDS, "twist", alphabet.Kind("twist", ("degree",), ("amount",)))
    monkeypatch.setitem(alphabet._KIND_OF_GROUP, "travel", "travel")
    monkeypatch.setitem(alphabet._KIND_OF_GROUP, "twist", "twist")
    monkeypatch.setitem(words.WORD_KINDS, "degree", bend)
    for name in bend.codes:
        monkeypatch.setitem(words.VALUES, name, ("degree", name))


def changed(made: Track, **columns: list[int]) -> Track:
    rows = made.symbols.copy()
    for name, codes in columns.items():
        rows[name] = codes
    return Track(made.part, rows, made.known)


def spans(pattern: str, made: Track) -> list[tuple[int, int]]:
    recording = CAPTURE, {made.part: made}
    hits = find(parse(pattern, PARTS), [recording], overlaps="all")
    found = [(hit.span.start, hit.span.stop, hit.fit) for hit in hits]
    if "slight" not in pattern:
        assert found == find_plainly(parse(pattern, PARTS), *recording)
    return [(start, stop) for start, stop, _ in found]


ROWS = "place low 0 0, forward high 10 20, right mid 30 40, forward low 50 60"


def test_a_symbol_without_a_level_is_matched_by_what_says_nothing_of_it():
    made = changed(track("r_arm", ROWS, 100), level=[0, -1, 1, 0])
    assert spans("r_arm forward", made) == [(10, 20), (50, 60)]
    assert spans("r_arm any", made) == [(10, 20), (30, 40), (50, 60)]
    assert spans("r_arm at forward", made) == [(19, 30), (59, 100)]
    assert spans("r_arm hold forward", made) == [(20, 30), (60, 100)]


def test_what_says_something_of_a_level_needs_one():
    made = changed(track("r_arm", ROWS, 100), level=[0, -1, 1, 0])
    assert spans("r_arm low/mid/high", made) == [(30, 40), (50, 60)]
    assert spans("r_arm not high", made) == [(30, 40), (50, 60)]
    assert spans("r_arm hold not high", made) == [(0, 10), (40, 50), (60, 100)]
    assert spans("r_arm rising", made) == []
    assert spans("r_arm not rising", made) == [(30, 40), (50, 60)]
    assert spans("r_arm sinking", made) == [(50, 60)]


def test_what_says_something_of_a_direction_needs_one():
    made = changed(track("r_arm", ROWS, 100), direction=[8, -1, 0, 2])
    assert spans("r_arm any", made) == [(10, 20), (30, 40), (50, 60)]
    assert spans("r_arm any high", made) == [(10, 20)]
    assert spans("r_arm not right", made) == [(50, 60)]
    assert spans("r_arm not right high", made) == []
    assert spans("r_arm place", made) == []


def test_words_of_a_kind_that_is_a_line_of_a_table():
    made = changed(
        track("r_arm", ROWS, 100), direction=[-1] * 4, level=[-1] * 4, amount=[0, 20, 90, -1]
    )
    made = Track("r_twist", made.symbols, made.known)
    assert spans("r_twist slight", made) == [(10, 20)]
    assert spans("twist slight/full", made) == [(10, 20), (30, 40)]
    assert spans("twist not slight", made) == [(30, 40)]
    assert spans("twist slight -> any", made) == [(10, 40)]
    assert spans("twist any x3", made) == [(0, 40), (10, 60)]
    assert str(parse("mirror(r_twist full)", PARTS)) == "(l_twist full)"
    assert sentence(parse("r_twist full", PARTS)) == "The right twist moves full."


@pytest.mark.parametrize(
    ("marked", "told"),
    [
        ("travel forward «high»", '"high" cannot be said of travel: a travel has no level.'),
        ("travel -> «rising»", '"rising" cannot be said of travel: a travel has no change of'),
        ("twist «not left»", '"not left" cannot be said of twist: a twist has no direction.'),
        ("r_arm «full»", '"full" cannot be said of r_arm: a gesture has no degree.'),
        ("twist full «slight»", 'One movement has one degree. "full/slight" means either'),
        ("twist «not full/slight»", "there is no degree that would match"),
        ("twist «full/left»", "joins words of one kind"),
    ],
)
def test_a_word_that_the_kind_does_not_have(marked: str, told: str):
    before, rest = marked.split("«")
    place, after = rest.split("»")
    with pytest.raises(PatternError) as caught:
        parse(before + place + after, PARTS)
    assert (caught.value.start, caught.value.stop) == (len(before), len(before + place))
    assert told in caught.value.found
