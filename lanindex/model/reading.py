"""What a reader is told in place of what it would have found."""

from __future__ import annotations

from dataclasses import dataclass, fields
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
    skeleton : str or None
        A file with the skeleton, where the capture's own has none and none lies beside it.
    body : str or None
        A file that says which joints or markers play the body.
    columns : str or None
        A file that says what the columns of a table are.
    take : str or None
        Which of several takes in a file.
    tempo : str or None
        How time is counted: ``auto``, by the movement's own beat, or a file of beats.
    """

    unit: str | None = None
    up: str | None = None
    rate: Fraction | float | str | None = None
    compose: str | None = None
    skeleton: str | None = None
    body: str | None = None
    columns: str | None = None
    take: str | None = None
    tempo: str | None = None

    def told(self) -> dict[str, str]:
        """Return what was told, as text."""
        values = ((one.name, getattr(self, one.name)) for one in fields(self))
        return {name: str(value) for name, value in values if value is not None}
