"""AMC, how an Acclaim skeleton moves, with the skeleton beside it, ASF: read, cut byte for byte."""

from lanindex.formats.amc.beside import companions
from lanindex.formats.amc.cut import cutter
from lanindex.formats.amc.read import beside, read

__all__ = ["beside", "companions", "cutter", "read"]
