"""The errors that LanIndex raises, and how messages show counts and texts from outside.

Every error names the place, what was found there, what was wanted, and (where there is one)
the remedy::

    walk.bvh:212: frame 40 has 93 numbers, wanted 96 as the hierarchy declares
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from importlib import import_module
from typing import Any


def shown(text: str, most: int = 60) -> str:
    """Return a text from outside as a message shows it: of a long one the beginning."""
    return text if len(text) <= most else text[: most - 1] + "…"


def quoted(value: object, most: int = 60) -> str:
    """Return a value from outside as a message shows it: as Python writes it."""
    try:
        return shown(repr(value), most)
    except (ValueError, RecursionError):  # a number of too many digits, lists in lists in lists
        return "something too large to show"


def counted(number: int, noun: str) -> str:
    """Return ``1 hit``, ``2 hits``."""
    return f"{number:,} {noun}" + ("" if number == 1 else "s")


def guess(word: str, known: Iterable[str]) -> str:
    """Return the known word most like `word`, for "Did you mean"; empty if none is like it."""
    from rapidfuzz import process

    near = process.extractOne(word, list(known), score_cutoff=60)
    return near[0] if near else ""


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return a remedy that names the known word most like `word`; empty if none is like it."""
    near = guess(word, known)
    return f"Did you mean {near}?" if near else ""


class LanindexError(Exception):
    """The root of all errors that LanIndex raises on purpose.

    Parameters
    ----------
    found : str
        What is wrong, as found.
    place : str, optional
        Where: a file, ``file:line``, or an argument.
    wanted : str, optional
        What would have been right.
    remedy : str, optional
        One sentence that says what to do.

    Examples
    --------
    >>> import lanindex
    >>> try:
    ...     lanindex.read("corpus/none.bvh")
    ... except lanindex.LanindexError as error:
    ...     print(error)
    corpus/none.bvh: there is no such file, wanted a file that can be read
    """

    def __init__(self, found: str, *, place: str = "", wanted: str = "", remedy: str = "") -> None:
        self.found, self.place, self.wanted, self.remedy = found, place, wanted, remedy
        super().__init__(found)

    def __str__(self) -> str:
        text = f"{self.place}: {self.found}" if self.place else self.found
        if self.wanted:
            text += f", wanted {self.wanted}"
        return f"{text}. {self.remedy}" if self.remedy else text


class CaptureError(LanindexError):
    """A capture file cannot be read."""


class BodyError(CaptureError):
    """A capture holds no human body that could be recognised."""


class EncodeError(LanindexError):
    """A capture that was read cannot be written down."""


class NotationError(LanindexError):
    """A notation file (LND, LPD, LDD) or a profile cannot be read."""


class LibraryError(LanindexError):
    """The library (the database) cannot be used."""


class AbsentError(LibraryError):
    """There is no library, or no such capture in it."""


class LibraryBusyError(LibraryError):
    """Another process holds the library for too long."""


class LibraryVersionError(LibraryError):
    """The library's schema is older or newer than this program's."""


class ExportError(LanindexError):
    """A clip cannot be written."""


@contextmanager
def extra(
    name: str, place: str = "", error_type: type[LanindexError] = ExportError
) -> Iterator[None]:
    """Turn a missing library into an error that names the extra with which it comes."""
    try:
        yield
    except ImportError as error:
        remedy = f"It comes with: pip install 'lanindex[{name}]'."
        raise error_type(f"{error.name} is not installed", place=place, remedy=remedy) from error


_WRITERS = {
    **{"png": ("pictures", "resvg_py"), "pdf": ("pictures", "svglib"), "gif": ("film", "PIL")},
    **{"webp": ("film", "av"), "mp4": ("film", "av"), "parquet": ("tables", "pyarrow")},
}
"""By the ending of a file: the extra and the library that write it."""


def writable(form: str) -> None:
    """Refuse a form whose library is missing, before there is something to write."""
    if form in _WRITERS:
        name, library = _WRITERS[form]
        with extra(name, form):
            import_module(library)


class OutOfMemoryError(LanindexError):
    """A job needs more memory than there is."""


class UsageError(LanindexError):
    """The arguments do not make sense together."""


_NEAR = 48
"""About how many characters of a long pattern are shown on each side of an error."""


class PatternError(LanindexError):
    """A pattern cannot be understood.

    Parameters
    ----------
    found : str
        One plain sentence, the fix included.
    text : str
        The whole pattern.
    start, stop : int
        The characters of `text` that the sentence is about.

    Its attribute `instead` is the whole pattern that was probably meant; empty: none is known.
    """

    def __init__(self, found: str, *, text: str, start: int, stop: int) -> None:
        super().__init__(found)
        self.text, self.start, self.stop, self.instead = text, start, stop, ""

    def __reduce__(self) -> tuple[Any, ...]:
        """Return how to make it again: an error may come from another process."""
        made = partial(type(self), text=self.text, start=self.start, stop=self.stop)
        return made, (self.found,), {"place": self.place, "instead": self.instead}

    def line(self) -> tuple[str, int, int]:
        """Return the line of the pattern, or what is near of a long one, and what it is about."""
        begin = self.text.rfind("\n", 0, self.start) + 1
        end = self.text.find("\n", self.start)
        end = len(self.text) if end < 0 else end
        first = begin if self.start - begin <= _NEAR else self.start - _NEAR // 2
        last = end if end - first <= 2 * _NEAR else first + 2 * _NEAR
        line = "…" * (first > begin) + self.text[first:last] + "…" * (last < end)
        start = self.start - first + (first > begin)
        return line, start, start + max(0, min(self.stop, last) - self.start)

    def __str__(self) -> str:
        """Return the line of the pattern, a caret below it, and the sentence."""
        line, start, stop = self.line()
        place = f"{self.place}:\n" if self.place else ""
        return f"{place}{line}\n{' ' * start}{'^' * max(1, stop - start)}\n{self.found}"
