"""How much random tests try: a little by default, everything with `--slow`."""

from collections.abc import Iterable

import pytest
from hypothesis import settings

SEEDS = 2
"""Seeds that are tried by default."""

settings.register_profile(
    "quick", deadline=None, max_examples=10
)  # a deadline is a timed assertion
settings.register_profile("slow", deadline=None, max_examples=100)


def slow() -> bool:
    """Return whether the tests run with `--slow`."""
    return settings.get_current_profile_name() == "slow"


def seeds(*numbers: int) -> list:
    """Return the seeds of a parametrized test, as of `range`: all but the first are marked slow."""
    every = range(*numbers)
    return [*every[:SEEDS], *(pytest.param(seed, marks=pytest.mark.slow) for seed in every[SEEDS:])]


def some(most: int, least: int = SEEDS) -> range:
    """Return the seeds of a loop: all with `--slow`, else the first few."""
    return range(most if slow() else min(most, least))


def examples(most: int) -> settings:
    """Return settings of Hypothesis: so many examples with `--slow`, else a tenth, or five."""
    return settings(max_examples=most if slow() else max(most // 10, min(most, 5)))


def thinned(cases: Iterable, every: int) -> list:
    """Return the cases of a parametrized test: all but every so many are marked slow."""
    return [
        pytest.param(*(it if isinstance(it, tuple) else (it,)), marks=pytest.mark.slow)
        if number % every
        else it
        for number, it in enumerate(cases)
    ]
