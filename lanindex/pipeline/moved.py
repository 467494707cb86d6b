"""Files that are elsewhere now: the library's file is gone, and the same content is found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from lanindex import formats
from lanindex.errors import LanindexError
from lanindex.formats.file import SUBJECT
from lanindex.library.encoding import Encoding
from lanindex.library.find import gone
from lanindex.library.texts import absolute
from lanindex.pipeline.prepare import Held, Task, companions, encoding_of


class Moved:
    """Tells files that have moved from new ones."""

    def __init__(self, held: Mapping[str, tuple[str, Encoding]]) -> None:
        self.found: dict[str, str] = {}
        self._held = held
        self._people = dict[str, dict[str, tuple[str, Encoding]]]()
        for place, one in held.items():
            file, name = formats.parted(place)
            self._people.setdefault(file, {})[name] = one
        self._gone: dict[str, dict[str, list[str]]] | None = None

    def told(self, task: Task, *, force: bool) -> Task:
        """Return a task that knows what the library holds; with `force` it is read in any case."""
        held = self.held(task)
        return task if force else replace(task, held=held)

    def held(self, task: Task) -> Held:
        """Return what the library holds of a file, be it from here or from where it was before."""
        file, meant = formats.parted(absolute(task.path))
        people: Held = self._people.get(file, {})
        if meant:
            people = {"": people[meant]} if meant in people else {}
        return people or self._before(task, file, meant)

    def _before(self, task: Task, file: str, meant: str) -> Held:
        if self._gone is None:  # asked once, and only where there is a file that is not held
            self._gone = _gone(self._held)
        if not self._gone:
            return {}
        try:
            found = formats.opened(task.path)
            sha256, encoding = found.sha256(), encoding_of(task, companions(task, found))
        except LanindexError:  # said when it is read
            return {}
        alike = self._gone.get(sha256, {})
        same = encoding, replace(encoding, beside="")  # what was beside it was not noted always
        for before, names in alike.items():
            people = {name: self._people[before][name] for name in names if meant in ("", name)}
            people = {name: one for name, one in people.items() if one[1] in same}
            if people:
                alike[before] = [name for name in names if name not in people]
                self.found |= {_called(file, name): _called(before, name) for name in people}
                return {"" if meant else name: one for name, one in people.items()}
        return {}


def _gone(held: Mapping[str, tuple[str, Encoding]]) -> dict[str, dict[str, list[str]]]:
    """Return by sha256 the files that are gone, and who of them was held."""
    found: dict[str, dict[str, list[str]]] = {}
    for place, (sha256, _) in held.items():
        if gone(place):
            file, name = formats.parted(place)
            found.setdefault(sha256, {}).setdefault(file, []).append(name)
    return found


def _called(file: str, name: str) -> str:
    return file + SUBJECT + name if name else file
