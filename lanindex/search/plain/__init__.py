"""The plain matcher: programs and tracks → hits, as the language's page says, word for word.

It is correct first, and the oracle of any faster one. A track becomes events, events become
candidates for a state, candidates joined by arrows become paths.
"""

from lanindex.search.plain.find import TOLERANCE, Teller, find

__all__ = ["TOLERANCE", "Teller", "find"]
