from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lanindex.notation.text import DECIMAL, fraction, number


@given(st.fractions(0, 1000, max_denominator=5000))
def test_every_fraction_survives(value: Fraction) -> None:
    assert DECIMAL.fullmatch(number(value))
    assert fraction(number(value)) == value


@given(st.decimals(0, 10_000, places=5))
def test_short_decimals_mean_what_they_say(value: object) -> None:
    assert fraction(str(value)) == Fraction(str(value))


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (Fraction(0), "0"),
        (Fraction(3), "3"),
        (Fraction(3, 2), "1.5"),
        (Fraction(1, 32), "0.03125"),
        (Fraction(1, 3), "0.333333"),
        (Fraction(200, 3), "66.666667"),
        (Fraction(1, 1000000), "0.000001"),
    ],
)
def test_numbers_are_short(value: Fraction, text: str) -> None:
    assert number(value) == text


@pytest.mark.parametrize("text", ["0.666666", "0.666667", "0.66666667"])
def test_thirds_may_be_cut_or_rounded(text: str) -> None:
    assert fraction(text) == Fraction(2, 3)


def test_three_places_are_no_third() -> None:
    assert fraction("0.333") == Fraction(333, 1000)
