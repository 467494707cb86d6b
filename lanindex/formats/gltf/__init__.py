"""glTF 2.0 (GL Transmission Format), and GLB, all of it in one file: read, cut, write."""

from lanindex.formats.gltf.read import read, subjects

__all__ = ["read", "subjects"]
