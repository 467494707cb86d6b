"""Files into the library: found, read, written down and stored, one transaction a file.

What a process of a cluster has read together is stored together.
"""

from __future__ import annotations

import csv
import io
import os
import unicodedata
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from contextlib import nullcontext
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lanindex import formats, locations
from lanindex.errors import CaptureError, LanindexError, LibraryError, UsageError, counted, shown
from lanindex.formats import archives, parted
from lanindex.formats.file import SUBJECT, on_disk
from lanindex.formats.sniff import COMPANIONS, unread
from lanindex.formats.sniff import WITHOUT_PLACES as ANGLES
from lanindex.library.rows import Encoding
from lanindex.library.selection import absolute, is_gone, printable
from lanindex.library.store import Store
from lanindex.model import Reading
from lanindex.notation import NOTATIONS, is_printed
from lanindex.notation.text import read_text
from lanindex.pipeline.prepare import (
    Outcome,
    StoredFile,
    Task,
    companions,
    encoding_of,
    prepared_together,
)

if TYPE_CHECKING:
    from lanindex.encoding.profile import Profile
    from lanindex.pipeline.spread import Spread

TOGETHER = 64
"""Captures that are stored in one transaction, of those that a process of a cluster has read."""

COMPACT_EVERY = 4096
"""Files after which an ingest puts what it has stored into columns; and after the last one."""

SUFFIXES = {suffix: form.name for form in formats.FORMATS for suffix in form.suffixes} | {
    form.suffix: form.name for form in NOTATIONS.values() if form.ingested
}
"""Endings that a folder is searched for, with the format each stands for."""

_UNSURE = {suffix for form in formats.FORMATS if not form.certain for suffix in form.suffixes}

CaptureLabels = tuple[str | None, dict[str, str]]
"""The label of a capture, None where the table has none, and its other columns."""

Labels = dict[str, CaptureLabels]
"""The labels of captures, by `key_of` their paths."""

_FROM = "a relative path counts from the table's folder, else from the working directory"
_DELIMITERS = (",", ";", "\t")
_LONGEST_HEAD = 10_000  # letters


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
    spread: Spread | None = None,
) -> Generator[Outcome, None, None]:
    """Read files into a library that may be written (`check_writable`)."""
    files = list(paths)
    target = None if dry_run else store
    known = store.known() if store else {}
    moved = Moved(known)
    first = {
        (sha, encoding.beside, parted(place)[1]): place for place, (sha, encoding) in known.items()
    }

    def task(path: str) -> Task:
        new = Task(path, profile, reading or Reading())
        stored = moved.stored(new)  # also where everything is read again: it may have moved
        return new if force else replace(new, stored=stored)

    def stored(outcome: Outcome) -> Outcome:
        place = absolute(outcome.path)
        before = moved.places.get(place, "")
        outcome = replace(outcome, was_stored=place in known or bool(before), moved=before)
        outcome = _with_duplicate_warning(outcome, place, first)
        _, held = known.get(place, ("", outcome.encoding))
        told_anew = outcome.status == "unchanged" and held.version != outcome.encoding.version
        outcome = _store(target, outcome, labels or {}, told_anew) if target else outcome
        return replace(outcome, score=None)

    waiting = 0
    for outcomes in prepared_together(map(task, files), jobs, spread):
        for at in range(0, len(outcomes), TOGETHER):
            some = outcomes[at : at + TOGETHER]
            several = sum(one.score is not None for one in some) > 1
            with target.session.together() if target and several else nullcontext():
                done = [stored(outcome) for outcome in some]
            yield from done
            waiting += len(some)
            if target and waiting >= COMPACT_EVERY:
                target.cache.compact()
                waiting = 0
    if target:
        target.cache.compact()


def check_writable(store: Store, paths: Iterable[str], *, force: bool) -> None:
    """Refuse a library that this user may not change, before the work whose result it keeps.

    Where it holds all of the files, they may be unchanged: then there is nothing to write.
    """
    try:
        store.check_writable()
    except LibraryError:
        held = {parted(place)[0] for place in store.known()}
        if force or not held.issuperset(parted(absolute(path))[0] for path in paths):
            raise


def again(
    store: Store, profile: Profile, jobs: int, spread: Spread | None, tick: Callable[[], None]
) -> tuple[int, Generator[Outcome, None, None]]:
    """Return how many files a library holds captures of, and what writes them down anew.

    Each is read as it was ingested; what has the profile already, and scores, stay.
    """
    groups: dict[tuple[tuple[str, str], ...], dict[str, None]] = {}
    for place, (_, encoding) in store.known().items():
        tick()
        if encoding.digest not in ("", profile.digest):
            options = tuple(sorted(encoding.options.items()))
            groups.setdefault(options, {})[parted(place)[0]] = None
    if groups:
        store.check_writable()

    def outcomes() -> Generator[Outcome, None, None]:
        how: dict[str, Any] = {"jobs": jobs, "spread": spread}
        for options, files in groups.items():
            yield from ingest(store, files, profile, reading=Reading(**dict(options)), **how)

    return sum(map(len, groups.values())), outcomes()


def _with_duplicate_warning(
    outcome: Outcome, place: str, first: dict[tuple[str, str, str], str]
) -> Outcome:
    """Warn of a file with the content of another that is there, by the first of each content."""
    content = outcome.sha256, outcome.encoding.beside, parted(place)[1]
    other = first.setdefault(content, place) if outcome.sha256 else place
    if outcome.status != "added" or on_disk(other) == on_disk(place) or is_gone(other):
        return outcome
    return replace(outcome, warnings=(*outcome.warnings, f"the same content as {other}"))


def _store(store: Store, outcome: Outcome, labels: Labels, told_anew: bool) -> Outcome:
    if outcome.status == "failed":
        return outcome
    place = absolute(outcome.path)
    if outcome.moved or told_anew:
        store.move(outcome.moved or place, outcome.path, outcome.encoding.version)
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
                subjects = [SUBJECT + name if name else "" for name in people]
                self.places |= {file + subject: before + subject for subject in subjects}
                return {"" if person else name: one for name, one in people.items()}
        return {}


# Which captures there are: in folders, in archives, several people in one file.


def discover(
    paths: Iterable[str | os.PathLike[str]], others: list[str] | None = None, *, apart: bool = True
) -> Iterator[str]:
    """Yield the captures to ingest: those named, and all that folders and archives hold, sorted."""
    seen: set[str] = set()
    left = [] if others is None else others
    for named in paths:
        for file in _files_at(locations.plain(named), left):
            place = locations.located(file)
            if place not in seen:
                seen.add(place)
                yield from map(printable, _captures_in(file, left, apart))


def _files_at(path: str, others: list[str]) -> Iterable[str]:
    """Return the files that are looked at where somebody names a file or a folder."""
    try:
        if not locations.is_folder(path):
            return [path]
    except CaptureError:  # reported when it is read
        return [path]
    return (_walk_store if locations.is_url(path) else _walk)(path, others)


def _walk_store(folder: str, others: list[str]) -> Iterator[str]:
    closed: list[str] = []
    for file in locations.walk(folder, closed):
        yield from if_read(file, others)
    yield from closed


def _walk(folder: str, others: list[str]) -> Iterator[str]:
    closed: list[OSError] = []
    for place, folders, names in os.walk(folder, onerror=closed.append):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        inner = (os.path.join(place, name) for name in folders)
        others.extend(path for path in inner if os.path.islink(path))  # they could form a circle
        for name in sorted(name for name in names if not name.startswith(".")):
            yield from if_read(os.path.join(place, name), others)
    for error in closed:  # reported like a file that cannot be read
        yield str(error.filename)


def if_read(path: str, others: list[str]) -> Iterator[str]:
    """Yield a path if what it leads to is an archive, a capture or a score."""
    suffix = Path(path).suffix.lower()
    packed = archives.is_archive(path) and not archives.split(path)[0]
    unsure = suffix in _UNSURE and not formats.is_capture(path)
    if packed or (suffix in SUFFIXES and not unsure):
        yield path
    elif suffix not in COMPANIONS:
        others.append(path)


def _captures_in(path: str, others: list[str], apart: bool) -> Iterator[str]:
    """Yield the captures in a file or an archive; several people in one file are told `apart`."""
    files: Iterable[str] = [path]
    try:
        if archives.is_archive(path) and locations.is_file(path):
            members = (
                path + archives.MARK + name
                for name in archives.members(path)
                if not any(part.startswith((".", "__MACOSX")) for part in name.split("/"))
            )
            files = (file for member in members for file in if_read(member, others))
        for file in files:
            yield from formats.captures_in(file) if apart else (file,)
    except LanindexError:  # reported when it is read
        yield path


def left_out(others: Iterable[str]) -> str:
    """Say how many files were passed over: by ending for formats that are not read yet."""
    paths = set(map(locations.located, others))
    kinds = Counter(
        "/" if os.path.isdir(path) else "picture" if is_printed(path) else unread(path)
        for path in paths
    )
    rest, linked, pictures = (kinds.pop(kind, 0) for kind in ("", "/", "picture"))
    by_number = sorted(kinds.items(), key=lambda kind: (-kind[1], kind[0]))
    counts = []
    for angles, why in ((False, "formats that are not read yet"), (True, "angles without places")):
        some = [f"{number} {kind}" for kind, number in by_number if (kind in ANGLES) is angles]
        counts += [f"{', '.join(some)} ({why})"] if some else []
    if pictures:
        counts.append(f"{counted(pictures, 'picture')} (name those of printed scores)")
    for number, noun in ((rest, "other file"), (linked, "linked folder")):
        counts += [counted(number, noun)] if number else []
    return "; ".join(counts)


# What users know of their captures: a table with a column ``file``.


def key_of(path: str | os.PathLike[str]) -> str:
    """Return the key of a path in `Labels`: absolute, its letters composed.

    One system writes é as one character, another as two; a table made on the one fits files that
    lie on the other.
    """
    return unicodedata.normalize("NFC", absolute(path))


def is_labels(path: str | os.PathLike[str]) -> bool:
    """Return whether a file is a table of labels: its first line names a column ``file``."""
    if Path(path).suffix.lower() not in (".csv", ".tsv", ".txt"):
        return False
    with open(path, encoding="utf-8-sig", errors="replace") as file:
        head = file.readline(_LONGEST_HEAD)
    return any("file" in names_of(head, delimiter) for delimiter in _DELIMITERS)


def names_of(head: str, delimiter: str) -> list[str]:
    """Return the names of the columns in a table's first line."""
    return [name.strip(' "\r\n').lower() for name in head.split(delimiter)]


def read_labels(
    path: str | os.PathLike[str], files: Iterable[str | os.PathLike[str]] | None = None
) -> Labels:
    """Read labels and other columns; refuse a table that names none of the files."""
    place = locations.plain(path)
    (first, names), *rows = _rows(place) or [(1, [])]
    head = [name.lower() for name in names]
    _check_head(head, f"{place}:{first}")
    labels: Labels = {}
    for line, row in rows:
        row += [""] * (len(head) - len(row))
        _check_row(row, head, f"{place}:{line}")
        cells = dict(zip(head, row, strict=True))
        file = cells.pop("file")
        if locations.is_url(file):  # never asked for: somebody else may have made the table
            key = key_of(file)
        else:
            beside = locations.beside(place, file)
            key = key_of(file if is_gone(beside) and not is_gone(file) else beside)
        label = cells.pop("label", "") or None
        entry = label, {name: cell for name, cell in cells.items() if cell}
        if labels.setdefault(key, entry) != entry:
            found = f"{key} stands twice"
            raise UsageError(found, place=f"{place}:{line}", wanted="one line a file")
    if labels and files is not None:
        held = {key_of(on_disk(os.fspath(file))) for file in files}
        named = (
            locations.holders(key) if locations.is_url(key) else {key_of(on_disk(key))}
            for key in labels
        )
        if not any(names & held for names in named):
            raise UsageError(unfitting(labels, held), place=place)
    return labels


def unfitting(labels: Labels, files: Iterable[str | os.PathLike[str]]) -> str:
    """Say how many rows of a table fit none of the files, and what they may have meant."""
    keys = {key_of(file) for file in files}
    unknown = [key for key in labels if key not in keys]
    if len(unknown) < len(labels) or not labels:
        return f"{len(unknown)} of {len(labels)} rows name no file that is read" if unknown else ""
    near = _nearest_key(unknown[0], keys)
    first = f"the first names {unknown[0]}" + (f"; is it {near}?" if near else "")
    return f"no row names a file that is read; {first} ({_FROM})"


def _nearest_key(key: str, keys: Iterable[str]) -> str:
    """Return the key of the likest file name, the likest path among equal ones."""
    from rapidfuzz import fuzz, process

    named = {other: os.path.basename(other) for other in sorted(keys)}
    near = process.extract(
        os.path.basename(key), named, scorer=fuzz.ratio, limit=20, score_cutoff=60
    )
    best = [other for _, score, other in near if score == near[0][1]]
    return max(best, key=lambda other: fuzz.ratio(key, other), default="")


def _rows(place: str) -> list[tuple[int, list[str]]]:
    """Return the rows that hold anything, each with its line."""
    text = read_text(place)
    head = next((line for line in text.splitlines() if line.strip()), "")

    def fits(delimiter: str) -> tuple[bool, int]:
        names = names_of(head, delimiter)
        return "file" in names, len(names)

    delimiter = max(_DELIMITERS, key=fits)
    table = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    try:
        rows = [(table.line_num, [cell.strip() for cell in row]) for row in table]
    except csv.Error as error:
        raise UsageError(str(error), place=f"{place}:{table.line_num}", wanted="CSV") from error
    return [(line, row) for line, row in rows if any(row)]


def _check_head(head: list[str], place: str) -> None:
    if "file" not in head:
        found = f"the columns are {shown(', '.join(head), 200) or 'none'}"
        raise UsageError(found, place=place, wanted='a column "file", and "label"')
    for number, name in enumerate(head, 1):
        if name and name in head[: number - 1]:
            found = f'columns {head.index(name) + 1} and {number} are both called "{shown(name)}"'
            raise UsageError(found, place=place, wanted="a name for each")
        if "=" in name:  # a condition, column=glob, cannot name it
            found = f'column {number} is called "{shown(name)}"'
            raise UsageError(found, place=place, wanted='a name without "="')


def _check_row(row: list[str], head: list[str], place: str) -> None:
    if len(row) > len(head):
        raise UsageError(f"{len(row)} cells", place=place, wanted=f"{len(head)} as in line 1")
    for number, (name, cell) in enumerate(zip(head, row, strict=True), 1):
        if cell and not name:
            found = f'column {number} has no name and holds "{shown(cell)}"'
            raise UsageError(found, place=place, wanted="a name for it in line 1")
    if not row[head.index("file")]:
        raise UsageError("no file", place=place, wanted='one in the column "file"')
