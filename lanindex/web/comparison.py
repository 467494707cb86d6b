"""Two captures or scores beside each other on the page: in which symbols they differ."""

from __future__ import annotations

from typing import Any

from lanindex import records
from lanindex.compare import compare
from lanindex.web.routes import Call

_MOST = 1000  # differences that are listed


def _pair(call: Call) -> tuple[int, int]:
    one, other = (int(call.number(name, 0, 1, 1 << 53)) for name in ("a", "b"))
    return one, other


def in_step(call: Call) -> dict[str, list[list[float]]]:
    """Return at which seconds two captures do the same."""
    pair = _pair(call)
    times = call.site.kept(("step", *pair), lambda: call.site.library.in_step(*pair))
    return {"times": times.T.round(4).tolist()}


def compared(call: Call) -> dict[str, Any]:
    """Return the differences of two captures, and the columns in which both are drawn."""
    one, other = _pair(call)
    found: dict[str, Any] = call.site.kept(
        ("compare", one, other), lambda: _compared(call, one, other)
    )
    return found


def _compared(call: Call, one: int, other: int) -> dict[str, Any]:
    library = call.site.library
    captures = [library.capture(it) for it in (one, other)]
    found = compare(*map(library.score, (one, other)))
    usual = {track for number in (one, other) for track in library.staff(number).tracks}
    differences = sorted(
        found.differences,
        key=lambda it: min(timed.start for timed in (it.one, it.other) if timed),
    )
    return {
        "captures": [records.of_capture(it) for it in captures],
        "same": found.same,
        "parts": list(found.parts),
        "columns": [it for it in found.parts if it in usual],
        "only": [list(it) for it in found.only],
        "all": len(differences),
        "differences": [
            {**records.of_difference(it), "change": it.change} for it in differences[:_MOST]
        ],
    }
