"""Files that are written whole or not at all, and never where they should not be."""

import os
import re
import tempfile
import unicodedata
from collections.abc import Callable, Container, Iterable, Sequence
from contextlib import suppress
from itertools import takewhile
from pathlib import Path
from typing import IO

from lanindex.errors import ExportError, LanindexError

_STEM = 200
"""Bytes of a stem: most file systems take names of 255, and frames and endings follow."""

_DEVICES = re.compile(r"(con|prn|aux|nul|(com|lpt)[0-9¹²³])\s*(\..*)?", re.IGNORECASE)
"""Names that Windows keeps for devices, whatever ending they have."""


def safe_stem(path: str) -> str:
    """Return a file's name without folders and ending, with nothing that a shell might trip on."""
    name = re.split(r"/|\\(?!x[89a-f][0-9a-f])", path)[-1]
    stem = name.rsplit(".", 1)[0] if "." in name[1:] else name
    safe = (
        "".join(map(_safe_letter, unicodedata.normalize("NFC", stem))).strip(". ").lstrip("-=+@. ")
    )
    cut = safe.encode()[:_STEM].decode(errors="ignore").rstrip(". ")
    return f"_{cut}" if _DEVICES.fullmatch(cut) else cut or "clip"


def _safe_letter(letter: str) -> str:
    mark = unicodedata.category(letter).startswith("M")
    return letter if letter.isalnum() or mark or letter in "_.#+=@ -" else "_"


def write_all(
    files: Iterable[tuple[Path, bytes | Callable[[IO[bytes]], object]]],
    *,
    force: bool = False,
    sources: Iterable[str | os.PathLike[str]] = (),
    suspects: Callable[[Sequence[Path]], Iterable[str]] = lambda replaced: (),
) -> None:
    """Write several files, all or none."""
    drafts: list[tuple[str, Path]] = []
    folders: list[Path] = []
    read_files = {_identity(source) for source in sources}
    try:
        for path, content in files:
            refuse(path, force=force, sources=read_files)
            folders += takewhile(lambda folder: not folder.exists(), path.parents)
            drafts.append((_write_draft(path, content), path))
        if replaced := [path for _, path in drafts if path.exists()]:
            identities = {_identity(source) for source in suspects(replaced)}
            for path in replaced:
                _refuse_source(path, identities)
        while drafts:
            os.replace(*drafts[0])
            drafts.pop(0)
    except OSError as error:
        raise ExportError(f"cannot be written ({error.strerror})", place=str(path)) from error
    finally:
        for draft, _ in drafts:
            Path(draft).unlink(missing_ok=True)
        for folder in sorted(folders, reverse=True):  # the inner ones first
            with suppress(OSError):  # it is not empty
                folder.rmdir()


def _identity(path: str | os.PathLike[str]) -> tuple[int, int] | None:
    """Return what tells a file apart, however it is spelt or linked to; None: it is not there."""
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_dev, found.st_ino


def refuse(
    path: Path, *, force: bool = False, sources: Container[tuple[int, int] | None] = ()
) -> None:
    """Refuse, before the work, a place that no file can be written to."""
    for folder in path.parents:
        if folder.exists() and not folder.is_dir():
            raise ExportError("is a file", place=str(folder), wanted="a folder")
    if path.is_dir():
        raise ExportError("is a folder", place=str(path), wanted="a file's name")
    if path.exists() and not path.is_file():  # a device, a pipe or a socket
        raise ExportError("is no regular file", place=str(path), wanted="another name")
    _refuse_source(path, sources)
    if os.path.lexists(path) and not force:
        raise ExportError(
            "exists already",
            place=str(path),
            wanted="a new file",
            remedy="Choose another folder, or replace it: --force, in Python force=True.",
        )


def _refuse_source(path: Path, sources: Container[tuple[int, int] | None]) -> None:
    """Refuse to replace a file that is read, or may be one day."""
    identity = _identity(path)
    if identity and identity in sources:
        raise ExportError("is the file that is read", place=str(path), wanted="another file")


def _write_draft(path: Path, content: bytes | Callable[[IO[bytes]], object]) -> str:
    """Write the content to a temporary file beside its place, and return that file's path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, draft = tempfile.mkstemp(dir=path.parent, prefix=".lanindex-")
    try:
        with os.fdopen(handle, "wb") as file:
            content(file) if callable(content) else file.write(content)
        os.chmod(draft, 0o666 & ~_umask())
    except BaseException:
        os.unlink(draft)
        raise
    return draft


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def choreographies() -> Path:
    """Return the folder of the bundled captures: in the package, or beside it in a checkout."""
    package = Path(__file__).parents[1]
    for folder in (package / "_corpus", package.parent / "corpus"):
        if (folder / "labels.csv").is_file():
            return folder
    raise LanindexError("the choreographies are missing", wanted="the folder corpus/")
