"""The matcher: programs and columns to hits, over all captures at once.

It finds what the plain matcher of the tests finds. Rows become events (`batch`), arrows lead from
events to ranges of others (`follow`), a line is run backwards over all of them (`backward`), or
walked with what it has to remember (`walk`), and joined with the lines beside it (`join`). Hits
that are looked at are traced to their symbols (`trace`).
"""

from lanindex.search.match.finder import Finder, Watch, columns_in, find_in
from lanindex.search.match.hits import ExactHits

__all__ = ["ExactHits", "Finder", "Watch", "columns_in", "find_in"]
