"""The manifest of exported clips: a row each, as CSV and as JSON lines."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from lanindex import formats
from lanindex.alphabet import KINDS, kind_of
from lanindex.model import Capture, Span
from lanindex.records import of_name, rate_of, seconds

if TYPE_CHECKING:
    from lanindex.pipeline.named import Request

FILES = ("manifest.csv", "manifest.jsonl")

_FORMULAS = ("=", "+", "-", "@", "\t", "\n")
"""Where a cell begins with one of these, a spreadsheet takes it for a formula."""


def row(
    name: str, capture: Capture, request: Request, clip: Span, preview: str | None
) -> dict[str, Any]:
    """Return the columns of a clip, in their order."""
    hit = request.hit
    return {
        "clip": name,
        **of_name(capture),
        "label": capture.label,
        "fps": rate_of(capture),
        "hit_start_frame": hit.start,
        "hit_end_frame": hit.stop,
        "clip_start_frame": clip.start,
        "clip_end_frame": clip.stop,
        "start": seconds(capture, clip.start),
        "end": seconds(capture, clip.stop),
        "fit": request.fit,
        "pattern": request.pattern,
        "symbols": list(request.symbols),
        **({} if preview is None else {"preview": preview}),
    }


def files(rows: Sequence[dict[str, Any]]) -> Iterator[formats.File]:
    """Yield the manifest as CSV, then as JSON lines."""
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    for one in rows:
        writer.writerow({key: _cell(value) for key, value in one.items()})
    lines = (json.dumps(one, ensure_ascii=False) + "\n" for one in rows)
    for name, content in zip(FILES, (text.getvalue(), "".join(lines)), strict=True):
        yield formats.File(name, content.encode())


def _cell(value: Any) -> Any:
    """Return a value as a cell of CSV that no spreadsheet takes for a formula."""
    if isinstance(value, list):
        value = "; ".join(map(_with_frames, value))
    if isinstance(value, str):
        value = re.sub("\r\n?", "\n", value)  # alone it would end the row
        return f"'{value}" if value.startswith(_FORMULAS) else value
    return value


def _with_frames(symbol: Mapping[str, Any]) -> str:
    frames = f"{symbol['start_frame']}-{symbol['end_frame']}"
    return " ".join(filter(None, (symbol["part"], in_words(symbol), frames)))


def in_words(symbol: Mapping[str, Any]) -> str:
    """Return direction, level and amount of a symbol, as it is in JSON."""
    words = [symbol.get(key) for key in ("direction", "level")]
    if (amount := symbol.get("amount")) is not None:
        words.append(KINDS[kind_of(symbol["part"])].amount(amount))
    return " ".join(filter(None, words))
