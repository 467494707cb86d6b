"""What a reader is told in place of what it would have found."""

from __future__ import annotations

from dataclasses import dataclass, fields
from fractions import Fraction


@dataclass(frozen=True, slots=True)
class Reading:
    """What a reader is told in place of what it would have found."""

    unit: str | None = None  # Of the file: ``mm``, ``cm``, ``m``, ``inch``, ``inch/0.45``
    up: str | None = None  # Its vertical axis: ``y``, ``z``, ``x``, ``-y``, ``-z``, ``-x``
    rate: Fraction | float | str | None = None  # Frames a second
    # ``parent``: a joint's turn follows its parent's; ``child``: it precedes it
    compose: str | None = None
    # A file with the skeleton, where the capture's own has none and none lies beside it
    skeleton: str | None = None
    body: str | None = None  # A file that says which joints or markers play the body
    columns: str | None = None  # A file that says what the columns of a table are
    take: str | None = None  # Which of several takes in a file
    # How time is counted: ``auto``, by the movement's own beat, or a file of beats
    tempo: str | None = None

    def told(self) -> dict[str, str]:
        """Return what was told, as text."""
        values = ((one.name, getattr(self, one.name)) for one in fields(self))
        return {name: str(value) for name, value in values if value is not None}
