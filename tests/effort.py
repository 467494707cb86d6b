"""How much random tests try: a little by default, everything with `--slow`."""

import pytest
from hypothesis import settings

SEEDS = 3
"""Seeds that are tried by default."""

settings.register_profile(
    "quick", deadline=None, max_examples=20
)  # a deadline is a timed assertion
settings.register_profile("slow", deadline=None, max_examples=100)


def slow() -> bool:
    """Return whether the tests run with `--slow`."""
    return settings.get_current_profile_name() == "slow"


def seeds(*numbers: int) -> list:
    """Return the seeds of a parametrized test, as of `range`: all but three are marked slow."""
    every = range(*numbers)
    return [*every[:SEEDS], *(pytest.param(seed, marks=pytest.mark.slow) for seed in every[SEEDS:])]


def some(most: int, least: int = SEEDS) -> range:
    """Return the seeds of a loop: all with `--slow`, else the first few."""
    return range(most if slow() else min(most, least))


def examples(most: int) -> settings:
    """Return settings of Hypothesis: so many examples with `--slow`, else a fifth, ten at least."""
    return settings(max_examples=most if slow() else max(most // 5, min(most, 10)))
