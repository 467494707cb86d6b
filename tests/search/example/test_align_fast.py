"""The compiled alignment (extra ``fast``) against the plain one."""

from itertools import product

import numpy as np
import pytest
from both_ways import fast, plain
from hypothesis import given, settings
from hypothesis import strategies as st
from made_clips import PARTS, clips

from lanindex.search import compiled
from lanindex.search.example import align
from lanindex.search.example.moves import clips_of

pytest.importorskip("numba")


@settings(max_examples=40)
@given(st.lists(clips(most=9), min_size=1, max_size=5))
def test_it_finds_what_the_plain_one_finds(many) -> None:
    laid_out = clips_of(many, [30.0] * len(many), PARTS)
    one, two = np.array(list(product(range(len(many)), repeat=2))).T
    ours, theirs = laid_out.whole().some(one), laid_out.whole().some(two)
    whole = align.sizes(laid_out.moves, ours) + align.sizes(laid_out.moves, theirs)
    found = {}
    for name, way in (("plain", plain), ("fast", fast)):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(compiled, "chosen", way)
            found[name] = align.savings(laid_out.moves, ours, laid_out.moves, theirs, whole)
    assert found["fast"] == pytest.approx(found["plain"], abs=1e-4)
