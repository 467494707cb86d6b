"""An interrupted ingest leaves whole captures, and the next run goes on."""

import contextlib
import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest
from sample_library import add_sample, fill, name_of, sample_score
from strategies import assert_same_score

from lanindex.errors import LibraryError
from lanindex.library.migrate import check
from lanindex.library.store import Store

BREAK_OFF = Path(__file__).with_name("interrupt.py")


@pytest.mark.sqlite
@pytest.mark.slow
@pytest.mark.parametrize("place", [(), ("cols",)], ids=["in the library", "in files"])
@pytest.mark.parametrize("how", ["kill", "interrupt"])
def test_broken_off_at_any_moment(tmp_path, how, place):
    command = [sys.executable, str(BREAK_OFF), str(tmp_path), how, "20", "1", *place]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "20\n"


HALF_WRITTEN = """
import os, sys
sys.path[:0] = [sys.argv[2]]
from sample_library import add_sample
from lanindex.library import store
from lanindex.library.store import Store
store.describe = lambda connection, *_: (
    connection.execute("UPDATE capture SET label = 'half'"),
    connection.execute("PRAGMA cache_spill = 1"),
    os._exit(9),
)
with Store.open(sys.argv[1]) as library:
    library.session.connection.execute("PRAGMA cache_size = 5")
    add_sample(library, 1, label="half")
"""
"""Ends in the middle of a transaction of which parts are already in the file."""


def half_written(path: Path, tests: Path) -> None:
    command = [sys.executable, "-c", HALF_WRITTEN, str(path), str(tests)]
    assert subprocess.run(command).returncode == 9
    assert path.with_name(path.name + "-journal").stat().st_size > 0


@pytest.mark.sqlite
def test_half_a_transaction_is_undone_by_a_mere_look(tmp_path, repository):
    path = tmp_path / "some.db"
    fill(path, 60)
    before = path.read_bytes()
    half_written(path, repository / "tests")
    assert path.read_bytes() != before
    with Store.open(path, readonly=True) as library:
        assert {capture.label for capture in library.captures()} == {""}
        assert_same_score(library.score(60), sample_score(59))
    assert path.read_bytes() == before
    assert check(path) == []


@pytest.mark.sqlite
def test_half_a_transaction_without_the_right_to_undo_it(folder, common_user, repository):
    path = folder / "some.db"
    fill(path, 60)
    half_written(path, repository / "tests")
    folder.chmod(0o555)
    with common_user(), pytest.raises(LibraryError, match="a write was broken off here"):
        Store.open(path, readonly=True)


@contextlib.contextmanager
def pages_left(library, pages):
    driver = library.session.connection
    used = driver.execute("PRAGMA page_count").fetchone()[0]
    driver.execute(f"PRAGMA max_page_count = {used + pages}")
    yield
    driver.execute("PRAGMA max_page_count = 1000000")


@contextlib.contextmanager
def bytes_left(library, pages):
    path = Path(library.place)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (path.stat().st_size + pages * 4096, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.sqlite
@pytest.mark.parametrize("pages", [0, 1, 2])
@pytest.mark.parametrize(
    ("limit", "said"), [(pages_left, "the disk is full"), (bytes_left, "the disk cannot be read")]
)
def test_no_room(tmp_path, pages, limit, said):
    path = tmp_path / "some.db"
    fill(path, 3)
    large = sample_score(7, length=3000)
    with Store.open(path) as library:
        with limit(library, pages):
            with pytest.raises(LibraryError, match=said) as caught:
                library.add("large.bvh", large, format="bvh", sha256="0")
            assert "What was stored before is whole; run again" in caught.value.remedy
            assert caught.value.place == str(path)
        assert len(library.captures()) == 3
        number = library.add("large.bvh", large, format="bvh", sha256="0")
        assert_same_score(library.score(number), large)
    assert check(path) == []


@pytest.fixture
def small_disk(tmp_path):
    """Mount a file system of 256 kB, where that is allowed."""
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=256k", "lanindex", str(tmp_path)],
        capture_output=True,
        text=True,
    )
    if mounted.returncode:
        pytest.skip(f"no right to mount a small disk: {mounted.stderr.strip()}")
    yield tmp_path
    subprocess.run(["umount", str(tmp_path)], check=True)


@pytest.mark.sqlite
def test_a_full_disk(small_disk):
    path = small_disk / "some.db"
    with Store.open(path, create=True) as library:
        with pytest.raises(LibraryError, match="the disk is full"):
            add_endlessly(library)
        stored = len(library.captures())
    assert stored > 5
    assert check(path) == []
    with contextlib.suppress(OSError), open(small_disk / "rest", "wb", buffering=0) as rest:
        while True:
            rest.write(b"0" * 512)
    with pytest.raises(LibraryError, match="the disk is full"):
        Store.open(small_disk / "other.db", create=True)


def add_endlessly(library):
    for number in range(10_000):
        add_sample(library, number)


TOGETHER = """
import sys
sys.path[:0] = [sys.argv[2]]
from sample_library import add_sample
from lanindex.library.store import Store
print("ready", flush=True)
sys.stdin.readline()
with Store.open(sys.argv[1], create=True) as library:
    for number in range(int(sys.argv[3]), int(sys.argv[4])):
        add_sample(library, number)
"""


@pytest.mark.parametrize("ranges", [((0, 40), (40, 80)), ((0, 40), (0, 40))])
def test_two_at_once(tmp_path, repository, ranges):
    path = tmp_path / "some.db"
    command = [sys.executable, "-c", TOGETHER, name_of(path), str(repository / "tests")]
    processes = [
        subprocess.Popen(
            [*command, *map(str, one)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
        )
        for one in ranges
    ]
    for process in processes:
        assert process.stdout.readline() == "ready\n"
    for process in processes:
        process.stdin.write("go\n")
        process.stdin.flush()
    for process in processes:
        process.communicate()
        assert process.returncode == 0
    with Store.open(path) as library:
        numbers = sorted(int(Path(capture.path).stem) for capture in library.captures())
        assert numbers == sorted({number for one in ranges for number in range(*one)})
        for capture, tracks in library.tracks():
            wanted = sample_score(int(Path(capture.path).stem)).tracks
            assert tracks["head"].symbols.tolist() == wanted["head"].symbols.tolist()
    assert check(path) == []
    assert os.listdir(tmp_path) in ([], ["some.db"])  # it is in a server, or one file
