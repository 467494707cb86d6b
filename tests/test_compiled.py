"""`lanindex.compiled` chooses plain or compiled loops by the work of the process."""

import subprocess
import sys
from multiprocessing import get_context
from pathlib import Path

import pytest

from lanindex import compiled
from lanindex.compiled import LOAD, LOOPS, chosen


@pytest.fixture(autouse=True)
def anew(monkeypatch, tmp_path):
    """Let each test begin as a process does after an install: nothing done, nothing cached."""
    pytest.importorskip("numba")
    for name, value in (("_expected", 0), ("_turn", None)):
        monkeypatch.setattr(compiled, name, value)
    for name in ("_done", "_again"):
        monkeypatch.setattr(compiled, name, compiled.Counter())
    monkeypatch.setattr(compiled, "_chosen", set())
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))


def keep(name: str, folder: Path) -> None:
    """Put there what tells that numba keeps loops."""
    module, kernel = LOOPS[name].modules[-1], LOOPS[name].last
    python = "".join(map(str, sys.version_info[:2]))
    place = folder / "somewhere"
    place.mkdir()
    (place / f"{module.split('.')[-1]}.{kernel}-1.py{python}.nbi").write_bytes(b"")


@pytest.mark.parametrize("name", LOOPS)
def test_nothing_is_compiled_before_it_pays(name):
    worth = LOOPS[name].worth
    assert not chosen(name, worth - 1)
    assert chosen(name, 1)
    assert chosen(name, 0)


@pytest.mark.parametrize("name", LOOPS)
def test_what_is_cached_is_loaded_after_little_work(name, tmp_path):
    keep(name, tmp_path)
    assert not chosen(name, LOAD - 1)
    assert chosen(name, 1)


def test_small_files_in_a_loop_count_together(tmp_path):
    keep("encode", tmp_path)
    found = [chosen("encode", LOAD // 10) for _ in range(12)]
    assert found == [False] * 9 + [True] * 3


def test_what_an_ingest_expects_counts_at_once():
    compiled.expect(LOOPS["numbers"].worth)
    assert chosen("numbers", 1)
    assert not chosen("encode", 1)


def test_one_process_of_several_compiles_and_the_others_find_it(tmp_path, monkeypatch):
    lock = get_context("spawn").Lock()
    compiled.take_turns(lock)
    assert chosen("encode", LOOPS["encode"].worth)
    monkeypatch.setattr(compiled, "_chosen", set())
    compiled.take_turns(lock)  # as another process
    assert not chosen("encode", 1)
    keep("encode", tmp_path)
    assert not chosen("encode", 1)  # it looks again after some work
    assert chosen("encode", LOAD // 10)


def test_what_numba_keeps_is_found_where_numba_puts_it(tmp_path):
    code = (
        "import numpy as np; from lanindex import compiled\n"
        "from lanindex.encoding.written_fast import looked\n"
        "print(compiled.cached('encode'))\n"
        "row = np.zeros(1, np.int64)\n"
        "looked(np.ones((3, 1, 9)), row, row, row + 8, np.ones(1), 2)\n"
        "print(compiled.cached('encode'))\n"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert found.stdout.split() == ["False", "True"], found.stderr


def test_a_short_ingest_compiles_nothing(tmp_path):
    code = (
        "import sys; from lanindex.app.cli import main\n"
        "words = ['ingest', 'corpus', '-q', '--jobs', '1', '--db']\n"
        f"sys.argv = ['lanindex', *words, {str(tmp_path / 'l.db')!r}]\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "print('numba' in sys.modules)"
    )
    root = Path(__file__).parents[1]
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=root)
    assert found.stdout.split() == ["False"], found.stderr
    assert not list(tmp_path.rglob("*.nbi"))


def test_without_numba_loops_are_plain(monkeypatch):
    def refuse(name):
        raise ImportError(name)

    monkeypatch.setattr(compiled, "import_module", refuse)
    compiled.imported.cache_clear()
    assert not chosen("encode", LOOPS["encode"].worth)
    compiled.imported.cache_clear()


def test_the_command_leaves_scipy_out():
    said = "from lanindex import compiled; compiled.without_scipy(); import sys, numba.np.arraymath"
    said += "; print('scipy.linalg' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", said], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
