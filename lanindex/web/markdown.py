"""Pages in Markdown as trees, of what our pages are written in; the page makes nodes of them.

A node is a text, or a list of its tag, attributes and children: ``["a", {"href": "…"}, "…"]``.
Headings, paragraphs, lists, tables, blocks of code, emphasis, code, links and pictures are known.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from html import unescape
from typing import Any

Node = str | list[Any]
Links = Callable[[str], str]
"""Returns the address that a link leads to on the page; empty where it has none there."""

_FENCE = re.compile(r"```(\w*)$")
_HEADING = re.compile(r"(#{1,4}) +(.+)")
_ITEM = re.compile(r"(?:[-*]|\d+\.) +")
_RULE = re.compile(r"\|?[ :|-]+\|?$")
_CELL = re.compile(r"(?<!\\)\|")
_SPAN = re.compile(
    r"<code>(?P<html>.*?)</code>"
    r"|(?P<ticks>`+)(?P<code>.+?)(?P=ticks)"
    r"|!\[(?P<alt>[^\]]*)\]\((?P<picture>[^)]*)\)"
    r"|\[(?P<text>(?:`[^`]*`|[^\]`])*)\]\((?P<link>[^)]*)\)"
    r"|\*\*(?P<strong>.+?)\*\*"
    r"|(?<![\w*])\*(?P<em>[^*\s](?:[^*]*[^*\s])?)\*(?![\w*])"
    r"|\\(?P<plain>[\\`*_|\[\]<>#-])",
    re.DOTALL,
)


def tree(text: str, links: Links) -> list[list[Any]]:
    """Return a page as a list of nodes."""
    return list(_blocks(text.splitlines(), links))


def slug(heading: str) -> str:
    """Return the name by which links call a heading."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")


def plain(node: Node) -> str:
    """Return the text of a node."""
    return node if isinstance(node, str) else "".join(map(plain, node[2:]))


def _blocks(lines: list[str], links: Links) -> Iterator[list[Any]]:
    at = 0
    while at < len(lines):
        line = lines[at]
        begin = at
        if not line.strip():
            at += 1
        elif fence := _FENCE.match(line):
            at = next(it for it in range(at + 1, len(lines)) if lines[it].startswith("```"))
            yield ["pre", {"lang": fence[1]}, "\n".join(lines[begin + 1 : at])]
            at += 1
        elif line.startswith("    "):
            at = _while(lines, at, lambda it: not it.strip() or it.startswith("    "))
            yield ["pre", {"lang": ""}, "\n".join(it[4:] for it in lines[begin:at]).rstrip()]
        elif heading := _HEADING.match(line):
            children = _spans(heading[2], links)
            name = slug("".join(map(plain, children)))
            yield [f"h{len(heading[1])}", {"id": name}, *children]
            at += 1
        elif line.startswith("|"):
            at = _while(lines, at, lambda it: it.startswith("|"))
            yield _table(lines[begin:at], links)
        elif _ITEM.match(line):
            at = _while(lines, at, lambda it: bool(_ITEM.match(it)) or it.startswith("  "), True)
            yield _list(lines[begin:at], links)
        else:
            at = _while(lines, at + 1, lambda it: not _begins_block(it))
            yield ["p", {}, *_spans(" ".join(lines[begin:at]), links)]


def _while(lines: list[str], at: int, fits: Callable[[str], bool], gaps: bool = False) -> int:
    """Return behind the lines from one on that fit; `gaps`: what follows an empty one may, too."""
    while at < len(lines):
        told = lines[at] if lines[at].strip() or not gaps else "".join(lines[at + 1 : at + 2])
        if not fits(told):
            break
        at += 1
    return at


def _begins_block(line: str) -> bool:
    return not line.strip() or line.startswith(("```", "#", "|")) or bool(_ITEM.match(line))


def _list(lines: list[str], links: Links) -> list[Any]:
    """Return a list; what is indented below an item belongs to it."""
    items: list[list[str]] = []
    for line in lines:
        if item := _ITEM.match(line):
            items.append([line[item.end() :]])
            indent = item.end()
        else:
            items[-1].append(line[min(indent, len(line) - len(line.lstrip())) :])
    found: list[Node] = []
    for own in items:
        blocks = list(_blocks(own, links))
        alone = len(blocks) == 1 and blocks[0][0] == "p"
        found.append(["li", {}, *(blocks[0][2:] if alone else blocks)])
    return ["ol" if lines[0][0].isdigit() else "ul", {}, *found]


def _table(lines: list[str], links: Links) -> list[Any]:
    """Return a table; what stands above its rule are the names of its columns."""
    head, rest = (lines[:1], lines[2:]) if _RULE.match(lines[1]) else ([], lines)

    def rows(lines: list[str], tag: str) -> list[Node]:
        cells = [_CELL.split(line.strip().removeprefix("|").removesuffix("|")) for line in lines]
        return [["tr", {}, *(cell(it.strip(), tag) for it in row)] for row in cells]

    def cell(text: str, tag: str) -> Node:
        return [tag if text else "td", {}, *_spans(text, links)]

    return ["table", {}, ["thead", {}, *rows(head, "th")], ["tbody", {}, *rows(rest, "td")]]


def _spans(text: str, links: Links) -> list[Node]:
    """Return a text with its emphasis, code and links."""
    found: list[Node] = []
    at = 0
    for span in _SPAN.finditer(text):
        found += [text[at : span.start()]] if span.start() > at else []
        at = span.end()
        match span.lastgroup:
            case "html":
                found.append(["code", {}, unescape(span["html"])])
            case "code":
                found.append(["code", {}, span["code"].strip().replace("\\|", "|")])
            case "link":
                href = links(span["link"])
                children = _spans(span["text"], links)
                found += [["a", {"href": href}, *children]] if href else children
            case "picture":
                found.append(["img", {"src": links(span["picture"]), "alt": span["alt"]}])
            case "strong" | "em" as tag:
                found.append([tag, {}, *_spans(span[tag], links)])
            case "plain":
                found.append(span["plain"])
    return [*found, text[at:]] if at < len(text) else found
