"""How a capture came to be written down, and the checksum of all that this led to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Self

from lanindex.library import checksums

ENCODED = (
    *("path", "location", "format", "sha256", "fps", "rate", "frames"),
    *("speed", "beats", "beat", "division", "options", "warnings", "tracks", "content"),
)
"""Columns of ``capture`` that its checksum is over; ``tracks`` and ``content`` are checksums."""


@dataclass(frozen=True, slots=True)
class Encoding:
    """How a capture came to be written down; equal ones give equal scores."""

    profile: str = ""
    digest: str = ""
    options: Mapping[str, str] = field(default_factory=dict)
    beside: str = ""
    people: int = field(default=0, compare=False)

    @classmethod
    def stored(cls, profile: str, digest: str, facts: Mapping[str, str]) -> Self:
        """Return what the profile and the column ``options`` of a capture say."""
        options = dict(facts)
        beside, people = options.pop("beside", ""), int(options.pop("people", 0))
        return cls(profile, digest, options, beside, people)

    def facts(self) -> dict[str, str]:
        """Return what the column ``options`` holds: what was told, and what there is to say."""
        more = {"beside": self.beside, "people": str(self.people or "")}
        return {**self.options, **{name: fact for name, fact in more.items() if fact}}


def encoded(values: Mapping[str, Any], profile: str | None, digest: str | None) -> int:
    """Return the checksum of all that was encoded of a capture."""
    return checksums.of_values(*(values[name] for name in ENCODED), profile, digest)
