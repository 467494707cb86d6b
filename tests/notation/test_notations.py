"""Laws of every notation: written scores read back equal, bad ones are refused."""

from contextlib import suppress
from pathlib import Path

import pytest
from effort import examples
from hypothesis import assume, given
from hypothesis import strategies as st
from random_scores import scores, shown

import lanindex
from lanindex.alphabet import BODY
from lanindex.errors import ExportError, LanindexError, NotationError
from lanindex.model import Meter, Score, Span, Track
from lanindex.model.symbol import blank
from lanindex.notation import NOTATIONS, WRITTEN, notation_of, read, write

WHOLE = (
    "r_arm",
    "torso",
    "r_arm_bend",
    "r_stance",
    "other_support",
    *(part for part in BODY if part != "step"),
)
"""Parts whose tracks notations write."""

TIERS = ("eaf", "textgrid")
"""Notations that tell times in milliseconds."""


@pytest.mark.parametrize("name", TIERS)
@given(score=scores(WHOLE))
@examples(60)
def test_what_is_written_is_read(name: str, score: Score) -> None:
    assume(score.rate <= 1000)
    content = write(score, name)
    again = read(f"x{NOTATIONS[name].suffix}", content)
    assert shown(again) == shown(score)
    assert not again.warnings
    starts = {part: [span.start for span in track.known] for part, track in again.tracks.items()}
    for part, begins in starts.items():
        mine = [span.start for span in score.tracks[part].known]
        apart = [a / again.rate - b / score.rate for a, b in zip(begins, mine, strict=True)]
        assert all(abs(one) <= 0.0005 for one in apart)
    assert shown(read(f"x{NOTATIONS[name].suffix}", write(again, name))) == shown(again)


@pytest.mark.parametrize("name", TIERS)
@pytest.mark.parametrize("source", ["jumping_jacks.bvh", "compass.bvh"])
def test_a_capture_comes_back(name: str, source: str) -> None:
    score = lanindex.encode(lanindex.read(f"corpus/{source}"))
    again = read(f"x{NOTATIONS[name].suffix}", write(score, name))
    assert shown(again) == shown(score)


@pytest.mark.parametrize("name", TIERS)
def test_scores_in_units_of_lnd_come_back_to_the_byte(name: str) -> None:
    score = lanindex.read_lnd("corpus/compass.lnd")
    lines = lanindex.write_lnd(score).splitlines()
    own = [line for line in lines if not line.startswith("//")]
    assert (
        lanindex.write_lnd(read(f"x{NOTATIONS[name].suffix}", write(score, name))).splitlines()
        == own
    )


@pytest.mark.parametrize("name", TIERS)
def test_an_empty_score(name: str) -> None:
    assert (
        read(
            f"x{NOTATIONS[name].suffix}", write(Score(Meter().tick_rate, 32, Meter(), {}), name)
        ).tracks
        == {}
    )


@pytest.mark.parametrize("name", TIERS)
def test_what_no_tier_can_hold(name: str) -> None:
    rows = blank(1)
    rows["stop"], rows["direction"], rows["level"] = 1, 0, 0
    for part, said in (("r_arm", "less than 1 ms"), ("Left Arm", 'the part "Left Arm"')):
        track = Track(part, rows, (Span(0, 10),))
        with pytest.raises(ExportError, match=said):
            write(Score(5000, 10, Meter(), {part: track}), name)


@pytest.mark.parametrize("name", WRITTEN)
@given(content=st.binary(max_size=200))
@examples(100)
def test_anything_else_is_refused(name: str, content: bytes) -> None:
    with suppress(LanindexError):
        read(f"x{NOTATIONS[name].suffix}", content)


@pytest.mark.parametrize("name", WRITTEN)
@given(data=st.data())
@examples(100)
def test_damage_is_read_or_refused(name: str, data: st.DataObject) -> None:
    content = write(lanindex.read_lnd("corpus/compass.lnd"), name)
    start = data.draw(st.integers(0, len(content)))
    stop = data.draw(st.integers(start, min(start + 9, len(content))))
    with suppress(NotationError):
        read(
            f"x{NOTATIONS[name].suffix}",
            content[:start] + data.draw(st.binary(max_size=4)) + content[stop:],
        )


def test_the_page_has_every_notation() -> None:
    page = Path("lanindex/notation/NOTATIONS.md").read_text()
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in page.splitlines()
            if line.startswith("| `")]  # fmt: skip
    assert {row[0].strip("`"): row[1].strip("`") for row in rows} == {
        name: NOTATIONS[name].suffix for name in WRITTEN
    }
    for row, name in zip(rows, WRITTEN, strict=True):
        assert NOTATIONS[name].title in row[2]


def test_endings(tmp_path: Path) -> None:
    assert notation_of("in/walk.EAF") is NOTATIONS["eaf"]
    assert notation_of("walk.bvh") is None
    with pytest.raises(NotationError, match="cannot be read: no such file"):
        read(str(tmp_path / "none.eaf"))
