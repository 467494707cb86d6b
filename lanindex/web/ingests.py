"""Files that were sent are read into the library, as a job; those that nothing came of go again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Any

from lanindex.errors import UsageError
from lanindex.formats import archives
from lanindex.formats.file import on_disk
from lanindex.formats.sniff import UNREAD, WITHOUT_PLACES
from lanindex.model import Reading
from lanindex.notation import NOTATIONS, is_printed
from lanindex.pipeline.files import choreographies
from lanindex.pipeline.ingest import SUFFIXES, Labels, if_read, is_labels, key_of, read_labels
from lanindex.pipeline.jobs import IngestJob
from lanindex.pipeline.prepare import processes
from lanindex.web.jobs import Told, trouble
from lanindex.web.routes import Call
from lanindex.web.uploads import BESIDE

if TYPE_CHECKING:
    from lanindex.web.server import Site

_READING = {"unit": "unit", "up": "up", "fps": "rate"}
_PAGE = 500  # outcomes in an answer, at most
_NO_CAPTURE = "neither a capture nor a score"


class Ingest(Told[IngestJob]):
    """Captures that are read into the library; `left` are files that were sent for nothing."""

    def __init__(self, site: Site, job: IngestJob, sent: Sequence[str], left: list[str]) -> None:
        super().__init__(job)
        self.left = left
        self._site, self._sent = site, sent
        self._tidied = Thread(target=self._tidy, daemon=True)
        self._tidied.start()

    @property
    def state(self) -> str:
        """As of the job that reads; it runs until what is of no use has gone."""
        return "running" if self._tidied.is_alive() else self.job.state

    def told(self) -> dict[str, Any]:
        """Return how far it is."""
        state = self.state
        _, done, total = self.job.progress
        counts = Counter(it.status for it in self.job.outcomes)
        return {
            "state": state,
            "done": done,
            "total": total,
            "counts": counts,
            "labelled": sum(it.labelled for it in self.job.outcomes),
            "error": trouble(self.job.error),
        }

    def _tidy(self) -> None:
        self.job.wait()
        used = set[str]()
        for outcome in self.job.outcomes:
            if outcome.status != "failed":
                used |= {on_disk(outcome.path), *outcome.beside}
        self._site.uploads.drop(map(Path, self._sent), used)


def about(call: Call) -> dict[str, Any]:
    """Return by which endings files are worth sending, and what is said of all others."""
    unread = {
        ending: "angles without places" if ending in WITHOUT_PLACES else f"{name} is not read yet"
        for ending, name in UNREAD.items()
    }
    packed = (*archives.ZIPPED, *archives.TARRED)
    return {
        "endings": [*SUFFIXES, *BESIDE, *packed],
        "pictures": [it.suffix for it in NOTATIONS.values() if not it.written],
        "unread": unread,
        "other": _NO_CAPTURE,
        "profiles": call.site.workshop.shelf.names(),
    }


def begin(call: Call) -> dict[str, Any]:
    """Begin to read files that were sent, or the bundled choreographies."""
    site = call.site
    if call.body.get("choreographies") is True:
        corpus = choreographies()
        captures = [str(path) for path in sorted(corpus.glob("*.bvh"))]
        labels = read_labels(corpus / "labels.csv", captures)
        return _begun(call, captures, labels, [], [])
    sent = call.said("files", dict, {})
    if not sent or not all(isinstance(it, str) for it in sent.values()):
        raise UsageError("no files", place="files", wanted="names that were sent, and kept")
    paths = site.uploads.gathered(sent)
    try:
        tables = [path for path in paths.values() if is_labels(path)]
        if len(tables) > 1:
            names = " and ".join(Path(path).name for path in tables[:2])
            raise UsageError(f"{len(tables)} tables of labels: {names}", wanted="one at a time")
        others = list[str]()
        rest = [path for path in paths.values() if path not in tables]
        captures = list[str]()
        for path in rest:  # a picture that was sent is meant to be read; in an archive it is not
            captures += [path] if is_printed(path) else if_read(path, others)
        if not captures:
            raise UsageError("no capture is among these files", wanted="captures or scores")
        table = _labels(site, tables[0], paths) if tables else None
        left = [path for path in others if Path(path).suffix.lower() not in BESIDE]
        return _begun(call, captures, table, list(paths.values()), left)
    except BaseException:
        site.uploads.drop(map(Path, paths.values()))
        raise


def _labels(site: Site, table: str, paths: Mapping[str, str]) -> Labels:
    """Read labels; a file that had to be given another name is named there as it was sent."""
    asked = {name: site.uploads.place(name) for name in paths}
    labels = read_labels(table, [*paths.values(), *asked.values()])
    renamed = {key_of(asked[name]): key_of(path) for name, path in paths.items()}
    return {renamed.get(key, key): entry for key, entry in labels.items()}


def _begun(
    call: Call, captures: list[str], labels: Labels | None, sent: list[str], left: list[str]
) -> dict[str, Any]:
    site = call.site
    options = call.said("reading", dict, {})
    if not all(name in _READING and isinstance(it, str) for name, it in options.items()):
        raise UsageError(f"{options!r:.40}", place="reading", wanted=f"{', '.join(_READING)}")
    reading = Reading(**{_READING[name]: value for name, value in options.items() if value})
    profile = site.workshop.shelf.place(call.said("profile", str, "default"))

    def make() -> Ingest:
        job = site.library.begin_ingest(
            captures,
            profile=profile,
            reading=reading,
            labels=labels,
            jobs=processes(len(captures), None),
        )
        return Ingest(site, job, sent, left)

    return {"job": site.jobs.begin(object(), make, goes_on="ingest")}


def outcomes(call: Call) -> dict[str, Any]:
    """Return what became of the files of a job so far, from one of them on."""
    job = call.site.jobs.get(call.path["job"])
    if not isinstance(job, Ingest):
        raise UsageError("this job reads no files", place="job", wanted="an ingest")
    at, numbers = int(call.number("at", 0)), dict[str, int]()
    if job.state != "running":
        numbers = {it["capture"]: it["capture_id"] for it in call.site.table.now().records}
    folder = call.site.uploads.folder
    some = [
        {
            "name": _short(outcome.path, folder),
            "status": outcome.status,
            "error": outcome.error and outcome.error.replace(f"{folder}/", ""),
            "doubts": [it.replace(f"{folder}/", "") for it in outcome.warnings],
            "capture_id": numbers.get(outcome.path),
        }
        for outcome in job.job.outcomes[at : at + _PAGE]
    ]
    left = [{"name": _short(path, folder), "reason": _NO_CAPTURE} for path in job.left]
    return {**job.told(), "outcomes": some, "left": left}


def _short(path: str, folder: Path) -> str:
    """Return a path below the folder of what was sent, or the name of a file elsewhere."""
    own = f"{folder}/"
    return path.removeprefix(own) if path.startswith(own) else Path(path).name
