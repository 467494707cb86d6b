"""The number of processes follows free memory, and what a job took is given back."""

import sys
from pathlib import Path
from time import sleep

import pytest
from bvh_bodies import person

from lanindex import compiled, memory
from lanindex.encoding.profile import load
from lanindex.pipeline import jobs as job_module
from lanindex.pipeline import prepare
from lanindex.pipeline.jobs import Job
from lanindex.pipeline.prepare import Task

GIGABYTE = 1 << 30


def free(monkeypatch: pytest.MonkeyPatch, amount: int | None) -> None:
    monkeypatch.setattr(prepare, "available", lambda: amount)


def test_the_largest_files_count(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = [1000, GIGABYTE, 2000, GIGABYTE]
    one, small = prepare.needed(GIGABYTE), prepare.needed(2000)
    for amount, jobs in ((2 * one, 2), (2 * one - 1, 1), (2 * one + small, 3), (0, 1)):
        free(monkeypatch, amount)
        assert prepare.affordable(sizes, 4) == jobs
    free(monkeypatch, None)  # a system that does not tell
    assert prepare.affordable(sizes, 4) == 4


def test_processes_without_a_file_of_their_own_take_room_too(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    free(monkeypatch, prepare.needed(GIGABYTE) + prepare.needed(0))
    assert prepare.affordable([GIGABYTE], 8) == 2


def test_the_system_tells_what_is_free() -> None:
    found = prepare.available()
    assert found is None or found > 1 << 20


def test_a_task_says_what_its_process_will_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    paths = [tmp_path / f"{number}.bvh" for number in range(3)]
    for path in paths:
        path.write_bytes(person(3))
    seen: list[int] = []
    monkeypatch.setattr(prepare, "prepare", lambda task: seen.append(task.total) or ())
    tasks = [Task(str(path), load("default")) for path in paths]
    list(prepare.prepared([*tasks, Task(str(tmp_path / "gone.bvh"), load("default"))], 1))
    assert seen == [3 * len(person(3))] * 4


@pytest.mark.parametrize("total", [0, 10**9])
def test_many_small_files_are_worth_the_fast_reader(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, total: int
) -> None:
    path = tmp_path / "small.bvh"
    path.write_bytes(person(3))
    monkeypatch.setattr(compiled, "_expected", 0)
    prepare.prepare(Task(str(path), load("default"), total=total))
    assert compiled._expected == total


@pytest.mark.skipif(sys.platform != "linux", reason="only the allocator of Linux keeps it")
def test_what_a_job_took_is_given_back(monkeypatch: pytest.MonkeyPatch) -> None:
    def held() -> int:
        return int(Path("/proc/self/statm").read_text().split()[1]) * 4096

    class Large(Job[list[bytearray]]):
        def _work(self) -> list[bytearray]:
            taken = [bytearray(50_000) for _ in range(4000)]
            return taken[::100]  # among what is given back

    sizes = []

    def give_back() -> None:
        sizes.append(held())
        memory.give_back()
        sizes.append(held())

    monkeypatch.setattr(job_module, "give_back", give_back)
    Large()._begin()
    while len(sizes) < 2:
        sleep(0.01)
    before, after = sizes
    assert before - after > 150_000_000
