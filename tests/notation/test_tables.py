"""Scores as tables: CSV, JSON lines and Parquet hold what ``show --json`` has."""

import csv
import json
import sys
from fractions import Fraction
from io import BytesIO

import numpy as np
import pytest
from effort import examples
from hypothesis import given
from random_scores import scores

import lanindex
from lanindex import records
from lanindex.errors import ExportError, NotationError
from lanindex.model import Capture, Meter, Score, Span, Track
from lanindex.model.symbol import blank
from lanindex.notation import TABLES, read, tables, write
from lanindex.notation.tables import rows_in

NAMES = [it.name for it in TABLES.values()]
KEPT = ("direction", "level", "start", "stop", "passing", "swings", "amount", "size",
        "runner_direction", "runner_level")  # fmt: skip
ROUNDED = {"margin": 0.0005, "speed": 0.005, "straightness": 0.005}


def assert_same(again: Score, score: Score) -> None:
    wanted = {part: track for part, track in score.tracks.items() if len(track)}
    assert again.tracks.keys() == wanted.keys()
    assert again.rate == score.rate or not wanted
    for part, track in wanted.items():
        found = again.tracks[part]
        assert [one.start for one in found.known] == [one.start for one in track.known]
        for name in KEPT:
            assert np.array_equal(found.symbols[name], track.symbols[name]), (part, name)
        for name, most in ROUNDED.items():
            assert np.allclose(found.symbols[name], track.symbols[name], atol=most + 1e-6)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("source", ["jumping_jacks", "semaphore", "marching"])
def test_a_capture_comes_back_frame_by_frame(name: str, source: str) -> None:
    score = lanindex.encode(lanindex.read(f"corpus/{source}.bvh"))
    again = read(f"x.{name}", write(score, name))
    assert_same(again, score)
    assert again.frames == score.frames
    assert_same(read(f"x.{name}", write(again, name)), score)


@pytest.mark.parametrize("name", NAMES)
@given(score=scores())
@examples(30)
def test_any_score_comes_back(name: str, score: Score) -> None:
    score = Score(Fraction("59.94006"), score.frames, score.meter, score.tracks)
    assert_same(read(f"x.{name}", write(score, name)), score)


def test_columns_are_those_of_show() -> None:
    score = lanindex.read_lnd("corpus/compass.lnd")
    capture = Capture(7, "compass.lnd", "lnd", "", "", score.rate, score.frames)
    rows = list(rows_in(capture, score.tracks))
    assert rows == [records.of_row(capture, it) for it in score.symbols()]
    assert all(list(row) == list(tables.COLUMNS) for row in rows)
    lines = write(score, "symbols.jsonl").decode().splitlines()
    nobody = {"capture": None, "capture_id": None}
    assert [json.loads(line) for line in lines] == [{**row, **nobody} for row in rows]
    first, second, *_ = csv.reader(write(score, "symbols.csv").decode().splitlines())
    assert dict(zip(first, second, strict=True))["passing"] == "false"


@pytest.mark.parametrize("name", NAMES)
def test_an_empty_score(name: str) -> None:
    again = read(f"x.{name}", write(Score(Fraction(8), 32, Meter(), {}), name))
    assert again.tracks == {}


def test_one_frame() -> None:
    rows = blank(1)
    rows["direction"], rows["level"] = 0, 0
    score = Score(Fraction(30), 1, Meter(), {"r_arm": Track("r_arm", rows, (Span(0, 1),))})
    for name in NAMES:
        assert_same(read(f"x.{name}", write(score, name)), score)


def test_rows_in_any_order_and_columns_of_others() -> None:
    text = "end_frame,start_frame,level,mood,part,fps,direction\n"
    text += "30,20,high,,r_arm,60.0,right\n9.0,0,low,sad,r_arm,60,place\n\n0,0,mid,,l_arm,60,left\n"
    score = read("x.symbols.csv", text.encode("utf-8-sig"))
    assert [str(it) for it in score.symbols()] == [
        *("r_arm place low [0, 9)", "r_arm right high [20, 30)"),
        "l_arm left mid [0, 0)",
    ]
    assert (score.rate, score.frames) == (60, 30)


GOOD = {"part": "r_arm", "direction": "right", "level": "mid", "fps": 60, "start_frame": 0,
        "end_frame": 20}  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"part": None}, "row 1: no part, wanted the columns part, fps, start_frame"),
        ({"fps": None}, "no fps"),
        ({"fps": 0}, "0 frames a second, wanted more than 0"),
        ({"fps": 1e-30}, "1e-30 frames a second, wanted a rate whose ticks have room"),
        ({"part": "R Arm"}, 'the part "R Arm", wanted one like r_arm'),
        ({"part": 7}, 'part "7", wanted a text'),
        ({"direction": "up"}, 'the direction "up" of r_arm, wanted right r_forward'),
        ({"direction": None}, 'the direction "None" of r_arm'),
        ({"level": "middle"}, 'the level "middle" of r_arm, wanted low mid high'),
        ({"part": "body_turn", "amount": 90}, 'the level "mid" of body_turn, wanted none of a t'),
        ({"part": "jump", "level": None}, "the amount None of jump, wanted 0 to 5"),
        ({"amount": 7}, "the amount 7 of r_arm, wanted 0 to 6"),
        ({"amount": 1e300}, 'amount "1e+300", wanted a whole number'),
        ({"end_frame": 20.5}, 'end_frame "20.5", wanted a whole number'),
        ({"end_frame": -1}, "frames 0 to -1, wanted from 0, and an end behind it"),
        ({"start_frame": 30}, "frames 30 to 20"),
        ({"end_frame": 1 << 31}, "frames 0 to 2147483648"),
        ({"passing": "perhaps"}, 'passing "perhaps", wanted true or false'),
        ({"margin": 2}, "margin 2, wanted 0 to 1"),
        ({"margin": "far"}, 'margin "far", wanted a number'),
        ({"swings": -1}, "swings -1, wanted 0 to"),
    ],
)
@pytest.mark.parametrize("form", ["csv", "jsonl"])
def test_what_is_wrong_is_said(changes: dict[str, object], said: str, form: str) -> None:
    row = {**GOOD, **changes}
    if form == "csv":
        if isinstance(changes.get("part"), int):
            pytest.skip("all of a CSV is text")
        values = ",".join("" if it is None else str(it) for it in row.values())
        content = f"{','.join(row)}\n{values}\n"
    else:
        content = json.dumps(row) + "\n"
    with pytest.raises(NotationError) as caught:
        read(f"x.symbols.{form}", content.encode())
    place = "x.symbols.csv:2" if form == "csv" else "x.symbols.jsonl:1"
    assert said.replace("row 1", place) in str(caught.value)


@pytest.mark.parametrize(
    ("form", "content", "said"),
    [
        ("csv", "", "no column part, wanted a line of names, as capture"),
        ("csv", "part,start_frame,part\n", "the column part twice, wanted each once"),
        ("csv", "part,start_frame\nr_arm\n", "x.symbols.csv:2: 1 values, wanted 2, as in"),
        ("csv", 'part,start_frame\n"r\n' + "a" * 200_000, "field larger"),
        ("csv", "\0", "binary data"),
        ("jsonl", "{}\n", "x.symbols.jsonl:1: no part"),
        ("jsonl", "[1]\n", "[1], wanted an object a line"),
        ("jsonl", "\n\n{", "x.symbols.jsonl:3: damaged JSON"),
        ("jsonl", "[" * 100_000, "damaged JSON"),
        ("jsonl", '{"part": "r_arm", "part": "head"}', '"part" twice in one object'),
        ("parquet", "PAR1", "damaged Parquet"),
    ],
)
def test_damage_is_said(form: str, content: str, said: str) -> None:
    with pytest.raises(NotationError) as caught:
        read(f"x.symbols.{form}", content.encode())
    assert said in str(caught.value)


def rows(*changes: dict[str, object]) -> bytes:
    return "".join(json.dumps({**GOOD, **it}) + "\n" for it in changes).encode()


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (rows({}, {"start_frame": 19, "end_frame": 30}), ":2: r_arm from frame 19, where one from"),
        (rows({}, {}), "where one from 0 is not over, wanted one at a time"),
        (rows({}, {"fps": 30}), "fps 60.0 and 30.0, wanted one score"),
        (rows({"capture": "a"}, {"capture": "b"}), "capture a and b, wanted one score"),
    ],
)
def test_rows_that_do_not_belong_together(content: bytes, said: str) -> None:
    with pytest.raises(NotationError, match=said):
        read("x.symbols.jsonl", content)


def test_without_pyarrow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    score = lanindex.read_lnd("corpus/compass.lnd")
    with pytest.raises(ExportError, match=r"pyarrow is not installed.*lanindex\[tables\]"):
        write(score, "symbols.parquet")
    with pytest.raises(NotationError, match="pyarrow is not installed"):
        read("x.symbols.parquet", b"")


def test_groups_of_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    from pyarrow import parquet

    monkeypatch.setattr(tables, "GROUP", 10)
    score = lanindex.read_lnd("corpus/compass.lnd")
    content = write(score, "symbols.parquet")
    file = parquet.ParquetFile(BytesIO(content))
    assert (file.num_row_groups, file.metadata.num_rows) == (3, 28)
    assert_same(read("x.symbols.parquet", content), score)
