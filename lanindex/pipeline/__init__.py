"""The main job in one place: a library that reads, finds and exports."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lanindex.pipeline.library import Library as Library
    from lanindex.pipeline.library import open_library as open_library

__all__ = ["Library", "open_library"]


def __getattr__(name: str) -> Any:
    # Only when it is asked for: the processes of an ingest need nothing that searches.
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from lanindex.pipeline import library

    return getattr(library, name)
