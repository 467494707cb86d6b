"""The dictionary of movement on the page: each word, how well it finds, and where it moves."""

from __future__ import annotations

from typing import Any

from lanindex import records
from lanindex.model.capture import in_words
from lanindex.search.dictionary import Entry, entries, entry_of, load, record
from lanindex.search.hits import hits_in
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
    """Return the clearest hit of a word in the library; null where it has none."""
    entry = entry_of(load(call.site.library.words), call.path["word"])
    found: dict[str, Any] = call.site.kept(("word", entry), lambda: _example(call, entry))
    return found


def _example(call: Call, entry: Entry) -> dict[str, Any]:
    library = call.site.library
    found = hits_in(library.search(entry.pattern, best=1, timeout=_PATIENCE))
    if not found:
        return {"hit": None}
    (hit,) = found
    return {"hit": {**records.of_hit(hit), "words": in_words(hit.symbols)}}
