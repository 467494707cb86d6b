"""Text of notation files: its lines, words and exact numbers, JSON and TOML."""

import re
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator
from fractions import Fraction
from functools import lru_cache
from itertools import count
from pathlib import Path
from typing import Any, NoReturn

from lanindex.errors import NotationError, shown
from lanindex.notation import content_of


def refuse(place: str, found: str, wanted: str = "") -> NoReturn:
    """Refuse a file for what is found in it."""
    raise NotationError(found, place=place, wanted=wanted)


def decoded(source: bytes, place: str, wanted: str) -> str:
    """Return the text of a file's bytes: UTF-8, or UTF-16 with a byte order mark."""
    encoding = "UTF-16" if source.startswith((b"\xff\xfe", b"\xfe\xff")) else "UTF-8"
    try:
        text = source.decode(encoding).removeprefix("\ufeff")
    except UnicodeDecodeError as error:
        line = source.count(b"\n", 0, error.start) + 1
        found = f"byte {error.start} is no {encoding}"
        remedy = "Save the file again as UTF-8."
        raise NotationError(found, place=f"{place}:{line}", wanted=wanted, remedy=remedy) from error
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        refuse(f"{place}:{line}", "binary data", f"{wanted}, which is text")
    return text


def read_text(path: Path | str) -> str:
    """Return a file's text."""
    return decoded(content_of(str(path)), str(path), "a text file")


def unique_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return a JSON object; a key twice is an error (an ``object_pairs_hook``)."""
    found = dict(pairs)
    if len(found) < len(pairs):
        again = next(key for key, many in Counter(key for key, _ in pairs).items() if many > 1)
        raise ValueError(f'"{shown(again)}" twice in one object')
    return found


def parse_toml(text: str, place: str) -> dict[str, Any]:
    """Return the table of a text of TOML."""
    wanted = "TOML"
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        found = shown(str(error), 200)
    except RecursionError:
        found = "brackets inside brackets, too many"
    except ValueError:  # the one that Python refuses to read
        found, wanted = "a number without end", f"at most {sys.get_int_max_str_digits()} digits"
    refuse(place, found, wanted)


def read_toml(path: Path) -> dict[str, Any]:
    """Return the table of a TOML file."""
    return parse_toml(read_text(path), str(path))


def words_of(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield number and words of each line that is not empty or a comment."""
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split("//", 1)[0].split()
        if words:
            yield number, words


DECIMAL = re.compile(r"\d{1,9}(\.\d{0,30})?|\.\d{1,30}")
"""A number of at least 0, without sign or exponent."""


@lru_cache(maxsize=4096)
def fraction(text: str) -> Fraction:
    """Read a decimal exactly, or as the fraction that it was rounded from, such as a third."""
    value = Fraction(text)
    places = len(text.partition(".")[2])
    if places < 6:
        return value
    # the more places the larger the denominators: fractions then stay a hundred times further
    # apart than the numbers that are written for them
    near = value.limit_denominator(10 ** (places // 2 - 1))
    return near if abs(near - value) * 10**places < 1 else value


@lru_cache(maxsize=4096)
def number(value: Fraction) -> str:
    """Write a number as the shortest decimal that `fraction` reads as the same."""
    return next(text for places in count() if fraction(text := _rounded(value, places)) == value)


def _rounded(value: Fraction, places: int) -> str:
    digits = str(round(value * 10**places)).rjust(places + 1, "0")
    return f"{digits[: len(digits) - places]}.{digits[len(digits) - places :]}".rstrip(".")
