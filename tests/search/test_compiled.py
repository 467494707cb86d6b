"""When the compiled loops are taken, and what is done without them."""

import builtins
import sys

import pytest

from lanindex.search import compiled

pytest.importorskip("numba")


@pytest.fixture
def fresh(monkeypatch):
    """A process that has done nothing yet."""
    monkeypatch.setattr(compiled, "_gone", dict.fromkeys(compiled.LOOPS, 0))
    for module, _ in compiled.LOOPS.values():
        monkeypatch.delitem(sys.modules, module, raising=False)
    compiled.loaded.cache_clear()
    yield
    compiled.loaded.cache_clear()


@pytest.mark.parametrize("name", compiled.LOOPS)
def test_they_are_loaded_once_much_has_been_done_without_them(name, fresh):
    worth = compiled.LOOPS[name].worth
    assert compiled.chosen(name, worth - 1) is None
    found = compiled.chosen(name, 1)
    assert found is compiled.loaded(name) is not None
    assert compiled.chosen(name, 0) is found


def test_without_numba_there_are_none(fresh, monkeypatch):
    plain = builtins.__import__

    def refusing(name, *rest, **more):
        if name == "numba" or name.startswith("numba."):
            raise ImportError(name)
        return plain(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", refusing)
    for name, (_, worth) in compiled.LOOPS.items():
        assert compiled.chosen(name, worth) is None
