"""The plain matcher, which follows the language's page word for word: the oracle of faster ones."""

from lanindex.search.plain.find import TOLERANCE, find

__all__ = ["TOLERANCE", "find"]
