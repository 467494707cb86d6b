"""Search that forgives: what is nearly what a pattern says, found and ranked by how nearly.

A symbol may differ from its step by an angle, others may lie between two steps, and steps may be
missing; each costs a part of an edit or more, and a match may cost so many.

``costs`` says what a symbol costs for a step, ``net`` which step may follow which, ``windows``
which symbols need aligning, ``align`` what their alignment costs and which symbols it consists of,
``lines`` finds one line in all captures, ``joining`` sets lines side by side, ``find`` chooses the
hits, ``found`` holds them.
"""

from lanindex.search.fuzzy.costs import Allowance
from lanindex.search.fuzzy.find import find

__all__ = ["Allowance", "find"]
