"""Pattern text → `Query`: words, grammar, and what to say where they fail. See LANGUAGE.md."""

from lanindex.search.language.grammar import parse
from lanindex.search.language.query import Query

__all__ = ["Query", "parse"]
