"""Work of a cluster done in this process, with all that goes there and back as bytes."""

import pickle
from collections.abc import Iterable, Iterator
from typing import Any

from lanindex.errors import LanindexError
from lanindex.pipeline.spread import Tick, Work


class Here:
    """Has tasks done one after the other."""

    def __init__(self, tasks: int) -> None:
        self.tasks = tasks

    def results(self, work: Work, items: Iterable[Any], tick: Tick) -> Iterator[Any]:
        for item in items:
            try:
                result = work(pickle.loads(pickle.dumps(item)), tick)
            except LanindexError as error:
                raise pickle.loads(pickle.dumps(error)) from error
            yield pickle.loads(pickle.dumps(result))

    def close(self) -> None:
        """Let go of nothing."""
