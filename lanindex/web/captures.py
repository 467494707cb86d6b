"""What the page shows of captures: the list with its facets; their labels and columns."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import cached_property
from operator import itemgetter
from threading import Lock
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex import __version__, records
from lanindex.alphabet import DIRECTIONS, TRACKS, plain
from lanindex.draw.staff import has_column, usual_tracks
from lanindex.errors import AbsentError, UsageError
from lanindex.library.dialect import Target
from lanindex.model.capture import common_folder
from lanindex.notation import NOTATIONS
from lanindex.web.routes import Call

if TYPE_CHECKING:
    from lanindex.pipeline.library import Library

_FACETS = 8  # columns that are counted: those of all captures, and the user's most frequent
_VALUES = 50  # values of a facet, the most frequent first
_PAGE = 200  # captures in an answer, at most
_FITTING = 20  # captures that are offered for a text

_SORTS: dict[str, Callable[[Mapping[str, Any]], Any]] = {
    "added": itemgetter("capture_id"),
    "path": lambda one: one["capture"].lower(),
    "label": lambda one: (not one["label"], one["label"].lower(), one["capture"].lower()),
    "length": itemgetter("seconds"),
    "doubts": lambda one: len(one["warnings"]),
}
_OWN: dict[str, Callable[[Mapping[str, Any], int], str]] = {
    "label": lambda one, shared: str(one["label"]),
    "folder": lambda one, shared: os.path.dirname(one["capture"][shared:]),
    "format": lambda one, shared: str(one["format"]),
    "doubts": lambda one, shared: "with doubts" if one["warnings"] else "",
}
"""What every capture has, from its record and the length of the folder that all share."""

_TAKEN = (*_OWN, "path", "file")
"""Names that a column of the user's cannot have: what a filter, or a table of labels, says."""


class Listed:
    """The records of all captures, and what they are filtered, counted and sorted by."""

    def __init__(self, every: Sequence[dict[str, Any]]) -> None:
        self.records = every
        self.folder = common_folder(one["capture"] for one in every)
        self.seconds = np.array([one["seconds"] for one in every], float)
        self._orders: dict[str, NDArray[np.int64]] = {}
        self._values: dict[str, tuple[NDArray[np.int64], list[str]]] = {}

    @cached_property
    def columns(self) -> list[str]:
        """The columns that captures can be told apart by: those of all, and the user's."""
        own = Counter(name for one in self.records for name in one["metadata"])
        return list(dict.fromkeys([*_OWN, *(name for name, _ in own.most_common())]))

    @cached_property
    def _texts(self) -> list[str]:
        return [
            "\n".join([it["capture"], it["label"], *it["metadata"].values()]).lower()
            for it in self.records
        ]

    def values(self, column: str) -> tuple[NDArray[np.int64], list[str]]:
        """Return the values of a column, and for each capture the place of its own among them."""
        if column not in self._values:
            shared, own = len(self.folder), _OWN.get(column)
            texts = [
                own(one, shared) if own else one["metadata"].get(column, "") for one in self.records
            ]
            places = {text: place for place, text in enumerate(dict.fromkeys(texts))}
            codes = np.fromiter((places[text] for text in texts), np.int64, len(texts))
            self._values[column] = codes, list(places)
        return self._values[column]

    def order(self, name: str) -> NDArray[np.int64]:
        """Return the places of all captures in an order; a minus before its name turns it."""
        named = name.removeprefix("-")
        if named not in _SORTS:
            raise UsageError(f'"{name[:20]}"', place="sort", wanted=f"one of {', '.join(_SORTS)}")
        if named not in self._orders:
            keys = list(map(_SORTS[named], self.records))
            self._orders[named] = np.array(sorted(range(len(keys)), key=keys.__getitem__), np.int64)
        return self._orders[named][:: -1 if name != named else 1]

    def holding(self, words: Iterable[str]) -> NDArray[np.bool_]:
        """Return which captures hold all of some words in their path, label or columns."""
        found = np.ones(len(self.records), bool)
        for word in words:
            found &= np.fromiter((word in text for text in self._texts), bool, len(found))
        return found

    def having(self, column: str, values: Iterable[str]) -> NDArray[np.bool_]:
        """Return which captures have one of some values in a column."""
        codes, known = self.values(column)
        wanted = set(values)
        return np.isin(codes, [place for place, value in enumerate(known) if value in wanted])


class CaptureTable:
    """The captures of a library as they are listed, kept until it changes."""

    def __init__(self, library: Library) -> None:
        self._library, self._lock = library, Lock()
        self._stamp: int | None = None
        self._listed = Listed([])

    def now(self) -> Listed:
        """Return all captures as they are now."""
        with self._lock:
            stamp = self._library.stamp
            if stamp != self._stamp:
                captures = self._library.captures()
                self._listed = Listed([records.of_capture(it) for it in captures])
                self._stamp = stamp
            return self._listed

    def renew(self, before: int, numbers: Collection[int]) -> None:
        """Read only some captures anew: those that one change since a stamp concerned."""
        with self._lock:
            after = self._library.stamp
            if self._stamp != before or after != before + 1:
                return  # others have changed it, too
            held = self._library.store.captures_numbered(list(numbers))
            again = {it.id: records.of_capture(it) for it in held}
            every = [
                again.get(one["capture_id"], one)
                for one in self._listed.records
                if one["capture_id"] in again or one["capture_id"] not in numbers
            ]
            self._listed, self._stamp = Listed(every), after

    def columns(self) -> list[str]:
        """Return the columns that captures can be told apart by."""
        return self.now().columns


def _filtered(call: Call) -> tuple[Listed, NDArray[np.bool_], dict[str, NDArray[np.bool_]]]:
    """Return all captures, which hold the words of a filter, and which fit each chosen facet."""
    listed = call.site.table.now()
    wanted: dict[str, list[str]] = {}
    for one in call.query.get("where", ()):
        column, _, value = one.partition("=")
        wanted.setdefault(column, []).append(value)
    fits = {column: listed.having(column, values) for column, values in wanted.items()}
    return listed, listed.holding(call.text("q").lower().split()), fits


def _both(found: NDArray[np.bool_], fits: Iterable[NDArray[np.bool_]]) -> NDArray[np.bool_]:
    both: NDArray[np.bool_] = np.logical_and.reduce([found, *fits])
    return both


def listing(call: Call) -> dict[str, Any]:
    """Return a page of the captures that fit a filter and facets, and the facets of them.

    A facet counts what would be found with each of its values: what is chosen of the other facets
    holds, what is chosen of its own does not.
    """
    listed, found, fits = _filtered(call)
    chosen = _both(found, fits.values())
    order = listed.order(call.text("sort", "added"))
    order = order[chosen[order]]
    at, most = int(call.number("at", 0)), int(call.number("n", 60, 0, _PAGE))
    facets = []
    for name in list(dict.fromkeys([*listed.columns[:_FACETS], *fits])):
        codes, values = listed.values(name)
        others = _both(found, (fit for own, fit in fits.items() if own != name))
        counts = np.bincount(codes[others], minlength=len(values))
        places = np.argsort(-counts, kind="stable")[: np.count_nonzero(counts)]
        some = [[values[place], int(counts[place])] for place in places[:_VALUES].tolist()]
        facets.append({"name": name, "values": some, "different": len(places)})
    return {
        "captures": [listed.records[place] for place in order[at : at + most].tolist()],
        "total": len(order),
        "all": len(listed.records),
        "seconds": round(float(listed.seconds[chosen].sum()), 3),
        "folder": listed.folder,
        "facets": facets,
    }


def fitting(call: Call) -> dict[str, Any]:
    """Return the first captures that a text may mean, and the number of the one that it means.

    A whole path comes before the name of a file, that before a part of a path, that before words
    of path, label or columns. ``moving`` leaves out scores, which have no movement.
    """
    listed, text = call.site.table.now(), call.text("q").strip().lower()
    held = listed.holding(text.split())
    if call.text("moving"):
        held &= [it["format"] not in NOTATIONS for it in listed.records]
    some = [listed.records[place] for place in np.flatnonzero(held).tolist()]
    some.sort(key=lambda it: _closeness(it["capture"].lower(), text))
    nearest = [_closeness(it["capture"].lower(), text) for it in some[:2]]
    return {
        "captures": some[:_FITTING],
        "total": len(some),
        "one": some[0]["capture_id"] if text and nearest[:1] != nearest[1:] else None,
    }


def _closeness(path: str, text: str) -> int:
    """Return how far a text is from being a path: it, its end, a part of it, none of it."""
    if path == text:
        return 0
    return 1 if path.endswith(f"/{text}") else 2 if text in path else 3


def numbers(call: Call) -> dict[str, Any]:
    """Return the numbers of all captures that fit a filter and facets."""
    listed, found, fits = _filtered(call)
    places = np.flatnonzero(_both(found, fits.values())).tolist()
    return {"captures": [listed.records[place]["capture_id"] for place in places]}


def one(call: Call) -> dict[str, Any]:
    """Return a capture with the parts that it has symbols of, of those that have a column."""
    capture = call.site.library.capture(call.path["number"])
    every = call.site.library.store.counts(capture.id)
    counts = {part: count for part, count in every.items() if count and has_column(part)}
    return {
        **records.of_capture(capture),
        "moves": capture.format not in NOTATIONS,
        "parts": counts,
        "usual": usual_tracks(counts),
    }


class Change(NamedTuple):
    """What is said of a capture; None: as it is. `held` is what must be said of it before."""

    label: str | None
    columns: dict[str, str]
    held: Change | None = None

    def back(self, before: Mapping[str, Any]) -> dict[str, Any]:
        """Return what undoes it, as long as nobody else has changed the same meanwhile."""
        return {
            "label": None if self.label is None else before["label"],
            "columns": {name: before["metadata"].get(name, "") for name in self.columns},
            "held": {"label": self.label, "columns": self.columns},
        }

    def holds(self, now: Mapping[str, Any]) -> bool:
        """Return whether a capture's record says this."""
        told = {name: now["metadata"].get(name, "") for name in self.columns}
        return self.label in (None, now["label"]) and told == self.columns


def change(call: Call) -> dict[str, Any]:
    """Change labels and other columns of captures, all or none; an empty column goes.

    Returns the changes that undo it.
    """
    listed = {one["capture_id"]: one for one in call.site.table.now().records}
    wanted: dict[int, Change] = {}
    for said in call.said("changes", list, []):
        numbers, one = _captures(said), _change(said)
        for number in numbers:
            if number not in listed:
                raise AbsentError(f"there is no capture {number} any more")
            if one.held is not None and not one.held.holds(listed[number]):
                found = f"{listed[number]['capture']} was changed by somebody else meanwhile"
                raise UsageError(found, remedy="It stays as it is now.")
            wanted[number] = one
    stamp = call.site.library.stamp
    changed = call.site.library.describe(
        (number, one.label, _merged(listed[number]["metadata"], one.columns))
        for number, one in wanted.items()
    )
    if changed:
        call.site.table.renew(stamp, set(changed))
    undo: dict[str, dict[str, Any]] = {}
    for number in changed:
        back = wanted[number].back(listed[number])
        undo.setdefault(repr(back), {**back, "captures": []})["captures"].append(number)
    return {"changed": len(changed), "undo": list(undo.values())}


def _captures(said: Any) -> list[int]:
    numbers = said.get("captures") if isinstance(said, dict) else None
    if not isinstance(numbers, list) or not all(isinstance(it, int) for it in numbers):
        raise UsageError(f"{said!r:.40}", place="changes", wanted="the numbers of captures")
    return numbers


def _change(said: Any) -> Change:
    if isinstance(said, dict):
        label, columns, held = said.get("label"), said.get("columns", {}), said.get("held")
        if (
            (label is None or isinstance(label, str))
            and isinstance(columns, dict)
            and all(isinstance(it, str) for it in columns.values())
        ):
            columns = {name.strip(): it for name, it in columns.items()}
            return Change(label, columns, None if held is None else _change(held))
    raise UsageError(f"{said!r:.40}", place="changes", wanted="captures, a label, columns of text")


def _merged(before: Mapping[str, str], columns: Mapping[str, str]) -> dict[str, str] | None:
    """Return all columns of a capture after some are changed; None: none is."""
    for name in columns:
        if name and name not in before and ("=" in name or name in _TAKEN):
            wanted = f'a name without "=" that is none of {", ".join(_TAKEN)}'
            raise UsageError(f'a column "{name[:40]}"', place="columns", wanted=wanted)
    if "" in columns:
        raise UsageError("a column without a name", place="columns", wanted="a name for it")
    return {name: it for name, it in {**before, **columns}.items() if it} if columns else None


def missing(call: Call) -> dict[str, Any]:
    """Return the numbers of captures whose file is not where it was."""
    return {"captures": [it.id for it in call.site.library.store.missing()]}


def remove(call: Call) -> dict[str, Any]:
    """Take captures out of the library; their files stay."""
    numbers = call.said("captures", list, [])
    if not numbers or not all(isinstance(it, int) for it in numbers):
        raise UsageError(f"{numbers!r:.40}", place="captures", wanted="their numbers")
    stamp = call.site.library.stamp
    call.site.library.remove(*numbers)
    call.site.table.renew(stamp, set(numbers))
    return {"removed": numbers}


def library(call: Call) -> dict[str, Any]:
    """Return what the page needs to know of a library before all else."""
    about: dict[str, Any] = call.site.kept("library", lambda: _about(call))
    return about


def _about(call: Call) -> dict[str, Any]:
    library = call.site.library
    stats = library.stats()
    target = library.store.session.target
    return {
        "name": target.title,
        "file": _file(target, hidden=call.site.readonly),
        "version": __version__,
        "stamp": library.stamp,
        "readonly": call.site.readonly,
        "captures": stats.captures,
        "symbols": stats.symbols,
        "seconds": round(float(stats.seconds), 3),
        "parts": library.store.parts(checked=False),
        "names": {it: plain(it) for it in (*TRACKS, *DIRECTIONS)},
        "columns": call.site.table.columns(),
        "folder": call.site.table.now().folder,
    }


def _file(target: Target, *, hidden: bool) -> str:
    """Return what names a library in a command; `hidden`: without the place where it is."""
    path = target.path
    if hidden:
        return path.name if path else target.title
    return str(path.resolve()) if path else target.place
