"""Scores as tables: a symbol a row, with the columns that ``show --json`` has.

Source: ``NOTATIONS.md``, "Tables".
"""

import csv
import json
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from fractions import Fraction
from io import StringIO, TextIOWrapper
from itertools import islice, pairwise
from typing import IO, Any

import numpy as np

from lanindex import records
from lanindex.alphabet import DIRECTION_CODES, KINDS, LEVEL_CODES, MOST_AMOUNT, kind_of
from lanindex.errors import NotationError, extra, shown
from lanindex.model import Capture, Meter, Score, Track
from lanindex.model.symbol import FIELDS, blank
from lanindex.notation.beats import ticks_at
from lanindex.notation.lnd import PART, track_of
from lanindex.notation.text import decoded, refuse, unique_keys

COLUMNS: dict[str, type] = {
    **{"capture": str, "capture_id": int, "fps": float, "frames": int, "part": str},
    **{"direction": str, "level": str, "start_frame": int, "end_frame": int, "amount": int},
    **{"start": float, "end": float, "passing": bool, "swings": int, "margin": float},
    **{"speed": float, "size": int, "straightness": float, "runner_up": str},
}
"""What a row holds, in order: `lanindex.records.of_row`."""

Rows = Iterator[tuple[str, Mapping[str, Any]]]  # of a file, each with its place
_FEWEST = ("part", "fps", "start_frame", "end_frame")
_MEASURED = ("swings", "margin", "speed", "size", "straightness")
_CODES = {"direction": DIRECTION_CODES, "level": LEVEL_CODES}
_MOST = (1 << 31) - 1  # frames


def rows_of(score: Score) -> Iterator[dict[str, Any]]:
    """Yield the rows of a score, without a capture."""
    nobody = Capture(0, "", "", "", "", score.rate, score.frames)
    for row in rows_in(nobody, score.tracks):
        yield {**row, "capture": None, "capture_id": None}


def rows_in(capture: Capture, tracks: Mapping[str, Track]) -> Iterator[dict[str, Any]]:
    """Yield the rows of the tracks of a capture, as lines of ``show``."""
    for track in tracks.values():
        for symbol in track.listed():
            yield records.of_row(capture, symbol)


def score_of(rows: Rows, place: str) -> Score:
    """Return the score that rows tell."""
    parts: dict[str, list[dict[str, Any]]] = defaultdict(list)
    wholes: dict[str, dict[Any, None]] = {name: {} for name in ("capture", "fps", "frames")}
    for where, values in rows:
        row = _typed(values, where)
        if absent := [name for name in _FEWEST if row.get(name) is None]:
            refuse(where, f"no {absent[0]}", f"the columns {', '.join(_FEWEST)}")
        for name, found in wholes.items():
            found[row.get(name)] = None
            if len(found) > 1:
                both = " and ".join(shown(str(it)) for it in found)
                refuse(where, f"{name} {both}", "one score")
        parts[row["part"]].append({**_fields(row, where), "where": where})
    rate, declared = (next(iter(wholes[name]), None) for name in ("fps", "frames"))
    if rate is not None and not 0 < rate < 100_000:
        refuse(place, f"{rate:g} frames a second", "more than 0")
    last = max((one["stop"] for own in parts.values() for one in own), default=0)
    frames = max(declared or 0, last)
    exact = Fraction(str(rate)) if rate is not None else Meter().tick_rate
    try:
        tracks = {part: _track(part, own, frames, exact) for part, own in parts.items()}
    except OverflowError:  # a rate so small or so exact that its ticks have no room in 64 bits
        refuse(place, f"{rate:g} frames a second", "a rate whose ticks have room")
    return Score(exact, frames, Meter(), tracks)


def _fields(row: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Return what a row tells of a symbol, by field of `SYMBOL`."""
    part, start, stop = row["part"], row["start_frame"], row["end_frame"]
    if not PART.fullmatch(part):
        refuse(where, f'the part "{shown(part)}"', "one like r_arm")
    if not 0 <= start <= stop <= _MOST:
        refuse(where, f"frames {start} to {stop}", "from 0, and an end behind it")
    fields = {"start": start, "stop": stop, "passing": bool(row.get("passing")), "margin": 1}
    kind, runner_up = KINDS[kind_of(part)], (row.get("runner_up") or "").split()
    for name, codes in _CODES.items():
        word = row.get(name)
        known = kind.directions if name == "direction" else tuple(codes)
        wanted = " ".join(known) if name in kind.fields else f"none of a {kind.name}"
        if (word in known) != (name in kind.fields) or (word and name not in kind.fields):
            refuse(where, f'the {name} "{shown(str(word))}" of {part}', wanted)
        fields[name] = codes[word] if word else -1
        fields[f"runner_{name}"] = next((codes[it] for it in runner_up if it in codes), -1)
    amount = row.get("amount")
    most = len(kind.amounts) - 1 if kind.amounts else MOST_AMOUNT
    if (amount is None and "amount" in kind.fields) or not -1 < (amount or 0) <= most:
        refuse(where, f"the amount {amount} of {part}", f"0 to {most}")
    fields["amount"] = -1 if amount is None else amount
    for name in _MEASURED:
        value, limit = row.get(name), FIELDS[name].most / FIELDS[name].scale
        if value is not None and not 0 <= value <= limit:
            refuse(where, f"{name} {value:g}", f"0 to {limit:g}")
        if value is not None:
            fields[name] = value
    return fields


def _track(part: str, symbols: list[dict[str, Any]], frames: int, rate: Fraction) -> Track:
    """Return a track; passing symbols stand before the one that they lead to."""
    symbols.sort(key=lambda it: (it["stop"], not it["passing"], it["start"]))
    for one, two in pairwise(it for it in symbols if not it["passing"]):
        if two["start"] < one["stop"] or two["stop"] == one["start"]:
            found = f"{part} from frame {two['start']}, where one from {one['start']} is not over"
            refuse(two["where"], found, "one at a time")
    rows = blank(len(symbols))
    for at, symbol in enumerate(symbols):
        for name in symbol.keys() - {"where"}:
            rows[name][at] = symbol[name]
    ends = ticks_at(np.stack((rows["start"], rows["stop"])).astype(np.int64), Meter(), rate)
    rows["tick"], rows["ticks"] = ends[0], ends[1] - ends[0]
    return track_of(part, rows, frames)


_WANTED = {str: "a text", int: "a whole number", float: "a number", bool: "true or false"}
_FLAGS = {"true": True, "false": False, "1": True, "0": False}


def _typed(values: Mapping[str, Any], place: str) -> dict[str, Any]:
    """Return a row with values of its columns' types; other columns are left out."""
    row: dict[str, Any] = {}
    for name, value in values.items():
        if name not in COLUMNS or value is None or value == "" or value != value:
            continue
        kind = COLUMNS[name]
        try:
            if kind is str:
                sound, row[name] = isinstance(value, str), value
            elif kind is bool:
                flag = str(value).lower()
                sound, row[name] = flag in _FLAGS, _FLAGS.get(flag)
            else:
                number = float(value)
                sound = abs(number) < 1e15 and (kind is float or number % 1 == 0)
                row[name] = int(number) if kind is int and sound else number
        except (ValueError, TypeError, OverflowError):
            sound = False
        if not sound:
            refuse(place, f'{name} "{shown(str(value))}"', _WANTED[kind])
    return row


def rows_csv(content: bytes, place: str) -> Rows:
    """Yield the rows of a file."""
    lines = csv.reader(StringIO(decoded(content, place, "a table of symbols"), newline=""))
    try:
        names: list[str] = next(lines, [])
        if absent := [name for name in ("part", "start_frame") if name not in names]:
            wanted = f"a line of names, as {', '.join(COLUMNS)}"
            refuse(place, f"no column {absent[0]}", wanted)
        if again := [name for at, name in enumerate(names) if name in names[:at]]:
            refuse(place, f"the column {shown(again[0])} twice", "each once")
        for values in filter(None, lines):
            where = f"{place}:{lines.line_num}"
            if len(values) != len(names):
                refuse(where, f"{len(values)} values", f"{len(names)}, as in the first line")
            yield where, dict(zip(names, values, strict=True))
    except csv.Error as error:
        refuse(f"{place}:{lines.line_num}", str(error))


def save_csv(rows: Iterable[Mapping[str, Any]], file: IO[bytes]) -> int:
    """Write rows into a file, one by one; return how many there are."""
    count = 0
    text = TextIOWrapper(file, "utf-8", newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in rows:
        writer.writerow([str(it).lower() if isinstance(it, bool) else it for it in row.values()])
        count += 1
    text.detach()
    return count


def rows_jsonl(content: bytes, place: str) -> Rows:
    """Yield the rows of a file."""
    for number, line in enumerate(decoded(content, place, "JSON lines").split("\n"), 1):
        if not line.strip():
            continue
        where = f"{place}:{number}"
        try:
            row = json.loads(line, object_pairs_hook=unique_keys)
        except (ValueError, RecursionError) as error:
            refuse(where, shown(f"damaged JSON ({error})", 200), "an object a line")
        if not isinstance(row, dict):
            refuse(where, shown(line.strip()), "an object a line")
        yield where, row


def save_jsonl(rows: Iterable[Mapping[str, Any]], file: IO[bytes]) -> int:
    """Write rows into a file, one by one; return how many there are."""
    count = 0
    for row in rows:
        file.write(json.dumps(row, ensure_ascii=False).encode() + b"\n")
        count += 1
    return count


GROUP = 1 << 15  # rows that are in memory at once

_TYPES = {str: "string", int: "int64", float: "float64", bool: "bool"}


def rows_parquet(content: bytes, place: str) -> Rows:
    """Yield the rows of a file."""
    with extra("tables", place, NotationError):
        import pyarrow as pa
        from pyarrow import parquet
    try:
        file = parquet.ParquetFile(pa.BufferReader(content))
        columns = [name for name in COLUMNS if name in file.schema_arrow.names]
        batches = file.iter_batches(GROUP, columns=columns)
        for number, row in enumerate((it for own in batches for it in own.to_pylist()), 1):
            yield f"{place}: row {number}", row
    except (pa.ArrowException, OSError, ValueError, KeyError, TypeError) as error:
        refuse(place, f"damaged Parquet ({shown(str(error), 100)})", "a whole file")


def save_parquet(rows: Iterable[Mapping[str, Any]], file: IO[bytes]) -> int:
    """Write rows into a file, a group at a time; return how many there are."""
    with extra("tables", "parquet"):
        import pyarrow as pa
        from pyarrow import parquet
    kinds = {kind: pa.type_for_alias(name) for kind, name in _TYPES.items()}
    schema = pa.schema([(name, kinds[kind]) for name, kind in COLUMNS.items()])
    count, left = 0, iter(rows)
    with parquet.ParquetWriter(file, schema) as writer:
        while group := list(islice(left, GROUP)):
            writer.write_table(pa.Table.from_pylist(group, schema))
            count += len(group)
    return count
