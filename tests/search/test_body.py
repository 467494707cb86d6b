"""Steps, jumps, travels and turns in patterns, beyond the cases of the page."""

from dataclasses import replace

import numpy as np
import pytest
from fast_search import find_fast
from plain_matcher import find
from query_cases import recordings_of, track
from sample_library import ENCODING

from lanindex.alphabet import DIRECTIONS
from lanindex.errors import PatternError, UsageError
from lanindex.library.store import Store
from lanindex.model import Span
from lanindex.model.derived import steps
from lanindex.pipeline.library import open_library
from lanindex.pipeline.search import entry_of_query
from lanindex.search.dictionary import load
from lanindex.search.explain.english import sentence
from lanindex.search.explain.why import away
from lanindex.search.language import parse

TEXT = (
    "fps 10 frames 60; step: place mid 0 0, forward mid 5 10, left low 10 20; "
    "jump: place spring 20 25, forward leap 30 33; "
    "body_travel: forward 10 0 25, place 0 25 60; body_turn: left 90 40 50, right 180 50 60"
)

SENTENCES = {
    "hands touch <0.3s": "The hands touch each other, for less than 0.3 s.",
    "r_hand touch head/trunk 1s+ -> knee": (
        "The right hand touches the head or the trunk, for at least 1 s, then touches a knee."
    ),
    "hand_touches knee -> hold": "Both hands touch a knee, then touch nothing.",
    "hand touch via foot": "Either hand touches, if only in passing, a foot.",
    "other support knee/seat": "The body rests on a knee or on the seat.",
    "turn left 90deg": "The body turns to the left, by 68 to 112 degrees.",
    "turn 360deg+ -> right <=90deg": (
        "The body turns by 360 degrees or more, then turns to the right, by 90 degrees or less."
    ),
    "jump hop/leap forward <0.3s": (
        "The body jumps from one foot to the same or from one foot to the other, forward, "
        "for less than 0.3 s."
    ),
    "jump": "The body jumps.",
    "travel forward circling": (
        "The body travels forward, on a way that curves by 45 degrees or more."
    ),
    "travel via side": "The body travels, if only in passing, to either side.",
    "torso twist left 45deg -> place": (
        "The torso twists to the left, by 23 to 67 degrees (or begins there), then twists in place."
    ),
    "head turn at right >60deg 2s+": (
        "The head is to the right, by 61 degrees or more, for at least 2 s."
    ),
    "incline forward >40deg -> hold": (
        "The torso inclines forward, by 41 degrees or more (or begins there), "
        "then stays where it is."
    ),
    "r_stance 2s+ without l_stance": (
        "The right foot holds weight, for at least 2 s; and in the meantime never: the left foot "
        "holds weight."
    ),
    "stances low": "Both feet together hold weight low.",
    "step place low -> at left": ("A foot steps in place, low, then is to the left."),
}


@pytest.mark.parametrize("text", SENTENCES)
def test_a_query_in_english(text: str) -> None:
    assert sentence(parse(text)) == SENTENCES[text]


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("Body Travel Forward 2s+", "body_travel forward 2s+"),
        ("travel left", "body_travel left"),
        ("turn 90deg left", "body_turn 90deg left"),
        ("turn not 45deg..90deg/180deg", "body_turn not 45deg..90deg/180deg"),
        (
            "mirror(turn right >180deg -> body turn left)",
            "(body_turn left >180deg -> body_turn right)",
        ),
        ("mirror(jump r_forward leap)", "(jump l_forward leap)"),
        ("mirror(step side_forward)", "(step side_forward)"),
        ("rotation body_turn left 90 1 2", "body_turn left 90deg"),
        ("Torso Twist left", "torso_twist left"),
        ("mirror(head turn left -> twist place)", "(head_turn right -> torso_twist place)"),
        ("head incline r_forward 30deg", "head_incline r_forward 30deg"),
        ("jump jump forward leap 0 1", "jump forward leap"),
        ("Right Hand Touch Knees", "r_hand_touch knee"),
        ("mirror(r_hand touch head)", "(l_hand_touch head)"),
        ("touch hands_touch hand 0 1", "hands_touch hand"),
        ("mirror(right palm forward/l_forward)", "(l_palm forward/r_forward)"),
        ("carrier other_support seat 0 1", "other_support seat"),
    ],
)
def test_what_is_read_is_printed(text: str, printed: str) -> None:
    assert str(parse(text)) == printed
    assert str(parse(printed)) == printed


def test_a_pasted_score_of_the_whole_body() -> None:
    lines = (
        "#speed=60",
        "#unit1",
        "support r_support forward mid 0 1",
        "support l_support forward low 1 2",
        "jump jump place spring 2 2.5",
        "rotation body_turn left 90 3 5",
        "travel body_travel forward 50 0 2",
    )
    assert str(parse("\n".join(lines))) == (
        "r_support forward mid with l_support forward low with jump place spring "
        "with body_turn left 90deg with body_travel forward 50deg"
    )
    with pytest.raises(PatternError, match="has five words behind rotation: part direction degr"):
        parse("rotation body_turn left 90 3")


@pytest.mark.parametrize("name", ["step", "jump", "turn", "travel", "hop", "spring"])
def test_what_is_said_of_the_body_may_be_a_name(name: str, tmp_path) -> None:
    text = f"{name}: r_arm high -> b: low where b.start - {name}.end < 1s"
    assert str(parse(text)) == text
    assert str(parse(f"let {name} = high; r_arm low -> @{name}")) == "r_arm low -> (high)"
    own = tmp_path / "own.toml"
    own.write_text(f'[{name}]\npattern = "r_arm high"\nsentence = "Up."\n')
    assert load(own)[name].pattern == "r_arm high"


def test_a_jump_wants_its_part_named() -> None:
    with pytest.raises(PatternError, match="Name the part first: jump hop"):
        parse("hop")


@pytest.fixture
def library(tmp_path):
    (recording,) = recordings_of(TEXT)
    with Store.open(tmp_path / "body.db", create=True) as store:
        for number in range(3):
            said = {"format": "bvh", "sha256": f"{number:064}", "encoding": ENCODING}
            store.add(f"{number}.bvh", recording.score(), **said)
    with open_library(tmp_path / "body.db") as found:
        yield found


def test_a_library_is_asked_for_what_the_body_does(library) -> None:
    assert library.parts() == ["step", "jump", "body_travel", "body_turn"]
    hits = library.search("turn >90deg with travel place")
    assert [(hit.span.start, hit.span.stop) for hit in hits] == [(25, 60)] * 3
    assert [str(it) for it in hits[0].symbols] == [
        "body_turn right 180deg [50, 60)",
        "body_travel place [25, 60)",
    ]
    assert len(library.search("jump leap")) == 3
    assert len(library.search("step left low where match.level = low")) == 3


@pytest.mark.parametrize("search", [find, find_fast])
def test_a_way_is_asked_for_its_speed_and_what_is_beside_it(search) -> None:
    (recording,) = recordings_of("fps 10 frames 60; body_travel: forward 0 0 25, forward 5 30 60")
    rows = recording.tracks["body_travel"].symbols.copy()
    rows["speed"], rows["runner_direction"] = [1.5, 4.25], [DIRECTIONS.index("l_forward"), -1]
    tracks = {"body_travel": replace(recording.tracks["body_travel"], symbols=rows)}

    def spans(text: str) -> list[tuple[int, int]]:
        hits = search(parse(text), [(recording.capture, tracks)], overlaps="all")
        return [(hit.span.start, hit.span.stop) for hit in hits]

    assert spans("travel where match.speed > 4") == [(30, 60)]
    assert spans("a: travel where a.else = l_forward and a.speed < 2") == [(0, 25)]
    assert spans("a: travel -> b: travel where a.else = b.direction") == []


def test_a_fuzzy_search_has_no_edits_of_amounts(library) -> None:
    assert len(library.search("turn left -> right", fuzzy="1")) == 3
    with pytest.raises(UsageError, match="in the feet of a jump, degrees of turns and bends, what"):
        library.search("turn left 90deg -> right", fuzzy="1")


def test_nothing_that_the_body_does_makes_captures_alike(library) -> None:
    assert library.similar().groups == []


def test_how_near_a_turn_comes_to_what_is_asked() -> None:
    (_, symbol) = track("body_turn", "left 90 0 5, right 90 5 9", 10).listed()
    assert away(symbol, parse("turn right 90deg").pattern.alternatives[0].first.items[0].unit) == 0
    assert away(symbol, parse("turn right 180deg").pattern.alternatives[0].first.items[0].unit) == 1


def test_the_steps_of_both_feet() -> None:
    steps_right = "place mid 0 0, forward mid 4 8, place mid 30 30, back mid 32 35"
    right = track("r_support", steps_right, 40)
    left = track("l_support", "place low 0 0, left mid 2 5, place mid 30 30", 40)
    known = (Span(0, 20), Span(30, 40))
    right, left = (type(it)(it.part, it.symbols, known) for it in (right, left))
    both = steps([right, left])
    assert (both.part, both.kind, both.known) == ("step", "step", known)
    assert [str(it) for it in both.listed()] == [
        "step left mid [2, 5)",
        "step forward mid [4, 8)",
        "step back mid [32, 35)",
    ]


@pytest.mark.parametrize(
    ("feet", "left"),
    [("spring", 2), ("hop", 2), ("assemble", 2), ("leap", 3), ("sissonne", 3), ("unseen", 3)],
)
def test_where_a_jump_lands(feet: str, left: int) -> None:
    own = track(
        "r_support", "place mid 0 0, forward mid 4 10, forward mid 10 18, left mid 18 20", 40
    )
    jump = track("jump", f"forward {feet} 12 17", 40)
    assert len(steps([own], jump)) == left


def test_the_steps_of_feet_that_are_not_seen_at_the_same_time() -> None:
    right = track("r_support", "place mid 0 0, forward mid 4 8", 40, (Span(0, 20),))
    left = track("l_support", "place mid 10 10, left mid 12 15", 40, (Span(10, 40),))
    both = steps([right, left])
    assert both.known == (Span(0, 40),)
    assert np.array_equal(both.symbols["start"], [4, 12])
    assert steps([left]).known == left.known


def test_what_the_body_does_recurs(library) -> None:
    motifs = library.motifs(min_count=3, length=2).found
    found = {motif.pattern for motif in motifs}
    assert found == {
        "step place mid -> forward mid -> left low",
        "jump place -> forward",
        "body_travel forward -> place",
        "body_turn left -> right",
    }
    assert all(len(library.search(pattern)) == 3 for pattern in found)


def test_a_bare_name_is_the_track(tmp_path, monkeypatch) -> None:
    own = tmp_path / "own.toml"
    own.write_text('[jump]\npattern = "r_arm high"\nsentence = "Up."\n')
    assert entry_of_query("jump") is entry_of_query("turn") is None
    assert (
        entry_of_query("jump", own).pattern == entry_of_query("@jump", own).pattern == "r_arm high"
    )
    monkeypatch.setattr("lanindex.pipeline.search.load", lambda words=None: load(own))
    assert entry_of_query("jump") is None
    assert entry_of_query("@jump").pattern == "r_arm high"


@pytest.mark.parametrize("search", [find, find_fast])
def test_no_arrow_and_no_rest_crosses_a_gap_of_what_just_happens(search) -> None:
    (recording,) = recordings_of("fps 10 frames 60; jump: place hop 2 5")
    known = (Span(0, 20), Span(30, 55))
    turns = track("body_turn", "left 90 5 10, right 45 12 18, left 90 32 40", 60, known)
    ways = track("body_travel", "left 0 0 20, left 0 30 50", 60, known)
    tracks = {**recording.tracks, "body_turn": turns, "body_travel": ways}

    def spans(text: str) -> list[tuple[int, int]]:
        hits = search(parse(text), [(recording.capture, tracks)], overlaps="all")
        return [(hit.span.start, hit.span.stop) for hit in hits]

    assert spans("turn left -> right") == [(5, 18)]
    assert spans("turn right ... left") == spans("travel left x2") == []
    assert spans("turn right -> left 90deg") == []
    assert spans("turn hold") == [(10, 12), (18, 20), (40, 55)]
    assert spans("start -> turn left") == [(5, 10)]
    assert spans("turn -> end") == []
    assert spans("jump ... turn") == [(2, 10)]
    assert spans("travel with travel") == []
