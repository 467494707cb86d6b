"""Searches: what a text means, hits as they come, their pictures, and what would be found."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from lanindex import records
from lanindex.alphabet import plain
from lanindex.draw import svg
from lanindex.draw.staff import has_column
from lanindex.errors import LanindexError, UsageError
from lanindex.film.hits import HEIGHT, fitted, playback, poses, seen_from
from lanindex.library.selection import Selection
from lanindex.model import Hit
from lanindex.model.capture import in_words
from lanindex.pipeline.jobs import Job, SearchJob
from lanindex.pipeline.library import Library
from lanindex.pipeline.search import query_of
from lanindex.search.hits import Counts, Hits, counted
from lanindex.search.language.clauses import CLIP, Reference
from lanindex.search.language.written import pattern_text
from lanindex.web.jobs import Told, trouble
from lanindex.web.routes import Call
from lanindex.web.watch import unnamed

_MEMORY = 256.0  # MB that the partial matches of a search may take: several run at once
_TOLD = 5  # times a second in which it is told that it goes on
_PAGE = 100  # hits in an answer, at most
_LIKE = re.compile(r"\d+(:\d+-\d+)?")
_ALIKE = 200  # captures that are like an example, at most
_SECONDS = 30.0  # that a search by example may take
_LEAST = 1.0  # seconds that are shown of a hit, at least
_STRIP = 2.0  # seconds on a staff of the usual height
_RATE = 12  # frames a second in which its poses are looked for
_FACETS = 4  # columns of which hits are counted
_OF_THE_LIST = ("folder", "doubts")  # columns that only the list of captures has
_VALUES = 30  # values of a column, the most frequent first


def read(call: Call) -> dict[str, Any]:
    """Return what a text means, or what is wrong in it, and what may stand at a position."""
    text = call.said("text", str, "")
    found = call.site.library.parse(text, call.said("position", int, len(text)))
    return found if text.strip() else {**found, "error": None}


def write(call: Call) -> dict[str, Any]:
    """Return the text of a tree."""
    return {"text": pattern_text(call.said("tree", dict, {}))}


@dataclass(frozen=True, slots=True)
class Asked:
    """A search as somebody asks for it."""

    pattern: str
    path: str | None
    where: tuple[tuple[str, str], ...]
    near: bool
    fuzzy: str | None
    overlaps: str

    @classmethod
    def of(cls, call: Call) -> Asked:
        """Return what the body of a request asks for."""
        return cls(
            call.said("pattern", str, ""),
            call.said("path", str),
            tuple(call.conditions()),
            call.body.get("near") is True,
            call.said("fuzzy", str),
            call.said("overlaps", str, "none"),
        )

    @property
    def selection(self) -> Selection:
        """Which captures it concerns."""
        return Selection(self.path, self.where)

    @property
    def options(self) -> dict[str, Any]:
        """How it matches, as the methods of a library take it."""
        return {"near": self.near, "fuzzy": self.fuzzy, "overlaps": self.overlaps}


class Search(Told[SearchJob]):
    """A search by pattern."""

    def __init__(self, asked: Asked, job: SearchJob) -> None:
        super().__init__(job)
        self.asked = asked

    @property
    def found(self) -> int:
        """How many hits it has found so far, and keeps."""
        return self.job.found

    def told(self) -> dict[str, Any]:
        """Return how far it is, and what it has found so far."""
        job, state = self.job, self.job.state
        told: dict[str, Any] = {
            "state": state,
            "progress": job.progress,
            "seconds": round(job.seconds * _TOLD) / _TOLD,
            "found": self.found,
            "captures": job.captures,
            "notes": [*job.notes, *map(str, job.refused[:5])],
            "stamp": job.stamp,
        }
        if state == "done" and isinstance(job.result, Counts):
            told["counts"] = job.result.dicts()
        if job.error is not None:
            told["error"] = trouble(job.error)
        return told

    def page(self, at: int, n: int, order: str) -> list[Hit]:
        """Return some of the hits."""
        return self.job.page(at, n, order)

    def facets(self, column: str) -> Counts:
        """Count the hits by a column of their captures."""
        return self.job.facets(column)


class Example(Job[Hits]):
    """A search by example."""

    noun = "captures"

    def __init__(self, library: Library, clip: str, selection: Selection) -> None:
        super().__init__()
        self._library, self._clip, self._selection = library, clip, selection
        self._notes: tuple[str, ...] = ()
        self._begin()

    def _work(self) -> Hits:
        limits: dict[str, Any] = {"limit": _ALIKE, "timeout": _SECONDS}
        found = self._library.like(self._clip, self._selection, **limits)
        self._notes = found.notes
        return found.hits

    @property
    def _hits(self) -> Sequence[Hit]:
        return self.result if self.state == "done" else ()

    def told(self) -> dict[str, Any]:
        """Return what it has found."""
        hits = self._hits
        return {
            "state": self.state,
            "progress": self.progress,
            "found": len(hits),
            "captures": len({hit.capture.id for hit in hits}),
            "notes": self._notes,
            **({"error": trouble(self.error)} if self.error else {}),
        }

    def page(self, at: int, n: int, order: str) -> Sequence[Hit]:
        """Return some of the hits, the likest first."""
        return self._hits[at : at + n]

    def facets(self, column: str) -> Counts:
        """Count the hits by a column of their captures."""
        hits = [self.result] if self.state == "done" else []
        return counted(hits, "", Reference(CLIP, column.lower()))


def begin(call: Call) -> dict[str, Any]:
    """Begin a search, by pattern or by example; the same search is begun once."""
    library, like = call.site.library, call.said("like", str)
    key: tuple[Any, ...]
    if like is not None:
        if not _LIKE.fullmatch(like):  # a path would be read from the disk
            raise UsageError(f'"{like[:40]}"', place="like", wanted="a capture's number")
        selection = Asked.of(call).selection
        key = "like", like, selection.path, tuple(selection.where), library.stamp

        def by_example() -> Example:
            return Example(library, like, selection)

        return {"job": call.site.jobs.begin(key, by_example)}
    asked = Asked.of(call)
    query_of(asked.pattern, call.site.parts(), library.words)  # raises what is wrong at once

    def by_pattern() -> Search:
        job = library.begin(asked.pattern, asked.selection, memory=_MEMORY, **asked.options)
        return Search(asked, job)

    return {"job": call.site.jobs.begin(("search", asked, library.stamp), by_pattern)}


def _order(call: Call) -> str:
    return call.text("order", "best")


def hits(call: Call) -> dict[str, Any]:
    """Return a page of hits, as they are so far."""
    search = call.site.jobs.get(call.path["job"])
    at, most = int(call.number("at", 0)), int(call.number("n", 24, 1, _PAGE))
    found = search.page(at, most, _order(call))
    return {"hits": [records.of_hit(it) for it in found]}


def facets(call: Call) -> dict[str, Any]:
    """Count the hits by the columns of their captures."""
    search = call.site.jobs.get(call.path["job"])
    columns = [it for it in call.site.table.columns() if it not in _OF_THE_LIST][:_FACETS]
    counts = {name: search.facets(name) for name in columns}
    return {
        name: [[it.value or "", it.count] for it in values[:_VALUES]]
        for name, values in counts.items()
    }


def advice(call: Call) -> dict[str, Any]:
    """Return why a search finds nothing, and what would be found."""
    search = call.site.jobs.get(call.path["job"])
    if not isinstance(search, Search):
        raise UsageError("a search by example", wanted="one by pattern")
    asked = search.asked
    found = call.site.library.suggest(asked.pattern, asked.selection, **asked.options)
    return found.record()


def card(call: Call) -> dict[str, Any]:
    """Return the pictures of a hit: poses of it, and its staff."""
    library, search = call.site.library, call.site.jobs.get(call.path["job"])
    found = search.page(call.path["hit"], 1, _order(call))
    if not found:
        raise UsageError(f"hit {call.path['hit']}", wanted="one that was found")
    hit = found[0]
    parts = list(dict.fromkeys(it.part for it in hit.symbols))
    answer: dict[str, Any] = {"poses": "", "tall": 0, "staff": "", "trouble": ""}
    start, stop, begin, end = _times(hit)
    if columns := [it for it in parts if has_column(it)]:
        stretch = min(max(_STRIP / (end - begin), 0.1), 10.0)
        staff = library.staff(hit, begin, end, parts=columns, stretch=stretch, near=True)
        answer["staff"] = unnamed(staff)
    try:
        body = library.motion(hit.capture.id, begin, end, _RATE)
        played = playback(body, parts, (start - begin, stop - begin), (0.0, end - begin))
        if played:
            eye = seen_from([played])
            answer["poses"] = svg.write(poses(played, eye, hit.path))
            answer["tall"] = HEIGHT / fitted(played, eye)[2]  # mm from its lower edge to its upper
    except LanindexError as error:  # a source that is gone: the staff tells enough
        answer["trouble"] = str(error)
    return {**answer, "parts": parts, "words": plain(", ".join(in_words(hit.symbols)))}


def _times(hit: Hit) -> tuple[float, float, float, float]:
    """Return the seconds of a hit, and those that are shown of its capture."""
    rate = float(hit.capture.rate)
    start, stop, whole = hit.start / rate, hit.stop / rate, hit.capture.frames / rate
    begin = max(min(start - (_LEAST - (stop - start)) / 2, start, whole - _LEAST), 0.0)
    return start, stop, begin, min(max(stop, begin + _LEAST), whole)
