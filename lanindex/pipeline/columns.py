"""Columns of captures that a pattern speaks of: ``clip.dancer``."""

from __future__ import annotations

from lanindex.errors import UsageError
from lanindex.library.store import Store
from lanindex.search.fields import CLIP_FIELDS
from lanindex.search.language.clauses import CLIP, references_in
from lanindex.search.language.query import Query


def check_columns(library: Store, query: Query) -> None:
    """Refuse a column that no capture has: it would meet no condition, without a word."""
    references = references_in((*query.where, *query.stages))
    named = {it.field for it in references if it.name == CLIP} - set(CLIP_FIELDS)
    said = library.called("metadata").values() if named else ()
    known = {column.lower() for columns in said for column in columns}
    for column in sorted(named - known) if said else ():
        raise UsageError(
            f'no capture has a column "{column}"',
            wanted=f"clip and one of {', '.join([*CLIP_FIELDS, *sorted(known)])}",
        )
