"""The oracle: programs and tracks → hits, as the language's page says, word for word.

It tries every way and keeps what the page allows, in as little code as that takes; nothing in it is
for speed, so it is for small captures alone. Nothing that is shown to anybody comes from here: it
is what the engine (``lanindex.search.match``) is held against. Read it in this order:

1. ``track``: a track becomes events, which are movements, stays and rests; what follows what.
2. ``candidates``: events become matches of a state, anywhere or over an arrow.
3. ``relations``: how two lines must lie to each other.
4. ``ways``: matches joined by arrows become ways, with the lines beside them.
5. ``clauses``: what rhythm and conditions ask of a way.
6. ``walk``: all ways through a capture, and what stands beside them, or must not.
7. ``find``: the best from each place, and which of them are hits.
"""

from plain_matcher.find import find, ties

__all__ = ["find", "ties"]
