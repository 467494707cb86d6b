"""What a clip is called in words: its label, what was asked for, and what was seen.

The English is that of ``lanindex search --explain``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import Any

from lanindex.alphabet import KINDS, kind_of
from lanindex.errors import LanindexError
from lanindex.search.explain import sentence
from lanindex.search.language import parse

MANY = 16
"""Symbols that a sentence may tell: nobody reads longer ones."""

_DONE = {
    r" \(or begins? there\)": "",
    r"; and in the meantime, sharing a frame at least,": ", while",
}
"""What is said of a pattern that may match in several ways, and of what was seen instead."""

_TAGS = {
    "ADP": "to on of at in by for from with after before than across",
    "DET": "the a an each either both no any other another",
    "ADV": "then high low forward back down straight later together where there anywhere slowly "
    "fast not up away apart overhead sideways twice again",
    "NOUN": "arm arms leg legs forearm forearms hand hands foot feet thigh thighs shank shanks "
    "head torso body palm palms front side height place joint trunk knee knees seat elbow elbows "
    "upper weight degree degrees way ground",
    "ADJ": "right left middle own drawn bent stretched little long",
    "VERB": "moves move goes go is are stays stay steps jumps travels turns turn twists inclines "
    "bends bend stretches stretch touches touch holds hold rests faces face leaves passing walk "
    "run walks runs jump wave waves raise raises kick kicks clap claps bow bows",
    "CCONJ": "and or",
    "SCONJ": "while",
    "PRON": "it its they their something nothing",
    "NUM": "one two three four five six",
}
_TAG = {word: tag for tag, words in _TAGS.items() for word in words.split()}


def of_pattern(pattern: str, names: Mapping[str, Any] | None = None) -> str:
    """Return what a pattern asks for as a sentence; empty where it is not understood here."""
    try:
        return sentence(parse(pattern, names=names) if names else parse(pattern))
    except LanindexError:
        return ""


def of_symbols(symbols: Sequence[Mapping[str, Any]]) -> str:
    """Return what some symbols say as a sentence; empty where they are none, or too many."""
    if not 0 < len(symbols) <= MANY:
        return ""
    order = list(dict.fromkeys(one["part"] for one in symbols))
    rows = sorted(
        {(order.index(one["part"]), one["start_frame"], one["end_frame"], _step(one))
         for one in symbols}
    )  # fmt: skip
    lines = [
        f"{order[part]} {' -> '.join(row[-1] for row in steps)}"
        for part, steps in groupby(rows, key=lambda row: row[0])
    ]
    return of_what_is_done(of_pattern(" with ".join(lines)))


def of_what_is_done(said: str) -> str:
    """Return what is said of a pattern as it is said of what was found."""
    for found, instead in _DONE.items():
        said = re.sub(found, instead, said)
    return said


def _step(symbol: Mapping[str, Any]) -> str:
    kind = KINDS[kind_of(symbol["part"])]
    words = [symbol.get(name) for name in ("direction", "level")]
    if (amount := symbol.get("amount")) is not None:
        words.append(kind.amount(amount))
    at = "at " if kind.lasts and symbol["start_frame"] == symbol["end_frame"] else ""
    return at + " ".join(word for word in words if word)


def several(texts: Iterable[str]) -> list[str]:
    """Return texts that say anything, each once, in order."""
    tidy = (" ".join(text.split()) for text in texts)
    return list(dict.fromkeys(text for text in tidy if text))


def tagged(text: str) -> str:
    """Return a text's words with their parts of speech, as HumanML3D has them.

    Those are known of words that LanIndex itself uses; others are ``X``.
    """
    words = re.findall(r"[^\W\d_]+", text.lower())
    return " ".join(f"{word}/{_TAG.get(word, 'X')}" for word in words)
