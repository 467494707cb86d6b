"""Lengths of time, and conditions on them; compared with frames exactly."""

import re
from dataclasses import dataclass
from decimal import Context, Decimal
from fractions import Fraction
from math import ceil, floor

TOLERANCE = Fraction(1, 10)
"""Seconds by which edges may differ that should agree, by default."""

_ABOUT = Fraction(1, 5)  # how far a bare length, 1s, may be off, in proportion
_ABOUT_DEGREES = Fraction(45, 2)  # how far a bare angle, 90deg, may be off
_ALL_DIGITS = Context(prec=200)


def decimal(number: Fraction) -> str:
    """Return a decimal number as written, with all its digits."""
    return f"{_ALL_DIGITS.divide(Decimal(number.numerator), number.denominator):f}"


@dataclass(frozen=True, slots=True)
class Clock:
    """Frames and beats a second of a capture."""

    rate: Fraction
    beat_rate: Fraction


COUNTED = Clock(Fraction(1), Fraction(1))
"""The clock for a `Length` that bounds a bare number."""


@dataclass(frozen=True, slots=True)
class Time:
    """A decimal number of seconds, milliseconds, frames or beats; without a unit, of anything."""

    number: Fraction
    unit: str

    def __str__(self) -> str:
        return decimal(self.number) + self.unit

    def frames(self, clock: Clock) -> Fraction:
        """Return it in frames of the source, exactly."""
        if self.unit in ("f", ""):
            return self.number
        rates = {"s": Fraction(1), "ms": Fraction(1000), "b": clock.beat_rate}
        return self.number / rates[self.unit] * clock.rate


@dataclass(frozen=True, slots=True)
class Length:
    """A condition on a length of time, or on a number with another unit."""

    form: str  # <, <=, > or >=; + (or more), .. (from, to), ~ (about), or empty: just that
    time: Time
    last: Time | None = None  # the longest, of the form ..

    def __str__(self) -> str:
        forms = {"+": f"{self.time}+", "..": f"{self.time}..{self.last}", "~": f"{self.time}"}
        return forms.get(self.form, f"{self.form}{self.time}")

    def bounds(self, clock: Clock, off: Fraction | None = None) -> tuple[int, int | None]:
        """Return the fewest and the most whole frames that meet it, None: no limit; exactly.

        `off` is by how much a bare length may be missed; None: by a fifth of it.
        """
        wanted = self.time.frames(clock)
        last = self.last.frames(clock) if self.last else wanted
        off = wanted * _ABOUT if off is None else off
        least = dict.fromkeys((">=", "+", "..", ""), ceil(wanted))
        least |= {">": floor(wanted) + 1, "~": max(ceil(wanted - off), 0)}
        most = {"<": ceil(wanted) - 1, "<=": floor(wanted), "~": floor(wanted + off)}
        most |= dict.fromkeys(("..", ""), floor(last))
        return least.get(self.form, 0), most.get(self.form)


_NUMBER = r"(\d+(?:\.\d+)?)(?:deg)?"
_RANGE = re.compile(rf"([<>]=?)?{_NUMBER}(\+|\.\.)?(?:{_NUMBER})?")


def degrees(text: str) -> tuple[int, int | None]:
    """Return the fewest and the most whole degrees of an angle or a bend, None: no limit."""
    match = _RANGE.fullmatch(text)
    assert match, text
    compare, number, form, last = match.groups()
    time, longest = Time(Fraction(number), ""), Time(Fraction(last or number), "")
    off = _ABOUT_DEGREES if "deg" in text else Fraction(0)
    return Length(compare or form or "~", time, longest).bounds(COUNTED, off)
