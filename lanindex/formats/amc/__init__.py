"""AMC, how an Acclaim skeleton moves, with the skeleton beside it, ASF: read, cut byte for byte."""

from lanindex.formats.amc.asf import companions
from lanindex.formats.amc.frames import cutter
from lanindex.formats.amc.read import beside, read

__all__ = ["beside", "companions", "cutter", "read"]
