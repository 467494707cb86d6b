"""What users know of their captures: a CSV file with a column ``file``."""

from __future__ import annotations

import csv
import io
import os
from pathlib import Path

from lanindex.errors import UsageError
from lanindex.notation.text import read_text

Labels = dict[str, tuple[str, dict[str, str]]]


def read_labels(path: str | os.PathLike[str]) -> Labels:
    """Read labels and other columns.

    Parameters
    ----------
    path : path-like
        A CSV file: ``file`` (relative to the CSV's folder, or absolute), ``label``, and any other
        columns.

    Returns
    -------
    dict of str to (str, dict of str to str)
        By absolute path: label, and the other columns that are not empty.

    Raises
    ------
    UsageError
        Where a column is missing, or a file stands twice with different words.
    NotationError
        Where it cannot be read or is no text.
    """
    place = Path(path)
    table = csv.reader(io.StringIO(read_text(place), newline=""), strict=True)
    try:
        rows = [(table.line_num, row) for row in table if any(cell.strip() for cell in row)]
    except csv.Error as error:
        raise UsageError(str(error), place=f"{place}:{table.line_num}", wanted="CSV") from error
    head = [name.strip().lower() for name in rows[0][1]] if rows else []
    if "file" not in head:
        raise UsageError(
            f"the columns are {', '.join(head) or 'none'}",
            place=f"{place}:1",
            wanted='a column "file", and "label"',
        )
    labels: Labels = {}
    for line, row in rows[1:]:
        if len(row) > len(head):
            raise UsageError(
                f"{len(row)} cells", place=f"{place}:{line}", wanted=f"{len(head)} as in line 1"
            )
        cells = {name: cell.strip() for name, cell in zip(head, row, strict=False)}
        named = os.path.abspath(place.parent / cells.pop("file"))
        entry = cells.pop("label", ""), {name: cell for name, cell in cells.items() if cell}
        if labels.setdefault(named, entry) != entry:
            raise UsageError(
                f"{named} stands twice", place=f"{place}:{line}", wanted="one line a file"
            )
    return labels
