"""What users know of their captures: a table with a column ``file``."""

from __future__ import annotations

import csv
import io
import os
import unicodedata
from collections.abc import Iterable
from pathlib import Path

from lanindex.errors import UsageError, shown
from lanindex.formats.file import on_disk
from lanindex.library.selection import absolute, is_gone
from lanindex.notation.text import read_text

CaptureLabels = tuple[str | None, dict[str, str]]
"""Of a capture: the label, None where the table has none, and the other columns."""

Labels = dict[str, CaptureLabels]
"""By `key_of` a capture's path."""

_FROM = "a relative path counts from the table's folder, else from the working directory"
_DELIMITERS = (",", ";", "\t")


def key_of(path: str | os.PathLike[str]) -> str:
    """Return by what a path is known in `Labels`: absolute, its letters composed.

    One system writes é as one character, another as two; a table made on the one fits files that
    lie on the other.
    """
    return unicodedata.normalize("NFC", absolute(path))


def read_labels(
    path: str | os.PathLike[str], files: Iterable[str | os.PathLike[str]] | None = None
) -> Labels:
    """Read labels and other columns; refuse a table that speaks of none of the files."""
    place = Path(path)
    (first, names), *rows = _rows(place) or [(1, [])]
    head = [name.lower() for name in names]
    _check_head(head, f"{place}:{first}")
    labels: Labels = {}
    for line, row in rows:
        row += [""] * (len(head) - len(row))
        _check_row(row, head, f"{place}:{line}")
        cells = dict(zip(head, row, strict=True))
        key = key_of(_row_path(place.parent, cells.pop("file")))
        label = cells.pop("label", "") or None
        entry = label, {name: cell for name, cell in cells.items() if cell}
        if labels.setdefault(key, entry) != entry:
            found = f"{key} stands twice"
            raise UsageError(found, place=f"{place}:{line}", wanted="one line a file")
    if labels and files is not None:
        held = {key_of(on_disk(os.fspath(file))) for file in files}
        if not any(key_of(on_disk(key)) in held for key in labels):
            raise UsageError(unfitting(labels, held), place=os.fspath(path))
    return labels


def _row_path(folder: Path, file: str) -> str:
    """Return the path that a row names: from the table's folder, else from where we are."""
    beside = os.path.join(folder, file)
    return file if is_gone(beside) and not is_gone(file) else beside


def unfitting(labels: Labels, files: Iterable[str | os.PathLike[str]]) -> str:
    """Say how many rows of a table fit none of the files, and what they may have meant."""
    keys = {key_of(file) for file in files}
    unknown = [key for key in labels if key not in keys]
    if len(unknown) < len(labels) or not labels:
        return f"{len(unknown)} of {len(labels)} rows name no file that is read" if unknown else ""
    near = _nearest_key(unknown[0], keys)
    first = f"the first names {unknown[0]}" + (f"; is it {near}?" if near else "")
    return f"no row names a file that is read; {first} ({_FROM})"


def _nearest_key(key: str, keys: Iterable[str]) -> str:
    """Return the key of the likest file name, the likest path among equal ones."""
    from rapidfuzz import fuzz, process

    named = {other: os.path.basename(other) for other in sorted(keys)}
    near = process.extract(
        os.path.basename(key), named, scorer=fuzz.ratio, limit=20, score_cutoff=60
    )
    best = [other for _, score, other in near if score == near[0][1]]
    return max(best, key=lambda other: fuzz.ratio(key, other), default="")


def _rows(place: Path) -> list[tuple[int, list[str]]]:
    """Return the rows that hold anything, each with its line."""
    text = read_text(place)
    head = next((line for line in text.splitlines() if line.strip()), "")

    def fits(delimiter: str) -> tuple[bool, int]:
        names = [name.strip(' "').lower() for name in head.split(delimiter)]
        return "file" in names, len(names)

    delimiter = max(_DELIMITERS, key=fits)
    table = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    try:
        rows = [(table.line_num, [cell.strip() for cell in row]) for row in table]
    except csv.Error as error:
        raise UsageError(str(error), place=f"{place}:{table.line_num}", wanted="CSV") from error
    return [(line, row) for line, row in rows if any(row)]


def _check_head(head: list[str], place: str) -> None:
    if "file" not in head:
        raise UsageError(
            f"the columns are {shown(', '.join(head), 200) or 'none'}",
            place=place,
            wanted='a column "file", and "label"',
        )
    for number, name in enumerate(head, 1):
        if name and name in head[: number - 1]:
            raise UsageError(
                f'columns {head.index(name) + 1} and {number} are both called "{shown(name)}"',
                place=place,
                wanted="a name for each",
            )


def _check_row(row: list[str], head: list[str], place: str) -> None:
    if len(row) > len(head):
        raise UsageError(f"{len(row)} cells", place=place, wanted=f"{len(head)} as in line 1")
    for number, (name, cell) in enumerate(zip(head, row, strict=True), 1):
        if cell and not name:
            raise UsageError(
                f'column {number} has no name and holds "{shown(cell)}"',
                place=place,
                wanted="a name for it in line 1",
            )
    if not row[head.index("file")]:
        raise UsageError("no file", place=place, wanted='one in the column "file"')
