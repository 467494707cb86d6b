"""Files that a browser sends: written beside the library, under safe names, then ingested.

A file is written under a name that ends in ``.part`` and gets its own when it is whole: what breaks
off leaves nothing that is read. No file is replaced, and none is ever executed.
"""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Container, Iterable, Mapping
from contextlib import suppress
from hashlib import file_digest, sha256
from itertools import count
from pathlib import Path
from typing import IO, TYPE_CHECKING, NamedTuple

from anyio import fail_after, to_thread
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response

from lanindex.errors import LanindexError, UsageError
from lanindex.library.dialect import Target
from lanindex.pipeline.files import safe_stem
from lanindex.web.routes import Refused, as_json, failed

if TYPE_CHECKING:
    from lanindex.web.server import Site

LARGEST = 2 << 30
"""Bytes of a file."""

SPARE = 1 << 30
"""Bytes that stay free on the disk."""

PATIENCE = 30
"""Seconds within which the next bytes of a file must come."""

BESIDE = (".asf", ".bin", ".json")
"""Endings of files that are no captures and are read with one: skeletons, data of glTF and BIDS."""

_DEEPEST = 8  # folders
_PART = ".part"


class Uploads:
    """The folder of what browsers sent."""

    def __init__(self, library: Target) -> None:
        self.folder = library.beside("captures")
        self.new = set[Path]()  # what was sent and is not in the library yet

    def clear(self) -> None:
        """Remove what was not sent to its end, by a server that is gone."""
        for draft in self.folder.glob(f"*{_PART}"):
            with draft.open("rb") as file:
                left = _locked(file)  # else another server is writing it
            if left:
                with suppress(PermissionError):
                    draft.unlink(missing_ok=True)

    def place(self, name: str) -> Path:
        """Return where a file of this name is kept: below the folder, whatever the name says."""
        *folders, last = [it for it in name.replace("\\", "/").split("/") if it.strip(". ")] or [""]
        if len(folders) >= _DEEPEST:
            raise UsageError("too many folders in each other", wanted=f"{_DEEPEST} at most")
        ending = "".join(it for it in Path(last).suffix.lower() if it.isalnum() or it == ".")
        safe = [safe_stem(f"{it}.") for it in folders]
        return self.folder.joinpath(*safe, safe_stem(last) + ending[:12])

    def keep(self, name: str, content: bytes) -> Path:
        """Write a file that was made here as one that was sent, and return its path."""
        self.folder.mkdir(parents=True, exist_ok=True)
        path = self.folder / f"{secrets.token_hex(8)}{_PART}"
        try:
            path.write_bytes(content)
            kept, new = _kept(_Draft(path, sha256(content).hexdigest()), self.place(name))
        finally:
            path.unlink(missing_ok=True)
        if new:
            self.new.add(kept)
        return kept

    def path(self, name: str) -> str:
        """Return the path of a file that was sent; refuse any other."""
        path = self.folder / name
        try:
            sent = path.resolve().is_relative_to(self.folder.resolve()) and path.is_file()
        except (OSError, ValueError):  # too long, or no name at all
            sent = False
        if not sent:
            raise UsageError(f'"{name[:60]}" was not sent', wanted="the name of a file that was")
        return str(path)

    def gathered(self, sent: Mapping[str, str]) -> dict[str, str]:
        """Return the paths of files that were sent together, by the names that they were sent by.

        A file that another one is read with, such as a skeleton, is known by its name. Where one
        had to be given another name, all of its folder go to a folder of their own.
        """
        paths = {name: Path(self.path(kept)) for name, kept in sent.items()}
        moved = {
            self.place(name).parent
            for name, path in paths.items()
            if path.suffix.lower() in BESIDE and path != self.place(name)
        }
        for folder in moved:
            own = next(
                place
                for number in count(2)
                if not (place := folder.with_name(f"{folder.name} {number}")).exists()
            )
            own.mkdir()
            for name, path in paths.items():
                if self.place(name).parent == folder:
                    paths[name] = own / self.place(name).name
                    os.link(path, paths[name])
                    self.drop([path])
                    self.new.add(paths[name])
        return {name: str(path) for name, path in paths.items()}

    def drop(self, paths: Iterable[Path], used: Container[str] = ()) -> None:
        """Remove those of some files that are new and that nothing was made of."""
        for path in self.new.intersection(paths):
            self.new.discard(path)
            if str(path) not in used:
                path.unlink(missing_ok=True)
                for folder in path.parents:
                    if folder == self.folder.parent or any(folder.iterdir()):
                        break
                    folder.rmdir()


class _Draft(NamedTuple):
    path: Path
    digest: str


def _locked(file: IO[bytes]) -> bool:
    """Lock a file as long as it is open, and return whether no other process has done so."""
    try:
        import fcntl
    except ImportError:  # Windows lets nobody remove what is open: PermissionError
        return True
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


async def receive(site: Site, request: Request) -> Response:
    """Write the body of a request as a file, and return its name below the folder."""
    try:
        if site.readonly:
            raise Refused("this library is only shown", remedy="Ask its owner to change it.")
        target = site.uploads.place(request.path_params["name"])
        draft = await _written(request, site.uploads.folder)
        try:
            kept, new = await to_thread.run_sync(_kept, draft, target)
            if new:
                site.uploads.new.add(kept)
        finally:
            draft.path.unlink(missing_ok=True)
        return as_json({"name": kept.relative_to(site.uploads.folder).as_posix()})
    except ClientDisconnect:
        return Response(status_code=499)
    except OSError as error:
        broken = LanindexError(f"the file cannot be written ({error.strerror})")
        return failed(broken, request.url.path)
    except Exception as error:
        return failed(error, request.url.path)


async def _written(request: Request, folder: Path) -> _Draft:
    """Write a body to a draft, as long as it is neither too long nor too slow."""
    too_long = UsageError("a file that is too long", wanted=f"{LARGEST >> 30} GB at most")
    if int(request.headers.get("content-length") or 0) > LARGEST:
        raise too_long
    folder.mkdir(parents=True, exist_ok=True)
    path, digest, size = folder / f"{secrets.token_hex(8)}{_PART}", sha256(), 0
    stream = aiter(request.stream())
    with path.open("xb") as file:
        _locked(file)
        try:
            while True:
                with fail_after(PATIENCE):
                    part = await anext(stream, None)
                if part is None:
                    return _Draft(path, digest.hexdigest())
                size += len(part)
                if size > LARGEST:
                    raise too_long
                if shutil.disk_usage(folder).free < SPARE + len(part):
                    raise LanindexError("the disk is full", remedy="Make room, and send it again.")
                digest.update(part)
                await to_thread.run_sync(file.write, part)
        except BaseException as error:
            path.unlink(missing_ok=True)
            if isinstance(error, TimeoutError):
                raise LanindexError("the file came too slowly", remedy="Send it again.") from error
            raise


def _kept(draft: _Draft, target: Path) -> tuple[Path, bool]:
    """Give a draft its name, or one with a number, and return whether it is new.

    A file that is there with its content stays.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    place = target
    for number in range(2, 10_000):
        if not place.parent.resolve().is_relative_to(draft.path.parent.resolve()):
            raise UsageError("the name leads out of the folder", wanted="another name")
        try:
            os.link(draft.path, place)
            return place, True
        except FileExistsError:
            if place.is_file() and not place.is_symlink():
                with place.open("rb") as file:
                    if file_digest(file, "sha256").hexdigest() == draft.digest:
                        return place, False
        place = target.with_name(f"{target.stem} {number}{target.suffix}")
    raise LanindexError("too many files of this name", remedy="Send it under another name.")
