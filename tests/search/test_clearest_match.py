"""Which of several matches is the hit: the clearest of those that end first and begin last."""

from plain_matcher import find
from query_cases import recordings_of

from lanindex.model import Hit, Track
from lanindex.search.language import parse


def hits(text: str, tracks: str, **margins: list[float]) -> list[Hit]:
    """Find a pattern in tracks, some of whose symbols are less clear than others."""
    (recording,) = recordings_of(f"fps 10 frames 100; {tracks}")
    marked = dict(recording.tracks)
    for part, track in recording.tracks.items():
        symbols = track.symbols.copy()
        symbols["margin"] = margins.get(part, 1)
        marked[part] = Track(part, symbols, track.known)
    return list(find(parse(text), [(recording.capture, marked)]))


def told(hit: Hit) -> list[str]:
    return [f"{symbol.part}.{symbol.ordinal}" for symbol in hit.symbols]


ARM = "r_arm: place low 0 0, right mid 5 10, forward mid 12 18, place high 20 30, place low 60 70"


def test_of_ways_that_span_the_same_the_clearest_is_told():
    for margins in ([1, 0.5, 0.25, 0.75, 1], [1, 0.25, 0.5, 0.75, 1]):
        (hit,) = hits("r_arm low ... mid ... high", ARM, r_arm=margins)
        assert hit.fit == 0.5
        assert told(hit) == ["r_arm.0", f"r_arm.{margins.index(0.5)}", "r_arm.3"]


def test_how_clear_the_lines_beside_are_counts_too():
    other = "l_arm: place low 0 0, left mid 32 38, left high 40 44, left mid 46 50"
    text = "r_arm at high with l_arm mid"
    for margins in ([1, 0.5, 1, 0.25], [1, 0.25, 1, 0.5]):
        (hit,) = hits(text, f"{ARM}; {other}", l_arm=margins)
        assert (hit.start, hit.stop, hit.fit) == (29, 60, 0.5)
        assert told(hit) == ["r_arm.3", f"l_arm.{margins.index(0.5)}"]


def test_an_earlier_end_and_a_later_start_come_first():
    (hit,) = hits("r_arm low ... mid", ARM, r_arm=[1, 0.25, 1, 1, 1])
    assert (told(hit), hit.fit) == (["r_arm.0", "r_arm.1"], 0.25)
    other = "l_arm: place low 0 0, left mid 15 22, left high 26 35"
    (hit,) = hits("r_arm high with l_arm any", f"{ARM}; {other}", l_arm=[1, 1, 0.25])
    assert (told(hit), hit.fit) == (["r_arm.3", "l_arm.1"], 1)


def test_of_ways_as_clear_as_each_other_the_one_of_most_steps_is_told():
    (hit,) = hits("r_arm any x1..3 ... high", ARM)
    assert told(hit) == ["r_arm.0", "r_arm.1", "r_arm.2", "r_arm.3"]


def test_labels_name_symbols_with_the_frames_of_their_steps():
    other = "l_arm: place low 0 0, left mid 32 38"
    text = "a: (r_arm mid -> mid) -> b: high -> c: hold -> low with d: l_arm any"
    (hit,) = hits(text, f"{ARM}; {other}")
    assert {name: [str(it) for it in symbols] for name, symbols in hit.labels.items()} == {
        "a": ["r_arm right mid [5, 10)", "r_arm forward mid [12, 18)"],
        "b": ["r_arm place high [20, 30)"],
        "c": ["r_arm place high [30, 60)"],
        "d": ["l_arm left mid [32, 38)"],
    }
    (hit,) = hits("a: r_arm at mid -> b: mid? -> high", ARM)
    assert {name: [str(it) for it in symbols] for name, symbols in hit.labels.items()} == {
        "a": ["r_arm right mid [9, 20)", "r_arm forward mid [9, 20)"],
    }
