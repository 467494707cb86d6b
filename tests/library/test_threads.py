"""One library, used by several threads at once."""

import sqlite3
from concurrent.futures import ThreadPoolExecutor
from random import Random
from threading import Event

import pytest
from sample_library import add_sample, fill

import lanindex
from lanindex.errors import LibraryError
from lanindex.library import connect, segments
from lanindex.library.connect import MOST_IDLE
from lanindex.library.sqlite import SQLITE
from lanindex.library.store import Store

PATTERNS = (
    "r_arm any -> any",
    "head any with l_arm any",
    "l_arm place ... any | sort by match.start",
    'r_arm any where clip.label != "x"',
)


@pytest.fixture
def place(tmp_path):
    fill(tmp_path / "some.db", 12)
    return tmp_path / "some.db"


@pytest.mark.slow
def test_many_threads_search_and_read_while_another_writes(place):
    done = Event()

    def read(library, seed):
        """Return how often everything could be read; what is read are whole captures."""
        random, rounds = Random(seed), 0
        while rounds < 5 or not done.is_set():
            hits = library.search(random.choice(PATTERNS[: 3 - seed % 2]), fuzzy=seed % 2 or None)
            capture = random.choice(library.captures()[:9])
            assert len(library.score(capture.id).tracks) == 3
            assert library.capture(capture.id).label in ("", "b")
            at, said = random.randrange(max(1, len(hits))), ""
            try:
                assert all(hit.symbols for hit in hits[at : at + 5])
            except LibraryError as error:  # stored anew since
                said = str(error)
            assert not said or "are gone, or others now" in said
            rounds += 1
        return rounds

    def write(store):
        for number in range(40):
            add_sample(store, 11 + number % 20, label="b")
            store.label(1 + number % 9, "b" if number % 2 else "")
            if number % 10 == 9:
                store.cache.compact()
                store.remove(f"{11 + number % 20}.bvh")

    with lanindex.open_library(place) as library, ThreadPoolExecutor(11) as pool:
        readers = [pool.submit(read, library, seed) for seed in range(10)]
        try:
            pool.submit(write, library.store).result(100)
        finally:
            done.set()
        assert min(job.result(100) for job in readers) >= 5
        found = [(hit.path, hit.span) for hit in library.search(PATTERNS[0])]
    with lanindex.open_library(place) as library:
        assert [(hit.path, hit.span) for hit in library.search(PATTERNS[0])] == found
        assert len(library.captures()) == 29
    assert [*place.parent.iterdir()] in ([], [place])  # it is in a server, or one file


def test_two_threads_that_write_wait_for_each_other(place):
    with Store.open(place, timeout=0.1) as store, ThreadPoolExecutor(4) as pool:
        jobs = [pool.submit(add_sample, store, number) for number in range(100, 160)]
        assert len({job.result(60) for job in jobs}) == 60


def test_all_threads_share_columns(place):
    with Store.open(place) as store, ThreadPoolExecutor(8) as pool:
        jobs = [pool.submit(store.columns, ["r_arm", "head"]) for _ in range(40)]
        rosters, columns = zip(*(job.result(60) for job in jobs), strict=True)
        assert len({id(roster) for roster in rosters}) == 1
        for part in ("r_arm", "head"):
            assert len({id(one[part].cell) for one in columns}) == 1


def test_a_part_that_loads_slowly_keeps_others_from_nothing(place, monkeypatch):
    slow, loads, go_on = Event(), [], Event()
    stored = segments.stored_columns

    def stored_columns(connection, held, part, *rest):
        loads.append(part)
        if part == "head":
            slow.set()
            assert go_on.wait(60)
        return stored(connection, held, part, *rest)

    monkeypatch.setattr(segments, "stored_columns", stored_columns)
    with Store.open(place, readonly=True) as store, ThreadPoolExecutor(3) as pool:
        first = pool.submit(store.columns, ["head"])
        assert slow.wait(60)
        second = pool.submit(store.columns, ["head", "r_arm"])
        assert len(pool.submit(store.columns, ["l_arm"]).result(60)[1]) == 1
        assert not first.done()
        assert not second.done()
        go_on.set()
        assert first.result(60)[1]["head"] is second.result(60)[1]["head"]
    assert sorted(loads) == ["head", "l_arm", "r_arm"]


def test_whoever_waits_for_columns_can_give_up(place, monkeypatch):
    slow, go_on, stored = Event(), Event(), segments.stored_columns

    def stored_columns(*given):
        slow.set()
        assert go_on.wait(60)
        return stored(*given)

    def tick():
        raise TimeoutError

    monkeypatch.setattr(segments, "stored_columns", stored_columns)
    with Store.open(place, readonly=True) as store, ThreadPoolExecutor(2) as pool:
        first = pool.submit(store.columns, ["head"])
        assert slow.wait(60)
        second = pool.submit(store.columns, ["head"], tick=tick)
        assert isinstance(second.exception(60), TimeoutError)
        go_on.set()
        assert len(first.result(60)[0]) == 12


@pytest.mark.sqlite
def test_connections_are_kept_for_the_next_threads_and_closed_with_the_library(place, monkeypatch):
    opened, made = SQLITE.connect, []

    def counted(*given, **how):
        made.append(opened(*given, **how))
        return made[-1]

    monkeypatch.setattr(SQLITE.__class__, "connect", staticmethod(counted))
    with Store.open(place, readonly=True) as store:
        for _ in range(30):  # threads that end
            with ThreadPoolExecutor(1) as pool:
                assert len(pool.submit(store.captures).result(60)) == 12
        assert len(made) == 1
        with ThreadPoolExecutor(20) as pool:
            for job in [pool.submit(store.captures) for _ in range(200)]:
                job.result(60)
        assert len(store.session._idle) <= MOST_IDLE
    for one in made:
        with pytest.raises(sqlite3.ProgrammingError, match="closed"):
            one.execute("SELECT 1")


def test_a_library_is_closed_while_others_read(place):
    store, reads, go_on = Store.open(place), Event(), Event()
    store.label(1, "b")

    def read():
        with store.session.reading() as connection:
            reads.set()
            assert go_on.wait(60)
            return connect.first_values(connect.ask(connection, "SELECT count(*) FROM capture"))

    with ThreadPoolExecutor(1) as pool:
        job = pool.submit(read)
        assert reads.wait(60)
        store.close()
        with pytest.raises(LibraryError, match="has been closed"):
            store.captures()
        go_on.set()
        assert job.result(60) == [12]
        with pytest.raises(LibraryError, match="has been closed"):
            pool.submit(store.captures).result(60)
    assert [*place.parent.iterdir()] in ([], [place])  # it is in a server, or one file


def test_hits_of_one_thread_are_looked_at_in_others(place):
    with lanindex.open_library(place) as library, ThreadPoolExecutor(8) as pool:
        for fuzzy in (None, 1):
            wanted = list(library.search(PATTERNS[0], fuzzy=fuzzy))
            hits = pool.submit(library.search, PATTERNS[0], fuzzy=fuzzy).result(60)
            jobs = [pool.submit(hits.__getitem__, at) for at in range(len(hits))]
            assert [job.result(60) for job in jobs] == wanted
            assert len({hit.capture.id for hit in wanted}) > 5
