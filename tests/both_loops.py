"""Numbers read by the plain loops and by the compiled ones."""

from collections.abc import Callable
from typing import TypeVar
from unittest.mock import patch

import pytest

from lanindex import compiled

T = TypeVar("T")


def plain_and_compiled(call: Callable[[], T]) -> tuple[T, T]:
    """Return the results of a call with plain loops and with compiled ones."""
    pytest.importorskip("numba")
    results = []
    for answer in (False, True):
        with patch.object(compiled, "chosen", lambda name, size, answer=answer: answer):
            results.append(call())
    return results[0], results[1]
