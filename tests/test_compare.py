"""Differences of two scores: laws, and known edits."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_scores import scores

import lanindex
from lanindex.compare import DEGREES, Comparison, compare
from lanindex.errors import UsageError
from lanindex.model import Score, Span
from lanindex.model.derived import STEP
from lanindex.model.symbol import SYMBOL


@pytest.fixture
def jacks(repository: Path) -> Score:
    return lanindex.read_lnd(repository / "corpus" / "jumping_jacks.lnd")


def changed(score: Score, part: str, rows: np.ndarray) -> Score:
    return replace(score, tracks={**score.tracks, part: replace(score.tracks[part], symbols=rows)})


def rows(score: Score, part: str = "r_arm") -> np.ndarray:
    return score.tracks[part].symbols.copy()


def told(found: Comparison) -> list[tuple[str, str | None, str | None]]:
    def said(it) -> str | None:
        return it and f"{it.symbol.words} {it.start:g}"

    return [(it.kind, said(it.one), said(it.other)) for it in found.differences]


def test_one_of_many_equal_ones_is_left_out_where_it_was(jacks: Score) -> None:
    for first in range(1, len(rows(jacks)) - 1):
        gone = np.delete(rows(jacks), [first, first + 1])
        found = compare(jacks, changed(jacks, "r_arm", gone), parts=["r_arm"])
        left = [it.one.symbol.ordinal for it in found.differences]
        assert [it.kind for it in found.differences] == ["left out"] * 2
        assert left == [first, first + 1]
        back = compare(changed(jacks, "r_arm", gone), jacks, parts=["r_arm"])
        assert [it.other.symbol.ordinal for it in back.differences] == [first, first + 1]


def test_what_says_something_else_is_replaced(jacks: Score) -> None:
    other = rows(jacks)
    other["level"][3] = (other["level"][3] + 1) % 3
    found = compare(jacks, changed(jacks, "r_arm", other), parts=["r_arm"])
    assert told(found) == [("replaced", "right high 3", "right low 3")]
    assert found.same == len(other) - 1


def test_what_comes_later_or_lasts_longer_is_moved(jacks: Score) -> None:
    other = rows(jacks)
    other["start"][3] += 4
    (it,) = compare(jacks, changed(jacks, "r_arm", other), parts=["r_arm"]).differences
    assert (it.kind, it.later, it.longer) == ("moved", 0.25, -0.25)
    near = compare(jacks, changed(jacks, "r_arm", other), parts=["r_arm"], tolerance=0.25)
    assert near.differences == ()


def test_what_could_not_be_seen_is_said_to_be(jacks: Score) -> None:
    track = jacks.tracks["r_arm"]
    own = track.symbols[:5]
    end = int(own["stop"][-1])
    for stop, kind in ((jacks.frames, "left out"), (end, "not seen")):
        known = (Span(0, stop),)
        lost = replace(jacks, tracks={"r_arm": replace(track, symbols=own, known=known)})
        whole = replace(jacks, tracks={"r_arm": track})
        there, back = compare(whole, lost), compare(lost, whole)
        assert {it.kind for it in there.differences} == {kind}
        assert {it.kind for it in back.differences} == {kind.replace("left out", "added")}
        assert len(there.differences) == len(track) - 5


def test_degrees_may_differ_a_little(jacks: Score) -> None:
    row = np.zeros(1, SYMBOL)
    row["direction"], row["level"], row["stop"], row["ticks"] = 7, -1, 8, 8
    track = replace(jacks.tracks["r_arm"], part="body_turn", symbols=row)
    scores = []
    for amount in (90, 90 + DEGREES, 91 + DEGREES):
        row = row.copy()
        row["amount"] = amount
        scores.append(replace(jacks, tracks={"body_turn": replace(track, symbols=row)}))
    assert not compare(scores[0], scores[1]).differences
    assert [it.kind for it in compare(scores[0], scores[2]).differences] == ["replaced"]


def test_how_far_a_limb_is_bent_counts_where_both_tell(jacks: Score) -> None:
    bent = rows(jacks)
    bent["amount"] = 0
    straight = changed(jacks, "r_arm", bent.copy())
    bent["amount"][2] = 3
    assert not compare(jacks, straight, parts=["r_arm"]).differences
    found = compare(straight, changed(jacks, "r_arm", bent), parts=["r_arm"])
    assert [it.kind for it in found.differences] == ["replaced"]


def test_tracks_of_one_alone_are_named(jacks: Score) -> None:
    arms = replace(jacks, tracks={part: jacks.tracks[part] for part in ("r_arm", "l_arm")})
    found = compare(arms, jacks)
    assert (found.differences, found.parts) == ((), ("r_arm", "l_arm"))
    assert found.only == ((), ("r_leg", "l_leg"))
    with pytest.raises(UsageError, match="no track that both have"):
        compare(arms, jacks, parts=["r_leg"])
    with pytest.raises(UsageError, match='there is no part "wing", wanted one of r_arm l_arm'):
        compare(arms, jacks, parts=["wing"])


@given(score=scores())
def test_a_score_does_not_differ_from_itself(score: Score) -> None:
    parts = [part for part in score.tracks if len(score.tracks[part]) and part != STEP]
    if parts:
        found = compare(score, score, tolerance=0)
        assert not found.differences
        assert {*found.parts} == {*parts}


@given(score=scores(["r_arm"]), other=scores(["r_arm"]), keep=st.lists(st.booleans(), min_size=40))
def test_every_symbol_is_told_once(score: Score, other: Score, keep: list[bool]) -> None:
    if not (score.tracks and other.tracks):
        return
    own = rows(score)
    kept = changed(score, "r_arm", own[np.resize(keep, len(own))])
    for two in (other, kept):
        found = compare(score, two)
        for side, held in (("one", score), ("other", two)):
            seen = [getattr(it, side) for it in found.differences]
            ordinals = [it.symbol.ordinal for it in seen if it]
            assert ordinals == sorted(set(ordinals))
            shown = np.count_nonzero(~held.tracks["r_arm"].symbols["passing"])
            assert len(ordinals) + found.same == shown
    assert {it.kind for it in found.differences} <= {"left out"}
