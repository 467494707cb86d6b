import pytest
from sample import sample_score

from lanindex.errors import UsageError


def test_symbols_of_a_part_that_a_score_lacks() -> None:
    score = sample_score()
    assert len(score.symbols()) == 3 * len(score.symbols("head")) > 0
    with pytest.raises(UsageError, match='no part "tail", wanted one of r_arm l_arm head'):
        score.symbols("tail")
