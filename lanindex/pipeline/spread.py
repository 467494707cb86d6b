"""Work that is spread over other processes, whoever runs them."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any, Protocol

Tick = Callable[[], None]
"""Called often while work goes on; it raises once nobody waits for the result."""

Work = Callable[[Any, Tick], Any]
"""What is done with an item: a function of a module, which other processes import."""


class Spread(Protocol):
    """Has work done by other processes."""

    @property
    def tasks(self) -> int:
        """Into how many tasks work is best cut."""

    def results(self, work: Work, items: Iterable[Any], tick: Tick) -> Iterator[Any]:
        """Yield the results of work on items, in their order; a few are done ahead."""
