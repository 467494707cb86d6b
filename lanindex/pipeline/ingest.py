"""Files into the library: read, written down and stored, one transaction a file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

from lanindex import formats
from lanindex.errors import LanindexError, UsageError
from lanindex.formats import parted
from lanindex.formats.file import SUBJECT, on_disk
from lanindex.library.rows import Encoding
from lanindex.library.selection import absolute, is_gone
from lanindex.library.store import Store
from lanindex.model import Reading
from lanindex.pipeline.labels import Labels, key_of
from lanindex.pipeline.prepare import Outcome, StoredFile, Task, companions, encoding_of, prepared

if TYPE_CHECKING:
    from lanindex.encoding.profile import Profile


COMPACT_EVERY = 4096
"""Files after which an ingest puts what it has stored into columns; and after the last one."""


def ingest(
    store: Store | None,
    paths: Iterable[str],
    profile: Profile,
    *,
    reading: Reading | None = None,
    labels: Labels | None = None,
    jobs: int = 1,
    force: bool = False,
    dry_run: bool = False,
) -> Iterator[Outcome]:
    """Read files into a library."""
    known = store.known() if store else {}
    moved = Moved(known)
    first = {
        (sha, encoding.beside, parted(place)[1]): place for place, (sha, encoding) in known.items()
    }

    def task(path: str) -> Task:
        new = Task(path, profile, reading or Reading())
        stored = moved.stored(new)  # also where everything is read again: it may have moved
        return new if force else replace(new, stored=stored)

    for number, outcome in enumerate(prepared(map(task, paths), jobs)):
        place = absolute(outcome.path)
        before = moved.places.get(place, "")
        outcome = replace(outcome, was_stored=place in known or bool(before), moved=before)
        outcome = _with_duplicate_warning(outcome, place, first)
        done = outcome if dry_run else _store(store, outcome, labels or {})
        yield replace(done, score=None)
        if store and not dry_run and (number + 1) % COMPACT_EVERY == 0:
            store.cache.compact()
    if store and not dry_run:
        store.cache.compact()


def _with_duplicate_warning(
    outcome: Outcome, place: str, first: dict[tuple[str, str, str], str]
) -> Outcome:
    """Warn of a file with the content of another that is there, by the first of each content."""
    content = outcome.sha256, outcome.encoding.beside, parted(place)[1]
    other = first.setdefault(content, place) if outcome.sha256 else place
    if outcome.status != "added" or on_disk(other) == on_disk(place) or is_gone(other):
        return outcome
    return replace(outcome, warnings=(*outcome.warnings, f"the same content as {other}"))


def _store(store: Store | None, outcome: Outcome, labels: Labels) -> Outcome:
    if store is None or outcome.status == "failed":
        return outcome
    place = absolute(outcome.path)
    if outcome.moved:
        store.move(outcome.moved, outcome.path)
    label, metadata = labels.get(key_of(place), (None, {}))
    if metadata and outcome.was_stored:
        metadata = {**store.capture(place).metadata, **metadata}
    if outcome.score is None:
        described = label is not None or bool(metadata)
        return replace(outcome, labelled=described and store.label(place, label, metadata or None))
    try:
        store.add(
            outcome.path,
            outcome.score,
            format=outcome.format,
            sha256=outcome.sha256,
            encoding=outcome.encoding,
            label=label,
            metadata=metadata or None,
            warnings=outcome.warnings,
        )
    except UsageError as error:
        return Outcome(outcome.path, "failed", error=str(error), was_stored=outcome.was_stored)
    return outcome


class Moved:
    """Tells files that have moved from new ones."""

    def __init__(self, known: Mapping[str, tuple[str, Encoding]]) -> None:
        self.places: dict[str, str] = {}
        self._known = known
        self._people = dict[str, dict[str, tuple[str, Encoding]]]()
        for place, one in known.items():
            file, name = parted(place)
            self._people.setdefault(file, {})[name] = one

    def stored(self, task: Task) -> StoredFile:
        """Return what the library holds of a file, by its place or by where it was before."""
        file, person = parted(absolute(task.path))
        people: StoredFile = self._people.get(file, {})
        if person:
            people = {"": people[person]} if person in people else {}
        return people or self._before_move(task, file, person)

    @cached_property
    def _gone_files(self) -> dict[str, dict[str, list[str]]]:
        """By sha256 the files that are gone, and who of them was stored."""
        gone: dict[str, dict[str, list[str]]] = {}
        for place, (sha256, _) in self._known.items():
            if is_gone(place):
                file, name = parted(place)
                gone.setdefault(sha256, {}).setdefault(file, []).append(name)
        return gone

    def _before_move(self, task: Task, file: str, person: str) -> StoredFile:
        if not self._gone_files:
            return {}
        try:
            opened = formats.opened(task.path)
            sha256, encoding = opened.sha256(), encoding_of(task, companions(task, opened))
        except LanindexError:  # reported when it is read
            return {}
        alike = self._gone_files.get(sha256, {})
        same = encoding, replace(encoding, beside="")  # what was beside it was not noted always
        for before, names in alike.items():
            people = {name: self._people[before][name] for name in names if person in ("", name)}
            people = {name: one for name, one in people.items() if one[1] in same}
            if people:
                alike[before] = [name for name in names if name not in people]
                self.places |= {
                    _place_of_person(file, name): _place_of_person(before, name) for name in people
                }
                return {"" if person else name: one for name, one in people.items()}
        return {}


def _place_of_person(file: str, name: str) -> str:
    return file + SUBJECT + name if name else file
