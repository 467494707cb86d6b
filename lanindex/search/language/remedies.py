"""What is said of a pattern that is not understood, by the sentences of ``remedies.toml``."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from lanindex.alphabet import DIRECTIONS
from lanindex.data import shipped
from lanindex.errors import PatternError
from lanindex.search.language.words import COUNT, LANGUAGE, UNITS, VALUES, Vocabulary

if TYPE_CHECKING:
    from lanindex.search.language.lexer import Cursor

_FEW = 6
"""Parts that are named where a word is none."""

_NO_STEPS = ("start", "let", "count", "sort", "first", "by", "mirrors", "clip", "match", "and")
"""Words that never begin a step."""


@cache
def remedies(table: str) -> dict[str, str]:
    """Return a table of ``remedies.toml`` by each word or mark of its keys."""
    rows = shipped("search/language/remedies.toml")[table].items()
    return {word: remedy for words, remedy in rows for word in words.split()}


def broken(rule: str, **said: object) -> str:
    """Return the sentence about a rule of the grammar that is broken."""
    sentence: str = shipped("search/language/remedies.toml")["rules"][rule]
    return sentence.format(**said)


def unknown_word(vocabulary: Vocabulary, word: str, part_expected: bool) -> str:
    """Return the sentence about a word that is not in the vocabulary."""
    from lanindex.search.dictionary import absent

    if part_expected and (lacking := absent(word)):  # no other word misspelt
        return f'I don\'t know "{word}". Did you mean:  {lacking.instead}'
    if guess := _guess(vocabulary, word.lower(), part_expected):
        return f'I don\'t know "{word}". Did you mean "{guess}"?'
    if not part_expected:
        directions = ", ".join(DIRECTIONS[:4])
        known = f"A movement has a direction ({directions} …) and a level (high, mid, low)."
        return f'I don\'t know "{word}". {known}'
    parts = " ".join(vocabulary.parts[:_FEW]) or "none"
    parts += " …" * (len(vocabulary.parts) > _FEW)
    return f'There is no part "{word}". The parts are: {parts}'


def _guess(vocabulary: Vocabulary, word: str, part_expected: bool) -> str:
    from rapidfuzz import process
    from rapidfuzz.distance import OSA

    from lanindex.search.dictionary import load

    named = {name: f"@{name}" for name in load()} if part_expected else {}
    if word in named:
        return named[word]
    side = next((it for it in ("right_", "left_", "r_", "l_") if word.startswith(it)), "")
    similar = remedies("meant")
    meant = (side and f"{side[0]}_") + similar.get(word.removeprefix(side), "")
    if word in similar or meant in vocabulary.movers:
        return meant
    known = [*VALUES, *vocabulary.movers, *LANGUAGE, *named]
    jumbled = [it for it in known if sorted(it) == sorted(word)]
    begun = [it for it in known if it[0] == word[:1]]  # people seldom mistype a beginning
    found = process.extractOne(word, begun, scorer=OSA.normalized_similarity, score_cutoff=0.7)
    guess = jumbled[0] if jumbled else found[0] if found else ""
    return named.get(guess, guess)


def is_unknown(cursor: Cursor) -> bool:
    """Return whether the next token is a word that the language does not know."""
    word = cursor.token.text
    known = word in VALUES or word in LANGUAGE or word in UNITS or COUNT.fullmatch(word)
    return cursor.stands("word") and not (known or cursor.vocabulary.mover(word))


def unknown(cursor: Cursor, part_expected: bool = False) -> PatternError:
    """Return the error of a word that is not in the vocabulary."""
    if cursor.stands("string"):
        return cursor.error("Take the quotation marks away.")
    word = cursor.excerpt(cursor.token)
    known = remedies("unknown").get(word.lower())
    error = cursor.error(known or unknown_word(cursor.vocabulary, word, part_expected))
    if not known and (guess := _guess(cursor.vocabulary, word.lower(), part_expected)):
        token = cursor.token
        error.instead = f"{cursor.text[: token.start]}{guess}{cursor.text[token.stop :]}"
    return error


def no_step(cursor: Cursor, after: str) -> PatternError:
    """Return the error where a step should begin behind `after`, and none does."""
    token = cursor.token
    remedy = remedies("stray").get(token.text, "")
    arrow = after in ("->", "start")
    if is_unknown(cursor):
        return unknown(cursor, part_expected=True)
    if token.kind in ("arrow", "dots"):
        return cursor.fault("two arrows" if arrow else "arrow first")
    if token.kind in ("unknown", "string"):
        return cursor.error(remedy) if remedy else unknown(cursor)
    if token.text in _NO_STEPS:
        return cursor.error(remedy)
    if after:
        return cursor.fault("arrow last" if arrow else "nothing after", cursor.before, after=after)
    if token.kind == "end":
        return cursor.fault("bracket last", cursor.before)
    return cursor.fault("nothing before", text=cursor.excerpt(token))


def stray(cursor: Cursor) -> PatternError:
    """Return the error of what follows a line that is complete."""
    token = cursor.token
    if cursor.at_label:
        return cursor.fault("label behind a step", token, cursor.ahead(1))
    remedy = remedies("stray").get(token.text)
    if is_unknown(cursor) or (token.kind in ("unknown", "string") and not remedy):
        return unknown(cursor)
    if token.kind == "word" and cursor.vocabulary.mover(token.text):
        return cursor.fault("another part")
    if cursor.before.text == "end":
        return cursor.fault("behind end")
    if remedy:
        return cursor.error(remedy)
    if token.text in VALUES:
        return cursor.fault("word too late", word=token.text)
    return cursor.fault("nothing said", text=cursor.excerpt(token))
