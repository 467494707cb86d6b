"""FBX (Autodesk FilmBox), by ``ufbx`` (extra ``fbx``): read.

``ufbx`` 0.0.5 reads all of FBX, pivots, layers and both encodings, and is kept up by the author of
the C library, which is MIT or public domain; but the wheel states no licence, and its Python side
is young: asking it in an ordinary way for an animated element ends the process. So it is never
loaded here, but in a child process that asks little, and whose end is an error like others.
"""

from lanindex.formats.fbx.read import read, subjects

__all__ = ["read", "subjects"]
