"""METHOD's law on paper: a choreography that is drawn, read and performed is the same again."""

import sys
from fractions import Fraction
from pathlib import Path

import pytest
from choreography import choreography, spoken
from effort import seeds

import lanindex

pytest.importorskip("cv2")
sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))

from loop import PARTS, drawn_and_read

from lanindex.reader.score import score_of


@pytest.mark.parametrize("seed", seeds(1, 5))
def test_a_score_comes_back_from_its_picture_and_its_motion(seed: int) -> None:
    drawn = choreography(seed, PARTS)
    _, page = drawn_and_read(drawn, seconds=True)
    read = score_of([page], Fraction(60))
    written = lanindex.encode(lanindex.animate(read))
    for part in PARTS:
        assert spoken(written, part) == spoken(read, part) == spoken(drawn, part)
