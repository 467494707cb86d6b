"""Pattern text → `Query`, as the page ``lanindex/search/LANGUAGE.md`` says.

Nothing here knows a capture. ``words`` has the tables of words, ``times`` the lengths; ``lexer``
makes tokens of a text, ``parser`` reads them by the grammar, with ``steps`` for one step,
``clauses`` for conditions and stages, ``score`` for pasted LND. What they build is the syntax tree
of ``query``. Where they fail, ``suggestions`` says what is wrong, and ``natural`` what plain words
may have meant. ``builder`` makes patterns in Python.
"""

from lanindex.search.language.parser import parse
from lanindex.search.language.query import Query

__all__ = ["Query", "parse"]
