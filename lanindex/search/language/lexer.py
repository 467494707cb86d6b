"""Pattern text → tokens, each with its place in the text.

The lexer never fails: a character it does not know becomes a token of kind ``unknown``, so that
the first error reported is the first one that a reader meets.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

_KINDS = {
    "comment": r"//[^\n]*",
    "dots": r"\.\.\.|…",
    "range": r"\.\.",
    "number": r"\d+(?:\.\d+)?|\.\d+",
    "word": r"[^\W\d]\w*",
    "arrow": r"->|→",
    "compare": r"<=|>=|<|>|≤|≥",
    "string": r'"[^"\n]*"?',
    "mark": r"!=|[()\[\]/?:;@|+\-=.,#]",
    "space": r"\s+",
    "unknown": r".",
}
_TOKEN = re.compile("|".join(f"(?P<{kind}>{form})" for kind, form in _KINDS.items()), re.DOTALL)
_SAME = {"≤": "<=", "≥": ">=", "→": "->", "…": "..."}


@dataclass(frozen=True, slots=True)
class Token:
    """A word, number or mark of a pattern.

    Attributes
    ----------
    kind : str
        ``word``, ``number``, ``arrow``, ``dots``, ``range``, ``compare``, ``string``, ``mark``,
        ``unknown`` or ``end``.
    text : str
        In lower case and one spelling: ``->`` for ``→``.
    start, stop : int
        Its characters in the pattern.
    """

    kind: str
    text: str
    start: int
    stop: int


def tokens(text: str) -> list[Token]:
    """Split a pattern into tokens; the last one is of kind ``end``, behind the others.

    ``then`` is an arrow; comments and white space are left out.
    """
    found = []
    for match in _TOKEN.finditer(text):
        kind, said = str(match.lastgroup), match.group()
        if kind in ("comment", "space"):
            continue
        said = _SAME.get(said, said.lower())
        if said == "then":
            kind, said = "arrow", "->"
        found.append(Token(kind, said, match.start(), match.end()))
    end = found[-1].stop if found else 0
    return [*found, Token("end", "", end, end)]
