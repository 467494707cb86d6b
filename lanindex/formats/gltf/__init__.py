"""glTF 2.0 (GL Transmission Format), and GLB, all of it in one file: read, cut, write."""

from lanindex.formats.gltf.cut import cutter
from lanindex.formats.gltf.document import companions
from lanindex.formats.gltf.read import read, subjects
from lanindex.formats.gltf.write import write

__all__ = ["companions", "cutter", "read", "subjects", "write"]
