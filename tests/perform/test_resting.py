"""Who kneels, sits, lies and goes on all fours as a score tells."""

import numpy as np
import pytest

from lanindex import encode, read_lnd
from lanindex.model import Motion
from lanindex.perform import perform
from tests.goings import RATE, Tally, compared
from tests.restings import OTHER, TRACKS, drawn


def act(*lines: str, units: int = 3) -> Motion:
    """Perform a score of one beat a second."""
    return perform(read_lnd("\n".join((f"#unit_total {units}", "#unit1", *lines))), rate=RATE)


@pytest.mark.parametrize(("noise", "least"), [(0.0, 0.99), (2.0, 0.97)])
def test_what_is_carried_out_comes_back(noise, least):
    tally: dict[str, Tally] = {}
    for seed in range(10):
        score = drawn(seed)
        compared(score, encode(perform(score, rate=RATE, noise=noise, seed=seed)), tally, TRACKS)
    assert tally[OTHER].wanted == 80
    for part, counts in tally.items():
        assert counts.exact >= least * counts.wanted, part
        assert counts.added == 0, part
        if counts.wanted:
            assert np.percentile(counts.starts, 95) <= 3, part
            assert np.percentile(counts.stops, 95) <= 3, part
