"""A pattern as it is written, as a tree for JSON with the place of each node, and back to text.

What is named by ``let`` or ``@name`` stays so. What a staff cannot show is a node with its text.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from os import PathLike
from typing import Any

from lanindex.errors import UsageError
from lanindex.search.dictionary import named_patterns
from lanindex.search.language import query as tree
from lanindex.search.language.lexer import Place
from lanindex.search.language.parser import Part, read_places
from lanindex.search.language.words import Vocabulary

Tree = dict[str, Any]


def pattern_tree(
    text: str,
    *,
    parts: Collection[str] | None = None,
    words: str | PathLike[str] | None = None,
) -> Tree:
    """Return the tree of a pattern as it is written.

    Parameters
    ----------
    text : str
        A pattern.
    parts : collection of str, optional
        Parts that it may name beside those of the alphabet, as a library has them.
    words : path-like, optional
        A file with words of your own for the dictionary of movement.

    Returns
    -------
    dict
        Ready for JSON: each node with its ``kind``, the characters ``at`` which it is, and its
        ``text``. The page ``lanindex guide json`` has all kinds and their keys.

    Raises
    ------
    PatternError
        The pattern is not understood.

    Examples
    --------
    >>> import lanindex
    >>> found = lanindex.pattern_tree("r_arm right/left -> high 1s+")
    >>> step = found["pattern"]["alternatives"][0]["first"]["steps"][1]
    >>> step["at"], step["text"], step["part"], step["length"]["text"]
    ([20, 28], 'high 1s+', 'r_arm', '1s+')
    """
    names = named_patterns(text, words)
    pattern, query, places = read_places(text, Vocabulary(parts), names)
    return _Dump(text, places).query(pattern, query)


class _Dump:
    """Turns the nodes that a parser read into dicts; a method for each kind with nodes inside."""

    def __init__(self, text: str, places: Mapping[int, Place]) -> None:
        self.text, self.places = text, places

    def node(self, kind: str, node: object, **keys: Any) -> Tree:
        place = self.places[id(node)]
        text = self.text[place.start : place.stop]
        return {"kind": kind, "at": [place.start, place.stop], "text": text, **keys}

    def leaf(self, kind: str, node: object) -> Tree | None:
        """Return a node that has nothing but its text; None where it is not written."""
        return self.node(kind, node) if id(node) in self.places else None

    def query(self, pattern: tree.Choice, query: tree.Query) -> Tree:
        said = [it.node for it in self.places.values() if isinstance(it.node, Part)]
        conditions = [self.node("condition", it) for it in query.where]
        return {
            "kind": "query",
            "at": [0, len(self.text)],
            "text": self.text,
            "lets": [self.node("let", it, name=it.name) for it in said if it.kind == "let"],
            "pattern": self.choice(pattern),
            "clauses": [
                self.node(it.name, it, **({"conditions": conditions} if it.name == "where" else {}))
                for it in said
                if it.kind == "clause"
            ],
            "stages": [self.node("stage", it) for it in query.stages],
        }

    def choice(self, choice: tree.Choice) -> Tree:
        return self.node("choice", choice, alternatives=list(map(self.lines, choice.alternatives)))

    def lines(self, lines: tree.Lines) -> Tree:
        others = [
            self.node(
                "beside",
                it,
                relation=it.relation,
                limit=self.leaf("length", it.within),
                line=self.line(it.line),
            )
            for it in lines.others
        ]
        return self.node("lines", lines, first=self.line(lines.first), others=others)

    def line(self, line: tree.Line) -> Tree:
        start, *arrows, end = (
            it and self.node("arrow", it, later=it.later, limit=self.limit(it))
            for it in (line.start, *line.arrows, line.end)
        )
        steps = list(map(self.step, line.items))
        return self.node("line", line, start=start, steps=steps, arrows=arrows, end=end)

    def limit(self, arrow: tree.Arrow) -> Tree | None:
        return self.leaf("length", arrow.length) or self.leaf("skips", arrow.skips)

    def step(self, item: tree.Item) -> Tree:
        place = self.places[id(item.unit)]
        keys: Tree = {}
        kind = place.written
        match place.inner or item.unit:
            case tree.Bracket(pattern) if kind in ("", "mirror"):
                kind, keys = kind or "bracket", {"pattern": self.choice(pattern)}
            case tree.Step() as step if not kind:
                kind, keys = "step", self.movement(step)
            case _:  # what is named, or lines of LND
                keys = {kind: self.text[place.start : place.stop].lstrip("@ ")}
        keys |= {"label": item.label, "length": self.leaf("length", item.length)}
        return self.node(kind, item, **keys, repeat=self.leaf("repeat", item.repeat))

    def movement(self, step: tree.Step) -> Tree:
        return {
            "part": step.name,
            "parts": list(step.mover.members),
            "form": step.mover.form,
            "written": step.named,
            "manner": step.manner,
            "words": [
                self.node("word", it, of=it.kind, values=list(it.values), negated=it.negated)
                for it in step.words
            ],
        }


def pattern_text(tree: Mapping[str, Any]) -> str:
    """Return the text of a tree, or of a node of one.

    Parameters
    ----------
    tree : mapping
        As `pattern_tree` returns it, or changed. A node with nodes inside is written from those,
        and a step and its words from their other keys; all others are their ``text``. The places
        may be missing or wrong.

    Returns
    -------
    str
        Comments and white space are not kept. A tree that was changed may be no pattern any more:
        `pattern_tree` of the text tells.

    Raises
    ------
    UsageError
        It is no such tree.

    Examples
    --------
    >>> import lanindex
    >>> found = lanindex.pattern_tree("r_arm  right ->low")
    >>> (first, _) = found["pattern"]["alternatives"][0]["first"]["steps"]
    >>> first["words"][0]["values"] = ["left", "place"]
    >>> lanindex.pattern_text(found)
    'r_arm left/place -> low'
    """
    try:
        return " ".join(_texts(tree))
    except (KeyError, TypeError, AttributeError, ValueError, RecursionError) as error:
        found = f"a tree of a pattern with a wrong node ({type(error).__name__}: {error})"
        raise UsageError(found, wanted="nodes as pattern_tree returns them") from error


def _texts(node: Mapping[str, Any]) -> Iterator[str]:
    """Yield the texts of a node, between which spaces may stand."""
    match node["kind"]:
        case "query":
            for it in (*node.get("lets", ()), node["pattern"], *node.get("clauses", ())):
                yield pattern_text(it)
            for it in node.get("stages", ()):
                yield f"| {pattern_text(it)}"
        case "where":
            yield f"where {' and '.join(map(pattern_text, node['conditions']))}"
        case "choice":
            yield " or ".join(map(pattern_text, node["alternatives"]))
        case "lines":
            yield from map(pattern_text, (node["first"], *node.get("others", ())))
        case "beside":
            yield f"{node['relation']}{_limit(node)} {pattern_text(node['line'])}"
        case "line":
            yield from _line(node)
        case "arrow":
            yield ("..." if node["later"] else "->") + _limit(node)
        case "step" | "bracket" | "mirror" | "named" | "score":
            label, length, repeat = (node.get(it) for it in ("label", "length", "repeat"))
            yield from [f"{label}:"] if label else ()
            yield from _unit(node)
            yield from map(pattern_text, filter(None, (length, repeat)))
        case "word":
            yield ("not " if node.get("negated") else "") + "/".join(node["values"])
        case _:
            yield node["text"]


def _limit(node: Mapping[str, Any]) -> str:
    limit = node.get("limit")
    return f"[{pattern_text(limit)}]" if limit else ""


def _line(node: Mapping[str, Any]) -> Iterator[str]:
    if start := node.get("start"):
        yield f"start {pattern_text(start)}"
    first, *others = node["steps"]
    yield pattern_text(first)
    for arrow, step in zip(node.get("arrows", ()), others, strict=True):
        yield f"{pattern_text(arrow)} {pattern_text(step)}"
    if end := node.get("end"):
        yield f"{pattern_text(end)} end"


def _unit(node: Mapping[str, Any]) -> Iterator[str]:
    match node["kind"]:
        case "step":
            manner = node.get("manner", "move")
            yield from [node["part"]] if node.get("written", True) else ()
            yield from [manner] if manner != "move" else ()
            yield from map(pattern_text, node.get("words", ()))
        case "named":
            yield f"@{node['named']}"
        case "score":
            yield node["score"]
        case kind:
            yield f"{'mirror ' * (kind == 'mirror')}({pattern_text(node['pattern'])})"
