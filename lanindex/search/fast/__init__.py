"""The fast engine: programs and columns → hits, over all captures at once.

It gives what the plain matcher gives, and is tested against it. Rows become events, arrows lead
from events to ranges of others, a line is run backwards over all of them; objects are made only of
the hits that are asked for. A pattern goes the quickest way that covers what it asks: chains,
linked lines side by side, lines alone, lines with their company, or ways that remember whatever
they must (``asking`` chooses). Where a capture is fitted in too many ways to try them, that is
said.
"""

from lanindex.search.fast.find import Finder, Watch, columns_in, find_in
from lanindex.search.fast.found import Found
from lanindex.search.fast.timeout import Timeout

__all__ = ["Finder", "Found", "Timeout", "Watch", "columns_in", "find_in"]
