"""Errors about a token that cannot stand where it stands, with what was probably meant."""

from __future__ import annotations

from lanindex.alphabet import DIRECTIONS
from lanindex.errors import PatternError
from lanindex.search.language.lexer import COUNT, Cursor
from lanindex.search.language.words import LANGUAGE, UNITS, VALUES, Vocabulary

_CONDITION = "Conditions stand behind where: r_arm high where match.length < 2s"
_LND = "A line of LND stands where a step could: behind an arrow, or at the beginning."
_STRAY = {
    ")": 'This bracket was never opened: take it away, or put a "(" before.',
    "(": 'Something is missing before the bracket: "->", "with" or "or".',
    "/": '"/" joins words, high/low; "or" joins lines: r_arm high or l_arm low',
    "[": "Square brackets follow an arrow: ->[<2s], ...[<=2]",
    "]": 'This bracket was never opened: ->[<2s] has a "[" too.',
    ",": 'No commas: "with" sets side by side, "->" puts one after the other.',
    "?": "Only a step can be left out, once: r_arm low -> mid? -> high",
    ":": "A label is a name before a step: a: r_arm high",
    "@": 'Something is missing before the name: "->", "with" or "or".',
    "#": _LND,
    ";": 'A ";" ends a let: let up = mid -> high; r_arm low -> @up',
    "|": "Stages stand behind the whole pattern, not in brackets or a let.",
    ".": '"..." leads to a later movement: r_arm low ... high',
    "*": '"x0+" is any number of times, "..." any movements between: r_arm low ... high',
    "+": '"x1+" is once or more: r_arm rising x1+',
    "=": _CONDITION,
    "!=": _CONDITION,
    "^": '"start ->" is the beginning of a clip: start -> r_arm high',
    "$": '"-> end" is the end of a clip: r_arm high -> end',
    "{": '"x2..3" is two or three times: r_arm rising x2..3',
    "&": '"with" sets side by side: r_arm high with l_arm high',
    "!": '"not" denies a word, "without" a line: r_arm not low without head',
    "start": '"start" begins a line: start -> r_arm high',
    "end": 'An arrow goes before "end": r_arm high -> end',
    "either": '"either side" speaks of the whole pattern: put it at its end.',
    "mirror": 'Something is missing before "mirror": "->", "with" or "or".',
    "not": '"not" goes with direction and level, before length and count: r_arm not low <1s',
    "at": '"at" is a step of its own: r_arm at high, or r_arm mid -> at high',
    "hold": '"hold" is a step of its own: r_arm right -> hold',
    "via": '"via" is a step of its own: r_arm via right high, or r_arm low -> via right',
    "and": 'Did you mean "with"? "and" joins conditions.',
    "let": '"let" stands before the whole pattern: let up = mid -> high; r_arm low -> @up',
    "where": '"where" speaks of the whole pattern: put it at its end.',
    "rhythm": '"rhythm" speaks of the whole pattern: put it at its end.',
    "mirrors": "Conditions stand behind where: a: r_arm with b: l_arm where a mirrors b",
    "clip": 'Conditions stand behind where: r_arm high where clip.label = "wave"',
    "match": _CONDITION,
    "count": 'A "|" goes before count: r_arm high | count by clip.label',
    "sort": 'A "|" goes before sort: r_arm high | sort by match.start',
    "first": 'A "|" goes before first: r_arm high | first 3',
    "by": '"by" belongs to a stage: | sort by match.start',
    "direction": _LND,
}
"""By mark or word that stands where it cannot, the remedy."""

_NO_STEPS = ("start", "let", "count", "sort", "first", "by", "mirrors", "clip", "match", "and")
"""Words that never begin a step."""

_UNKNOWN = {
    "for": "Times stand behind the step that they speak of: r_arm forward 1s",
    "x": '"x3" is three times, in one word: r_arm rising x3',
    "times": '"x3" is three times: r_arm rising x3',
    "twice": '"x2" is twice: r_arm rising x2',
}
"""By word that the language does not know, what to write instead."""


_MEANT = {
    alias: word
    for word, aliases in {
        "high": "up upward upwards raised",
        "low": "down downward downwards lowered",
        "mid": "horizontal",
        "place": "centre center",
        "place high": "overhead",
        "place low": "hanging",
        "forward": "front forwards",
        "back": "behind",
        "side": "outward sideways",
        "across": "inward",
        "any": "everything anything",
        "rising": "raise raises raising lift lifts",
        "sinking": "lower lowers lowering falling",
        "fast": "quick quickly rapid",
        "slow": "slowly",
        "large": "big wide",
        "small": "little",
        "hold": "stay rest still",
        "via": "through",
        "start": "begin",
        "then": "next",
        "during": "while",
        "with": "meanwhile simultaneously concurrently",
        "overlapping": "overlap overlaps",
        "incline": "tilt",
        "torso_incline": "lean leans leaning",
        "head_incline forward": "nod",
        "torso_twist": "twists",
        "torso_twist at": "twisted",
        "forearm": "lower_arm wrist",
        "upper_arm": "elbow",
        "thigh": "upper_leg knee",
        "shank": "lower_leg calf shin ankle",
        "torso": "trunk chest spine body",
        "head": "neck",
    }.items()
    for alias in aliases.split()
}
"""The word or part that people mean, by what they write; too different to guess by spelling."""


def unknown_word(vocabulary: Vocabulary, word: str, part_expected: bool) -> str:
    """Return the sentence about a word that is not in the vocabulary."""
    if guess := _guess(vocabulary, word.lower(), part_expected):
        return f'I don\'t know "{word}". Did you mean "{guess}"?'
    if not part_expected:
        directions = ", ".join(DIRECTIONS[:4])
        known = f"A movement has a direction ({directions} …) and a level (high, mid, low)."
        return f'I don\'t know "{word}". {known}'
    parts = " ".join(vocabulary.parts) or "none"
    if vocabulary.of_library:
        return f'This library has no part "{word}". It has: {parts}'
    return f'There is no part "{word}". The parts are: {parts}'


def _guess(vocabulary: Vocabulary, word: str, part_expected: bool) -> str:
    from rapidfuzz import process
    from rapidfuzz.distance import OSA

    from lanindex.search.dictionary import load

    named = {name: f"@{name}" for name in load()} if part_expected else {}
    if word in named:
        return named[word]
    side = next((it for it in ("right_", "left_", "r_", "l_") if word.startswith(it)), "")
    meant = (side and f"{side[0]}_") + _MEANT.get(word.removeprefix(side), "")
    if word in _MEANT or meant in vocabulary.movers:
        return meant
    known = [*VALUES, *vocabulary.movers, *LANGUAGE, *named]
    jumbled = [it for it in known if sorted(it) == sorted(word)]
    found = process.extractOne(word, known, scorer=OSA.normalized_similarity, score_cutoff=0.7)
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
    said = cursor.excerpt(cursor.token)
    known = _UNKNOWN.get(said.lower())
    return cursor.error(known or unknown_word(cursor.vocabulary, said, part_expected))


def no_step(cursor: Cursor, after: str) -> PatternError:
    """Return the error where a step should begin behind `after`, and none does."""
    token = cursor.token
    arrow = after in ("->", "start")
    if is_unknown(cursor):
        return unknown(cursor, part_expected=True)
    if token.kind in ("arrow", "dots"):
        if arrow:
            return cursor.error("Two arrows, and no movement between them.")
        return cursor.error("Nothing before the arrow. Name a part first: r_arm low -> high")
    if token.kind in ("unknown", "string"):
        known = _STRAY.get(token.text)
        return cursor.error(known) if known else unknown(cursor)
    if token.text in _NO_STEPS:
        return cursor.error(_STRAY[token.text])
    if after:
        what = "the arrow" if arrow else f'"{after}"'
        return cursor.error(f"Nothing after {what}: a movement follows it.", cursor.before)
    if token.kind == "end":
        return cursor.error("Nothing follows this bracket.", cursor.before)
    return cursor.error(f'Nothing before "{cursor.excerpt(token)}". Name a part first: r_arm high')


def stray(cursor: Cursor) -> PatternError:
    """Return the error of what follows a line that is complete."""
    token = cursor.token
    if cursor.at_label:
        found = "A label goes before a step, behind the arrow: r_arm low -> a: high"
        return cursor.error(found, token, cursor.ahead(1))
    known = token.text in _STRAY
    if is_unknown(cursor) or (token.kind in ("unknown", "string") and not known):
        return unknown(cursor)
    if token.kind == "word" and cursor.vocabulary.mover(token.text):
        found = 'Another part: "with" sets it beside, "->" puts it after, "or" is either of them.'
        return cursor.error(found)
    if cursor.before.text == "end":
        return cursor.error('After "end" the line does not go on.')
    if known:
        return cursor.error(_STRAY[token.text])
    if token.text in VALUES:
        order = "Direction and level stand before length and count: r_arm high <1s x2."
        return cursor.error(f"{order} The next movement has an arrow: -> {token.text}")
    return cursor.error(f'"{cursor.excerpt(token)}" says nothing here.')
