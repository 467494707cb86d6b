"""A score as rows: whole numbers, texts and their checksums.

Small fields of a symbol share a column of ``symbol_code``, each with bits of its own
(`lanindex.model.symbol.FIELDS` says where), so that a symbol takes a dozen bytes; the view that
`view_sql` makes shows them as words. A checksum is a CRC-32, enough to notice whatever happens to a
file by accident or by hand, as a whole number with a sign, which takes four bytes in a library.
"""

import json
import shlex
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate, chain, pairwise
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import KINDS
from lanindex.errors import LibraryError, UsageError
from lanindex.library.selection import printable
from lanindex.model import Score, Span
from lanindex.model.symbol import FIELDS, SYMBOL, Field, joined

Integers = NDArray[np.int64]

COLUMNS = tuple(dict.fromkeys(how.column for how in FIELDS.values()))
"""The columns of ``symbol_code`` that hold fields, in the order of `pack`."""

TRACK = ("ordinal", "part", "kind", "known", "symbols", "checksum")
"""The columns of ``track`` after the capture's number."""

ENCODED = (
    *("path", "location", "format", "sha256", "fps", "rate", "frames"),
    *("speed", "beats", "beat", "division", "options", "warnings", "tracks", "content"),
)
"""Columns of ``capture`` that its checksum is over; ``tracks`` and ``content`` are checksums."""

VIEW = "symbol"
"""The view in words."""

KIND_NAMES = tuple(KINDS)
"""By code."""

_NEEDED = {
    name: np.array([name in kind.fields for kind in KINDS.values()])
    for name in dict.fromkeys(chain.from_iterable(kind.fields for kind in KINDS.values()))
}
"""By field, which kinds of symbols have it, in the order of their codes."""

_RAW, _TENTHS = b"\0", b"\1"
"""The first byte of a heading: how the rest is to be read."""


def checksum(*values: Any) -> int:
    """Return the checksum of what a row holds: numbers, texts, bytes, nothing, tuples of them.

    The type counts: 1, 1.0 and "1" differ.
    """
    return bytes_checksum(ascii(values).encode())


def bytes_checksum(*values: bytes | memoryview) -> int:
    """Return the checksum of bytes, one after the other."""
    crc = 0
    for value in values:
        crc = zlib.crc32(value, crc)
    return crc - ((crc >> 31) << 32)


def damaged(number: object, path: object, what: str) -> LibraryError:
    """Return the error that says what of a capture is damaged, and the remedy."""
    shown = printable(path) if isinstance(path, str) else f"capture {number}"
    return LibraryError(
        f"capture {number} is damaged in the library: {what}",
        place=shown,
        wanted="what was stored",
        remedy=f"Write it down anew: lanindex ingest --force {shlex.quote(shown)}",
    )


@dataclass(frozen=True, slots=True)
class Encoding:
    """How a capture was read and encoded; equal encodings of one file give equal scores."""

    profile: str = ""
    digest: str = ""
    options: Mapping[str, str] = field(default_factory=dict)
    beside: str = ""
    people: int = field(default=0, compare=False)
    version: str = field(default="", compare=False)  # of its file, as its store tells it

    @classmethod
    def stored(cls, profile: str, digest: str, facts: Mapping[str, str]) -> Self:
        """Return the encoding that a profile and the column ``options`` of a capture hold."""
        options = dict(facts)
        beside, people = options.pop("beside", ""), int(options.pop("people", 0))
        return cls(profile, digest, options, beside, people, options.pop("version", ""))

    def facts(self) -> dict[str, str]:
        """Return the content of the column ``options``: the options, and what else is known."""
        more = {"beside": self.beside, "people": str(self.people or ""), "version": self.version}
        return {**self.options, **{name: fact for name, fact in more.items() if fact}}


def encoded_checksum(values: Mapping[str, Any], profile: str | None, digest: str | None) -> int:
    """Return the checksum of a capture's columns in `ENCODED` and of its profile."""
    return checksum(*(values[name] for name in ENCODED), profile, digest)


def _whole_numbers(name: str, symbols: NDArray[Any]) -> NDArray[Any]:
    """Return a field as whole numbers, (S,), before its bits are placed; NaN stays NaN."""
    how = FIELDS[name]
    if how.scale != 1:
        return np.rint(symbols[name].astype(np.float64) * how.scale)
    values: Integers = symbols[name].astype(np.int64)
    return values - symbols[how.since] if how.since else values


def wrong(symbols: NDArray[Any], frames: int | Integers) -> NDArray[np.bool_]:
    """Return which of (S,) symbols cannot be stored, or end behind their capture's frames: (S,)."""
    bad: NDArray[np.bool_] = symbols["stop"] > frames
    for name, how in FIELDS.items():
        values = _whole_numbers(name, symbols)
        bad |= ~((values >= how.least) & (values <= how.most))
    return bad


def pack(symbols: NDArray[Any]) -> Integers:
    """Return (S,) symbols as a library stores them: (S, C) int64, in the order of `COLUMNS`."""
    packed = np.zeros((len(symbols), len(COLUMNS)), np.int64)
    for name, how in FIELDS.items():
        values = _whole_numbers(name, symbols).astype(np.int64, copy=False)
        packed[:, COLUMNS.index(how.column)] |= (values - how.least) << how.shift
    return packed


def unpack(packed: Integers) -> NDArray[Any]:
    """Return (S,) symbols from what a library stores: (S, C) int64."""
    symbols = np.empty(len(packed), SYMBOL)
    for name, how in FIELDS.items():
        values = (packed[:, COLUMNS.index(how.column)] >> how.shift) & ((1 << how.bits) - 1)
        if how.least:
            values += how.least
        if how.since:
            values += symbols[how.since]
        symbols[name] = values if how.scale == 1 else values / how.scale
    return symbols


def view_sql() -> str:
    """Return the statement that makes the view ``symbol``, which shows symbols in words."""
    shown = [_expression(name, how) for name, how in FIELDS.items()]
    kind = f"{_words('t.kind', KIND_NAMES)} AS kind"
    columns = ["c.capture_id", "t.part", "c.ordinal", *shown, kind]
    return (
        f"CREATE VIEW {VIEW} AS SELECT {', '.join(columns)} FROM symbol_code c "
        "JOIN track t ON t.capture_id = c.capture_id AND t.ordinal = c.track"
    )


def _expression(name: str, field: Field) -> str:
    text, shown = f"c.{field.column}", field.shown or name
    if shown == field.column:
        return text
    if sum(field.column == other.column for other in FIELDS.values()) > 1:
        text = f"({text} >> {field.shift})" if field.shift else text
        text = f"({text} & {(1 << field.bits) - 1})"
    if field.words:
        text = _words(text, field.words, -field.least)
    elif field.least:  # the code 0 stands for nothing
        text = f"(NULLIF({text}, 0) - {-field.least})"
    if field.scale != 1:
        text = f"{text} / {field.scale}.0"
    if field.since:
        text = f"c.{FIELDS[field.since].column} + {text}"
    return f"{text} AS {shown}"


def _words(text: str, words: tuple[str, ...], first: int = 0) -> str:
    cases = (f"WHEN {code} THEN '{word}'" for code, word in enumerate(words, first))
    return f"CASE {text} {' '.join(cases)} END"


def check(score: Score, place: str) -> None:
    """Refuse a score that cannot be stored as it is."""
    for part, track in score.tracks.items():
        if track.part != part:
            raise UsageError(f"{part} holds the track of {track.part}", place=place)
    tracks = list(score.tracks.values())
    symbols = joined(track.symbols for track in tracks)
    bad = wrong(symbols, score.frames)
    each = np.array([KIND_NAMES.index(one.kind) for one in tracks], np.int64)
    kinds = each.repeat(list(map(len, tracks)))
    for name, needed in _NEEDED.items():
        bad |= needed[kinds] & (symbols[name] < 0)
    if bad.any():
        row = int(bad.argmax())
        parts = [part for part, track in score.tracks.items() for _ in range(len(track))]
        raise UsageError(
            f"{parts[row]} has the symbol {symbols[row]}",
            place=place,
            wanted=f"codes of the alphabet and a span within {score.frames} frames",
        )


def rows_of(score: Score) -> tuple[list[tuple[Any, ...]], list[list[int]], int]:
    """Return the rows of tracks, the columns of symbols, and the checksum of the list of tracks.

    The capture's number, which comes first in each row, is left out.
    """
    held = list(score.tracks.values())
    counts = list(map(len, held))
    numbers = numbered(pack(joined(track.symbols for track in held)), counts, range(len(held)))
    tracks: list[tuple[Any, ...]] = []
    for track, content in zip(held, track_checksums(numbers, counts), strict=True):
        kind, known = KIND_NAMES.index(track.kind), None
        if track.known != (Span(0, score.frames),):
            known = json.dumps([[span.start, span.stop] for span in track.known])
        tracks.append((len(tracks), track.part, kind, known, len(track), content))
    return tracks, numbers.T.tolist(), checksum(*tracks)


def numbered(packed: Integers, counts: Sequence[int], ordinals: Sequence[int]) -> Integers:
    """Return (S, C) packed symbols with the ordinals of track and row before them: (S, C + 2)."""
    numbers = np.empty((len(packed), packed.shape[1] + 2), np.int64)
    numbers[:, 0] = np.repeat(np.array(ordinals, np.int64), counts)
    begins = np.cumsum([0, *counts], dtype=np.int64)[:-1]
    numbers[:, 1] = np.arange(len(packed)) - np.repeat(begins, counts)
    numbers[:, 2:] = packed
    return numbers


def track_checksums(numbers: Integers, counts: Iterable[int]) -> list[int]:
    """Return the checksums of the rows of tracks: (S, C + 2) int64, track, ordinal, fields."""
    content = np.ascontiguousarray(numbers, "<i8").reshape(-1).view(np.uint8).data
    ends = [0, *(8 * numbers.shape[1] * end for end in accumulate(counts))]
    crcs = [zlib.crc32(content[first:last]) for first, last in pairwise(ends)]
    signed: list[int] = np.array(crcs, np.uint32).view(np.int32).tolist()  # as `bytes_checksum`
    return signed


def pack_heading(heading: NDArray[np.float32]) -> bytes:
    """Return (N,) degrees as they are stored: small if in tenths of a degree, always exact."""
    raw = heading.astype("<f4").tobytes()
    with np.errstate(all="ignore"):  # NaN or vast: tenths differ, and it is stored raw
        tenths = np.rint(heading.astype(np.float64) * 10).astype(np.int64)
        changes = np.diff(tenths, n=2, prepend=[0, 0])
        folded = ((changes << 1) ^ (changes >> 63)).astype("<u2")
    packed = zlib.compress(folded.view(np.uint8).reshape(-1, 2).T.tobytes())
    return _TENTHS + packed if _unfold(folded).tobytes() == raw else _RAW + raw


def unpack_heading(blob: bytes) -> NDArray[np.float32]:
    """Return the heading that `pack_heading` stores: (N,) float32, degrees."""
    if blob[:1] == _RAW:
        return np.frombuffer(blob[1:], "<f4").astype(np.float32)
    try:
        planes = np.frombuffer(zlib.decompress(blob[1:]), np.uint8).reshape(2, -1)
    except zlib.error as error:
        raise ValueError(str(error)) from error
    return _unfold(np.ascontiguousarray(planes.T).view("<u2").ravel())


def _unfold(folded: NDArray[np.uint16]) -> NDArray[np.float32]:
    changes = folded.astype(np.int64)
    changes = (changes >> 1) ^ -(changes & 1)
    return (np.cumsum(np.cumsum(changes)) / 10).astype("<f4").astype(np.float32)
