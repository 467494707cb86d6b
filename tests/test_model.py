from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from motions import motion_of, swung
from sample_library import sample_score

from lanindex.encoding import encode
from lanindex.errors import EncodeError, UsageError
from lanindex.model import SYMBOL, Capture, Hit, Span
from lanindex.model.symbol import joined


def test_symbols_of_a_part_that_a_score_lacks() -> None:
    score = sample_score()
    assert len(score.symbols()) == 3 * len(score.symbols("head")) > 0
    with pytest.raises(UsageError, match='no part "tail", wanted one of r_arm l_arm head'):
        score.symbols("tail")


def test_a_rate_may_be_any_number() -> None:
    motion = motion_of(swung(1, 40, Fraction(30), 0.0), Fraction(30))
    assert replace(motion, rate=29.5).rate == Fraction(59, 2)
    assert set(encode(replace(motion, rate=29.97)).tracks) == set(encode(motion).tracks)


def test_a_motion_without_frames_is_refused() -> None:
    motion = motion_of(swung(1, 40, Fraction(30), 0.0), Fraction(30))
    with pytest.raises(EncodeError, match="no frames, wanted one at least"):
        encode(replace(motion, positions=motion.positions[:0], axes={}))


def test_what_is_nowhere_is_a_gap() -> None:
    motion = motion_of(swung(1, 40, Fraction(30), 0.0), Fraction(30))
    positions = motion.positions.copy()
    positions[20:23] = np.inf
    unknown = np.where(np.isinf(positions), np.nan, positions)
    found, wanted = (encode(replace(motion, positions=it)) for it in (positions, unknown))
    assert found.tracks.keys() == wanted.tracks.keys() != set()
    for part, track in found.tracks.items():
        assert np.array_equal(track.symbols, wanted.tracks[part].symbols)


def test_captures_and_hits_can_be_kept_in_a_set() -> None:
    captures = [
        Capture(1, "a", "bvh", "", "", Fraction(30), 9, metadata={"style": s}) for s in "xy"
    ]
    hits = {Hit(capture, Span(0, 5), 1.0, ()) for capture in [*captures, *captures]}
    assert {hit.capture.metadata["style"] for hit in hits} == {"x", "y"}


def test_tables_joined_are_their_rows() -> None:
    score = sample_score()
    tables = [track.symbols for track in score.tracks.values()]
    rows = joined(tables)
    assert rows.dtype == SYMBOL
    assert rows.tolist() == [row for table in tables for row in table.tolist()]
    assert len(joined([])) == 0
