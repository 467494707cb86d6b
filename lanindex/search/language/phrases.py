"""Plain words → what each phrase means, by the tables of `natural.toml`."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from importlib import resources

from lanindex.search.language.words import VALUES, Vocabulary

_TOKEN = re.compile(r"->|→|\.\.\.|…|[^\W\d]\w*|\S")
_HALF = re.compile(r"\b(right|left|both|the|an?|his|her|their|your|my) (lower|upper) (arm|leg)")
"""Where 'lower arm' is surely a limb, and 'lower' no verb."""

_FROM = re.compile(r"(.*)\bfrom (.+?) to (.+)")
"""From where to where: the one, and later the other."""

SINGLE = ("head", "torso")
"""Parts that have no side."""

Meaning = tuple[str, str]
"""Which table of `natural.toml` knows a phrase, and what it stands for there."""


class UnclearError(Exception):
    """It could mean more than one thing, or nothing that the language can say."""


@lru_cache(maxsize=1)
def _tables() -> Mapping[str, Mapping[str, Sequence[str]]]:
    text = resources.files("lanindex.search.language").joinpath("natural.toml").read_text("utf-8")
    return tomllib.loads(text)


def _raising() -> frozenset[str]:
    """Return the verbs that tell an end, and so go with no 'from'."""
    verbs = _tables()["verbs"]
    return frozenset((*verbs["raise"], *verbs["lower"]))


@lru_cache(maxsize=1)
def _phrases() -> Mapping[tuple[str, ...], Meaning]:
    """Return what each phrase stands for, those of the language itself included."""
    known: dict[tuple[str, ...], Meaning] = {
        **{(word,): ("phrases", word) for word in VALUES},
        **{(name,): ("movers", name) for name in Vocabulary().movers},
    }
    for table, meanings in _tables().items():
        for meaning, phrases in meanings.items():
            for phrase in phrases:
                known[tuple(phrase.replace(",", " , ").split())] = (table, meaning)
    for limb, phrases in _tables()["limbs"].items():
        if limb not in SINGLE:
            known |= {tuple(f"{phrase}s".split()): ("limbs", f"{limb}s") for phrase in phrases}
    return known


def _plain(text: str) -> list[str]:
    """Return the words without articles, hyphens and the stop at the end."""
    text = re.sub(r"(?<=\w)-(?=\w)", " ", text.lower()).strip()
    text = _HALF.sub(r"\1 \2_\3", text)
    if (said := _FROM.fullmatch(text)) and not any(word in _raising() for word in text.split()):
        text = f"{said[1]} {said[2]} ... {said[3]}"
    text = text.rstrip("!? ")
    words = _TOKEN.findall(text.removesuffix(".") if not text.endswith("..") else text)
    return [word for word in words if word not in _tables()["fillers"]["articles"]]


def meanings(text: str) -> Iterator[Meaning]:
    """Yield what the words of a text stand for, the longest phrases first.

    Raises
    ------
    UnclearError
        A word stands for nothing, or for something else than it seems.
    """
    words = _plain(text)
    known = _phrases()
    longest = max(map(len, known))
    index = 0
    while index < len(words):
        for count in range(min(longest, len(words) - index), 0, -1):
            meaning = known.get(tuple(words[index : index + count]))
            if meaning and not _is_side(words, index + count, meaning):
                break
        else:
            raise UnclearError
        if meaning[0] == "unclear":
            raise UnclearError
        if words[index] in ("right", "left") and count == 1:
            limb = any(_begins_limb(words, index + 1, known))
            meaning = ("sides", words[index][0]) if limb else ("phrases", words[index])
        index += count
        yield meaning


def _begins_limb(
    words: list[str], index: int, known: Mapping[tuple[str, ...], Meaning]
) -> Iterator[bool]:
    for count in (1, 2):
        table, _ = known.get(tuple(words[index : index + count]), ("", ""))
        yield table in ("limbs", "movers")


def _is_side(words: list[str], index: int, meaning: Meaning) -> bool:
    """Tell whether 'to right' goes on with a limb, whose side it then is."""
    said = meaning[1] in ("right", "left") and words[index - 2 : index - 1] == ["to"]
    return said and any(_begins_limb(words, index, _phrases()))
