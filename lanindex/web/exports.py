"""What leaves a library by the page: clips, films, a data set or ELAN files of hits, as a ZIP."""

from __future__ import annotations

import json
import os
import tempfile
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any
from weakref import finalize
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from starlette.responses import Response, StreamingResponse

from lanindex.errors import LanindexError, UsageError, counted, shown
from lanindex.notation import NOTATIONS, eaf, left_out
from lanindex.notation.tiers import TierEntry, milliseconds
from lanindex.pipeline import dataset
from lanindex.pipeline.export import FORMATS, ClipOptions, clips, source_of
from lanindex.pipeline.jobs import Job
from lanindex.pipeline.named import Request, from_lines
from lanindex.web.jobs import trouble
from lanindex.web.routes import Call

if TYPE_CHECKING:
    from lanindex.model import Capture
    from lanindex.pipeline.library import Library

MOST = 2000
"""Hits of an export."""

_TIER = "hits"
_NOTED = 20  # sentences that are told beside the file; all of them stand in it
_CHUNK = 1 << 16  # bytes that are sent at once

Files = Iterator[tuple[str, bytes]]
"""Names of files with what is in them."""


Note = Callable[[str], None]
"""Is given a sentence on what is lost."""

NOTES = "NOTES.txt"


def _clips(library: Library, requests: list[Request], options: dict[str, str], note: Note) -> Files:
    how = ClipOptions(options["pad"], options["format"])
    for file in clips(library.store, requests, how, [], note):
        yield file.name, bytes(file.content[:])


def _films(library: Library, requests: list[Request], options: dict[str, str], note: Note) -> Files:
    how = ClipOptions(options["pad"], "lnd", preview=options["film"])
    for file in clips(library.store, requests, how, [], note):
        yield file.name, bytes(file.content[:])


def _dataset(
    library: Library, requests: list[Request], options: dict[str, str], note: Note
) -> Files:
    patterns: dict[str, list[Request]] = defaultdict(list)
    for request in requests:
        patterns[request.pattern].append(request)
    groups = [dataset.of_requests(some, pattern) for pattern, some in patterns.items()]
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder, "dataset")
        how = dataset.DatasetOptions(pad=options["pad"])
        _, card = dataset.write(library.store, groups, place, how)
        for why, number in card["left_out"].items():
            note(f"left out: {counted(number, 'clip')}: {why}")
        for path in sorted(place.rglob("*")):
            if path.is_file():
                yield path.relative_to(place).as_posix(), path.read_bytes()


def _elan(library: Library, requests: list[Request], options: dict[str, str], note: Note) -> Files:
    """Yield a file for each capture; hits that overlap others go to a second tier, or a third."""
    captures: dict[int, list[Request]] = defaultdict(list)
    for request in requests:
        captures[request.capture.id].append(request)
    for number, some in captures.items():
        capture = some[0].capture
        name = f"{number} {Path(capture.path).stem}.eaf"
        score, tiers = library.score(number), list[list[TierEntry]]()
        content = eaf.write(score)
        for request in sorted(some, key=lambda it: it.hit.start):
            start, stop = (
                milliseconds(it, capture.rate) for it in (request.hit.start, request.hit.stop)
            )
            free = next((it for it in tiers if it[-1].stop <= start), None)
            if free is None:
                tiers.append(free := [])
            words = " ".join(request.pattern.split()) or "hit"
            free.append(TierEntry(words, start, max(stop, start + 1)))
        for place, tier in enumerate(tiers, 1):
            title = f"{_TIER} {place}" if place > 1 else _TIER
            content = eaf.mark(content, title, tier, place=name)
        if len(tiers) > 1:
            note(f"{name}: hits overlap, and stand in {len(tiers)} tiers")
        if lost := left_out(score, "eaf"):
            note(f"{name}: no room for {' '.join(lost)}")
        yield name, content


_KINDS: dict[str, Callable[[Library, list[Request], dict[str, str], Note], Files]] = {
    "clips": _clips,
    "films": _films,
    "dataset": _dataset,
    "elan": _elan,
}


def _trouble(library: Library, capture: Capture) -> LanindexError | None:
    """Return why a capture's file cannot be taken as it was ingested, if so."""
    try:
        source_of(library.store, capture)
    except LanindexError as error:
        return error
    return None


class Export(Job[IO[bytes]]):
    """Hits that are written into a ZIP."""

    noun = "files"

    def __init__(
        self, library: Library, kind: str, hits: list[Any], options: dict[str, str]
    ) -> None:
        super().__init__()
        self.kind, self._library, self._hits, self._options = kind, library, hits, options
        self.notes = list[str]()
        self._begin()

    def _work(self) -> IO[bytes]:
        requests = self._requests()
        file = tempfile.TemporaryFile()  # noqa: SIM115 (open as long as the job is kept)
        finalize(self, file.close)
        with ZipFile(file, "w", ZIP_DEFLATED) as packed:
            files = _KINDS[self.kind](self._library, requests, self._options, self.notes.append)
            for done, (name, content) in enumerate(chain(files, self._noted()), 1):
                packed.writestr(ZipInfo(name), content, ZIP_DEFLATED)
                self._tell(self.noun, done, 0)
        return file

    def _requests(self) -> list[Request]:
        """Return what can be written; what cannot be is noted, and is raised if nothing can be."""
        store, there, why = self._library.store, dict[int, LanindexError | None](), Counter[str]()
        found, errors = list[Request](), list[LanindexError]()
        for hit in self._hits:
            try:
                (request,) = from_lines(store, [json.dumps(hit)])
                capture = request.capture
                if self.kind != "elan" and capture.format not in NOTATIONS:
                    if capture.id not in there:
                        there[capture.id] = _trouble(self._library, capture)
                    if error := there[capture.id]:
                        raise error
                found.append(request)
            except LanindexError as error:
                errors.append(error)
                path = hit.get("capture") if isinstance(hit, dict) else None
                why[f"{shown(str(path), 200)}: {error.found}"] += 1
        if not found:
            raise errors[0]
        self.notes += [f"left out: {counted(number, 'hit')} of {it}" for it, number in why.items()]
        return found

    def _noted(self) -> Files:
        if self.notes:
            yield NOTES, "".join(f"{it}\n" for it in self.notes).encode()

    def told(self) -> dict[str, Any]:
        """Return how far it is, and what was lost."""
        told: dict[str, Any] = {"state": self.state, "progress": self.progress}
        told["notes"] = self.notes[:_NOTED]
        if self.error is not None:
            told["error"] = trouble(self.error)
        return told


def begin(call: Call) -> dict[str, Any]:
    """Begin to write hits into a ZIP."""
    kind, hits = call.said("kind", str, "clips"), call.said("hits", list, [])
    options = {
        "pad": call.said("pad", str, "0"),
        "format": call.said("format", str, "native"),
        "film": call.said("film", str, "webp"),
    }
    if kind not in _KINDS:
        raise UsageError(f'"{kind[:20]}"', place="kind", wanted=f"one of {', '.join(_KINDS)}")
    if options["format"] not in FORMATS:
        raise UsageError(f'"{options["format"][:20]}"', place="format", wanted=", ".join(FORMATS))
    if not 0 < len(hits) <= MOST:
        raise UsageError(f"{len(hits)} hits", wanted=f"1 to {MOST:,}")

    def export() -> Export:
        return Export(call.site.library, kind, hits, options)

    return {"job": call.site.jobs.begin(("export", object()), export)}


def packed(call: Call) -> Response:
    """Return the ZIP of an export."""
    job = call.site.jobs.get(call.path["job"])
    if not isinstance(job, Export) or job.state == "running":  # nothing is waited for
        raise UsageError("this job", wanted="an export that has ended")
    size = os.fstat(job.result.fileno()).st_size  # or raises why there is none

    def parts() -> Iterator[bytes]:
        at = 0
        while part := os.pread(job.result.fileno(), _CHUNK, at):
            at += len(part)
            yield part

    disposition = f'attachment; filename="{job.kind}.zip"'
    headers = {"content-disposition": disposition, "content-length": str(size)}
    return StreamingResponse(parts(), media_type="application/zip", headers=headers)
