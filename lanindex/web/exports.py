"""What leaves a library by the page: clips, films, a data set or ELAN files of hits, as a ZIP."""

from __future__ import annotations

import json
import os
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from starlette.responses import Response, StreamingResponse

from lanindex.errors import UsageError
from lanindex.notation import eaf
from lanindex.notation.tiers import TierEntry, milliseconds
from lanindex.pipeline import dataset
from lanindex.pipeline.export import FORMATS, ClipOptions, clips
from lanindex.pipeline.jobs import Job
from lanindex.pipeline.named import Request, from_lines
from lanindex.web.jobs import trouble
from lanindex.web.routes import Call

if TYPE_CHECKING:
    from lanindex.pipeline.library import Library

MOST = 2000
"""Hits of an export."""

_TIER = "hits"
_CHUNK = 1 << 16  # bytes that are sent at once

Files = Iterator[tuple[str, bytes]]
"""Names of files with what is in them."""


def _clips(library: Library, requests: list[Request], options: dict[str, str]) -> Files:
    how = ClipOptions(options["pad"], options["format"])
    for file in clips(library.store, requests, how, []):
        yield file.name, bytes(file.content[:])


def _films(library: Library, requests: list[Request], options: dict[str, str]) -> Files:
    how = ClipOptions(options["pad"], "lnd", preview=options["film"])
    for file in clips(library.store, requests, how, []):
        yield file.name, bytes(file.content[:])


def _dataset(library: Library, requests: list[Request], options: dict[str, str]) -> Files:
    patterns: dict[str, list[Request]] = defaultdict(list)
    for request in requests:
        patterns[request.pattern].append(request)
    groups = [dataset.of_requests(some, pattern) for pattern, some in patterns.items()]
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder, "dataset")
        dataset.write(library.store, groups, place, dataset.DatasetOptions(pad=options["pad"]))
        for path in sorted(place.rglob("*")):
            if path.is_file():
                yield path.relative_to(place).as_posix(), path.read_bytes()


def _elan(library: Library, requests: list[Request], options: dict[str, str]) -> Files:
    captures: dict[int, list[Request]] = defaultdict(list)
    for request in requests:
        captures[request.capture.id].append(request)
    for number, some in captures.items():
        capture = some[0].capture
        name = f"{number} {Path(capture.path).stem}.eaf"
        content, last, tier = eaf.write(library.score(number)), 0, list[TierEntry]()
        for request in sorted(some, key=lambda it: it.hit.start):
            start, stop = (
                milliseconds(it, capture.rate) for it in (request.hit.start, request.hit.stop)
            )
            start = max(start, last)  # in a tier nothing shares time
            last = max(stop, start + 1)
            tier.append(TierEntry(" ".join(request.pattern.split()) or "hit", start, last))
        yield name, eaf.mark(content, _TIER, tier, place=name)


_KINDS: dict[str, Callable[[Library, list[Request], dict[str, str]], Files]] = {
    "clips": _clips,
    "films": _films,
    "dataset": _dataset,
    "elan": _elan,
}


class Export(Job[IO[bytes]]):
    """Hits that are written into a ZIP."""

    noun = "files"

    def __init__(
        self, library: Library, kind: str, hits: list[Any], options: dict[str, str]
    ) -> None:
        super().__init__()
        self.kind, self._library, self._hits, self._options = kind, library, hits, options
        self._begin()

    def _work(self) -> IO[bytes]:
        requests = from_lines(self._library.store, map(json.dumps, self._hits))
        file = tempfile.TemporaryFile()  # noqa: SIM115 (open as long as the job is kept)
        with ZipFile(file, "w", ZIP_DEFLATED) as packed:
            for done, (name, content) in enumerate(
                _KINDS[self.kind](self._library, requests, self._options), 1
            ):
                packed.writestr(ZipInfo(name), content, ZIP_DEFLATED)
                self._tell(self.noun, done, 0)
        return file

    def told(self) -> dict[str, Any]:
        """Return how far it is."""
        told: dict[str, Any] = {"state": self.state, "progress": self.progress}
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
    file = job.result

    def parts() -> Iterator[bytes]:
        at = 0
        while part := os.pread(file.fileno(), _CHUNK, at):
            at += len(part)
            yield part

    headers = {"content-disposition": f'attachment; filename="{job.kind}.zip"'}
    return StreamingResponse(parts(), media_type="application/zip", headers=headers)
