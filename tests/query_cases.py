"""Read `tests/search/query_cases.txt`: the hand-worked cases of the pattern language."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from lanindex.alphabet import DIRECTION_CODES, KINDS, LEVEL_CODES, kind_of
from lanindex.model import Capture, Meter, Score, Span, Track
from lanindex.model.derived import with_bends
from lanindex.model.symbol import blank
from lanindex.search.hits import Counted, Counts, Hits

PAGE = Path(__file__).parent / "search" / "query_cases.txt"

_CODES = {"direction": DIRECTION_CODES, "level": LEVEL_CODES}


@dataclass(frozen=True)
class Recording:
    name: str
    capture: Capture
    tracks: Mapping[str, Track]

    def score(self) -> Score:
        return Score(self.capture.rate, self.capture.frames, self.capture.meter, self.tracks)


@dataclass(frozen=True)
class Expected:
    """A hit, or, without a span, a line of a table: ``d1 1``."""

    name: str
    span: Span | None
    symbols: tuple[str, ...]


@dataclass(frozen=True)
class Case:
    line: int
    recordings: tuple[Recording, ...]
    pattern: str
    overlaps: str
    tolerance: Fraction
    hits: tuple[Expected, ...]
    error: str

    def __str__(self) -> str:
        return f"{self.line}: {self.pattern}"


def cases(page: Path = PAGE) -> Iterator[Case]:
    """Yield all cases of the page, each with its recordings."""
    recordings: tuple[Recording, ...] = ()
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        if line.startswith("= "):
            recordings = tuple(recordings_of(line[2:]))
        elif line and not line.startswith("#"):
            yield _case(number, line, recordings)


def told(found: Hits | Counts, names: Mapping[int, str]) -> list[Expected]:
    """Return what was found as the page writes it; names of captures by number."""
    return [
        Expected(f"{it.value} {it.count}", None, ())
        if isinstance(it, Counted)
        else Expected(
            names[it.capture.id],
            it.span,
            tuple(sorted(f"{symbol.part}.{symbol.ordinal}" for symbol in it.symbols)),
        )
        for it in found
    ]


def track(part: str, text: str, frames: int, known: tuple[Span, ...] = ()) -> Track:
    """Read ``place low 0 0, right mid 5 12``: by default one known stretch; all margins 1.

    A symbol has what its kind has: ``forward hop 5 9`` is a jump, ``left 90 5 9`` a turn. Measures
    stand behind: ``right mid 5 12 speed=3.2``.
    """
    rows = blank(text.count(",") + 1)
    kind = KINDS[kind_of(part)]
    for row, symbol in zip(rows, text.split(","), strict=True):
        said = symbol.split()
        measured = dict(it.split("=") for it in said if "=" in it)
        *words, start, stop = (it for it in said if "=" not in it)
        for name, value in measured.items():
            row[name] = float(value)
        row["passing"] = symbol.count("*")
        amounts = {name: number for number, name in enumerate(kind.amounts)}
        for name, word in zip(kind.fields, words, strict=True):
            row[name] = _CODES.get(name, amounts).get(word.rstrip("*"), word)
        row["start"], row["stop"], row["tick"] = int(start), int(stop), int(start)
        row["ticks"] = int(stop) - int(start)
        row["margin"] = 1
        row["runner_direction"] = row["runner_level"] = -1
    return Track(part, rows, known or (Span(0, frames),))


def recordings_of(text: str) -> Iterator[Recording]:
    """Read what stands behind ``= ``: one recording, or several that say ``capture``."""
    for number, capture in enumerate(re.split(r";\s*(?=capture )", text), 1):
        head, *parts = capture.split(";")
        words = head.split()
        told = dict(zip(words[::2], words[1::2], strict=True))
        name, frames = told.pop("capture", ""), int(told.pop("frames"))
        rate = Fraction(told.pop("fps"))
        meter = Meter(Fraction(told.pop("tempo", "60")))
        path = f"{name or number}.lnd"
        yield Recording(
            name,
            Capture(number, path, "lnd", f"{number:064x}", "", rate, frames, meter, told),
            with_bends(
                {
                    part.strip(): track(part.strip(), symbols, frames)
                    for part, symbols in (it.split(":") for it in parts)
                }
            ),
        )


def _case(number: int, line: str, recordings: tuple[Recording, ...]) -> Case:
    pattern, expected = line.split(" ⇒ ")
    overlaps, tolerance = "none", Fraction(1, 10)
    if pattern.endswith("  --all"):
        pattern, overlaps = pattern.removesuffix("  --all"), "all"
    if pattern.endswith("  --tolerance"):
        pattern, tolerance = pattern.removesuffix("  --tolerance"), Fraction(1, 2)
    error = expected[1:] if expected.startswith("!") else ""
    found = () if error or expected == "none" else tuple(map(_expected, expected.split(" | ")))
    return Case(
        *(number, recordings, pattern.replace("\\n", "\n"), overlaps, tolerance, found, error)
    )


def _expected(text: str) -> Expected:
    *name, place = text.split()
    span, _, symbols = place.partition(":")
    if "-" not in span:
        return Expected(text, None, ())
    start, stop = map(int, span.split("-"))
    return Expected(name[0] if name else "", Span(start, stop), tuple(sorted(symbols.split(","))))
