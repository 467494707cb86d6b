"""The dictionary of movement on the page: each word, how well it finds, and where it moves."""

from __future__ import annotations

import atexit
import shutil
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

from starlette.responses import Response

from lanindex import records
from lanindex.alphabet import plain
from lanindex.model.capture import in_words
from lanindex.pipeline.files import choreographies
from lanindex.pipeline.library import Library
from lanindex.search.dictionary import Entry, entries, entry_of, load, record
from lanindex.search.hits import hits_in
from lanindex.web import watch
from lanindex.web.routes import Call

_PATIENCE = 5.0  # seconds in which the hit of a word is looked for


def listing(call: Call) -> dict[str, Any]:
    """Return all words, those of the user's file among them."""
    words, ours = load(call.site.library.words), load()
    return {
        "words": [{**record(it, words), "own": it not in entries(ours)} for it in entries(words)]
    }


def one(call: Call) -> dict[str, Any]:
    """Return a word with what its pattern says in English."""
    from lanindex.pipeline.search import query_of
    from lanindex.search.explain.english import sentence

    library, words = call.site.library, load(call.site.library.words)
    entry = entry_of(words, call.path["word"])
    said = sentence(query_of(entry.pattern, words=library.words))
    return {**record(entry, words), "own": entry not in entries(load()), "explained": said}


def example(call: Call) -> dict[str, Any]:
    """Return the clearest hit of a word in the library, or else in the bundled choreographies."""
    entry = entry_of(load(call.site.library.words), call.path["word"])
    library = call.site.library
    own: dict[str, Any] | None = call.site.kept(("word", entry), lambda: _clearest(library, entry))
    hit = own or _clearest(_bundled(), entry)
    return {"hit": hit, "bundled": hit is not None and own is None}


def figure(call: Call) -> dict[str, Any]:
    """Return the figure of a bundled choreography."""
    return watch.figure_of(_bundled(), call.path["number"])


def motion(call: Call) -> Response:
    """Return a tile of the movement of a bundled choreography."""
    return watch.tile_of(_bundled(), call.path["number"], call.path["tile"])


def _clearest(library: Library, entry: Entry) -> dict[str, Any] | None:
    found = hits_in(library.search(entry.pattern, best=1, timeout=_PATIENCE))
    if not found:
        return None
    words = [plain(it) for it in in_words(found[0].symbols)]
    return {**records.of_hit(found[0]), "words": words}


@cache
def _bundled() -> Library:
    """Return a library of the bundled choreographies: a temporary file, while the server runs."""
    folder = mkdtemp(prefix="lanindex-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    library = Library.open(Path(folder) / "choreographies.db", create=True)
    atexit.register(library.close)  # before the folder goes: the last one first
    library.ingest(*sorted(choreographies().glob("*.bvh")))
    return library
