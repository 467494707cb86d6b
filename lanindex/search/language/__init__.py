"""Pattern text → `Query`, as the page ``lanindex/search/LANGUAGE.md`` says.

``lexer`` makes tokens of a text. ``parser`` reads them by the grammar, with ``clauses`` (`where`
and pipes) and ``score`` (pasted LND), and builds the syntax tree of ``query``. ``words`` and
``times`` have the vocabulary. ``natural`` says in errors what plain words may mean. ``builder``
makes patterns in Python.
"""

from lanindex.search.language.parser import parse
from lanindex.search.language.query import Query

__all__ = ["Query", "parse"]
