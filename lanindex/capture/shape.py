"""The body by its shape alone (to come)."""

from __future__ import annotations

from lanindex.capture.skeleton import Rig


def by_shape(rig: Rig) -> tuple[dict[str, int], tuple[str, ...]]:
    """Return nothing yet."""
    return {}, ()
