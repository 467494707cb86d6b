"""What users know of their captures: a CSV file with a column ``file``."""

from __future__ import annotations

import csv
import io
import os
from pathlib import Path

from lanindex.errors import UsageError
from lanindex.notation.text import read_text

Labels = dict[str, tuple[str | None, dict[str, str]]]
"""By absolute path: the label, None where the table has none, and the other columns."""


def read_labels(path: str | os.PathLike[str]) -> Labels:
    """Read labels and other columns.

    Parameters
    ----------
    path : path-like
        A CSV file: ``file`` (relative to the CSV's folder, or absolute), ``label``, and any other
        columns.

    Returns
    -------
    dict of str to (str or None, dict of str to str)
        By absolute path: label, None where there is none; the other columns that are not empty.

    Raises
    ------
    UsageError
        Where a column is missing or has no name of its own, a row names no file, or a file stands
        twice with different words.
    NotationError
        Where it cannot be read or is no text.
    """
    place = Path(path)
    (first, names), *rows = _rows(place) or [(1, [])]
    head = [name.lower() for name in names]
    _check_head(head, f"{place}:{first}")
    labels: Labels = {}
    for line, row in rows:
        row += [""] * (len(head) - len(row))
        _check_row(row, head, f"{place}:{line}")
        cells = dict(zip(head, row, strict=True))
        named = os.path.abspath(place.parent / cells.pop("file"))
        label = cells.pop("label", "") or None
        entry = label, {name: cell for name, cell in cells.items() if cell}
        if labels.setdefault(named, entry) != entry:
            raise UsageError(
                f"{named} stands twice", place=f"{place}:{line}", wanted="one line a file"
            )
    return labels


def _rows(place: Path) -> list[tuple[int, list[str]]]:
    """Return the rows that hold anything, each with its line."""
    table = csv.reader(io.StringIO(read_text(place), newline=""), strict=True)
    try:
        rows = [(table.line_num, [cell.strip() for cell in row]) for row in table]
    except csv.Error as error:
        raise UsageError(str(error), place=f"{place}:{table.line_num}", wanted="CSV") from error
    return [(line, row) for line, row in rows if any(row)]


def _check_head(head: list[str], place: str) -> None:
    if "file" not in head:
        raise UsageError(
            f"the columns are {', '.join(head) or 'none'}",
            place=place,
            wanted='a column "file", and "label"',
        )
    for number, name in enumerate(head, 1):
        if name and name in head[: number - 1]:
            raise UsageError(
                f'columns {head.index(name) + 1} and {number} are both called "{name}"',
                place=place,
                wanted="a name for each",
            )


def _check_row(row: list[str], head: list[str], place: str) -> None:
    if len(row) > len(head):
        raise UsageError(f"{len(row)} cells", place=place, wanted=f"{len(head)} as in line 1")
    for number, (name, cell) in enumerate(zip(head, row, strict=True), 1):
        if cell and not name:
            raise UsageError(
                f'column {number} has no name and holds "{cell}"',
                place=place,
                wanted="a name for it in line 1",
            )
    if not row[head.index("file")]:
        raise UsageError("no file", place=place, wanted='one in the column "file"')
