"""After any history a library holds and answers what one clean ingest gives."""

import numpy as np
from effort import examples
from hypothesis import example, given
from hypothesis import strategies as st
from sample_library import sample_score

from lanindex.alphabet import TRACKS
from lanindex.library.migrate import check
from lanindex.library.segments import read_spine
from lanindex.model import Score, Span, Track
from lanindex.model.columns import EXTRA, Columns
from lanindex.model.symbol import blank
from lanindex.pipeline.library import Library, open_library

FILES = range(6)
PATTERNS = (
    *("arm high", "arm high never turn", "arm high or turn left", "arm high without hands touch"),
    *("head any with arm any", "clap", "jump", "arm any never step"),
)
steps = st.lists(
    st.one_of(
        st.tuples(st.just("add"), st.sampled_from(FILES), st.integers(0, 2)),
        st.tuples(st.just("remove"), st.sampled_from(FILES)),
        st.just(("gather",)),
    ),
    max_size=14,
)


def score_of(file: int, version: int) -> Score:
    """Return a score; some of its parts are seen and have no symbols, some are seen in part."""
    limbs = (("r_arm", "l_arm"), ("r_arm", "head"), ("l_arm",))[(file + version) % 3]
    made = sample_score(file + version, limbs, length=3 + file)
    always, in_part = Span(0, made.frames), Span(3, made.frames - 2)
    tracks = dict(made.tracks)
    if file % 2:
        tracks["body_turn"] = Track("body_turn", blank(0), (always,))
    if version:
        tracks["jump"] = Track("jump", blank(0), (in_part,))
    if file % 3 == 0:
        tracks["hands_touch"] = Track("hands_touch", blank(0), (always,))
    return Score(made.rate, made.frames, made.meter, tracks)


def played(library: Library, history) -> None:
    """Let a library live through a history."""
    for what, *more in history:
        path = f"{more[0]}.lnd" if more else ""
        if what == "add":
            library.store.add(path, score_of(*more), format="lnd", sha256=f"{more[0]}{more[1]:063}")
        elif what == "remove" and path in {one.path for one in library.captures()}:
            library.remove(path)
        elif what == "gather":
            library.store.cache.compact()


def told(library: Library) -> list[object]:
    """Return all columns and answers of a library, capture by capture in the order of paths."""
    paths = library.store.texts("path")
    roster, columns = library.store.columns(TRACKS, more=EXTRA)
    order = np.array(sorted(range(len(roster)), key=lambda at: paths[roster.number[at]]), np.int64)
    found: list[object] = [sorted(paths.values())]
    for part in TRACKS:
        own = columns[part].at(order)
        found += [
            (part, name, getattr(own, name).tolist()) for name in ("bounds", "seen", *own.rows)
        ]
    for pattern in PATTERNS:
        hits = library.search(pattern)
        found.append(sorted((hit.capture.path, hit.span.start, hit.span.stop) for hit in hits))
    return found


@examples(60)
@given(history=steps)
@example(history=[("add", 1, 0), ("gather",), ("add", 1, 0), ("gather",)])
@example(history=[step for file in FILES for step in (("add", file, 0), ("gather",))])
@example(history=[("add", 3, 1), ("gather",), ("add", 2, 0), ("gather",), ("remove", 3)])
def test_any_history_gives_what_a_clean_ingest_gives(tmp_path_factory, history):
    folder = tmp_path_factory.mktemp("history")
    with open_library(folder / "lived.db", create=True) as lived:
        played(lived, history)
        held = {}
        for what, *more in history:
            held.pop(more[0] if more else None, None)
            if what == "add":
                held[more[0]] = more[1]
        with open_library(folder / "clean.db", create=True) as clean:
            played(clean, [("add", *one) for one in sorted(held.items())])
            clean.store.cache.compact()
            assert told(lived) == told(clean)
    assert check(folder / "lived.db") == check(folder / "clean.db") == []


def test_segments_that_list_parts_without_symbols_say_the_same(tmp_path, monkeypatch):
    """Earlier versions listed such a part, and dropped it when they joined segments."""
    history = [("add", file, 0) for file in FILES]
    with open_library(tmp_path / "now.db", create=True) as now:
        played(now, history)
        now.store.cache.compact()
        with (
            monkeypatch.context() as patched,
            open_library(tmp_path / "then.db", create=True) as then,
        ):
            patched.setattr(Columns, "blank", False)
            played(then, history)
            then.store.cache.compact()
            with then.store.session.reading() as connection:
                assert "body_turn" in read_spine(connection).segments[0].parts
        with open_library(tmp_path / "then.db") as then:
            assert told(then) == told(now)
    assert check(tmp_path / "then.db") == []
