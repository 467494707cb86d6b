"""Short names of long patterns, for addresses: kept in a file beside the library."""

from __future__ import annotations

import json
from hashlib import sha256
from threading import Lock
from typing import Any

from lanindex.errors import LanindexError, UsageError
from lanindex.library.dialect import Target
from lanindex.pipeline.files import write_all
from lanindex.web.routes import Call

MOST = 10_000
"""Patterns that are kept, the newest."""

LONGEST = 10_000
"""Characters of a pattern."""


class PatternNames:
    """The names of patterns of a library."""

    def __init__(self, library: Target) -> None:
        self._path, self._lock = library.beside("patterns.json"), Lock()

    def _read(self) -> dict[str, str]:
        try:
            held = json.loads(self._path.read_text("utf-8"))
        except FileNotFoundError:
            return {}
        except (OSError, ValueError) as error:
            found = "the names of patterns cannot be read"
            raise LanindexError(found, place=str(self._path)) from error
        return {str(name): str(text) for name, text in held.items()}

    def name(self, text: str) -> str:
        """Return the name of a pattern, made where it has none."""
        name = sha256(text.encode()).hexdigest()[:10]
        with self._lock:
            held = self._read()
            if held.get(name) != text:
                held = dict([*held.items(), (name, text)][-MOST:])
                write_all([(self._path, json.dumps(held, indent=0).encode())], force=True)
        return name

    def text(self, name: str) -> str:
        """Return the pattern of a name."""
        held = self._read()
        if name not in held:
            raise UsageError(f'no pattern has the name "{name[:20]}"', wanted="one that was kept")
        return held[name]


def keep(call: Call) -> dict[str, Any]:
    """Keep a pattern, and return its name."""
    text = call.said("text", str, "")
    if not 0 < len(text) <= LONGEST:
        raise UsageError(f"a pattern of {len(text)} characters", wanted=f"{LONGEST:,} at most")
    return {"name": call.site.names.name(text)}


def kept(call: Call) -> dict[str, Any]:
    """Return the pattern of a name."""
    return {"text": call.site.names.text(call.path["name"])}
