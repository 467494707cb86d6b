"""Arrays that nobody may change."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Return a view of an array that cannot be written to."""
    array = array.view()
    array.flags.writeable = False
    return array
