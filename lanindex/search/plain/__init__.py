"""The plain matcher: programs and tracks → hits, as the language's page says, word for word.

It is correct first, and the oracle of any faster one. Read it in this order:

1. ``track``: a track becomes events, which are movements, stays and rests; what follows what.
2. ``candidates``: events become matches of a state, anywhere or over an arrow.
3. ``paths``: what a walk remembers; matches joined by arrows become paths.
4. ``relations``: how two lines must lie to each other.
5. ``wanted``: what cannot serve two lines.
6. ``clauses``: what rhythm and conditions ask of a way.
7. ``beside``: what stands beside a line, or must not.
8. ``walk``: all ways through a capture, and the best from each place.
9. ``find``: which of them are hits.
"""

from lanindex.search.plain.find import TOLERANCE, Teller, find

__all__ = ["TOLERANCE", "Teller", "find"]
