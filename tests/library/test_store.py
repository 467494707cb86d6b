"""Storing, finding and counting captures."""

import json
import os
import re
from concurrent.futures import ThreadPoolExecutor
from unicodedata import normalize

import numpy as np
import pytest
from sample_library import ENCODING, add_sample, fill, sample_score, sql
from strategies import assert_same_score

from lanindex.errors import LibraryError, UsageError
from lanindex.library import connect, rows, schema, store
from lanindex.library.read import read_state
from lanindex.library.rows import Encoding
from lanindex.library.selection import Selection
from lanindex.library.store import Store
from lanindex.model import Score, Track


@pytest.fixture
def library():
    with Store.open(":memory:", create=True) as library:
        yield library


def add(library, path, score=None, **extra):
    said = {"format": "bvh", "sha256": "ab", "encoding": ENCODING} | extra
    return library.add(path, sample_score() if score is None else score, **said)


def test_a_plain_select_can_be_read(tmp_path):
    path = tmp_path / "some.db"
    fill(path, 1)
    with sql(path) as connection:
        found = connection.execute(
            "SELECT part, direction, level, start_frame, end_frame FROM symbol WHERE part = 'head'"
        ).fetchall()
        assert found[:3] == [
            ("head", "right", "low", 0, 0),
            ("head", "r_forward", "mid", 1, 10),
            ("head", "forward", "high", 11, 20),
        ]
        (capture,) = connection.execute("SELECT path, fps, rate, frames FROM capture").fetchall()
        assert capture == ("0.bvh", pytest.approx(29.97, abs=0.01), "30000/1001", 60)
        profiles = connection.execute(
            "SELECT path, name, options FROM capture JOIN profile ON profile.id = profile_id"
        ).fetchall()
        assert profiles == [("0.bvh", "default", '{"up": "z"}')]


def test_the_same_content_elsewhere_is_another_capture(library):
    assert add(library, "a.bvh") != add(library, "b.bvh")
    assert len(library.captures()) == 2


def test_one_path_however_written_is_one_capture(library, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sub").mkdir()
    first = add(library, "sub/a.bvh")
    assert library.capture(first).path == "sub/a.bvh"
    assert library.capture(first).location == str(tmp_path / "sub" / "a.bvh")
    assert add(library, "./sub/a.bvh") == first
    monkeypatch.chdir(tmp_path / "sub")
    assert add(library, "a.bvh") == first
    assert add(library, tmp_path / "sub" / "a.bvh") == first
    assert list(library.known()) == [str(tmp_path / "sub" / "a.bvh")]


def test_another_profile_replaces_the_encoding(library):
    number = add(library, "a.bvh", label="walk", metadata={"who": "x"})
    add(library, "b.bvh")
    paper = Encoding("paper", "e" * 64, {"unit": "cm", "fps": "30"})
    assert add(library, "a.bvh", sample_score(4), encoding=paper) == number
    assert_same_score(library.score(number), sample_score(4))
    (first, second) = library.captures()
    assert (first.label, first.metadata) == ("walk", {"who": "x"})
    assert library.known() == {
        first.location: ("ab", paper),
        second.location: ("ab", ENCODING),
    }
    assert library.stats().profiles == {"default": 1, "paper": 1}
    add(library, "b.bvh", encoding=paper)
    assert library.stats().profiles == {"paper": 2}
    assert library.session.connection.execute("SELECT name FROM profile").fetchall() == [("paper",)]


def test_a_score_that_came_as_one_has_no_profile(library):
    add(library, "a.lnd", format="lnd", encoding=None)
    assert list(library.known().values()) == [("ab", Encoding())]
    assert library.stats().profiles == {"": 1}


def test_labels_change_without_the_score(library):
    number = add(library, "a.bvh", label="walk", metadata={"who": "x", "take": "1"})
    assert not library.label(number)
    assert not library.label(number, "walk", {"take": "1", "who": "x"})
    assert library.label("a.bvh", "run")
    assert library.label(number, metadata={"who": "y"})
    capture = library.capture(number)
    assert (capture.label, capture.metadata) == ("run", {"who": "y"})
    assert library.label(number, "", {})
    assert (library.capture(number).label, library.capture(number).metadata) == ("", {})
    assert_same_score(library.score(number), sample_score())


def test_what_is_removed_is_gone(library):
    numbers = [add(library, name, metadata={"a": "b"}) for name in ("a.bvh", "b.bvh")]
    library.remove("a.bvh")
    assert [capture.id for capture in library.captures()] == numbers[1:]
    with pytest.raises(LibraryError, match=r"there is no capture 1\."):
        library.score(numbers[0])
    library.remove(numbers[1])
    for table in schema.tables.sorted_tables:
        left = [] if table is not schema.state else [(1, 4, 0, 0, 4, None)]
        assert library.session.connection.execute(f"SELECT * FROM {table.name}").fetchall() == left


def test_several_are_removed_or_none(library):
    for name in ("a.bvh", "b.bvh", "c.bvh"):
        add(library, name)
    with pytest.raises(LibraryError, match=r"there is no capture d\.bvh"):
        library.remove("a.bvh", 2, "d.bvh")
    assert len(library.captures()) == 3
    library.remove("a.bvh", 1, 3)
    assert [capture.path for capture in library.captures()] == ["b.bvh"]


def test_what_is_missing(library, folder, common_user):
    for name in ("here.bvh", "closed/there.bvh", "file/gone.bvh", "gone.bvh"):
        add(library, folder / name)
    (folder / "closed").mkdir(0)
    for name in ("here.bvh", "file"):
        (folder / name).touch()
    library.missing()  # imports what a user without rights may not read
    with common_user():
        names = [os.path.relpath(capture.path, folder) for capture in library.missing()]
    assert names == [os.path.join("file", "gone.bvh"), "gone.bvh"]


def test_tracks_of_some_captures_and_parts(library):
    numbers = [add_sample(library, number) for number in range(200)]
    assert [capture.id for capture, _ in library.tracks()] == numbers
    chosen = [numbers[150], numbers[3], 10_000, numbers[3]]
    found = list(library.tracks(chosen, ["head", "tail"]))
    assert [(capture.path, list(tracks)) for capture, tracks in found] == [
        ("3.bvh", ["head"]),
        ("150.bvh", ["head"]),
    ]
    assert [list(tracks) for _, tracks in library.tracks([1], ["tail"])] == [[]]
    wanted = sample_score(150).tracks["head"]
    assert found[1][1]["head"].symbols.tolist() == wanted.symbols.tolist()


def test_a_reader_between_two_captures_lets_others_write(tmp_path):
    fill(tmp_path / "some.db", 3)
    with Store.open(tmp_path / "some.db", readonly=True) as library:
        tracks = library.tracks()
        next(tracks)
        with Store.open(tmp_path / "some.db", timeout=0.1) as other:
            add_sample(other, 3)
        assert len(list(tracks)) == 2


def test_arrays_of_the_library_are_read_only(library):
    score = library.score(add(library, "a.bvh"))
    with pytest.raises(ValueError, match="read-only"):
        score.tracks["head"].symbols["start"] = 3


def test_parts_in_the_order_of_the_alphabet(library):
    assert library.parts() == []
    add(library, "a.bvh", sample_score(parts=("torso", "tail", "l_arm")))
    add(library, "b.bvh", sample_score(parts=("r_arm",)))
    assert library.parts() == ["r_arm", "l_arm", "torso", "tail"]


def test_counts(library):
    assert library.stats().captures == 0
    for name, label in (("a.bvh", "walk"), ("b.bvh", "walk"), ("c.lnd", "")):
        add(library, name, label=label, format=name[-3:])
    stats = library.stats()
    assert (stats.captures, stats.frames, stats.symbols) == (3, 180, 54)
    assert stats.seconds == pytest.approx(180 * 1001 / 30000)
    assert stats.parts == {"head": 18, "l_arm": 18, "r_arm": 18}
    assert stats.labels == {"": 1, "walk": 2}
    assert stats.formats == {"bvh": 2, "lnd": 1}
    assert stats.profiles == {"default": 3}


def test_captures_by_glob(library):
    for name in ("a/walk_1.bvh", "a/run_1.bvh", "b/walk_2.bvh"):
        add(library, name)
    found = {
        glob: [capture.path for capture in library.captures(Selection(glob))]
        for glob in ("walk*", "a/*", os.path.abspath("b") + "/*", "*", "walk")
    }
    assert list(found.values()) == [
        ["a/walk_1.bvh", "b/walk_2.bvh"],
        ["a/walk_1.bvh", "a/run_1.bvh"],
        ["b/walk_2.bvh"],
        ["a/walk_1.bvh", "a/run_1.bvh", "b/walk_2.bvh"],
        [],
    ]


def test_a_capture_by_its_name(library):
    for name in ("a/walk.bvh", "b/walk.bvh", "b/run.bvh"):
        add(library, name)
    for named, wanted in (
        ("b/run.bvh", 3),
        ("run.bvh", 3),
        (os.path.abspath("a/walk.bvh"), 1),
        ("2", 2),
        (2, 2),
    ):
        assert library.capture(named).id == wanted
    add(library, "77")
    with pytest.raises(LibraryError, match=r"there is no capture 77\."):
        library.capture(77)
    with pytest.raises(LibraryError, match=r"2 captures are called walk.bvh\. Name one: /"):
        library.capture("walk.bvh")
    with pytest.raises(LibraryError, match=r"no capture b/runn.bvh\. Did you mean b/run.bvh"):
        library.capture("b/runn.bvh")
    with pytest.raises(LibraryError, match=r"no capture \*\. All are shown by: lanindex list"):
        library.capture("*")


def bad_scores():
    score = sample_score()
    for field, value in (
        ("direction", 9),
        ("level", -1),
        ("runner_level", 3),
        ("runner_direction", -2),
        ("start", 99),
        ("start", -1),
        ("stop", 61),
    ):
        symbols = score.tracks["head"].symbols.copy()
        symbols[field][3] = value
        said = f"head has the symbol {symbols[3]}, wanted codes of the alphabet and a span"
        yield re.escape(said), {"r_arm": score.tracks["r_arm"], "head": Track("head", symbols, ())}
    yield "the track of head", {"r_arm": score.tracks["head"]}


@pytest.mark.parametrize(("said", "tracks"), list(bad_scores()))
def test_a_score_that_says_nonsense_is_refused(library, said, tracks):
    score = Score(sample_score().rate, 60, sample_score().meter, tracks)
    with pytest.raises(UsageError, match=said) as caught:
        add(library, "a.bvh", score)
    assert caught.value.place == "a.bvh"
    assert library.captures() == []


@pytest.mark.parametrize(
    ("path", "extra"),
    [
        ("a.bvh", {"label": "\udcff"}),
        ("a.bvh", {"metadata": {"k": "\udcff"}}),
        ("a.bvh", {"metadata": {"\udcff": "v"}}),
    ],
)
def test_names_that_are_no_text_are_refused(library, path, extra):
    with pytest.raises(UsageError, match="bytes that are no UTF-8") as caught:
        add(library, path, **extra)
    str(caught.value).encode()
    assert library.captures() == []
    number = add(library, "b.bvh")
    if extra:
        with pytest.raises(UsageError, match="bytes that are no UTF-8"):
            library.label(number, **extra)


def test_what_fails_halfway_leaves_nothing(library, monkeypatch):
    number = add(library, "a.bvh", label="walk")
    nothing = ([(0, "head", 0, None, 1, 0)], [[0], [0], *[[None]] * 6], 0)
    monkeypatch.setattr(rows, "rows_of", lambda *_: nothing)
    for path in ("a.bvh", "b.bvh"):
        with pytest.raises(LibraryError, match=r"the database says: (NOT NULL|null value)"):
            add(library, path, sample_score(5), label="run")
    assert_same_score(library.score(number), sample_score())
    assert [capture.label for capture in library.captures()] == ["walk"]


@pytest.mark.parametrize(
    "which",
    [True, False, 1.0, 0, -1, 1 << 63, (1 << 63) - 1, -(1 << 70), 10**40, None, [1], b"1", (1,)],
)
def test_what_is_no_number_of_a_capture_names_none(library, which):
    add(library, "a.bvh")
    for call in (library.capture, library.score, library.label, library.remove):
        with pytest.raises(LibraryError, match=r"there is no capture "):
            call(which)
    assert list(library.tracks([which])) == []
    assert len(library.captures()) == 1


def test_whole_numbers_of_other_types_are_numbers(library):
    number = add(library, "a.bvh")
    assert library.capture(np.int64(number)).id == number
    assert len(list(library.tracks(np.array([number])))) == 1


def test_nothing_hangs_on_what_is_not_there(tmp_path):
    fill(tmp_path / "some.db", 2)
    with Store.open(tmp_path / "some.db") as library:
        for statement in (
            "INSERT INTO metadata VALUES (7, 'who', 'x')",
            "INSERT INTO track VALUES (7, 0, 'head', 0, NULL, 0, 0)",
            "INSERT INTO symbol_code VALUES (1, 7, 0, 0, 0, 0, 0, 0, 0)",
            "UPDATE capture SET profile_id = 7",
            "DELETE FROM profile",
        ):
            with pytest.raises(connect.faults(), match=r"(?i)foreign key"):
                library.session.connection.execute(statement)
            library.session.connection.rollback()
        library.session.connection.execute("DELETE FROM capture WHERE id = 1")
        for table in ("track", "symbol_code"):
            asked = f"SELECT DISTINCT capture_id FROM {table}"
            assert library.session.connection.execute(asked).fetchall() == [(2,)]


def test_a_number_is_never_used_twice(tmp_path):
    fill(tmp_path / "some.db", 2)
    with Store.open(tmp_path / "some.db") as library:
        library.remove(2)
    with Store.open(tmp_path / "some.db") as library:
        assert add(library, "c.bvh") == 3
        library.remove(1, 3)
    with Store.open(tmp_path / "some.db") as library:
        assert add(library, "d.bvh") == 4


def stamp(library):
    with library.session.reading() as connection:
        return read_state(connection).stamp


def test_the_stamp_tells_every_change(library):
    stamps = [stamp(library)]
    for change in (
        lambda: add(library, "a.bvh"),
        lambda: add(library, "a.bvh", sample_score(3)),
        lambda: library.label(1, "walk"),
        lambda: library.move(1, "b.bvh"),
        lambda: library.remove(1),
    ):
        change()
        stamps.append(stamp(library))
    assert stamps == sorted(set(stamps))
    add(library, "a.bvh")
    before = stamp(library)
    library.captures(), library.score("a.bvh"), list(library.tracks()), library.known()
    assert not library.label("a.bvh")
    assert stamp(library) == before
    with pytest.raises(LibraryError):
        library.remove("a.bvh", "b.bvh")
    assert stamp(library) == before


def test_what_the_reader_found_doubtful_is_kept(library):
    add(library, "a.bvh", warnings=("its unit is a guess", "\udcff"))
    add(library, "b.bvh")
    assert [one.warnings for one in library.captures()] == [("its unit is a guess", "\udcff"), ()]
    assert [one.path for one in library.captures() if one.warnings] == ["a.bvh"]
    add(library, "a.bvh")
    assert not any(one.warnings for one in library.captures())


def test_a_capture_that_moved_keeps_what_is_known_of_it(library, tmp_path):
    number = add(library, "a.bvh", label="walk", metadata={"who": "x"}, warnings=("doubtful",))
    before = library.capture(number)
    library.move("a.bvh", tmp_path / "b.bvh")
    after = library.capture(number)
    assert (after.path, after.location) == (str(tmp_path / "b.bvh"),) * 2
    assert (after.label, after.metadata, after.warnings) == ("walk", {"who": "x"}, ("doubtful",))
    assert after.sha256 == before.sha256
    assert_same_score(library.score(number), sample_score())
    add(library, "c.bvh")
    with pytest.raises(LibraryError, match=r"UNIQUE|unique"):
        library.move(number, "c.bvh")
    library.move(number, "\udcff.bvh")
    assert library.capture("\udcff.bvh") == library.capture(r"\xff.bvh")
    assert library.capture(number).location == os.path.abspath(r"\xff.bvh")


@pytest.mark.parametrize(
    ("where", "wanted"),
    [
        ({"label": "walk"}, "ad"),
        ({"label": "*a*"}, "acd"),
        ({"label": ""}, "b"),
        ({"format": "lnd"}, "c"),
        ({"path": "*.bvh", "label": "dance"}, ""),
        ({"path": "sub/*"}, "d"),
        ({"who": "x"}, "ac"),
        ({"who": "x", "label": "walk"}, "a"),
        ([("who", "[xy]"), ("who", "y")], "d"),
        ({"who": ""}, "b"),
        ({"dataset": "one"}, ""),
        ({"caf\u00e9": "cre\u0301*"}, "b"),
        ({"label": "z\u00fcrich"}, ""),
        ({}, "abcd"),
    ],
)
def test_captures_by_what_is_known_of_them(library, where, wanted):
    add(library, "a.bvh", label="walk", metadata={"who": "x"})
    add(library, "b.bvh", metadata={"caf\u00e9": "cr\u00e9me"})
    add(library, "c.lnd", format="lnd", label="dance", metadata={"who": "x"})
    add(library, "sub/d.bvh", label="walk", metadata={"who": "y"})
    assert [
        os.path.basename(one.path)[0] for one in library.captures(Selection(where=where))
    ] == list(wanted)
    both = library.captures(Selection("*.lnd", where))
    assert [one.path for one in both] == (["c.lnd"] if "c" in wanted else [])


def test_a_column_that_no_capture_has_is_refused(library):
    assert library.captures(Selection(where={"who": "x"})) == []
    add(library, "a.bvh", metadata={"take": "1"})
    said = 'no capture has a column "who", wanted one of path, label, format, dataset, take'
    with pytest.raises(UsageError, match=said):
        library.captures(Selection(where={"who": "x"}))


@pytest.mark.parametrize("form", ["NFC", "NFD"])
def test_globs_match_letters_however_composed(library, form):
    add(library, normalize(form, "\u00fcbung/\u00e9t\u00e9.bvh"))
    for other in ("NFC", "NFD"):
        for glob in ("\u00fcbung/*", "\u00e9t?.bvh"):
            assert len(library.captures(Selection(normalize(other, glob)))) == 1
            assert len(library.captures(Selection(where={"path": normalize(other, glob)}))) == 1


def test_a_heading_in_tenths_is_small(library):
    turning = np.round(100 + np.cumsum(np.sin(np.arange(6000) / 50)), 1).astype(np.float32)
    score = sample_score()
    number = add(library, "a.bvh", Score(score.rate, 60, score.meter, {}, turning))
    assert library.score(number).heading.tobytes() == turning.tobytes()
    ((stored,),) = library.session.connection.execute("SELECT length(heading) FROM capture")
    assert stored < turning.nbytes / 10


@pytest.mark.parametrize(
    "heading", [[-0.0], [1e30, 0.0], [0.25], [np.inf], [3276.9, -3276.9], [0.1, np.nan], []]
)
def test_any_heading_comes_back_to_the_bit(heading):
    wanted = np.array(heading, np.float32)
    assert rows.unpack_heading(rows.pack_heading(wanted)).tobytes() == wanted.tobytes()


def test_a_capture_that_is_not_there_leaves_no_trace(library):
    add(library, "a.bvh")
    with pytest.raises(LibraryError, match=r"no capture b\.bvh"):
        library.remove("b.bvh")
    add(library, "b.bvh")
    assert library.numbers(Selection("b.bvh")) == [2]


def test_a_closed_library_says_so(tmp_path):
    library = Store.open(tmp_path / "some.db", create=True)
    library.close()
    library.close()
    for call in (library.captures, lambda: library.remove(1)):
        with pytest.raises(LibraryError, match=r"this library has been closed\. Open it again\."):
            call()


@pytest.mark.sqlite
def test_a_library_in_memory_belongs_to_one_thread(library):
    number = add(library, "a.bvh")
    calls = (library.captures, lambda: library.remove(number), library.close)
    for call in calls:
        with ThreadPoolExecutor(1) as other, pytest.raises(LibraryError) as caught:
            other.submit(call).result()
        assert str(caught.value) == (
            ":memory:: this library is in memory, and was opened in another thread. "
            "Keep it in a file, which serves all threads."
        )
    assert len(library.captures()) == 1


def test_the_heading_is_kept_as_bytes_of_one_order(library):
    score = sample_score()
    turned = Score(score.rate, 60, score.meter, {}, np.array([1.5, np.nan], ">f4").astype("f4"))
    number = add(library, "a.bvh", turned)
    ((heading, options),) = library.session.connection.execute(
        "SELECT heading, options FROM capture"
    )
    assert heading == b"\0" + np.array([1.5, np.nan], "<f4").tobytes()
    assert json.loads(options) == {"up": "z"}
    assert library.score(number).heading[0] == 1.5


def test_a_library_prints_its_place(library):
    assert repr(library) == "<Store :memory:>"


def test_a_track_without_symbols_comes_back(tmp_path):
    score = sample_score(length=0)
    with Store.open(tmp_path / "l.db", create=True) as library:
        number = library.add("a.bvh", score, format="bvh", sha256="0" * 64)
        assert [len(one) for one in library.score(number).tracks.values()] == [0, 0, 0]
        library.cache.compact()
        assert len(library.columns(["head"], more=["swings"])[1]["head"]) == 0
        assert library.session.notes == []


def break_off(library):
    with library.session.together():
        add(library, "c.bvh")
        raise KeyboardInterrupt


def test_what_is_written_together_is_there_at_once_or_not_at_all(tmp_path, monkeypatch):
    path, put = tmp_path / "l.db", store.put_capture
    fill(path, 1)

    def half_put(connection, values, *rest):
        found = put(connection, values, *rest)
        if values["path"] == "half.bvh":
            raise UsageError("half")
        return found

    monkeypatch.setattr(store, "put_capture", half_put)
    with Store.open(path) as library, Store.open(path, readonly=True) as other:
        with library.session.together():
            number = add(library, "a.bvh")
            library.move(number, "b.bvh")
            with pytest.raises(UsageError):
                add(library, "half.bvh")
            assert library.capture("b.bvh").id == number
            with ThreadPoolExecutor(1) as thread:  # not in it
                assert thread.submit(library.capture_count).result() == 1
            assert other.capture_count() == 1
        assert [one.path for one in other.captures()] == ["0.bvh", "b.bvh"]
        before = library.stamp()
        with pytest.raises(KeyboardInterrupt):
            break_off(library)
        assert library.stamp() == before
        assert add(library, "c.bvh") > number
