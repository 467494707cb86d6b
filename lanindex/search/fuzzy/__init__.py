"""Search that forgives: the operators of the matcher with costs, best matches first.

A symbol may differ from its step by an angle (`costs`), others may lie between two steps, and steps
may be missing (`follow`); lines beside each other add what they cost (`join`).
"""

from lanindex.search.fuzzy.costs import Allowance
from lanindex.search.fuzzy.find import find

__all__ = ["Allowance", "find"]
