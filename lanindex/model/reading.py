"""What a reader is told in place of what it would have found."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction


@dataclass(frozen=True, slots=True)
class Reading:
    """What a reader is told in place of what it would have found.

    Attributes
    ----------
    unit : str or None
        Of the file: ``mm``, ``cm``, ``m``, ``inch``, ``inch/0.45``.
    up : str or None
        Its vertical axis: ``y``, ``z``, ``x``, ``-y``, ``-z``, ``-x``.
    rate : Fraction, float, str or None
        Frames a second.
    compose : str or None
        ``parent``: a joint's turn follows its parent's; ``child``: it precedes it.
    """

    unit: str | None = None
    up: str | None = None
    rate: Fraction | float | str | None = None
    compose: str | None = None

    def told(self) -> dict[str, str]:
        """Return what was told, as text."""
        values = {"unit": self.unit, "up": self.up, "rate": self.rate, "compose": self.compose}
        return {name: str(value) for name, value in values.items() if value is not None}
