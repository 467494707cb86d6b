"""Searches and ingests that go on in a thread."""

import shutil
from threading import Event, Semaphore, get_ident
from time import monotonic, sleep

import pytest
from dances import BOW, RAISE, dance
from sample_library import ENCODING, add_sample, sample_score

from lanindex.errors import LanindexError, LibraryError, PatternError, UsageError
from lanindex.library import segments
from lanindex.library.selection import Selection
from lanindex.library.store import Store
from lanindex.pipeline import ingest
from lanindex.pipeline.library import open_library
from lanindex.search.match import batch
from lanindex.search.match.finder import Finder

PATTERNS = (
    *("r_arm any", "r_arm any -> any", "r_arm right -> any", "arms any", "head any ... any"),
    *("r_arm low -> mid -> high", "r_arm forward or l_arm left", "r_arm any x2", "r_arm any x1+"),
    *("r_arm any with head any", "r_arm any without l_arm any", "head any during l_arm any"),
    *("(r_arm any ... l_arm any)x2", "r_arm any <0.5s", "r_arm at high", "r_arm still"),
    *("r_arm any ... any ... any", "a: r_arm any ... b: l_arm any where a.length = b.length"),
    *('r_arm any where clip.label = "b"', 'head any where clip.who != "Bob"', "r_leg any"),
    *("r_arm any | first 7", "r_arm any | sort by match.start", "head any | count"),
    *("r_arm any | sort by clip.who | first 20", "r_arm any | count by clip.label", "@walk"),
    *(
        "r_arm right mid -> left low",
        "(r_arm right or r_arm left) -> any",
        "l_arm any overlapping head any",
    ),
)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    made = tmp_path_factory.mktemp("made") / "some.db"
    with Store.open(made, create=True) as store:
        for number in range(40):
            who = {"who": "Bob"} if number % 3 else {}
            add_sample(store, number, label="ab"[number % 2] * (number > 5), metadata=who)
        store.cache.compact()
    return made


@pytest.fixture
def place(made, tmp_path):
    return shutil.copy(made, tmp_path / "some.db")


@pytest.fixture
def library(place):
    with open_library(place) as library:
        yield library


class Steps:
    """Lets a search go on batch by batch, a capture each."""

    def __init__(self, monkeypatch):
        self._go_on, self._waits, work = Semaphore(0), Semaphore(0), Finder.in_batches
        monkeypatch.setattr(batch, "LARGE", 1 << 40)
        monkeypatch.setattr(batch, "FEWEST_ROWS", 1)

        def in_batches(finder, *given):
            for found in work(finder, *given):
                self._waits.release()
                assert self._go_on.acquire(timeout=60)
                yield found

        monkeypatch.setattr(Finder, "in_batches", in_batches)

    def take(self, batches):
        """Let so many batches be taken, and wait until the search is at the next."""
        for _ in range(batches):
            assert self._waits.acquire(timeout=60)
            self._go_on.release()
        self.wait(1)

    def wait(self, searches):
        """Wait until so many searches are at a batch."""
        for _ in range(searches):
            assert self._waits.acquire(timeout=60)
        self._waits.release(searches)

    def run(self):
        """Let it run to its end."""
        self._go_on.release(10_000)


@pytest.fixture
def steps(monkeypatch):
    return Steps(monkeypatch)


def told(hits):
    return [(hit.capture.id, hit.span, hit.symbols, hit.fit) for hit in hits]


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_job_finds_what_a_search_finds(library, pattern):
    found = library.search(pattern)
    job = library.begin(pattern)
    result = job.result
    assert (job.state, job.error, job.stamp) == ("done", None, library.store.stamp())
    assert type(result) is type(found)
    if "count" in pattern:
        assert result.dicts() == found.dicts()
        found = library.search(pattern.split(" |")[0])
    assert told(job.page(0, 10_000)) == told(found)
    assert (job.found, job.captures) == (len(found), found.captures)
    assert told(job.page(3, 5)) == told(found)[3:8]
    assert told(job.page(0, 10_000, "best")) == told(found.by_fit())
    by_capture = sorted(told(found), key=lambda hit: (hit[0], hit[1].start, hit[1].stop))
    assert told(job.page(0, 10_000, "capture")) == by_capture
    ranks = {number: -rank for rank, (number, *_) in enumerate(reversed(told(found.by_fit())))}
    together = sorted(by_capture, key=lambda hit: ranks[hit[0]])
    for at, n in ((0, 2), (2, 5), (0, 10_000)):  # no more of them are sorted than are looked at
        assert told(job.page(at, n, "best capture")) == together[at : at + n]
    for field in ("label", "clip.who"):
        by = field.removeprefix("clip.")
        if "|" not in pattern:
            counts = library.search(f"{pattern} | count by clip.{by}")
            assert job.facets(field).dicts() == counts.dicts()
            assert job.facets(field).total == len(found)


@pytest.mark.parametrize("options", [{"fuzzy": 1}, {"fuzzy": "40%", "best": 9}, {"best": 9}])
def test_options_are_those_of_a_search(library, options):
    patterns = "r_arm right -> high -> low", "head any with l_arm right", "r_arm left x1+"
    for pattern in patterns:
        found = library.search(pattern, Selection("1*.bvh"), **options)
        job = library.begin(pattern, Selection("1*.bvh"), **options)
        assert told(job.result) == told(found) == told(job.page(0, 10_000))
        assert told(job.page(2, 3, "best")) == told(found.by_fit())[2:5]


@pytest.mark.parametrize("fuzzy", [None, 1])
def test_hits_come_while_it_runs(library, steps, fuzzy):
    job = library.begin("r_arm any -> any", fuzzy=fuzzy)
    steps.take(10)
    assert (job.state, job.progress[0], job.progress[2]) == ("running", "captures", 40)
    assert 9 <= job.progress[1] <= 11
    some = told(job.page(0, 10_000, "best"))
    assert job.captures == len({number for number, *_ in some}) == 10
    assert job.found == len(some) == job.facets("who").total
    assert told(job.page(3, 4)) == some[3:7]
    before = job.seconds
    steps.take(5)
    assert job.seconds > before > 0
    more = told(job.page(0, 10_000))
    assert more[: len(some)] == some
    assert len(more) > len(some)
    steps.run()
    assert told(job.result)[: len(more)] == more
    assert (job.captures, job.progress) == (40, ("captures", 40, 40))


def test_two_searches_go_on_at_once(library, steps):
    first, second = library.begin("r_arm any"), library.begin("head any", fuzzy=1)
    steps.wait(2)
    steps.take(30)
    assert (first.state, second.state) == ("running", "running")
    assert first.found > 0 < second.found
    steps.run()
    assert (len(first.result), len(second.result)) == (first.found, second.found)
    assert first.found > 40 < second.found


def test_a_search_is_cancelled(library, steps):
    job = library.begin("r_arm any -> any")
    steps.take(10)
    job.cancel()
    assert job.state == "running"
    steps.run()
    assert job.wait(5)
    assert (job.state, job.error, job.captures) == ("cancelled", None, 10)  # not one more
    assert len(job.page(0, 10_000)) == job.found > 0
    with pytest.raises(LanindexError, match=r"cancelled after 1[01] of 40 captures"):
        _ = job.result
    assert repr(job) == f"<SearchJob cancelled, {job.progress[1]} of 40 captures>"


def test_a_search_is_cancelled_while_its_columns_are_loaded(library, monkeypatch):
    loads, read = Event(), segments.read_column

    def slow(*given):
        loads.set()
        sleep(0.05)
        return read(*given)

    monkeypatch.setattr(segments, "read_column", slow)
    jobs = [library.begin("r_arm any with head any with l_arm any") for _ in range(2)]
    assert loads.wait(60)
    begun = monotonic()
    for job in jobs:  # the one that loads, and the one that waits for it
        job.cancel()
        assert job.wait(5)
        assert (job.state, job.found) == ("cancelled", 0)
    assert monotonic() - begun < 0.5


def test_a_sort_is_cancelled(library, monkeypatch):
    sorts, go_on = Event(), Event()

    def values(hits, by):
        sorts.set()
        assert go_on.wait(60)
        for hit in hits:
            yield hit.fit

    monkeypatch.setattr("lanindex.search.hits._values", values)
    job = library.begin("r_arm any | sort by match.margin")
    assert sorts.wait(60)
    assert job.progress[0] == "hits"
    job.cancel()
    go_on.set()
    assert job.wait(5)
    assert job.state == "cancelled"


def test_closing_the_library_cancels_its_jobs(place, steps):
    with open_library(place) as library:
        job = library.begin("r_arm any")
        steps.take(1)
    steps.run()
    assert job.wait(5)
    assert job.state == "cancelled"


def test_what_has_ended_is_not_cancelled(library):
    job = library.begin("r_arm any")
    assert job.wait(60)
    job.cancel()
    assert (job.state, len(job.result)) == ("done", job.found)


@pytest.mark.parametrize(
    ("pattern", "kind"),
    [
        ("r_arm sideways", PatternError),
        ('r_arm any where clip.whom = "Bob"', UsageError),
        ("a: r_arm any where a.start > 1s", UsageError),
    ],
)
def test_a_search_fails(library, pattern, kind):
    job = library.begin(pattern, fuzzy=1)
    assert job.wait(60)
    assert (job.state, job.found, job.page(0, 10)) == ("failed", 0, [])
    assert isinstance(job.error, kind)
    with pytest.raises(kind) as caught:
        _ = job.result
    assert caught.value is job.error


def test_a_search_that_takes_too_long_fails(library):
    job = library.begin("r_arm any", timeout=0)
    assert job.wait(60)
    assert job.state == "failed"
    assert "longer than 0 s" in str(job.error)


def test_options_that_make_no_sense_are_refused_at_once(library):
    with pytest.raises(UsageError, match="a tolerance of -1 s"):
        library.begin("r_arm any", tolerance=-1)
    with pytest.raises(TypeError, match="patience"):
        library.begin("r_arm any", patience=1)
    job = library.begin("r_arm any")
    for at, n, order in ((-1, 5, ""), (0, -1, ""), (0, 5, "worst")):
        with pytest.raises(UsageError):
            job.page(at, n, order)
    with pytest.raises(UsageError, match='no capture has a column "whom"'):
        job.facets("whom")


def test_notes_and_refusals_are_the_job_s(library, monkeypatch):
    monkeypatch.setattr(Finder, "_in_batch", _refusing(Finder._in_batch))
    job = library.begin("r_arm any")
    assert job.wait(60)
    assert (job.state, job.captures) == ("done", 39)
    assert [error.place for error in job.refused] == ["3.bvh"]
    assert ["3.bvh" in note for note in job.notes] == [True]
    assert (library.refused, library.notes) == ([], [])


def _refusing(work):
    def in_batch(finder, places):
        hits, rich = work(finder, places)
        return hits.at(hits.capture != 3), [*rich, 3]

    return in_batch


def test_the_library_changes_meanwhile(library, steps):
    job = library.begin("r_arm any")
    steps.take(5)
    stamp = library.store.stamp()
    library.store.add("0.bvh", sample_score(7), format="bvh", sha256="1", encoding=ENCODING)
    steps.run()
    assert (len(job.result), job.stamp) == (job.found, stamp)
    assert library.store.stamp() == stamp + 1
    assert job.page(10, 5)  # of other captures
    with pytest.raises(LibraryError, match=r"are gone, or others now.*Search again"):
        job.page(0, 1)
    assert job.facets("label").total == job.found
    assert library.begin("r_arm any").result[0].capture.sha256 == "1"


# Ingests.


@pytest.fixture
def folder(tmp_path):
    for number in range(6):
        dance(tmp_path / "dances" / f"{number}.bvh", RAISE if number % 2 else BOW)
    (tmp_path / "dances" / "none.bvh").write_text("nothing")
    return tmp_path / "dances"


def paths(outcomes):
    return [(outcome.status, outcome.path) for outcome in outcomes]


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_ingest_does_what_ingest_does(tmp_path, folder, jobs):
    with open_library(tmp_path / "a.db", create=True) as library:
        wanted = paths(library.ingest(folder))
    with open_library(tmp_path / "b.db", create=True) as library:
        job = library.begin_ingest(folder, jobs=jobs)
        come = [(outcome, len(library.captures())) for outcome in job]
        assert all(stored >= at for at, (_, stored) in enumerate(come[:6], 1))
        assert paths(job.result) == paths(job.outcomes) == wanted
        assert paths(outcome for outcome, _ in come) == wanted
        assert (job.state, job.progress) == ("done", ("files", 7, 7))
        assert paths(job) == wanted  # once more
        assert {status for status, _ in paths(library.begin_ingest(folder).result)} == {
            "unchanged",
            "failed",
        }


def test_an_ingest_is_cancelled_between_files(tmp_path, folder, monkeypatch):
    thread, go_on, work = [], Semaphore(0), ingest._store

    def store(*given):
        thread.append(get_ident())
        assert go_on.acquire(timeout=60)
        return work(*given)

    monkeypatch.setattr(ingest, "_store", store)
    with open_library(tmp_path / "some.db", create=True) as library:
        job = library.begin_ingest(folder)
        come = iter(job)
        go_on.release(2)
        assert [next(come).path[-5:], next(come).path[-5:]] == ["0.bvh", "1.bvh"]
        assert (job.state, job.progress[2]) == ("running", 7)
        job.cancel()
        go_on.release()
        assert [outcome.path[-5:] for outcome in come] == ["2.bvh"]
        assert job.state == "cancelled"
        assert job.progress == ("files", 3, 7)
        assert get_ident() not in thread
        assert [capture.path[-5:] for capture in library.captures()] == ["0.bvh", "1.bvh", "2.bvh"]
        assert library.begin("r_arm any").result.captures == 3
        with pytest.raises(LanindexError, match="cancelled after 3 of 7 files"):
            _ = job.result
        go_on.release(10)
        statuses = [status for status, _ in paths(library.begin_ingest(folder))]
        assert statuses == ["unchanged"] * 3 + ["added"] * 3 + ["failed"]


def test_an_ingest_fails(tmp_path, folder):
    (tmp_path / "labels.csv").write_text("file,label\nanother.bvh,x\n")
    with open_library(tmp_path / "some.db", create=True) as library:
        job = library.begin_ingest(folder, labels=tmp_path / "labels.csv")
        with pytest.raises(UsageError, match="no row names a file"):
            list(job)
        assert job.state == "failed"
        assert library.captures() == []


def test_searches_go_on_while_an_ingest_does(tmp_path, folder):
    with open_library(tmp_path / "some.db", create=True) as library:
        job, counts = library.begin_ingest(folder), []
        while job.state == "running":
            counts.append(library.begin("r_arm any").result.captures)
        counts.append(len({hit.capture.id for hit in library.begin("r_arm any").result}))
    assert counts == sorted(counts)
    assert counts[-1] == 6
