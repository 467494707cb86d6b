"""The names of captures: which texts a library can store, and which captures a user selects."""

import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import translate
from numbers import Integral
from typing import Any, TypeGuard
from unicodedata import normalize

from lanindex import locations
from lanindex.errors import CaptureError, UsageError

_COMPARED = {"path": ("path", "location"), "label": ("label",), "format": ("format",)}
"""Which texts of captures a glob of a column is compared with; of other columns ``metadata``."""

Texts = Mapping[str, Sequence[Any]]
"""Texts of captures: by name of the column, a value for each."""

_COLUMNS = ("label", "format", "dataset")
"""What every capture can be selected by, beside its path."""

_LARGEST_NUMBER = (1 << 63) - 1
"""The largest whole number of SQLite."""

_BYTES = re.compile("[\udc80-\udcff]")
"""How Python reads the bytes of a file's name that are no UTF-8."""


def check_text(place: str, texts: Iterable[str]) -> None:
    """Refuse text that came from bytes that are no UTF-8."""
    for text in texts:
        try:
            text.encode()
        except UnicodeEncodeError as error:
            raise UsageError(
                f"{printable(text)} has bytes that are no UTF-8",
                place=printable(place),
                remedy="Rename the file, or save the table of labels as UTF-8.",
            ) from error


def check_description(place: str, label: str | None, metadata: Mapping[str, str] | None) -> None:
    """Refuse a label or metadata that is no text."""
    check_text(place, [label or "", *(metadata or {}), *(metadata or {}).values()])


def printable(text: str) -> str:
    r"""Return a text that UTF-8 can spell: of a byte of a file's name that is no UTF-8, ``\xff``.

    `lanindex.formats.archives.native` finds the file again.
    """
    escaped = _BYTES.sub(lambda byte: f"\\x{ord(byte[0]) - 0xDC00:02x}", text)
    return escaped.encode("utf-8", "backslashreplace").decode()


def absolute(path: str | os.PathLike[str]) -> str:
    """Return a path made absolute, as a library keeps it."""
    return printable(locations.located(path))


@dataclass(frozen=True, slots=True)
class Selection:
    """Which captures of a library are meant: those that fit all globs.

    Parameters
    ----------
    path : str, optional
        A glob: only captures whose path, absolute path or (without a slash in it) file name it
        fits.
    where : Mapping of str to str, or sequence of (str, str)
        Globs by what they are compared with: ``label``, ``format``, ``path``, ``dataset`` or any
        other column that the user gave. A column that a capture lacks is compared as the empty
        text. A column that no capture has is a `UsageError` of the method that selects.

    Examples
    --------
    >>> import lanindex
    >>> with lanindex.open_library("dance.db") as library:
    ...     for capture in library.captures(lanindex.Selection(where={"label": "march*"})):
    ...         print(capture.id, capture.path)
    6 corpus/marching.bvh
    """

    path: str | None = None
    where: Mapping[str, str] | Sequence[tuple[str, str]] = ()

    @property
    def globs(self) -> list[tuple[str, str]]:
        """Globs by column."""
        pairs = list(self.where.items() if isinstance(self.where, Mapping) else self.where)
        return pairs if self.path is None else [*pairs, ("path", self.path)]


ALL = Selection()
"""All captures."""


def texts_needed(selection: Selection) -> list[str]:
    """Return which texts of captures the globs are compared with."""
    names = [_COMPARED.get(key, ("metadata",)) for key, _ in selection.globs]
    return list(dict.fromkeys(name for some in names for name in some))


def selected(selection: Selection, texts: Texts, count: int) -> Sequence[int]:
    """Return the places of those captures that fit, of `count` captures with these texts."""
    places: Sequence[int] = range(count)
    for key, glob in selection.globs:
        if key == "path":
            places = _fitting_paths(texts, places, glob)
            continue
        fits, values = _matcher(glob), _values(texts, key)
        known = {text: fits(text) for text in {values[place] for place in places}}
        places = [place for place in places if known[values[place]]]
    return places


def is_number(which: object) -> TypeGuard[int]:
    """Return whether this can be the number of a capture: whole, from 1, and not a bool."""
    whole = isinstance(which, Integral) and not isinstance(which, bool)
    return whole and 0 < int(which) <= _LARGEST_NUMBER  # type: ignore[call-overload]


def _matcher(glob: str) -> Callable[[str], bool]:
    """Return a function that tells whether a text fits a glob."""
    # The same letters may be composed or not: macOS names files in one way, people type in both.
    fits = re.compile(translate(normalize("NFC", glob))).match
    return lambda text: fits(text if text.isascii() else normalize("NFC", text)) is not None


def _fitting_paths(texts: Texts, places: Sequence[int], glob: str) -> list[int]:
    """Return those captures of which a path fits: as ingested, absolute, or the file's name."""
    fits, paths, locations = _matcher(glob), texts["path"], texts["location"]
    if glob.startswith("*"):  # what fits the end of a path fits all of it
        rest = [place for place in places if not locations[place].endswith(paths[place])]
        known = {place for place in rest if fits(paths[place])}
        return [place for place in places if fits(locations[place]) or place in known]
    named = "/" not in glob
    return [
        place
        for place in places
        if fits(paths[place])
        or fits(locations[place])
        or (named and fits(os.path.basename(locations[place])))
    ]


def _values(texts: Texts, key: str) -> Sequence[str]:
    if key in ("label", "format"):
        return texts[key]
    metadata: Sequence[Mapping[str, str]] = texts["metadata"]
    columns = {column for one in metadata for column in one}
    if metadata and key not in columns and key not in _COLUMNS:
        raise UsageError(
            f'no capture has a column "{key}"',
            wanted=f"one of {', '.join(dict.fromkeys(('path', *_COLUMNS, *sorted(columns))))}",
        )
    return [one.get(key, "") for one in metadata]


def is_gone(path: str) -> bool:
    """Return whether a file is surely no longer there."""
    from lanindex.formats.file import on_disk

    try:
        return locations.is_gone(on_disk(path))
    except CaptureError:  # nobody tells whether its archive is there
        return False
