"""What a library holds as a whole: captures that are alike, what recurs, how movement is spread."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from lanindex import records
from lanindex.alphabet import TRACKS
from lanindex.draw.staff import has_column
from lanindex.errors import UsageError
from lanindex.library.connect import Progress
from lanindex.library.selection import Selection
from lanindex.pipeline import example, motifs
from lanindex.pipeline.jobs import Job
from lanindex.pipeline.library import Library
from lanindex.pipeline.movement import COUNTABLE_PARTS, Moves
from lanindex.web.jobs import trouble
from lanindex.web.routes import Call
from lanindex.web.watch import unnamed

_PATIENCE = 300.0  # seconds that it may take
_MOTIFS = 60  # that are shown, each with its staff
_GROUPS = 60  # that are shown
_MEMBERS = 12  # captures of a group that are shown
_VALUES = 24  # groups of captures that are counted apart
_HEIGHT = 2.0  # of a motif's staff, as tall as so many seconds usually are
_LEAST = 0.5  # seconds that are shown of a motif, at least


class Exploration(Job[dict[str, Any]]):
    """Work on all captures that goes on in a thread."""

    noun = "captures"

    def __init__(self, work: Callable[[Progress], dict[str, Any]]) -> None:
        super().__init__()
        self._all = work
        self._begin()

    def _work(self) -> dict[str, Any]:
        return self._all(self._tell)

    def told(self) -> dict[str, Any]:
        """Return how far it is; at the end what it has found."""
        state = self.state
        told: dict[str, Any] = {"state": state, "progress": self.progress}
        if self.error is not None:
            told["error"] = trouble(self.error)
        return told | ({"found": self.result} if state == "done" else {})


def begin(call: Call) -> dict[str, Any]:
    """Begin to look at the captures that fit, in one of the ways; the same again is one job."""
    what = call.said("what", str, "")
    if what not in _WAYS:
        raise UsageError(f'"{what[:40]}"', place="what", wanted=f"one of {', '.join(_WAYS)}")
    library = call.site.library
    parts = call.said("parts", list, [])
    if unknown := [it for it in parts if it not in TRACKS]:
        raise UsageError(f"{unknown[0]!r:.40}", place="parts", wanted="names of parts")
    path = call.said("path", str, "")
    selection = Selection(f"*{path}*" if path else None, call.conditions())
    key = what, library.stamp, json.dumps(call.body, sort_keys=True)

    def work(progress: Progress) -> dict[str, Any]:
        return _WAYS[what](library, selection, parts, call, progress)

    return {"job": call.site.jobs.begin(key, lambda: Exploration(work))}


def _motifs(
    library: Library, selection: Selection, parts: list[str], call: Call, progress: Progress
) -> dict[str, Any]:
    """Return the sequences of symbols that recur, each as a pattern and on a staff."""
    result = library.motifs(
        selection, parts=parts or None, sample=motifs.SAMPLE, timeout=_PATIENCE, progress=progress
    )
    shown = result.found[:_MOTIFS]
    rows = []
    for at, motif in enumerate(shown):
        progress("motifs that are drawn", at, len(shown))
        first = motif.first
        own, span = first.capture, first.span
        start, stop = records.seconds(own, span.start), records.seconds(own, span.stop)
        stop = min(max(stop, start + _LEAST), records.seconds(own, own.frames))
        drawn = ""
        if has_column(motif.part):
            scale = min(_HEIGHT / (stop - start), 3.0)
            how: dict[str, Any] = {"parts": [motif.part], "scale": scale, "near": True}
            drawn = unnamed(library.staff(own.id, start, stop, **how))
        rows.append(
            {
                "pattern": motif.pattern,
                "part": motif.part,
                "hits": motif.hits,
                "captures": motif.captures,
                "first": {**records.of_name(own), **records.of_span(own, span.start, span.stop)},
                "svg": drawn,
            }
        )
    counts = {"captures": result.captures, "of": result.of, "all": len(result.found)}
    return {"motifs": rows, **counts, "notes": result.notes}


def _similar(
    library: Library, selection: Selection, parts: list[str], call: Call, progress: Progress
) -> dict[str, Any]:
    """Return the groups of captures that are alike, the largest first."""
    result = library.similar(selection, sample=example.SAMPLE, timeout=_PATIENCE, progress=progress)
    several = [it for it in result.groups if len(it.captures) > 1]
    groups = [
        {
            "count": len(group.captures),
            "likeness": round(group.likeness, 3),
            "captures": [records.of_capture(it) for it in group.captures[:_MEMBERS]],
        }
        for group in several[:_GROUPS]
    ]
    counts = {"captures": result.captures, "of": result.of, "all": len(several)}
    return {"groups": groups, **counts, "alone": len(result.groups) - len(several)}


def _movement(
    library: Library, selection: Selection, parts: list[str], call: Call, progress: Progress
) -> dict[str, Any]:
    """Return where parts go, how often and when, by group, and in what two groups differ."""
    by, compared = call.said("by", str, ""), call.said("compared", list, [])
    if compared and (len(compared) != 2 or not all(isinstance(it, str) for it in compared)):
        raise UsageError(f"{compared!r:.60}", place="compared", wanted="two groups")
    pair = (compared[0], compared[1]) if compared else None
    found = library.movement(
        selection, by=by, compared=pair, parts=[it for it in parts if it in COUNTABLE_PARTS]
    )
    if len(found.groups) > _VALUES:
        raise UsageError(
            f"{len(found.groups)} groups",
            place=by,
            wanted=f"{_VALUES} at most",
            remedy="Choose two of them, or fewer captures.",
        )
    groups = [*found.groups]
    two = (groups[0], groups[1]) if len(groups) == 2 else None
    return {
        "groups": found.groups,
        "moves": [_moves(it, by) for it in found.moves],
        "differences": [it.record(by, two) for it in found.differences if two and it.matters],
        "compared": len(found.differences),
    }


def _moves(moves: Moves, by: str) -> dict[str, Any]:
    record = moves.record(by)
    return record | {"transitions": record["transitions"][:12]}


_WAYS: dict[str, Callable[[Library, Selection, list[str], Call, Progress], dict[str, Any]]] = {
    "statistics": _movement,
    "motifs": _motifs,
    "similar": _similar,
}
