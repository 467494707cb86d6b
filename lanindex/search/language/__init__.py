"""Pattern text → `Query`, as the page ``lanindex/search/LANGUAGE.md`` says."""

from lanindex.search.language.parser import parse
from lanindex.search.language.query import Query

__all__ = ["Query", "parse"]
