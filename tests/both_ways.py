"""The two ways that the loops of a search go, to be put for `lanindex.search.compiled.chosen`."""

from lanindex.search import compiled


def plain(name: str, work: int) -> None:
    """Choose the plain loops."""


def fast(name: str, work: int):
    """Choose the compiled loops."""
    return compiled.loaded(name)
