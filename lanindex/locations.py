"""Where files lie: each at a path of the disk or at a URL, which fsspec opens.

What lies at a URL is copied to the disk before it is read, once for each of its versions; of one
that a library remembers, parts can be fetched alone. Nothing else knows paths from URLs.
"""

from __future__ import annotations

import os
import posixpath
import re
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from errno import ENOSPC
from pathlib import Path
from time import monotonic, time
from typing import Any

from lanindex.errors import CaptureError, LanindexError, extra, shown

FRESH = 10.0
"""Seconds for which what a store said of a file holds; where it is opened, it is asked anew."""

BYTES = 4 << 30
"""Bytes of copies that are kept."""

Mark = tuple[Any, ...]
"""What changes when a file does."""

_URL = re.compile(r"\A([A-Za-z][A-Za-z0-9+.-]+)://")  # two letters at least: Windows has disks C:
_WHEN = (
    "mtime",
    "LastModified",
    "last_modified",
    "Last-Modified",
    "updated",
    "modified",
    "created",
)
_PROCESS = f"{os.getpid()} {time()}"


def is_url(path: str) -> bool:
    """Return whether a location is a URL."""
    return _URL.match(path) is not None


def plain(path: str | os.PathLike[str]) -> str:
    """Return a location as text; of the disk, ``file:///share/a.bvh`` is a path as any other."""
    text = _URL.sub(lambda found: found[0].lower(), os.fspath(path), count=1)
    if not text.startswith("file://"):
        return text
    from urllib.request import url2pathname

    rest = text[7:].removeprefix("localhost")
    if os.name != "nt" and not rest.startswith("/"):
        found, wanted = "names another computer", "file:/// and a path"
        raise CaptureError(found, place=text, wanted=wanted, remedy="Name where it is mounted.")
    return url2pathname(rest)


def located(path: str | os.PathLike[str]) -> str:
    """Return a location made absolute."""
    text = plain(path)
    return text if is_url(text) else os.path.abspath(text)


def holders(url: str) -> set[str]:
    """Return what may be the file that holds a capture, by its name alone: no store is asked."""
    return {url, url.partition("!/")[0], url.rpartition("#")[0]}


def beside(path: str, name: str) -> str:
    """Return the location of a file that is named as seen from another one's folder."""
    if is_url(name):
        return plain(name)
    if not is_url(path) or os.path.isabs(name):
        return os.path.join(os.path.dirname(path), name)
    start, _, rest = _folder_of(path).partition("://")
    steps = {".", ".."} & set(name.split("/"))
    return f"{start}://{posixpath.normpath(rest + name) if steps else rest + name}"


def _folder_of(url: str) -> str:
    """Return the folder that a URL lies in, with the slash behind it."""
    return url[: url.rindex("/") + 1]


@dataclass(frozen=True, slots=True)
class Found:
    """What a store says of a file or folder."""

    mark: Mark
    size: int | None  # None: it does not say
    is_folder: bool
    listed: bool = False  # whether its folder's list says so, which may tell versions otherwise


_known: dict[str, tuple[float, Found | CaptureError | None]] = {}
"""By URL when a store was asked, and what it said; None: there is no such file."""

_listed: dict[str, tuple[float, dict[str, bool] | CaptureError]] = {}
"""By folder when it was listed, and what lies in it: whether that is a folder, by URL."""


_NEVER = -FRESH, None


def forget(path: str) -> None:
    """Let a file of a store be asked for anew, and the file that it is in, if it answered."""
    for url in holders(path):
        if not isinstance(_known.get(url, _NEVER)[1], CaptureError):
            _known.pop(url, None)


def _found(url: str, *, listed: bool = True) -> Found:
    """Return what a store says of a file, or its folder's list; said a moment ago, it holds."""
    asked, found = _known.get(url, _NEVER)
    only_listed = isinstance(found, Found) and found.listed and not listed
    if monotonic() - asked >= FRESH or only_listed:
        try:
            with asking(url) as (system, path):
                found = _told(url, system.info(path))
        except FileNotFoundError:
            found = None
        except CaptureError as error:
            found = error
        _known[url] = monotonic(), found
    if found is None:
        raise FileNotFoundError(url)
    if isinstance(found, CaptureError):
        raise found
    return found


def _told(url: str, info: dict[str, Any], *, listed: bool = False) -> Found:
    size, etag = info.get("size"), info.get("ETag") or info.get("etag")
    when = next((info[key] for key in _WHEN if info.get(key)), None)
    # Where nothing tells two versions apart, a copy serves the process that made it, and no other
    mark = str(etag or when or _PROCESS), size
    is_folder = info["type"] == "directory" or str(info.get("url", url)).endswith("/")
    return Found(mark, size, is_folder, listed)


@contextmanager
def asking(url: str) -> Iterator[tuple[Any, str]]:
    """Open the store of a URL, and say what is wrong as one kind of error, or `FileNotFoundError`.

    Each package behind fsspec has errors of its own.
    """
    with extra("remote", url, CaptureError):
        import fsspec.core
    protocol = url.partition("://")[0]
    try:
        fsspec.get_filesystem_class(protocol)
    except ValueError as error:
        found, wanted = f"fsspec knows no {protocol}://", "s3, gs, https or another that it knows"
        raise CaptureError(found, place=url, wanted=wanted) from error
    except ImportError as error:
        name = (getattr(error.__cause__, "name", None) or str(error)).partition(".")[0]
        found = f"{protocol}:// is opened by a package that is not installed"
        remedy = f"Install it: pip install {name}"
        raise CaptureError(found, place=url, wanted=name, remedy=remedy) from error
    try:
        system, path = fsspec.core.url_to_fs(url)
        system.invalidate_cache()  # else it goes by old lists
        yield system, path
    except (MemoryError, LanindexError):
        raise
    except Exception as error:
        if _is_absence(error):
            raise FileNotFoundError(url) from error
        cause = error.__cause__ or error if isinstance(error, FileNotFoundError) else error
        why = next(iter(str(cause).strip().splitlines()), "") or type(cause).__name__
        raise CaptureError(
            "no answer in time" if isinstance(cause, TimeoutError) else shown(why, 200),
            place=url,
            wanted="a store that answers and lets it be read",
            remedy="See to the network, the name, and the rights to read there.",
        ) from error


def _is_absence(error: Exception) -> bool:
    """Return whether a store has said that there is no such file."""
    if not isinstance(error, (FileNotFoundError, NotADirectoryError)):
        return False
    # fsspec calls all that goes wrong with HTTP so; what it was stands behind it
    cause = error.__cause__
    if type(cause).__module__.startswith("aiohttp"):
        return getattr(cause, "status", None) in (404, 410)
    return not isinstance(cause, OSError) or isinstance(cause, FileNotFoundError)


def _entries(folder: str) -> dict[str, bool]:
    """Return what lies in a folder of a store, sorted: whether it is a folder, by URL."""
    folder = folder if folder.endswith("/") else folder + "/"
    asked, listed = _listed.get(folder, (-FRESH, {}))
    if monotonic() - asked >= FRESH:
        try:
            listed = _list(folder)
        except CaptureError as error:
            listed = error
        _listed[folder] = monotonic(), listed
    if isinstance(listed, CaptureError):
        raise listed
    return listed


def _list(folder: str) -> dict[str, bool]:
    with asking(folder) as (system, path):
        infos = system.ls(path, detail=True)
    root = path.rstrip("/")
    names = ((str(it["name"]).rstrip("/"), it) for it in infos)
    entries = {folder + name.rpartition("/")[2]: it for name, it in names if name != root}
    if _is_http(folder):  # links of a page: also to itself in another order
        entries = {url: it for url, it in entries.items() if not {"?", "#"} & set(url)}
    now = monotonic()
    for url, info in entries.items():
        if info.get("size") is not None:  # else it is but a link
            _known[url] = now, _told(url, info, listed=True)
    return {url: entries[url]["type"] == "directory" for url in sorted(entries)}


def _is_http(url: str) -> bool:
    return url[:4].lower() == "http"


def siblings(path: str) -> list[str]:
    """Return the locations of what lies beside a file, sorted; servers need not tell."""
    if not is_url(path):
        folder = os.path.dirname(path)
        return sorted(os.path.join(folder, name) for name in os.listdir(folder or "."))
    try:
        return list(_entries(_folder_of(path)))
    except FileNotFoundError:
        return []


def walk(folder: str, closed: list[str]) -> Iterator[str]:
    """Yield the URLs of all files in a folder of a store, but for folders that are `closed`."""
    try:
        entries = _entries(folder)
    except (FileNotFoundError, CaptureError):
        closed.append(folder)
        return
    for url, holds_more in entries.items():
        if not url.rpartition("/")[2].startswith("."):
            yield from walk(url, closed) if holds_more else [url]


def is_folder(path: str) -> bool:
    """Return whether a folder lies at a location."""
    if not is_url(path):
        return os.path.isdir(path)
    with suppress(FileNotFoundError):
        return path.endswith("/") or _found(path).is_folder
    return False


def is_file(path: str) -> bool:
    """Return whether a file lies at a location."""
    if not is_url(path):
        return os.path.isfile(plain(path))
    with suppress(FileNotFoundError):
        return not _found(path).is_folder
    return False


def is_gone(path: str) -> bool:
    """Return whether there is surely no file at a location."""
    try:
        if is_url(path):
            if not _is_http(path):
                with suppress(FileNotFoundError):
                    _entries(_folder_of(path))  # one question for all in a folder
            _found(path)
        else:
            os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        return True
    except (OSError, CaptureError):  # It may be there, where it may not be read
        return False
    return False


def mark(path: str) -> Mark:
    """Return what changes when a file does."""
    return _found(path, listed=False).mark if is_url(path) else mark_of(os.stat(path))


def version(path: str) -> str:
    """Return what a store says that tells a file's version from all others; empty: nothing."""
    told, size = _found(path).mark if is_url(path) else (_PROCESS, None)
    return "" if told == _PROCESS or size is None else f"{size} {told}"


def mark_of(status: os.stat_result) -> Mark:
    """Return what changes when a file of the disk does."""
    return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns


def size(path: str) -> int:
    """Return the bytes of a file, 0 where nothing is there; what a list said of it will do."""
    if not is_url(path):
        return os.stat(path).st_size
    known = _known.get(path, _NEVER)[1]
    found = known if isinstance(known, Found) else _found(path)
    return found.size or 0


def head(path: str, size: int) -> bytes:
    """Return the first bytes of a file."""
    if not is_url(path):
        with open(path, "rb") as file:
            return file.read(size)
    with asking(path) as (system, place):
        return bytes(system.cat_file(place, start=0, end=size)[:size])


def parts(url: str, mark: Mark, ranges: Sequence[tuple[int, int]]) -> list[bytes] | None:
    """Return some bytes of one version of a file; None: its store gives no parts."""
    starts, stops = map(list, zip(*ranges, strict=True))
    with asking(url) as (system, path):
        found = system.cat_ranges([path] * len(ranges), starts, stops)
        for one in found:
            if isinstance(one, Exception):
                raise one
        after = _told(url, system.info(path))
    if after.mark != mark:
        raise changed(url)
    whole = all(len(one) == b - a for one, (a, b) in zip(found, ranges, strict=True))
    return [bytes(one) for one in found] if whole else None


# Copies of files of stores, by what tells their versions apart; the least recently used is let go.

_COPY = "copy-"  # so begin the names of copies

_turns = [threading.Lock() for _ in range(64)]
_unswept = BYTES  # bytes that were copied since copies were let go; at first they might have been


def local(path: str | os.PathLike[str]) -> str:
    """Return a path of the disk at which a file can be read: its own, or that of a copy."""
    text = plain(path)
    return copy_of(text, mark(text)) if is_url(text) else text


def place_of_copy(url: str, mark: Mark) -> Path:
    """Return where a copy of one version of a file lies if there is one."""
    from hashlib import sha256  # late: most files are on the disk

    return copies("captures") / (_COPY + sha256(repr((url, mark)).encode()).hexdigest()[:32])


def copy_of(url: str, mark: Mark) -> str:
    """Return the path of the copy of one version of a file."""
    place = place_of_copy(url, mark)
    with _turns[hash(url) % len(_turns)]:
        with suppress(OSError):  # what is wrong with the folder is said where it is written to
            os.utime(place, ns=(int(time() * 1e9), os.stat(place).st_mtime_ns))
            return str(place)
        found = _found(url)
        if found.is_folder:
            raise IsADirectoryError(url)
        if found.mark != mark:
            raise changed(url)
        try:
            _copy(url, found, place)
        except OSError as error:
            if isinstance(error, FileNotFoundError):
                raise
            where = "Let LANINDEX_CACHE name another folder for copies."
            why = f"cannot be copied to {place.parent} ({error.strerror or error})"
            raise CaptureError(why, place=url, wanted="room for it", remedy=where) from error
    return str(place)


def changed(path: str) -> CaptureError:
    """Return the error that another program writes a file while it is read."""
    return CaptureError(
        "has changed while it was read",
        place=path,
        wanted="a file that stays as it is",
        remedy="Try again when nothing writes to it.",
    )


def copies(kind: str) -> Path:
    """Return the folder of one kind of copies: the user's own, or as LANINDEX_CACHE says."""
    of_user = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")) / "lanindex"
    return Path(os.environ.get("LANINDEX_CACHE") or of_user) / kind


def _copy(url: str, found: Found, place: Path) -> None:
    import shutil
    from tempfile import mkstemp

    place.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    _sweep(place.parent, found.size or 0)
    if found.size and shutil.disk_usage(place.parent).free < found.size:
        raise OSError(ENOSPC, os.strerror(ENOSPC))
    handle, draft = mkstemp(dir=place.parent, prefix=_COPY)
    os.close(handle)
    try:
        with asking(url) as (system, path):
            system.get_file(path, draft)
            after = _told(url, system.info(path))
        # what is stored packed is longer
        if after.mark != found.mark or os.stat(draft).st_size < (found.size or 0):
            raise changed(url)
        os.replace(draft, place)
    finally:
        with suppress(FileNotFoundError):
            os.unlink(draft)


def _sweep(folder: Path, more: int) -> None:
    """Let go of what was not used for longest; not for each copy: there may be thousands."""
    global _unswept
    _unswept += more
    if _unswept < BYTES // 16:
        return
    _unswept = 0
    left = BYTES - more
    files = []
    for entry in os.scandir(folder):
        with suppress(OSError):  # another process lets go, too
            files += [(entry.stat(), entry.path)] if entry.name.startswith(_COPY) else []
    for status, path in sorted(files, key=lambda one: -one[0].st_atime_ns):
        left -= status.st_size
        if left < 0:
            with suppress(OSError):  # on Windows one that is open stays
                os.unlink(path)
