"""Files into the library: read, written down and stored, one transaction a file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from lanindex.errors import UsageError
from lanindex.formats import parted
from lanindex.formats.file import on_disk
from lanindex.library.find import gone
from lanindex.library.store import Store
from lanindex.library.texts import absolute
from lanindex.model import Reading
from lanindex.pipeline.labels import key_of
from lanindex.pipeline.moved import Moved
from lanindex.pipeline.pool import prepared
from lanindex.pipeline.prepare import Outcome, Task

if TYPE_CHECKING:
    from lanindex.encoding.profile import Profile

GATHER = 4096
"""Files after which an ingest puts what it has stored into columns; and after the last one."""


def ingest(
    library: Store | None,
    paths: Iterable[str],
    profile: Profile,
    *,
    reading: Reading | None = None,
    labels: Mapping[str, tuple[str | None, Mapping[str, str]]] | None = None,
    jobs: int = 1,
    force: bool = False,
    dry_run: bool = False,
) -> Iterator[Outcome]:
    """Read files into a library."""
    held = library.known() if library else {}
    moved, told = Moved(held), reading or Reading()
    first = {(sha, how.beside, parted(place)[1]): place for place, (sha, how) in held.items()}
    tasks = (moved.told(Task(path, profile, told), force=force) for path in paths)
    for number, outcome in enumerate(prepared(tasks, jobs)):
        place = absolute(outcome.path)
        before = moved.found.get(place, "")
        outcome = replace(outcome, held=place in held or bool(before), moved=before)
        outcome = _noticed(outcome, place, first)
        done = outcome if dry_run else _store(library, outcome, labels or {})
        yield replace(done, score=None)
        if library and not dry_run and (number + 1) % GATHER == 0:
            library.gather()
    if library and not dry_run:
        library.gather()


def _noticed(outcome: Outcome, place: str, first: dict[tuple[str, str, str], str]) -> Outcome:
    """Warn of a file with the content of another that is there, by the first of each content."""
    content = outcome.sha256, outcome.encoding.beside, parted(place)[1]
    other = first.setdefault(content, place) if outcome.sha256 else place
    if outcome.status != "added" or on_disk(other) == on_disk(place) or gone(other):
        return outcome
    return replace(outcome, warnings=(*outcome.warnings, f"the same content as {other}"))


def _store(
    library: Store | None,
    outcome: Outcome,
    labels: Mapping[str, tuple[str | None, Mapping[str, str]]],
) -> Outcome:
    if library is None or outcome.status == "failed":
        return outcome
    place = absolute(outcome.path)
    if outcome.moved:
        library.move(outcome.moved, outcome.path)
    label, metadata = labels.get(key_of(place), (None, {}))
    if metadata and outcome.held:
        metadata = {**library.capture(place).metadata, **metadata}
    if outcome.score is None:
        told = label is not None or bool(metadata)
        return replace(outcome, labelled=told and library.label(place, label, metadata or None))
    try:
        library.add(
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
        return Outcome(outcome.path, "failed", error=str(error), held=outcome.held)
    return outcome
