"""Pages that we draw are read back: the score that was drawn, or what is not known is told."""

import sys
from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path

import command
import numpy as np
import pytest

import lanindex
from lanindex.notation import lnd

cv2 = pytest.importorskip("cv2")
sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))

from printed_page import clean, scribbled  # noqa: E402
from reader import matched, wrong  # noqa: E402
from reader_pages import made  # noqa: E402

from lanindex.reader.score import Read, Record, joined, read_signs, score_of  # noqa: E402

CORPUS = Path(lanindex.__file__).parents[1] / "corpus"


def shares(seeds: Iterable[int], damage: str = "clean") -> tuple[float, float]:
    """Return the share of signs on made pages that are read rightly, and of false ones."""
    right = signs = false = 0
    for seed in seeds:
        page = made(seed, damage)
        signs += len(page.truth)
        for sign, found in matched(page.truth, read_signs(page.image).records):
            right += bool(sign and found and not {*wrong(sign, found)} - {"amount"})
            false += sign is None
    return right / signs, false / signs


def test_signs_of_clean_pages_are_read() -> None:
    right, false = shares(range(3, 9))
    assert right > 0.985
    assert false < 0.01


def test_thin_lines_and_signs_without_gaps_are_read_on_blurred_pages() -> None:
    right, false = shares((9, 20), "hard")  # symbols are 15 pixels wide
    assert right > 0.95
    assert false < 0.02


def test_what_is_only_paper_is_no_sign() -> None:
    page = read_signs(clean())  # nothing is inside its staff
    assert {it.part for it in page.records} == {"l_arm", "r_arm"}
    assert page.unknown == []


def test_a_score_that_was_drawn_is_the_score_that_is_read(tmp_path: Path) -> None:
    command.run("score", str(CORPUS / "compass.lnd"), "-o", "page.png", cwd=tmp_path)
    done = command.run("read-score", "page.png", cwd=tmp_path)
    assert done.returncode == 0
    assert "page.lnd: 28 signs, 0 more not known" in done.stderr
    drawn, read = lnd.read(CORPUS / "compass.lnd"), lnd.read(tmp_path / "page.lnd")
    names = ["tick", "ticks", "direction", "level"]
    assert drawn.meter.beats == read.meter.beats == 4
    scale = drawn.meter.division // 4, read.meter.division // 4
    for own, other in zip(drawn.tracks["r_arm"].symbols, read.tracks["r_arm"].symbols, strict=True):
        assert [own[it] for it in names[2:]] == [other[it] for it in names[2:]]
        assert [own[it] / scale[0] for it in names[:2]] == [
            other[it] / scale[1] for it in names[:2]
        ]


def test_pages_follow_each_other(tmp_path: Path) -> None:
    page = read_signs(made(3).image)
    score = score_of([page, page], Fraction(60))
    whole = [it for it in page.records if it.end > 0]
    assert len(score.tracks["r_arm"]) == len(page.records) + len(whole)


def test_what_is_not_known_is_told(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "page.png"), scribbled())
    done = command.run("read-score", "page.png", cwd=tmp_path)
    assert done.returncode == 1
    assert "l_arm, count 4" in done.stderr


@pytest.mark.parametrize("seed", [8, 10, 13, 26])  # twists, repeats, inclines, bends
def test_what_is_read_is_read_back_from_lnd(seed: int) -> None:
    page = read_signs(made(seed).image)
    written = lnd.read(lnd.write(score_of([page], Fraction(60))), place="LND")
    symbols = [it for part in written.tracks for it in written.symbols(part) if part != "step"]
    told = sorted((it.part, it.direction, it.level, it.amount) for _, it in joined([page]))
    kept = sorted((it.part, it.direction, it.level, it.amount) for it in symbols)
    assert [it[:3] for it in kept] == [it[:3] for it in told]
    assert {it[3] for it in told if "bend" in it[0] or "twist" in it[0]} <= {it[3] for it in kept}


def record(kind: str, way: str | None, start: float, end: float) -> Record:
    level = "mid" if way else None
    return Record(0, "r_arm", kind, way, level, None, start, end, 0.9, (0, 0, 1, 1))


@pytest.mark.parametrize(
    ("before", "repeat", "expected"),
    [
        ("right 0 1, left 1 2", (2, 6), "right 2 3, left 3 4, right 4 5, left 5 6"),
        ("right 0 0.5, left 0.5 1", (1, 2.75), "right 1 2, left 2 2.75"),
        ("right 0 0, left 0 1", (1, 3), "left 1 2, left 2 3"),  # not the starting position
        ("right 0 0", (1, 3), "right 1 3"),  # as it was
        ("right 0 1, left 2 3", (3, 5), "left 3 4, left 4 5"),  # not what is before a pause
        ("right 0 1, left 1 4", (4, 5), "right 4 4.25, left 4.25 5"),  # in less time
        ("right 0 1, left 1 2, right 6 7", (3, 5), "right 3 4, left 4 5"),
    ],
)
def test_a_repeat_is_written_out(before: str, repeat: tuple[float, float], expected: str) -> None:
    own = [it.split() for it in before.split(", ")]
    signs = [record("gesture", it[0], float(it[1]), float(it[2])) for it in own]
    page = Read([*signs, record("again", None, *repeat)], [], 4, 8, [])
    found = [it for _, it in joined([page])]
    assert found[: len(signs)] == signs
    told = [f"{it.direction} {it.start:g} {it.end:g}" for it in found[len(signs) :]]
    assert ", ".join(told) == expected


def test_a_repeat_may_stand_for_what_is_on_the_page_before() -> None:
    first = Read([record("gesture", "right", 2, 3), record("gesture", "left", 3, 4)], [], 4, 4, [])
    position, repeat = record("gesture", "left", 0, 0), record("again", None, 0, 2)
    found = [*joined([first, Read([position, repeat], [], 4, 4, [])])]
    told = [(number, it.direction, it.start, it.end) for number, it in found[2:]]
    assert told == [(1, "right", 4, 5), (1, "left", 5, 6)]


def test_a_repeat_in_a_column_of_a_later_page_alone_is_its_position() -> None:
    position, repeat = record("gesture", "left", 0, 0), record("again", None, 0, 2)
    found = [*joined([Read([], [], 4, 4, []), Read([position, repeat], [], 4, 4, [])])]
    assert [(it.direction, it.start, it.end) for _, it in found] == [("left", 4, 6)]


def test_repeats_of_a_page_are_read() -> None:
    page = read_signs(made(10).image)  # has two
    repeats = [it for it in page.records if it.kind == "again"]
    assert [(it.start, it.end) for it in repeats] == [(9.25, 10.75), (11.25, 11.75)]
    rows = score_of([page], Fraction(60)).tracks["l_arm"].symbols
    assert not (rows["direction"] < 0).any()


@pytest.mark.parametrize("kind", ["blank", "none", "text"])
def test_what_is_no_score_is_refused(tmp_path: Path, kind: str) -> None:
    if kind == "blank":
        cv2.imwrite(str(tmp_path / "page.png"), np.full((900, 700), 255, np.uint8))
    elif kind == "text":
        (tmp_path / "page.png").write_text("no picture")
    done = command.run("read-score", "page.png", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("lanindex: page.png: ")
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "page.lnd").exists()


WIDE = """\
#speed=60
#rhythm 4/4
#unit_total 2
#unit0
direction r_arm place low 0 0
direction l_arm place low 0 0
#unit1
direction r_support forward mid 0 1
direction r_leg right low 1 2
incline torso_incline forward 30 0 2
direction r_arm right mid 0 1
bend r_arm_bend bend3 1 2
direction r_hand right high 0 1
twist head_turn left 45 0 2
incline head_incline right 60 0 2
turn body_turn left 90 0 3
travel body_travel forward 10 2 4
#unit2
direction l_arm left mid 0 1
"""


def test_degrees_that_are_no_multiples_of_15_are_read(tmp_path: Path) -> None:
    (tmp_path / "wide.lnd").write_text(WIDE.replace("left 45 0 2", "left 37 0 2"))
    command.run("score", "wide.lnd", "-o", "page.png", cwd=tmp_path)
    command.run("read-score", "page.png", cwd=tmp_path)
    amounts = lnd.read(tmp_path / "page.lnd").tracks["head_turn"].symbols["amount"]
    assert 37 in amounts


def test_columns_far_from_the_staff_are_read(tmp_path: Path) -> None:
    (tmp_path / "wide.lnd").write_text(WIDE)
    command.run("score", "wide.lnd", "-o", "page.png", cwd=tmp_path)
    command.run("read-score", "page.png", cwd=tmp_path)
    drawn, read = (lnd.read(tmp_path / name).tracks for name in ("wide.lnd", "page.lnd"))
    names = ["direction", "level"]
    for part, track in drawn.items():
        assert read[part].symbols[names].tolist() == track.symbols[names].tolist()


@pytest.mark.parametrize(
    "signs",
    [
        ["place low 0 2", "place low 2 4"],  # long ones: there is little else than ink
        ["l_forward low 0 1", "right mid 1 3", "place low 3 4"],  # also where a staff ends
    ],
)
def test_low_signs_that_meet_are_read_as_two(tmp_path: Path, signs: list[str]) -> None:
    lines = ["#speed=60", "#rhythm 4/4", "#unit_total 6", "#unit0", "direction r_arm left mid 0 0"]
    for bar in range(6):
        lines += [f"#unit{bar + 1}", *(f"direction r_arm {it}" for it in signs)]
    (tmp_path / "low.lnd").write_text("\n".join(lines))
    command.run("score", "low.lnd", "-o", "page.png", "--bars", "2", cwd=tmp_path)
    command.run("read-score", "page.png", cwd=tmp_path)
    names = ["direction", "level", "start", "stop"]
    drawn, read = (lnd.read(tmp_path / it).tracks["r_arm"] for it in ("low.lnd", "page.lnd"))
    assert read.symbols[names].tolist() == drawn.symbols[names].tolist()
