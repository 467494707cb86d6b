"""Files that are written whole or not at all, and never where they should not be."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Container, Iterable
from pathlib import Path

from lanindex.errors import ExportError


def safe_stem(path: str) -> str:
    """Return a file's name without folders and ending, with nothing that a shell might trip on.

    Parameters
    ----------
    path : str
        Whatever a capture is called.

    Returns
    -------
    str
        At most 100 characters, never empty, no separator, no leading dot or dash.
    """
    name = re.split(r"[/\\]", path)[-1]
    stem = name.rsplit(".", 1)[0] if "." in name[1:] else name
    kept = re.sub(r"[^\w.#+=@ -]", "_", stem, flags=re.UNICODE).strip(". ").lstrip("-")
    return kept[:100] or "clip"


def write_all(
    files: Iterable[tuple[Path, bytes]],
    *,
    force: bool = False,
    sources: Iterable[str | os.PathLike[str]] = (),
) -> None:
    """Write several files, all or none.

    Parameters
    ----------
    files : iterable of (Path, bytes)
        What to write where; folders are made. Taken one by one, so they may be many; an error on
        the way leaves no trace.
    force : bool
        Whether regular files that are there already may be replaced.
    sources : iterable of path-like
        What is read, or will be: never replaced.

    Raises
    ------
    ExportError
        Where a file exists, is a source or no regular file, or one cannot be written; then none
        of them is changed.
    """
    drafts: list[tuple[str, Path]] = []
    kept = {identity for source in sources if (identity := _identity(source))}
    try:
        for path, content in files:
            _check(path, force, kept)
            drafts.append((_draft(path, content), path))
        while drafts:
            os.replace(*drafts[0])
            drafts.pop(0)
    except OSError as error:
        raise ExportError(f"cannot be written ({error.strerror})", place=str(path)) from error
    finally:
        for draft, _ in drafts:
            Path(draft).unlink(missing_ok=True)


def _identity(path: str | os.PathLike[str]) -> tuple[int, int] | None:
    """Return what tells a file apart, however it is spelt or linked to; None: it is not there."""
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_dev, found.st_ino


def _check(path: Path, force: bool, kept: Container[tuple[int, int] | None]) -> None:
    for folder in path.parents:
        if folder.exists() and not folder.is_dir():
            raise ExportError("is a file", place=str(folder), wanted="a folder")
    if path.is_dir():
        raise ExportError("is a folder", place=str(path), wanted="a file's name")
    if path.exists() and not path.is_file():  # a device, a pipe or a socket
        raise ExportError("is no regular file", place=str(path), wanted="another name")
    if _identity(path) in kept:
        raise ExportError("is the file that is read", place=str(path), wanted="another file")
    if os.path.lexists(path) and not force:
        raise ExportError(
            "exists already",
            place=str(path),
            wanted="a new file",
            remedy="Choose another folder, or --force to replace it.",
        )


def _draft(path: Path, content: bytes) -> str:
    """Write the content beside its place, under a name of no importance."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, draft = tempfile.mkstemp(dir=path.parent, prefix=".lanindex-")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        os.chmod(draft, 0o666 & ~_umask())
    except BaseException:
        os.unlink(draft)
        raise
    return draft


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
