"""What a hit answers when a field is asked for: ``a.start``, ``match.length``, ``clip.label``."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from operator import attrgetter

from lanindex.alphabet import KINDS, LEVEL_CODES, MEASURES, kind_of
from lanindex.model import Capture, Hit, Span, Symbol
from lanindex.model.bends import degree_of
from lanindex.model.measures import GRADES
from lanindex.search.language.clauses import CLIP, MATCH, Reference, references_in
from lanindex.search.language.query import Query, steps_of
from lanindex.search.language.words import AMOUNTS

Value = str | Fraction | None
"""A text, a number (times in seconds), or nothing."""

_CLIP: dict[str, Callable[[Capture], str | Fraction]] = {
    **{name: attrgetter(name) for name in ("path", "label", "format", "sha256")},
    "fps": lambda capture: capture.rate,
    "frames": lambda capture: Fraction(capture.frames),
    "seconds": lambda capture: capture.frames / capture.rate,
    "tempo": lambda capture: capture.meter.speed,
}

CLIP_FIELDS = tuple(_CLIP)
"""What every capture can be asked for; its other columns have the names that the user gave."""

_TIMES = ("start", "end", "length")


def value_of(reference: Reference, hit: Hit) -> Value:
    """Return what a field of a hit is: of a label, of all that matched, or of the capture.

    Times are seconds from the clip's first frame; None stands for what is missing. Of several
    symbols: where the first begins, where the last ends, and what the last one is; of all that
    matched, the frames of the hit and what its first line ends with.
    """
    if told_by_span(reference):
        return value_of_span(reference, hit.capture, hit.span)
    symbols = hit.lines[0] if reference.name == MATCH else hit.labels.get(reference.name, ())
    if not symbols:
        return None
    if reference.field not in _TIMES:
        return _told(symbols[-1], reference.field)
    span = Span(min(it.start for it in symbols), max(it.stop for it in symbols))
    return value_of_span(Reference(MATCH, reference.field), hit.capture, span)


def measures_in(query: Query) -> frozenset[str]:
    """Return the measures of symbols that a search reads: words and conditions speak of them."""
    kinds = {word.kind for step in steps_of(query.pattern) for word in step.words}
    said = {name for kind, name in GRADES.items() if kind in kinds}
    asked = {it.field for it in references_in(query.where) if it.name != CLIP}
    return frozenset(said | asked.intersection(MEASURES))


def extras_in(query: Query) -> frozenset[str]:
    """Return the columns that a search reads besides those that every search does."""
    swings = {it.field for it in references_in(query.where) if it.field == "swings"}
    return measures_in(query) | swings


def told_by_span(reference: Reference) -> bool:
    """Tell whether capture and frames of a hit are all that a field needs."""
    return reference.name == CLIP or (reference.name == MATCH and reference.field in _TIMES)


def value_of_span(reference: Reference, capture: Capture, span: Span) -> Value:
    """Return a field that capture and frames of a hit tell, as `told_by_span` says."""
    if reference.name == CLIP:
        return _of_clip(capture, reference.field)
    frames = {"start": span.start, "end": span.stop, "length": span.stop - span.start}
    return frames[reference.field] / capture.rate


def _told(symbol: Symbol, field: str) -> Value:
    if field in AMOUNTS:
        kind = KINDS[kind_of(symbol.part)]
        if field not in kind.words or symbol.amount is None:
            return None
        if field == "bend":
            return Fraction(degree_of(symbol.amount))
        return kind.amount(symbol.amount) if kind.amounts else Fraction(symbol.amount)
    said = symbol.runner_direction if field == "else" else getattr(symbol, field)
    return Fraction(round(said * 1000), 1000) if isinstance(said, float | int) else said


def _of_clip(capture: Capture, field: str) -> Value:
    """Return a column of a capture; None where it is empty."""
    if field in _CLIP:
        value = _CLIP[field](capture)
        return None if value == "" else value
    # people write the name of a column of theirs in small letters or capitals
    return next((it for name, it in capture.metadata.items() if name.lower() == field), "") or None


def _number(text: str) -> Fraction | None:
    digits = text.strip().removeprefix("-").replace(".", "", 1)
    if not (digits.isascii() and digits.isdecimal() and len(digits) < 100):
        return None
    return Fraction(text.strip())


def order(reference: Reference, value: Value) -> tuple[bool, bool, str | Fraction | int]:
    """Return what to sort values of a field by: the smallest first, what is missing last.

    Numbers, and texts that are numbers, stand before texts; those go by letter, levels from low to
    high.
    """
    if isinstance(value, str):
        if reference.name != CLIP and reference.field == "level":
            return False, False, LEVEL_CODES[value]
        number = _number(value)
        return (False, True, value) if number is None else (False, False, number)
    return value is None, False, value or 0
