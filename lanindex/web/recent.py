"""Values that were asked for recently, which several threads share."""

from collections import OrderedDict
from threading import Lock
from typing import Generic, TypeVar

Key = TypeVar("Key")
Value = TypeVar("Value")


class Recent(Generic[Key, Value]):
    """So many values by their keys; those that nobody has asked for the longest go."""

    def __init__(self, most: int) -> None:
        self._most, self._lock = most, Lock()
        self._held: OrderedDict[Key, Value] = OrderedDict()

    def get(self, key: Key) -> Value | None:
        """Return a value; None where it is not held."""
        with self._lock:
            if key in self._held:
                self._held.move_to_end(key)
            return self._held.get(key)

    def put(self, key: Key, value: Value) -> list[Value]:
        """Hold a value, and return those that go."""
        with self._lock:
            self._held[key] = value
            self._held.move_to_end(key)
            gone = len(self._held) - self._most
            return [self._held.popitem(last=False)[1] for _ in range(gone)]
