"""What the page shows of captures: the list with its facets, labels, poses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from operator import itemgetter
from threading import Lock
from typing import TYPE_CHECKING, Any

from lanindex import records
from lanindex.errors import UsageError
from lanindex.web.routes import Call

if TYPE_CHECKING:
    from lanindex.pipeline.library import Library

_FACET = 50  # values of a facet, the most frequent first
_PAGE = 200  # captures in an answer, at most
_SORTS: dict[str, Callable[[Mapping[str, Any]], Any]] = {
    "added": itemgetter("capture_id"),
    "path": lambda one: one["capture"].lower(),
    "label": lambda one: (not one["label"], one["label"].lower(), one["capture"].lower()),
    "length": itemgetter("seconds"),
    "doubts": lambda one: len(one["warnings"]),
}


class CaptureTable:
    """The records of all captures of a library, kept until it changes."""

    def __init__(self, library: Library) -> None:
        self._library, self._lock = library, Lock()
        self._stamp: int | None = None
        self._records: list[dict[str, Any]] = []
        self._texts: list[str] = []

    def records(self) -> tuple[list[dict[str, Any]], list[str]]:
        """Return the record of each capture, and what a filter looks at in it."""
        with self._lock:
            stamp = self._library.stamp
            if stamp != self._stamp:
                self._records = [records.of_capture(it) for it in self._library.captures()]
                self._texts = [
                    "\n".join([it["capture"], it["label"], *it["metadata"].values()]).lower()
                    for it in self._records
                ]
                self._stamp = stamp
            return self._records, self._texts

    def columns(self) -> list[str]:
        """Return the columns that captures can be told apart by: the label, and the user's."""
        own = Counter(name for one in self.records()[0] for name in one["metadata"])
        return ["label", "format", *(name for name, _ in own.most_common())]


def value_of(record: Mapping[str, Any], column: str) -> str:
    """Return what a capture's record has in a column."""
    own = record["metadata"].get(column, "")
    return str(record[column] if column in ("label", "format") else own)


def facet(chosen: Iterable[Mapping[str, Any]], column: str) -> list[list[Any]]:
    """Return how many of some captures have each value of a column, the most frequent first."""
    counts = Counter(value_of(one, column) for one in chosen)
    return [[value, count] for value, count in counts.most_common(_FACET)]


def listing(call: Call) -> dict[str, Any]:
    """Return a page of the captures that fit a filter and facets, and the facets of them."""
    every, texts = call.site.table.records()
    words = call.text("q").lower().split()
    columns = call.site.table.columns()
    wanted = {name: {*call.query[name]} for name in columns if name in call.query}
    chosen = [
        one
        for one, text in zip(every, texts, strict=True)
        if all(word in text for word in words)
        and all(value_of(one, name) in values for name, values in wanted.items())
    ]
    name = call.text("sort", "added")
    down = name.startswith("-")
    if name.lstrip("-") not in _SORTS:
        raise UsageError(f'"{name[:20]}"', place="sort", wanted=f"one of {', '.join(_SORTS)}")
    chosen.sort(key=_SORTS[name.lstrip("-")], reverse=down)
    at, most = int(call.number("at", 0)), int(call.number("n", 60, 1, _PAGE))
    return {
        "captures": chosen[at : at + most],
        "total": len(chosen),
        "all": len(every),
        "seconds": round(sum(one["seconds"] for one in chosen), 3),
        "doubtful": sum(bool(one["warnings"]) for one in chosen),
        "facets": {name: facet(chosen, name) for name in columns[:6]},
    }


def one(call: Call) -> dict[str, Any]:
    """Return a capture with the parts that it has symbols of."""
    capture = call.site.library.capture(call.path["number"])
    _, tracks = next(call.site.library.tracks([capture.id]))
    counts = {part: len(track) for part, track in tracks.items() if len(track)}
    return {**records.of_capture(capture), "parts": counts}


def change(call: Call) -> dict[str, Any]:
    """Change the label or other columns of a capture."""
    label, columns = call.said("label", str), call.said("metadata", dict)
    if columns is not None and not all(isinstance(it, str) for it in columns.values()):
        raise UsageError("a column that is no text", place="metadata", wanted="texts")
    call.site.library.label(call.path["number"], label, columns)
    return one(call)


def remove(call: Call) -> dict[str, Any]:
    """Take captures out of the library; their files stay."""
    numbers = call.said("captures", list, [])
    if not numbers or not all(isinstance(it, int) for it in numbers):
        raise UsageError(f"{numbers!r:.40}", place="captures", wanted="their numbers")
    call.site.library.remove(*numbers)
    return {"removed": numbers}
