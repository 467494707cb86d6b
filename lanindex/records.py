"""Captures, symbols and hits as JSON: the one contract with other programs.

They are made here for every verb's ``--json`` and every ``dicts()``, so that the same thing has the
same key everywhere. Frames are of the source file, half-open; times are in seconds, to the
microsecond.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from lanindex.alphabet import MEASURES

if TYPE_CHECKING:
    from lanindex.compare import Difference, Timed
    from lanindex.errors import LanindexError
    from lanindex.model import Capture, Hit, Symbol

HIT = (
    *("capture", "capture_id", "label", "fps", "start_frame", "end_frame", "start", "end"),
    *("fit", "symbols", "labels", "pattern"),
)
"""The keys of a hit, in order."""

_MORE = ("passing", "swings", "margin", *MEASURES)


def seconds(capture: Capture, frame: int) -> float:
    """Return the time of a frame, in seconds."""
    rate = capture.rate
    return round(int(frame) * rate.denominator / rate.numerator, 6)


def rate_of(capture: Capture) -> float:
    """Return the rate of a capture, frames a second, to the millionth."""
    return round(capture.rate.numerator / capture.rate.denominator, 6)


def of_name(capture: Capture) -> dict[str, Any]:
    """Return the two keys that name a capture."""
    return {"capture": capture.path, "capture_id": capture.id}


def of_span(capture: Capture, start: int, stop: int) -> dict[str, Any]:
    """Return the four keys of a range of frames."""
    times = {"start": seconds(capture, start), "end": seconds(capture, stop)}
    return {"start_frame": start, "end_frame": stop, **times}


def _fields(symbol: Symbol, names: tuple[str, ...]) -> dict[str, Any]:
    return {name: getattr(symbol, name) for name in names}


def of_symbol(symbol: Symbol) -> dict[str, Any]:
    """Return the five keys of a symbol, and its amount if it has one.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex import records
    >>> score = lanindex.read_lnd("corpus/compass.lnd")
    >>> records.of_symbol(score.symbols("r_arm")[0])
    {'part': 'r_arm', 'direction': 'place', 'level': 'low', 'start_frame': 0, 'end_frame': 0}
    """
    amount = {} if symbol.amount is None else {"amount": symbol.amount}
    span = {"start_frame": symbol.start, "end_frame": symbol.stop}
    return {**_fields(symbol, ("part", "direction", "level")), **span, **amount}


def _border_words(symbol: Symbol) -> str | None:
    """Return the words across the nearest border; of travel, which has no level, the direction."""
    words = (symbol.runner_direction, symbol.runner_level)
    return " ".join(word for word in words if word) or None


def of_row(capture: Capture, symbol: Symbol) -> dict[str, Any]:
    """Return a symbol with all its measures: a line of ``show``."""
    return {
        **of_name(capture),
        "fps": rate_of(capture),
        "frames": capture.frames,
        **of_symbol(symbol),
        "amount": symbol.amount,
        **of_span(capture, symbol.start, symbol.stop),
        **_fields(symbol, _MORE),
        "margin": round(symbol.margin, 3),
        "runner_up": _border_words(symbol),
    }


def of_label(capture: Capture, symbols: Sequence[Symbol]) -> dict[str, Any]:
    """Return the symbols of a label as one: the times of all, the rest of the last one."""
    last = symbols[-1]
    start, stop = min(it.start for it in symbols), max(it.stop for it in symbols)
    return {
        **of_symbol(last),
        **of_span(capture, start, stop),
        "swings": last.swings,
        "margin": round(last.margin, 3),
        **_fields(last, MEASURES),
    }


def of_matched(symbol: Symbol) -> dict[str, Any]:
    """Return a symbol with its margin, as a line of ``search --why`` has it."""
    margin = round(symbol.margin, 3)
    return {**of_symbol(symbol), "margin": margin, "runner_up": _border_words(symbol)}


def of_difference(difference: Difference) -> dict[str, Any]:
    """Return a difference of two scores: a line of ``diff``.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex import records
    >>> from lanindex.compare import compare
    >>> three, four = (lanindex.read_lnd(f"corpus/conductor_{it}.lnd") for it in ("three", "four"))
    >>> found = records.of_difference(compare(three, four).differences[0])
    >>> found["part"], found["difference"], found["longer"]
    ('r_arm', 'moved', 0.119048)
    """

    def timed(it: Timed | None) -> dict[str, Any] | None:
        if it is None:
            return None
        return {**of_symbol(it.symbol), "start": round(it.start, 6), "end": round(it.stop, 6)}

    return {
        "part": difference.part,
        "difference": difference.kind,
        "one": timed(difference.one),
        "other": timed(difference.other),
        "later": round(difference.later, 6),
        "longer": round(difference.longer, 6),
    }


def of_error(error: LanindexError) -> dict[str, Any]:
    """Return an error; of a pattern with the characters that it is about, and what was meant.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex import records
    >>> try:
    ...     lanindex.pattern_tree("r_arm hgih")
    ... except lanindex.LanindexError as error:
    ...     found = records.of_error(error)
    >>> found["start"], found["stop"], found["instead"]
    (6, 10, 'r_arm high')
    """
    said = {name: getattr(error, name) for name in ("found", "place", "wanted", "remedy")}
    return said | {it: getattr(error, it, None) for it in ("text", "start", "stop", "instead")}


def of_capture(capture: Capture) -> dict[str, Any]:
    """Return a capture: a line of ``list`` or ``remove``."""
    return {
        **of_name(capture),
        "label": capture.label,
        "format": capture.format,
        "fps": rate_of(capture),
        "frames": capture.frames,
        "seconds": seconds(capture, capture.frames),
        "sha256": capture.sha256,
        "metadata": dict(capture.metadata),
        "warnings": list(capture.warnings),
    }


def of_hit(hit: Hit, pattern: str | None = None) -> dict[str, Any]:
    """Return a hit: a line of ``search``."""
    capture = hit.capture
    return {
        **of_name(capture),
        "label": capture.label,
        "fps": rate_of(capture),
        **of_span(capture, hit.start, hit.stop),
        "fit": round(hit.fit, 3),
        "symbols": [of_symbol(symbol) for line in hit.lines for symbol in line],
        "labels": {
            name: of_label(capture, symbols) for name, symbols in hit.labels.items() if symbols
        },
        **({} if pattern is None else {"pattern": pattern}),
    }
