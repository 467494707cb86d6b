"""Pattern text → `Query`: words, grammar, and what to say where they fail.

Nothing here knows a capture. The page that rules this room is ``lanindex/search/LANGUAGE.md``.
"""

from lanindex.search.language.parser import parse
from lanindex.search.language.query import Query

__all__ = ["Query", "parse"]
