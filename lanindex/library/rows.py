"""Score ↔ rows of ``track`` and ``symbol_code``: whole tracks at a time, column by column."""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import accumulate, chain, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import KINDS
from lanindex.errors import UsageError
from lanindex.library import checksums, codes
from lanindex.model import Score, Span
from lanindex.model.symbol import joined

_RAW, _TENTHS = b"\0", b"\1"
"""The first byte of a heading: how the rest is to be read."""


_NEEDED = {
    name: np.array([name in kind.fields for kind in KINDS.values()])
    for name in dict.fromkeys(chain.from_iterable(kind.fields for kind in KINDS.values()))
}
"""By field, which kinds of symbols have it, in the order of their codes."""


def check(score: Score, place: str) -> None:
    """Refuse a score that cannot be stored as it is."""
    for part, track in score.tracks.items():
        if track.part != part:
            raise UsageError(f"{part} holds the track of {track.part}", place=place)
    tracks = list(score.tracks.values())
    symbols = joined(track.symbols for track in tracks)
    bad = wrong(symbols, score.frames)
    each = np.array([codes.KIND_NAMES.index(one.kind) for one in tracks], np.int64)
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


def wrong(symbols: NDArray[Any], frames: int) -> NDArray[np.bool_]:
    """Return which symbols cannot be stored, or lie outside a capture's frames: (S,) bool."""
    return codes.wrong(symbols) | (symbols["stop"] > frames)


@dataclass(frozen=True, slots=True)
class Rows:
    """A score as rows without the capture's number, which comes first in each."""

    tracks: list[tuple[Any, ...]]
    symbols: list[list[int]]
    checksum: int


def rows_of(score: Score) -> Rows:
    """Return the rows of a score."""
    kept = list(score.tracks.values())
    counts = list(map(len, kept))
    packed = codes.pack(joined(track.symbols for track in kept))
    numbers = numbered(packed, counts, range(len(kept)))
    tracks = []
    for ordinal, (track, checksum) in enumerate(zip(kept, of_tracks(numbers, counts), strict=True)):
        kind, known = codes.KIND_NAMES.index(track.kind), _known_text(track.known, score.frames)
        tracks.append((ordinal, track.part, kind, known, len(track), checksum))
    return Rows(tracks, numbers.T.tolist(), checksums.of_values(*tracks))


def numbered(
    packed: NDArray[np.int64], counts: Sequence[int], ordinals: Sequence[int]
) -> NDArray[np.int64]:
    """Return (S, C) packed symbols with the ordinals of track and row before them: (S, C + 2)."""
    numbers = np.empty((len(packed), packed.shape[1] + 2), np.int64)
    numbers[:, 0] = np.repeat(np.array(ordinals, np.int64), counts)
    begins = np.cumsum([0, *counts], dtype=np.int64)[:-1]
    numbers[:, 1] = np.arange(len(packed)) - np.repeat(begins, counts)
    numbers[:, 2:] = packed
    return numbers


def of_tracks(numbers: NDArray[np.int64], counts: Iterable[int]) -> list[int]:
    """Return the checksums of the rows of tracks: (S, C + 2) int64, track, ordinal, fields."""
    content = np.ascontiguousarray(numbers, "<i8").reshape(-1).view(np.uint8).data
    ends = [0, *(8 * numbers.shape[1] * end for end in accumulate(counts))]
    found = [zlib.crc32(content[first:last]) for first, last in pairwise(ends)]
    signed: list[int] = np.array(found, np.uint32).view(np.int32).tolist()  # as checksums.of_bytes
    return signed


def _known_text(known: tuple[Span, ...], frames: int) -> str | None:
    if known == (Span(0, frames),):
        return None
    return json.dumps([[span.start, span.stop] for span in known])


def read_known(known: str | None, frames: int) -> tuple[Span, ...]:
    """Return the stretches in which a part was seen."""
    if known is None:
        return (Span(0, frames),)
    return tuple(Span(start, stop) for start, stop in json.loads(known))


def capture_columns(score: Score) -> dict[str, Any]:
    """Return what a row of ``capture`` says of a score."""
    meter = score.meter
    return {
        "fps": float(score.rate),
        "rate": str(score.rate),
        "frames": int(score.frames),
        "speed": str(meter.speed),
        "beats": int(meter.beats),
        "beat": int(meter.beat),
        "division": int(meter.division),
        "other": json.dumps(score.other),
        "heading": pack_heading(score.heading),
    }


def pack_heading(heading: NDArray[np.float32]) -> bytes:
    """Return (N,) degrees as they are stored: small if in tenths of a degree, always exact."""
    raw = heading.astype("<f4").tobytes()
    with np.errstate(all="ignore"):  # no number, or a vast one: it does not come back, and stays
        tenths = np.rint(heading.astype(np.float64) * 10).astype(np.int64)
        changes = np.diff(tenths, n=2, prepend=[0, 0])
        folded = ((changes << 1) ^ (changes >> 63)).astype("<u2")
    packed = zlib.compress(folded.view(np.uint8).reshape(-1, 2).T.tobytes())
    return _TENTHS + packed if _unfolded(folded).tobytes() == raw else _RAW + raw


def read_heading(blob: bytes) -> NDArray[Any]:
    """Return a heading as `pack_heading` keeps it: (N,) float32, or (2, N) uint8, its bytes."""
    if blob[:1] == _RAW:
        return np.frombuffer(blob[1:], "<f4")
    try:
        return np.frombuffer(zlib.decompress(blob[1:]), np.uint8).reshape(2, -1)
    except zlib.error as error:
        raise ValueError(str(error)) from error


def unpacked_heading(packed: NDArray[Any]) -> NDArray[np.float32]:
    """Return the heading that `read_heading` has read: (N,) float32, degrees."""
    if packed.ndim == 1:
        return packed.astype(np.float32)
    return _unfolded(np.ascontiguousarray(packed.T).view("<u2").ravel())


def _unfolded(folded: NDArray[np.uint16]) -> NDArray[np.float32]:
    changes = folded.astype(np.int64)
    changes = (changes >> 1) ^ -(changes & 1)
    return (np.cumsum(np.cumsum(changes)) / 10).astype("<f4").astype(np.float32)
