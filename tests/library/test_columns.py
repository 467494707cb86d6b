"""Columns equal the rows of a library, wherever they come from."""

import json
from fractions import Fraction

import numpy as np
import pytest
from sample_library import add_sample, fill, sample_score, sql

from lanindex.library import cache
from lanindex.library.migrate import check, status, upgrade
from lanindex.library.rows import checksum
from lanindex.library.segments import TEXTS, read_spine
from lanindex.library.store import Store
from lanindex.model import Meter, Score, Span, Track
from lanindex.model.columns import EXTRA, columns_of, has_amount, roster_of

PARTS = ("r_arm", "l_arm", "head", "body_turn", "tail")
"""The last is nobody's; a turn and an arm have amounts."""


def assert_same(one, other, names):
    for name in names:
        found, wanted = getattr(one, name), getattr(other, name)
        assert found.dtype == wanted.dtype, name
        np.testing.assert_array_equal(found, wanted, err_msg=name)


def assert_true(library, parts=PARTS, numbers=None):
    """Hold what a library gives as columns against its tracks and captures."""
    known = library.captures()
    for name in ("path", "location", "format", "label", "metadata"):
        assert library.texts(name) == {one.id: getattr(one, name) for one in known}
    profiles = {one.id: library.encoding(one.id).profile for one in known}
    assert library.texts("profile") == profiles
    roster, columns = library.columns(parts, numbers)
    held = list(library.tracks(numbers))
    captures = [capture for capture, _ in held]
    assert_same(roster, roster_of(captures), ("number", "frames", "rate", "speed"))
    for part in parts:
        wanted = columns_of(part, captures, [tracks.get(part) for _, tracks in held])
        names = ("bounds", "cell", "runner", "margin", "start", "stop", "seen")
        names += ("amount",) * has_amount(part)
        assert_same(columns[part], wanted, names)
        assert (columns[part].amount is None) == (part in ("head", "tail"))
    _, columns = library.columns(parts, numbers, more=EXTRA)
    for part in parts:
        wanted = columns_of(part, captures, [tracks.get(part) for _, tracks in held])
        assert_same(columns[part], wanted, (*names, *columns[part].rows))


def segments(library):
    """Return how many captures each segment holds."""
    with sql(library.place) as connection:
        return [one for (one,) in connection.execute("SELECT captures FROM segment ORDER BY id")]


@pytest.fixture
def library(tmp_path):
    with Store.open(tmp_path / "some.db", create=True) as library:
        yield library
        assert library.session.notes == []


def odd_score(seed: int) -> Score:
    """Return a score with everything that columns can hold: gaps, passing rows, parts missing."""
    choice = np.random.default_rng(seed)
    score = sample_score(seed, length=int(choice.integers(2, 30)))
    tracks = {}
    for part in choice.permutation([*PARTS[:4], "torso"])[: choice.integers(1, 6)]:
        symbols = score.tracks["r_arm"].symbols.copy()
        symbols["passing"] = choice.random(len(symbols)) < 0.3
        symbols["margin"] = (choice.integers(0, 1001, len(symbols)) / 1000).astype(np.float32)
        symbols["swings"] = choice.integers(0, 3, len(symbols)) ** 9
        symbols["runner_level"] = choice.integers(-1, 3, len(symbols))
        if has_amount(str(part)):
            symbols["amount"] = choice.integers(0, 7, len(symbols))
        if part == "body_turn":
            symbols["level"], symbols["amount"] = -1, choice.integers(0, 32767, len(symbols))
        spans = ((Span(0, score.frames),), (), (Span(0, 5), Span(9, score.frames)))
        tracks[str(part)] = Track(str(part), symbols, spans[choice.integers(3)])
    meter = Meter(Fraction(int(choice.integers(1, 400)), 7))
    return Score(score.rate, score.frames, meter, tracks)


def test_columns_are_what_the_rows_say(library):
    for number in range(30):
        library.add(f"{number}.bvh", odd_score(number), format="bvh", sha256="0")
    assert_true(library)
    library.cache.compact()
    assert segments(library) == [30]
    assert_true(library)
    assert_true(library, numbers=[3, 7, 29, 30, 99])
    assert_true(library, numbers=[])


def test_a_part_may_be_seen_for_a_while_and_have_no_symbols(library):
    score = sample_score(0)
    jumps = Track("jump", score.tracks["r_arm"].symbols[:0], (Span(0, 5),))
    score.tracks["jump"] = jumps
    library.add("walk.bvh", score, format="bvh", sha256="0")
    for _ in range(2):
        (_, tracks), *_ = library.tracks(None)
        assert tracks["jump"].known == jumps.known
        assert_true(library, parts=("r_arm", "jump"))
        library.cache.compact()


def test_an_empty_library_has_columns(library):
    assert_true(library)
    library.cache.compact()
    assert_true(library)
    assert segments(library) == []


def test_what_is_added_later_is_found_without_a_segment(library):
    fill(library.place, 3)
    library.cache.compact()
    add_sample(library, 3)
    assert segments(library) == [3]
    assert_true(library)


def test_what_is_replaced_removed_moved_or_labelled_counts_once(library):
    for number in range(12):
        add_sample(library, number)
    library.cache.compact()
    for compacted in (False, True):
        library.add("4.bvh", odd_score(1 + compacted), format="bvh", sha256="1")
        library.label(2, f"walk {compacted}", {"who": f"\u00e9 {compacted}"})
        library.move(3, f"/elsewhere/{compacted}.bvh")
        library.remove(6 + compacted)
        assert_true(library)
        if compacted:
            library.cache.compact()
            assert_true(library)
    library.remove("4.bvh")
    add_sample(library, 4)
    assert_true(library)


@pytest.mark.sqlite
@pytest.mark.parametrize("upgraded", [False, True])
def test_segments_of_an_earlier_version_are_made_anew(library, upgraded):
    for number in range(5):
        add_sample(library, number)
        if number in (1, 3):
            library.cache.compact()
    library.remove(2)
    new = (*TEXTS, "swings")
    with sql(library.place) as connection:
        for number, captures, symbols, listing in connection.execute(
            "SELECT id, captures, symbols, listing FROM segment"
        ).fetchall():
            kept = json.dumps([one for one in json.loads(listing) if one[1] not in new])
            told = (kept, checksum(captures, symbols, kept), number)
            connection.execute("UPDATE segment SET listing = ?, checksum = ? WHERE id = ?", told)
        for name in new:
            connection.execute("DELETE FROM segment_column WHERE name = ?", (name,))
    assert status(library.place).fault == "made by an earlier version"
    if upgraded:
        upgrade(library.place)
    with Store.open(library.place) as other:
        other.texts("label")
        other.columns(["r_arm"])
        assert bool(other.session.notes) != upgraded
        assert status(library.place).fault == ""
        with other.session.reading() as connection:
            (segment,) = read_spine(connection).segments
        assert (segment.captures, segment.complete) == (4, True)
        assert_true(other)
    assert check(library.place) == []


def test_segments_are_joined_as_they_grow(library):
    sizes = []
    for number in range(16):
        add_sample(library, number)
        library.cache.compact()
        sizes.append(segments(library))
        assert_true(library)
    assert sizes[:6] == [[1], [2], [2, 1], [4], [4, 1], [4, 2]]
    assert sizes[-1] == [16]


def test_dead_captures_leave_when_they_are_many(library):
    for number in range(8):
        add_sample(library, number)
    library.cache.compact()
    library.remove(1, 2)
    library.cache.compact()
    assert segments(library) == [8]
    library.remove(3)
    library.cache.compact()
    assert segments(library) == [5]
    assert_true(library)


@pytest.fixture
def large(library, monkeypatch):
    """Return a library whose first two segments are too large to be joined."""
    for number in range(10):
        add_sample(library, number)
        library.cache.compact()
        monkeypatch.setattr(cache, "LARGEST", 4 * (3 * 6 + 1))
        if number == 5:
            assert segments(library) == [4, 2]
    assert segments(library) == [4, 4, 2]
    return library


def test_a_large_segment_is_left_alone(large):
    assert_true(large)
    large.remove(3, 4)
    large.cache.compact()
    assert segments(large) == [4, 4, 2]  # a fifth of all is dead


def test_dead_captures_leave_a_large_segment_alone(large):
    large.remove(3, 4, 5)
    large.cache.compact()
    assert segments(large) == [4, 4]  # 5 to 8, of which one is dead; then 9, 10, 1, 2
    assert_true(large)
    large.remove(1, 2, 6, 7, 8, 9)
    large.cache.compact()
    assert segments(large) == [1]
    assert_true(large)


def test_a_segment_holds_no_more_than_a_chunk(library, monkeypatch):
    monkeypatch.setattr(cache, "CHUNK", 40)
    monkeypatch.setattr(cache.segments, "BATCH", 1)
    monkeypatch.setattr(cache, "join", lambda connection: False)
    for number in range(7):
        add_sample(library, number)
    library.cache.compact()
    assert segments(library) == [3, 3, 1]
    assert_true(library)


def test_columns_are_read_once(library):
    fill(library.place, 3)
    library.cache.compact()
    _, first = library.columns(["head"])
    _, again = library.columns(["head", "r_arm"])
    assert first["head"] is again["head"]
    add_sample(library, 3)
    assert library.columns(["head"])[1]["head"] is not first["head"]


def test_the_names_of_the_parts_come_from_wherever_they_are(library):
    for compacted, parts in ((True, ("head", "r_arm")), (False, ("l_leg",))):
        score = sample_score(0, parts)
        library.add(f"{parts}.bvh", score, format="bvh", sha256="0")
        if compacted:
            library.cache.compact()
    assert library.parts(checked=False) == library.parts() == ["r_arm", "l_leg", "head"]
    library.remove(2)
    assert library.parts(checked=False) == ["r_arm", "head"]
    with sql(library.place) as connection:
        connection.execute("UPDATE state SET stamp = stamp + 1")
    assert library.parts(checked=False) == ["r_arm", "head"]


def test_vast_fractions_have_gather(library):
    score = Score(Fraction(30), 60, Meter(Fraction(10**30, 3 * 10**27)), sample_score().tracks)
    library.add("a.bvh", score, format="bvh", sha256="0")
    score = Score(Fraction(3, 10**30), 60, Meter(), sample_score().tracks)
    library.add("b.bvh", score, format="bvh", sha256="0")
    roster, _ = library.columns([])
    assert roster.speed[0, 0] / roster.speed[0, 1] == pytest.approx(1000 / 3)
    assert (roster.rate > 0).all()
