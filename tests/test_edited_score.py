"""An edited score is performed and encoded as the same score."""

from itertools import product
from pathlib import Path

import pytest
from effort import thinned

import lanindex
from lanindex.alphabet import BENDS, kind_of
from lanindex.compare import compare
from lanindex.notation import read, write
from lanindex.pipeline.convert import file_content
from tests import (
    choreography,
    random_bends,
    random_palms,
    random_steps,
    random_supports,
    random_touches,
    random_twists,
)

RATE = 60
BOTH_ARMS = ("r_arm", "l_arm")
SCORES = {
    "limbs": lambda: choreography.choreography(3, BOTH_ARMS),
    "steps": lambda: random_steps.drawn(2),
    "bends": lambda: random_bends.drawn(1),
    "palms": lambda: random_palms.drawn(1),
    "twists and inclines": lambda: random_twists.drawn(1),
    "touches": lambda: random_touches.drawn(1),
    "other supports": lambda: random_supports.drawn(2),
}


@pytest.mark.parametrize(
    ("name", "notation", "form"), thinned(product(SCORES, ["lnd", "eaf"], ["bvh", "glb"]), 3)
)
def test_a_score_comes_back(name: str, notation: str, form: str, tmp_path: Path) -> None:
    score = SCORES[name]()
    edited = read(f"score.{notation}", write(score, notation))
    content, _ = file_content(lanindex.animate(edited, rate=RATE), form)
    (tmp_path / f"moved.{form}").write_bytes(content)
    again = lanindex.encode(lanindex.read(tmp_path / f"moved.{form}"))
    parts = [part for part in edited.tracks if part in BENDS.values()] if name == "bends" else None
    found = compare(edited, again, parts=parts, tolerance=0.15)  # a bend moves its limb, too
    assert not found.only[0]
    assert [(it.kind, it.one, it.other) for it in found.differences] == []


def test_every_kind_that_is_written_goes_round() -> None:
    kinds = {kind_of(part) for make in SCORES.values() for part in make().tracks}
    assert kinds == {
        *("gesture", "support", "jump", "turn", "bend", "twist", "incline", "touch", "carrier")
    }  # steps, stances and ways follow from supports
