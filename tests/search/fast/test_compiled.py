"""When the compiled loops are taken, and what is done without them."""

import builtins

from lanindex.search.fast import compiled


def test_they_are_loaded_once_much_was_done_without_them(monkeypatch):
    assert compiled.chosen(compiled.WORTH) is not None
    assert compiled.chosen(0) is compiled.compiled()
    monkeypatch.delitem(compiled.sys.modules, compiled._FAST)
    monkeypatch.setattr(compiled, "_gone", 0)
    assert compiled.chosen(compiled.WORTH - 1) is None
    assert compiled.chosen(1) is compiled.compiled()


def test_without_numba_there_are_none(monkeypatch):
    plain = builtins.__import__

    def refusing(name, *rest, **more):
        if name == "numba" or name.startswith("numba."):
            raise ImportError(name)
        return plain(name, *rest, **more)

    compiled.compiled.cache_clear()
    monkeypatch.delitem(compiled.sys.modules, compiled._FAST, raising=False)
    monkeypatch.delattr("lanindex.search.fast.joins_fast", raising=False)
    monkeypatch.setattr(builtins, "__import__", refusing)
    assert compiled.chosen(compiled.WORTH) is None
    compiled.compiled.cache_clear()
