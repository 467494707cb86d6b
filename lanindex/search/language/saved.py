"""Patterns that are kept in files: ``@raise.lq``."""

from __future__ import annotations

import re
from pathlib import Path

from lanindex.notation import NOTATIONS, notation_of, read
from lanindex.notation.text import read_text

_ENDINGS = "|".join(("lq", *map(re.escape, NOTATIONS)))
_FILE = re.compile(rf"@(?P<path>.*\.(?:{_ENDINGS})|\S*[/\\].*)", re.IGNORECASE | re.DOTALL)


class Saved(str):
    """A pattern's text that knows the file it comes from, so that an error can name it."""

    path: Path

    def __new__(cls, text: str, path: Path) -> Saved:
        """Make one of a text."""
        made = super().__new__(cls, text)
        made.path = path
        return made

    def place(self, start: int) -> str:
        """Return file and line of a character."""
        return f"{self.path}:{self.count(chr(10), 0, start) + 1}"


def pattern_in(text: str, folder: Path | None = None) -> str:
    r"""Return a pattern, read from a file where its text names one.

    Parameters
    ----------
    text : str
        A pattern, or ``@`` and the path of a file that ends in ``.lq`` or as a score, or has a
        slash. Scores in other notations are read as LND.
    folder : Path, optional
        What the path starts from; by default the working folder.

    Returns
    -------
    str
        The text itself, or a `Saved`.

    Raises
    ------
    NotationError
        Where the file cannot be read, or is not text.

    Examples
    --------
    >>> from pathlib import Path
    >>> from lanindex.search.language.saved import pattern_in
    >>> _ = Path("up.lq").write_text("// to overhead\nr_arm low -> place high")
    >>> print(pattern_in("@up.lq"))
    // to overhead
    r_arm low -> place high
    """
    named = _FILE.fullmatch(text.strip())
    if named is None:
        return text
    path = Path(named["path"]) if folder is None else folder / named["path"]
    form = notation_of(str(path))
    if form is not None and form.name != "lnd":
        from lanindex.notation import lnd

        return Saved(lnd.write(read(str(path))), path)
    return Saved(read_text(path).replace("\r\n", "\n").replace("\r", "\n"), path)
