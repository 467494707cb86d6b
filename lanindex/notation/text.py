"""Lines of a notation file: how they are read, and what a bad one is called."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from lanindex.errors import NotationError


def read_text(path: Path) -> str:
    """Return a file's text.

    Parameters
    ----------
    path : Path
        UTF-8, with or without a byte order mark; any line ends.

    Returns
    -------
    str

    Raises
    ------
    NotationError
        Where the file cannot be read or is not text.
    """
    try:
        return path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise NotationError(str(error.strerror), place=str(path), wanted="a text file") from error
    except UnicodeDecodeError as error:
        raise NotationError(
            f"byte {error.start} is no UTF-8", place=str(path), wanted="a text file"
        ) from error


def words_of(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the number and the words of each line that says something.

    Parameters
    ----------
    text : str
        ``//`` begins a comment; empty lines are passed over.

    Yields
    ------
    tuple of int and list of str
        Line number from 1, words.

    Examples
    --------
    >>> from lanindex.notation.text import words_of
    >>> list(words_of('''// a comment
    ... place 250 // mm'''))
    [(2, ['place', '250'])]
    """
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split("//", 1)[0].split()
        if words:
            yield number, words
