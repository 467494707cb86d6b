"""Files that are elsewhere now: the library's file is gone, and the same content is found."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace

from lanindex import formats
from lanindex.errors import LanindexError
from lanindex.library.encoding import Encoding
from lanindex.library.find import gone
from lanindex.pipeline.prepare import Task, encoding_of


class Moved:
    """Tells files that have moved from new ones.

    Parameters
    ----------
    held : Mapping
        Of the library, as `Store.known` returns it: sha256 and encoding by absolute path.

    Attributes
    ----------
    found : dict of str to str
        By its new absolute path, where the library has a file that has moved.
    """

    def __init__(self, held: Mapping[str, tuple[str, Encoding]]) -> None:
        self.found: dict[str, str] = {}
        self._held = held
        self._gone: list[str] | None = None

    def known(self, task: Task) -> tuple[str, Encoding] | None:
        """Return what the library holds of a file, be it from here or from where it was before."""
        place = os.path.abspath(task.path)
        if place not in self._held:
            before = self._before(task)
            if before is None:
                return None
            self.found[place] = before
            return self._held[before]
        return self._held[place]

    def _before(self, task: Task) -> str | None:
        if self._gone is None:  # asked once, and only where there is a file that is not held
            self._gone = [place for place in self._held if gone(place)]
        if not self._gone:
            return None
        try:
            same = (formats.opened(task.path).sha256(), encoding_of(task))
        except LanindexError:  # said when it is read
            return None
        for place in self._gone:
            if self._held[place] == same:
                self._gone.remove(place)
                return place
        return None

    def told(self, task: Task, *, force: bool) -> Task:
        """Return a task that knows what the library holds; with `force` it is read in any case."""
        known = self.known(task)
        return task if force else replace(task, known=known)
