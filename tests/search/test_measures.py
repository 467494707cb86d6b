"""Speed and size in patterns, beyond the cases of the page."""

import json

import numpy as np
import pytest
from query_cases import recordings_of, track
from sample_library import ENCODING

from lanindex import records
from lanindex.errors import PatternError, UsageError
from lanindex.library import rows
from lanindex.library.store import Store
from lanindex.model.columns import columns_of
from lanindex.pipeline.library import open_library
from lanindex.search.explain.english import sentence
from lanindex.search.explain.why import away
from lanindex.search.hits import extras_in
from lanindex.search.language import parse
from lanindex.search.match.batch import Rows

TEXT = (
    "fps 10 frames 60; r_arm: place low 0 0, right mid 5 9 speed=6 size=90 straightness=0.95, "
    "place low 12 20 speed=2 size=88 straightness=1, right mid 30 33; head: place high 0 0"
)

SENTENCES = {
    "r_arm right fast -> slow": "The right arm moves to the right, fast, then moves slowly.",
    "head not small": "The head moves not a little way.",
    "arm large where match.speed > 3 | sort by match.size": (
        "Either arm moves a long way. And so that the hit's highest speed (in its lengths a "
        "second) is more than 3. Then sort them by the hit's size (in degrees), the smallest first."
    ),
}


@pytest.mark.parametrize("text", SENTENCES)
def test_a_query_in_english(text: str) -> None:
    assert sentence(parse(text)) == SENTENCES[text]


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("r_arm high", set()),
        ("r_arm high fast", {"speed"}),
        ("r_arm high with (head small -> l_arm not slow)", {"size", "speed"}),
        ("r_arm high where match.straightness > 0.5 and match.margin > 0", {"straightness"}),
        ('r_arm high where clip.size = "big" | sort by match.speed', set()),  # hits tell that
    ],
)
def test_which_measures_a_search_reads(text: str, wanted: set[str]) -> None:
    assert extras_in(parse(text)) == wanted


def test_words_of_measures_may_be_names() -> None:
    assert str(parse("fast: r_arm fast where fast.speed > 3"))
    assert str(parse("let large = high; r_arm low -> @large"))


def test_plain_words() -> None:
    with pytest.raises(PatternError, match="Did you mean:  r_arm high fast"):
        parse("raise the right arm fast")
    with pytest.raises(PatternError, match='Did you mean "slow"'):
        parse("r_arm slowly")


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory):
    path = tmp_path_factory.mktemp("library") / "measured.db"
    (recording,) = recordings_of(TEXT)
    with Store.open(path, create=True) as store:
        for number in range(3):
            said = {"format": "bvh", "sha256": f"{number:064}", "encoding": ENCODING}
            store.add(f"{number}.bvh", recording.score(), **said)
        store.cache.compact()
    with open_library(path) as found:
        yield found


def test_a_library_is_asked(library) -> None:
    hits = library.search("a: r_arm fast -> slow where a.size > 88")
    assert [(hit.span.start, hit.span.stop) for hit in hits] == [(5, 20)] * 3
    symbol = hits[0].labels["a"][0]
    assert (symbol.speed, symbol.size, symbol.straightness) == (6, 90, 0.95)
    assert len(library.search("r_arm any where match.speed < 100")) == 6
    assert [it.symbols[0].speed for it in library.search("r_arm any | sort by match.speed")] == [
        *([2] * 3),
        *([6] * 3),
        *([None] * 3),
    ]


def test_it_is_said_where_nothing_is_known(tmp_path) -> None:
    with Store.open(tmp_path / "old.db", create=True) as store:
        for number, text in enumerate((TEXT, "fps 10 frames 60; r_arm: right mid 5 9")):
            (recording,) = recordings_of(text)
            said = {"format": "bvh", "sha256": f"{number:064}", "encoding": ENCODING}
            store.add(f"{number}.bvh", recording.score(), **said)
    with open_library(tmp_path / "old.db") as found:
        assert len(found.search("r_arm right mid")) == 3
        assert found.notes == []
        assert len(found.search("r_arm right mid fast")) == 1
        (note,) = found.notes
        assert note.startswith("1 of 2 captures tell no speed: they came as scores")


def test_what_json_says(library) -> None:
    (hit, *_) = library.search("a: r_arm fast")
    label = json.loads(json.dumps(records.of_hit(hit)))["labels"]["a"]
    assert (label["speed"], label["size"], label["straightness"]) == (6, 90, 0.95)
    (_, tracks), *_ = library.tracks()
    lines = [records.of_row(hit.capture, it) for it in tracks["r_arm"].listed()]
    assert [line["size"] for line in lines] == [None, 90, 88, None]


def test_a_fuzzy_search_has_no_edits_of_measures(library) -> None:
    with pytest.raises(UsageError, match="how fast or large a movement is"):
        library.search("r_arm fast -> slow", fuzzy="1")


def test_how_near_a_movement_comes_to_what_is_asked() -> None:
    *_, fast, unknown = track(
        "r_arm", "place low 0 0, right mid 0 5 speed=6, left mid 5 9", 10
    ).listed()
    for text, symbol, apart in (
        ("r_arm right fast", fast, 0),
        ("r_arm right slow", fast, 1),
        ("r_arm right fast small", fast, 1),
        ("r_arm left not fast", unknown, 1),
    ):
        step = parse(text).pattern.alternatives[0].first.items[0].unit
        assert away(symbol, step) == apart


def test_what_was_not_read_is_no_zero() -> None:
    (recording,) = recordings_of(TEXT)
    columns = columns_of("r_arm", [recording.capture], [recording.tracks["r_arm"]])
    bare = type(columns)(
        "r_arm", *(getattr(columns, it) for it in ("bounds", *columns.rows[:5])), columns.seen
    )
    rows = Rows(bare, np.arange(1), np.array([60]))
    with pytest.raises(ValueError, match="the speed of r_arm was not read"):
        rows.grade("pace")


def test_rows_of_an_earlier_version_are_not_measured() -> None:
    symbols = track(
        "r_arm", "place low 0 0, right mid 5 9 speed=6 size=90 straightness=0.95", 60
    ).symbols
    packed = rows.pack(symbols)
    packed[:, rows.COLUMNS.index("sign")] &= (1 << 23) - 1
    found = rows.unpack(packed)
    for name in symbols.dtype.names:
        same = name not in ("speed", "size", "straightness")
        assert (found[name] == symbols[name]).all() if same else (found[name] < 0).all()
