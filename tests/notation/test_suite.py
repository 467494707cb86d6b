"""LabanotationSuite's gestures: timed positions, read as movements and written back."""

import json
from typing import Any

import pytest
from effort import examples
from hypothesis import assume, given
from random_scores import scores, shown

import lanindex
from lanindex.errors import NotationError
from lanindex.model import Score
from lanindex.notation import left_out, suite

LOW = ["Place", "Low"]
ARMS = {name: LOW for name in suite.ARMS}


def position(time: object, **says: object) -> dict[str, Any]:
    named = {name.replace("_", " "): it for name, it in says.items()}
    return {"start time": [str(time)], "duration": ["1"], "head": ["Forward", "Normal"], **ARMS,
            "rotation": ["ToLeft", "0"], **named}  # fmt: skip


def gesture(*positions: dict[str, Any]) -> bytes:
    named = {f"Position{number}": it for number, it in enumerate(positions)}
    return json.dumps({"wave": named}).encode()


def moves(score: Score) -> list[str]:
    return [
        f"{it.part} {it.words} {float(it.start / score.rate):g}-{float(it.stop / score.rate):g}"
        for it in score.symbols()
        if it.stop
    ]


def test_a_part_moves_between_positions_that_differ() -> None:
    found = suite.read(
        gesture(
            position(67),
            position("500.0", right_elbow=["Right  forward", "Normal"]),
            position(1000, right_elbow=["Right Forward", "normal"], left_wrist=["Place", "High"]),
            position(4000, right_elbow=["Left Backward", "High"], left_wrist=["Place", "High"]),
        ),
        "x",
    )
    assert moves(found) == [
        "l_forearm place high 0.5-1",
        "r_upper_arm r_forward mid 0.067-0.5",
        "r_upper_arm l_back high 1-4",
    ]
    starts = [(it.part, it.words) for it in found.symbols() if it.stop == 0]
    assert starts == [
        (part, "place low") for part in ("r_forearm", "l_forearm", "r_upper_arm", "l_upper_arm")
    ]
    assert found.warnings == ()
    assert found.frames / found.rate == 4


def test_turns_and_the_head() -> None:
    found = suite.read(
        gesture(
            position(1),
            position(500, rotation=["ToRight", "30"], head=["Forward", "Low"]),
            position(1500, rotation=["ToRight", "-30"], head=["Left Forward", "Normal"]),
            position(2500, rotation=["ToLeft", "30.0"], head=["Left Backward", "Normal"]),
        ),
        "x",
    )
    assert [it for it in moves(found) if "arm" not in it] == [
        "head forward high 0.001-0.5",
        "head place high 0.5-1.5",
        "body_turn right 30deg 0.001-0.5",
        "body_turn left 60deg 0.5-1.5",
        "head_turn left 45deg 0.5-1.5",
    ]
    assert found.warnings == ("a face that looks back or to its place: left out",)


def test_other_columns_are_left_out_with_a_word() -> None:
    found = suite.read(gesture(position(1, tail=LOW)), "x")
    assert found.warnings == ('the column "tail" is no part of the body: left out',)


LND = """\
#unit0
direction r_arm place low 0 0
direction r_forearm place low 0 0
#unit1
direction r_arm right mid 0 1
direction r_forearm place high 0 2
rotation body_turn right 90 1 2
"""

WRITTEN = """\
{
  "gesture": {
    "Position0": {"start time": ["0"], "duration": ["1"], "head": ["Forward", "Normal"], \
"right elbow": ["Place", "Low"], "right wrist": ["Place", "Low"], "left elbow": ["Place", "Low"], \
"left wrist": ["Place", "Low"], "rotation": ["ToLeft", "0"], \
"lanindex": {"left elbow": "unknown", "left wrist": "unknown"}},
    "Position1": {"start time": ["1000"], "duration": ["1"], "head": ["Forward", "Normal"], \
"right elbow": ["Right", "Normal"], "right wrist": ["Place", "High"], "left elbow": ["Place", "Low"], \
"left wrist": ["Place", "Low"], "rotation": ["ToLeft", "0"], \
"lanindex": {"right wrist": "on its way", "left elbow": "unknown", "left wrist": "unknown"}},
    "Position2": {"start time": ["2000"], "duration": ["1"], "head": ["Forward", "Normal"], \
"right elbow": ["Right", "Normal"], "right wrist": ["Place", "High"], "left elbow": ["Place", "Low"], \
"left wrist": ["Place", "Low"], "rotation": ["ToRight", "90"], \
"lanindex": {"left elbow": "unknown", "left wrist": "unknown"}},
    "Position3": {"start time": ["4000"], "duration": ["-1"], "head": ["Forward", "Normal"], \
"right elbow": ["Right", "Normal"], "right wrist": ["Place", "High"], "left elbow": ["Place", "Low"], \
"left wrist": ["Place", "Low"], "rotation": ["ToRight", "90"], \
"lanindex": {"left elbow": "unknown", "left wrist": "unknown"}}
  }
}
"""  # noqa: E501


def test_what_is_written() -> None:
    assert suite.write(lanindex.read_lnd(LND)) == WRITTEN
    assert moves(suite.read(WRITTEN.encode(), "x")) == [
        "r_forearm place high 0-2",
        "r_upper_arm right mid 0-1",
        "body_turn right 90deg 1-2",
    ]


@given(score=scores([*(part for part in suite.PARTS if part[2:] != "arm"), "r_leg"]))
@examples(150)
def test_what_is_written_is_read(score: Score) -> None:
    assume(score.rate <= 1000)  # others have ticks of less than 1 ms
    again = suite.read(suite.write(score).encode(), "x")
    wanted = shown(score)
    gone = {*left_out(score, "json"), "r_leg_bend"}
    wanted["body_turn"] = [it for it in wanted.get("body_turn", []) if it[3] < it[4]]
    wanted = {part: it for part, it in wanted.items() if it and part not in gone}
    assert shown(again) == wanted
    assert again.warnings == ()


def test_a_way_between() -> None:
    text = suite.write(lanindex.read_lnd(LND.replace("place high 0 2", "forward high 0 2")))
    at = json.loads(text)["gesture"]["Position1"]
    assert at["right wrist"] == ["Forward", "Low"]


def changed(**says: object) -> bytes:
    return gesture(position(1), position(500, **says))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "x:1: damaged JSON (Expecting value)"),
        (b"[1]", "no gesture, wanted an object with one gesture"),
        (b"{}", "0 gestures"),
        (b'{"a": {}, "b": {}}', "2 gestures"),
        (b'{"a": 1}', '"a" is no gesture'),
        (b'{"a": {"Pose1": {}}}', '"Pose1", wanted Position0'),
        (b'{"a": {"Position1": 2}}', "Position1 is no position"),
        (b'{"a": {"Position1": {}, "Position1": {}}}', '"Position1" twice in one object'),
        (b"[" * 100_000, "JSON that cannot be read"),
        (b'{"a": ' + b"1" * 9999 + b"}", "JSON that cannot be read"),
        (b"\xff\xfe\x00", "no UTF-16"),
        (changed(right_elbow=["Up", "Low"]), 'Position1, right elbow: ["Up", "Low"], wanted a dir'),
        (changed(right_elbow="Low"), '"Low", wanted a direction and a level'),
        (changed(left_wrist=[float("nan"), 2]), "[NaN, 2], wanted a direction"),
        (changed(rotation=["ToLeft", "far"]), '["ToLeft", "far"], wanted ["ToLeft", degrees]'),
        (changed(rotation=["ToLeft", "99999"]), '"left 99999deg", wanted degrees at its end'),
        (changed(start_time=["soon"]), 'x: Position1: the start time "soon", wanted millisec'),
        (changed(start_time=[float("nan")]), 'the start time "nan"'),
        (changed(start_time=["-1"]), 'the start time "-1"'),
        (changed(lanindex=3), "lanindex 3, wanted an object"),
        (gesture(position(1), position(50), position(40)), "at 0.04 s, not behind the position"),
        (gesture(position(1), position(0)), "at 0 s, not behind the position before it"),
        (changed(start_time=["86400001"]), "wanted at most 24 hours"),
    ],
)
def test_what_is_wrong_is_said(content: bytes, said: str) -> None:
    with pytest.raises(NotationError) as caught:
        suite.read(content, "x")
    assert said in str(caught.value)
    assert str(caught.value).startswith("x")
