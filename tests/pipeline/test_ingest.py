import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
from dances import BOW, RAISE, dance

from lanindex.encoding.profile import load
from lanindex.errors import LibraryError
from lanindex.formats.sniff import UNREAD, unread
from lanindex.model import Reading
from lanindex.pipeline.ingest import SUFFIXES, discover, ingest, left_out, read_labels
from lanindex.pipeline.library import Library, open_library
from lanindex.pipeline.prepare import Outcome, Task, prepared

PROFILE = load("default")


@pytest.fixture
def library(tmp_path: Path):
    with open_library(tmp_path / "l.db", create=True) as opened:
        yield opened


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    dance(tmp_path / "in" / "b" / "raise.bvh")
    dance(tmp_path / "in" / "bow.BVH", BOW)
    (tmp_path / "in" / "score.lnd").write_text(RAISE)
    (tmp_path / "in" / "notes.txt").write_text("not a capture")
    return tmp_path / "in"


def take(library: Library | None, folder: Path, **options) -> list[Outcome]:
    store, profile = library and library.store, options.pop("profile", PROFILE)
    return list(ingest(store, discover([folder]), profile, **options))


def statuses(outcomes: list[Outcome]) -> list[str]:
    return [outcome.status for outcome in outcomes]


def test_folders_are_searched_in_order(folder: Path) -> None:
    (folder / ".hidden.bvh").write_text("")
    names = [os.path.relpath(path, folder) for path in discover([folder, folder / "bow.BVH"])]
    assert names == ["bow.BVH", "score.lnd", os.path.join("b", "raise.bvh")]


def test_what_is_passed_over_is_counted_by_kind(folder: Path) -> None:
    for name in (
        "a.vmd",
        "b.VMD",
        "walk.htr",
        "x.bvh.gz",
        "b/.hidden.vmd",
        ".x.htr",
    ):
        (folder / name).write_text("")
    others: list[str] = []
    assert len(list(discover([folder, folder / "b", folder / ".." / "in"], others))) == 3
    said = "2 .vmd, 1 .gz, 1 .htr (formats that are not read yet); 1 other file"
    assert left_out(others) == said
    os.symlink(folder / "b", folder / "linked")
    os.symlink(folder / "b", folder / ".linked")
    assert len(list(discover([folder], others))) == 3
    assert left_out(others) == said + "; 1 linked folder"
    assert left_out(["a.txt", "b", "v1.2"]) == "3 other files"
    assert left_out(["a/b.vmd"]) == "1 .vmd (formats that are not read yet)"
    assert left_out(["a.mot", "b.sto", "c.mot"]) == "2 .mot, 1 .sto (angles without places)"
    assert left_out([]) == ""


def test_what_is_read_is_not_among_what_is_not() -> None:
    assert SUFFIXES.keys().isdisjoint(UNREAD)
    assert all(unread("a" + suffix) == suffix for suffix in UNREAD)


def test_a_file_of_a_format_that_is_not_read_yet(library: Library, folder: Path) -> None:
    (folder / "a.VMD").write_bytes(b"Vocaloid Motion")
    (folder / "b.csv").write_bytes((folder / "bow.BVH").read_bytes())
    failed, added = take(library, folder / "a.VMD") + take(library, folder / "b.csv")
    assert "its format, VMD, is not read yet, wanted BVH" in str(failed.error)
    assert added.status == "added"


def test_the_same_content_twice_is_noticed(library: Library, folder: Path) -> None:
    again = folder / "b" / "again.bvh"
    again.write_bytes((folder / "bow.BVH").read_bytes())
    outcomes = take(library, folder)
    assert statuses(outcomes) == ["added"] * 4
    (twice,) = (it for it in outcomes if it.warnings)
    assert twice.path.endswith("again.bvh")
    assert twice.warnings == (f"the same content as {folder / 'bow.BVH'}",)
    assert [it.warnings for it in library.captures() if it.warnings] == [twice.warnings]
    assert all(it.status == "unchanged" and not it.warnings for it in take(library, folder))


def test_a_file_named_is_taken_whatever_its_ending(folder: Path) -> None:
    assert list(discover([folder / "notes.txt"])) == [str(folder / "notes.txt")]


@pytest.mark.parametrize("jobs", [1, 2])
def test_all_kinds_go_in(library: Library, folder: Path, jobs: int) -> None:
    outcomes = take(library, folder, jobs=jobs)
    assert statuses(outcomes) == ["added"] * 3
    assert [one.format for one in library.captures()] == ["bvh", "lnd", "bvh"]
    assert sum(outcome.symbols for outcome in outcomes) == library.stats().symbols
    assert statuses(take(library, folder, jobs=jobs)) == ["unchanged"] * 3


def test_another_profile_replaces_and_keeps_the_number(library: Library, folder: Path) -> None:
    take(library, folder)
    before = {capture.path: capture.id for capture in library.captures()}
    assert statuses(take(library, folder, profile=load("paper"))) == ["added", "unchanged", "added"]
    assert {capture.path: capture.id for capture in library.captures()} == before
    assert library.stats().profiles == {"paper": 2, "": 1}


def test_other_reader_options_read_again(library: Library, folder: Path) -> None:
    take(library, folder)
    told = Reading(unit="cm")
    assert statuses(take(library, folder, reading=told)) == ["added", "unchanged", "added"]
    assert statuses(take(library, folder, reading=told)) == ["unchanged"] * 3


def test_changed_content_is_read_again(library: Library, folder: Path) -> None:
    take(library, folder)
    dance(folder / "bow.BVH", RAISE)
    assert statuses(take(library, folder)) == ["added", "unchanged", "unchanged"]


def test_force_reads_all_again(library: Library, folder: Path) -> None:
    take(library, folder)
    assert statuses(take(library, folder, force=True)) == ["added"] * 3


def test_same_content_elsewhere_is_another_capture(library: Library, folder: Path) -> None:
    (folder / "copy.bvh").write_bytes((folder / "bow.BVH").read_bytes())
    take(library, folder)
    assert len(library.captures()) == 4


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_bad_file_does_not_stop_the_others(library: Library, folder: Path, jobs: int) -> None:
    (folder / "a.bvh").write_text("HIERARCHY\nROOT Hips\n{\n")
    (folder / "c.lnd").write_text("#unit1\ndirection r_arm rigth mid 0 1\n")
    os.symlink(folder / "nowhere", folder / "d.bvh")
    outcomes = take(library, folder, jobs=jobs)
    failed = {Path(one.path).name: one.error for one in outcomes if one.status == "failed"}
    assert set(failed) == {"a.bvh", "c.lnd", "d.bvh"}
    assert "a.bvh:" in str(failed["a.bvh"])
    assert "c.lnd:2" in str(failed["c.lnd"])
    assert "d.bvh: a link that leads nowhere" in str(failed["d.bvh"])
    assert len(library.captures()) == 3


@pytest.mark.parametrize("copies", [1, pytest.param(12, marks=pytest.mark.slow)])
def test_a_script_without_a_guard_is_told(tmp_path: Path, folder: Path, copies: int) -> None:
    for copy in range(copies):
        (folder / f"{copy}.lnd").write_text(RAISE)
    script = tmp_path / "script.py"
    script.write_text(
        "import sys\n"
        "from lanindex.errors import CaptureError\n"
        "from lanindex.pipeline.library import open_library\n"
        'with open_library(":memory:", create=True) as library:\n'
        "    try: library.ingest(sys.argv[1], jobs=2)\n"
        "    except CaptureError as error: print(error)\n"
    )
    done = subprocess.run(
        [sys.executable, script, folder], capture_output=True, text=True, check=True, timeout=120
    )
    assert "0.lnd: a process that read this or a later file could not start" in done.stdout
    assert 'begin it under if __name__ == "__main__".' in done.stdout


def test_dry_run_stores_nothing(library: Library, folder: Path) -> None:
    assert statuses(take(library, folder, dry_run=True)) == ["added"] * 3
    assert library.captures() == []
    assert statuses(take(None, folder, dry_run=True)) == ["added"] * 3


def test_labels_change_without_reading_again(library: Library, folder: Path) -> None:
    take(library, folder)
    path = str(folder / "bow.BVH")
    outcomes = take(library, folder, labels={path: ("bow", {"style": "slow"})})
    assert statuses(outcomes) == ["unchanged"] * 3
    capture = library.capture(path)
    assert (capture.label, capture.metadata) == ("bow", {"style": "slow"})
    dance(folder / "bow.BVH", RAISE)
    take(library, folder)
    assert library.capture(path).label == "bow"


@pytest.mark.parametrize("force", [True, False])
def test_what_a_table_does_not_tell_is_kept(library: Library, folder: Path, force: bool) -> None:
    path = str(folder / "bow.BVH")
    tables = [
        {path: ("bow", {"style": "slow"})},
        {path: (None, {"dataset": "d1"})},
        {path: ("deep bow", {})},
        {path: (None, {})},
        {},
    ]
    outcomes = [take(library, folder, labels=table, force=force)[0] for table in tables]
    capture = library.capture(path)
    assert capture.label == "deep bow"
    assert capture.metadata == {"style": "slow", "dataset": "d1"}
    changed = [not force] * 2
    assert [one.labelled for one in outcomes] == [False, *changed, False, False]


def test_lists_of_paths_are_taken_as_they_come(library: Library, folder: Path) -> None:
    paths = [folder / "bow.BVH", str(folder / "score.lnd")]
    assert statuses(library.ingest(paths)) == ["added"] * 2
    found = library.ingest(str(folder / "b"), folder.glob("*.*"))
    assert sorted(statuses(found)) == ["added", "failed", "unchanged", "unchanged"]


def test_outcomes_carry_no_score(library: Library, folder: Path) -> None:
    assert all(outcome.score is None for outcome in take(library, folder))


@pytest.mark.parametrize("jobs", [1, 2])
@pytest.mark.parametrize("force", [False, True])
def test_a_file_that_moved_stays_what_it_was(
    library: Library, folder: Path, jobs: int, force: bool
) -> None:
    take(library, folder)
    library.label("bow.BVH", "bow", {"who": "x"})
    before = library.capture("bow.BVH")
    (folder / "bow.BVH").rename(folder / "b" / "moved.bvh")
    looked = take(library, folder, dry_run=True)
    assert [one.moved for one in looked] == ["", before.location, ""]
    assert library.capture(before.id) == before
    outcomes = take(library, folder, jobs=jobs, force=force)
    assert statuses(outcomes) == (["added"] if force else ["unchanged"]) * 3
    (moved,) = (one for one in outcomes if one.moved)
    assert (moved.moved, moved.path, moved.was_stored) == (
        *(before.location, str(folder / "b" / "moved.bvh"), True),
    )
    after = library.capture(moved.path)
    assert (after.id, after.label, after.metadata) == (before.id, "bow", {"who": "x"})
    assert len(library.captures()) == 3


def test_a_copy_is_a_capture_of_its_own(library: Library, folder: Path) -> None:
    take(library, folder)
    shutil.copy(folder / "bow.BVH", folder / "copy.bvh")
    outcomes = take(library, folder)
    assert sorted(statuses(outcomes)) == ["added", "unchanged", "unchanged", "unchanged"]
    assert len(library.captures()) == 4


def test_of_several_that_are_gone_the_first_has_moved(library: Library, folder: Path) -> None:
    shutil.copy(folder / "bow.BVH", folder / "copy.bvh")
    first = [one for one in take(library, folder) if one.path.endswith(("BVH", "copy.bvh"))]
    ids = [library.capture(one.path).id for one in first]
    for one in first:
        os.remove(one.path)
    dance(folder / "b" / "one.bvh", BOW)
    take(library, folder)
    assert library.capture("one.bvh").id == min(ids)
    dance(folder / "b" / "three.bvh", BOW)
    dance(folder / "b" / "two.bvh", BOW)
    assert [bool(one.moved) for one in take(library, folder)].count(True) == 1
    assert library.capture("three.bvh").id == max(ids)
    assert library.capture("two.bvh").id > max(ids)


def test_another_profile_does_not_follow_a_file_that_moved(library: Library, folder: Path) -> None:
    take(library, folder)
    (folder / "bow.BVH").rename(folder / "moved.bvh")
    outcomes = take(library, folder, profile=load("paper"))
    assert statuses(outcomes) == ["added", "unchanged", "added"]
    assert not any(one.moved for one in outcomes)
    assert len(library.captures()) == 4


def test_words_of_a_file_that_moved_follow_the_table(library: Library, folder: Path) -> None:
    take(library, folder)
    library.label("bow.BVH", "bow", {"who": "x"})
    (folder / "bow.BVH").rename(folder / "moved.bvh")
    (folder / "labels.csv").write_text("file,label,take\nmoved.bvh,deep bow,2\n")
    take(library, folder, labels=read_labels(folder / "labels.csv"))
    moved = library.capture("moved.bvh")
    assert (moved.label, moved.metadata) == ("deep bow", {"who": "x", "take": "2"})


def test_doubts_are_stored(library: Library, folder: Path) -> None:
    text = (folder / "bow.BVH").read_text()
    (folder / "bow.BVH").write_text(re.sub(r"Frames: \d", "Frames: 9", text, count=1))
    doubtful = {one.path: one.warnings for one in take(library, folder) if one.warnings}
    assert list(doubtful) == [str(folder / "bow.BVH")]
    assert {one.path: one.warnings for one in library.captures() if one.warnings} == doubtful


class Sleeper:
    """What takes for ever to arrive in another process."""

    def __reduce__(self):
        return time.sleep, (10**6,)


def test_who_breaks_off_does_not_wait_for_what_is_half_done(folder: Path) -> None:
    tasks = [Task(str(folder / "none.bvh"), PROFILE), *[Task("", Sleeper()) for _ in range(9)]]
    outcomes = prepared(tasks, 2)
    assert next(outcomes).status == "failed"
    outcomes.close()


def test_a_library_that_may_not_be_written_takes_what_it_has_and_nothing_else(
    folder: Path, tmp_path: Path
) -> None:
    path, new = tmp_path / "l.db", dance(tmp_path / "new.bvh")
    with open_library(path, create=True) as library:
        library.ingest(folder)
    for cluster in (None, "local"):
        with open_library(path, readonly=True, cluster=cluster) as library:
            for what, how in (([new], {}), ([folder, new], {}), ([folder], {"force": True})):
                with pytest.raises(LibraryError, match="may not be written"):
                    library.ingest(*what, **how)
            assert "spread" not in vars(library)  # no cluster was begun
            if cluster is None:
                assert statuses(library.ingest(folder)) == ["unchanged"] * 3
