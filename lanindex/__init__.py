"""LanIndex: find human movement by what it is.

Motion captures are read, written down as Labanotation, kept in a library, and found again by
pattern::

    import lanindex

    motion = lanindex.read("walk.bvh")          # positions of joints over time
    score = lanindex.encode(motion)             # symbols: part, direction, level, frames
    with lanindex.open_library("dance.db", create=True) as library:
        library.ingest("captures/")
        hits = library.search("r_arm right mid -> high")
        library.export(hits, "clips")

The examples of each function and class are typed in a folder with the choreographies of
``corpus/`` and, where they open ``dance.db``, a library into which those were ingested.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lanindex.draw.strip import Staff as Staff
    from lanindex.encoding import encode as encode
    from lanindex.encoding import trace as trace
    from lanindex.encoding.profile import load as load_profile
    from lanindex.errors import LanindexError as LanindexError
    from lanindex.formats import read as read
    from lanindex.library.selection import Selection as Selection
    from lanindex.model import Hit as Hit
    from lanindex.model import Motion as Motion
    from lanindex.model import Score as Score
    from lanindex.model import Symbol as Symbol
    from lanindex.notation.lnd import read as read_lnd
    from lanindex.notation.lnd import write as write_lnd
    from lanindex.perform import perform as animate
    from lanindex.pipeline.library import Library as Library
    from lanindex.pipeline.library import open_library as open_library
    from lanindex.search.language.builder import part as part
    from lanindex.search.language.completion import complete as complete
    from lanindex.search.language.written import pattern_text as pattern_text
    from lanindex.search.language.written import pattern_tree as pattern_tree

    __version__: str

_PUBLIC = {
    "read": ("lanindex.formats", "read"),
    "encode": ("lanindex.encoding", "encode"),
    "trace": ("lanindex.encoding", "trace"),
    "load_profile": ("lanindex.encoding.profile", "load"),
    "read_lnd": ("lanindex.notation.lnd", "read"),
    "write_lnd": ("lanindex.notation.lnd", "write"),
    "animate": ("lanindex.perform", "perform"),
    "open_library": ("lanindex.pipeline.library", "open_library"),
    "Library": ("lanindex.pipeline.library", "Library"),
    "complete": ("lanindex.search.language.completion", "complete"),
    "pattern_tree": ("lanindex.search.language.written", "pattern_tree"),
    "pattern_text": ("lanindex.search.language.written", "pattern_text"),
    "part": ("lanindex.search.language.builder", "part"),
    "Selection": ("lanindex.library.selection", "Selection"),
    "Motion": ("lanindex.model", "Motion"),
    "Score": ("lanindex.model", "Score"),
    "Symbol": ("lanindex.model", "Symbol"),
    "Staff": ("lanindex.draw.strip", "Staff"),
    "Hit": ("lanindex.model", "Hit"),
    "LanindexError": ("lanindex.errors", "LanindexError"),
}
"""Public names, with the place that each is imported from when it is first asked for."""

__all__ = [
    "Hit",
    "LanindexError",
    "Library",
    "Motion",
    "Score",
    "Selection",
    "Staff",
    "Symbol",
    "__version__",
    "animate",
    "complete",
    "encode",
    "load_profile",
    "open_library",
    "part",
    "pattern_text",
    "pattern_tree",
    "read",
    "read_lnd",
    "trace",
    "write_lnd",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first asked for: the command's start shall be quick."""
    if name == "__version__":
        from importlib.metadata import version

        return version("lanindex")
    if name not in _PUBLIC:
        raise AttributeError(f"module 'lanindex' has no attribute {name!r}")
    module, attribute = _PUBLIC[name]
    return getattr(import_module(module), attribute)


def __dir__() -> list[str]:
    return __all__
