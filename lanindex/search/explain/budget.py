"""How long an answer that nobody asked for may take."""

from __future__ import annotations

from dataclasses import dataclass, field
from time import monotonic, process_time

_PATIENCE = 4
"""How many times as long it may take where others use the machine as well."""


@dataclass(frozen=True)
class Budget:
    """A time to work in, counted from now.

    Attributes
    ----------
    seconds : float
        Of work. That of the clock is bounded too, at a multiple: so a busy machine gives the same
        answer as a quiet one, only later.
    """

    seconds: float
    _worked: float = field(default_factory=process_time)
    _begun: float = field(default_factory=monotonic)

    def late(self, share: float = 1) -> bool:
        """Tell whether a share of the time is over."""
        allowed = share * self.seconds
        return (
            process_time() - self._worked >= allowed
            or monotonic() - self._begun >= _PATIENCE * allowed
        )
