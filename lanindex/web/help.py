"""The guide on the page: its pages as trees, and the signs of the staff with what they mean."""

from __future__ import annotations

import posixpath
import re
from functools import cache
from importlib.resources import files
from typing import Any
from urllib.parse import urlencode

from starlette.responses import FileResponse, Response

from lanindex.data import shipped
from lanindex.draw import svg
from lanindex.draw.staff import legend_signs
from lanindex.errors import AbsentError, PatternError, UsageError, did_you_mean
from lanindex.pipeline.files import choreographies
from lanindex.web import markdown
from lanindex.web.routes import Call

_TOPICS: dict[str, list[str]] = shipped("guide/topics.toml")
_SEARCHED = re.compile(r'\$? ?lanindex search "([^"]+)"')
_APART = re.compile(r"\s{2,}|\s*//")  # what a pattern means stands behind it, a little apart


def topics(call: Call) -> dict[str, Any]:
    """Return the pages that there are."""
    return {"topics": [{"name": name, "about": about} for name, (_, about) in _TOPICS.items()]}


def topic(call: Call) -> dict[str, Any]:
    """Return a page."""
    name = call.path["topic"]
    if name not in _TOPICS:
        remedy = did_you_mean(name, _TOPICS)
        raise UsageError(f'the guide has no topic "{name[:60]}"', remedy=remedy)
    return {"name": name, "nodes": _page(name)}


def signs(call: Call) -> dict[str, Any]:
    """Return the signs of a staff, drawn, and what each means."""
    return {"signs": [{"svg": svg.write(it), "means": it.title} for it in legend_signs()]}


def picture(call: Call) -> Response:
    """Return a picture of the guide: they lie beside the choreographies, which they show."""
    name = call.path["name"]
    pictures = {it.name: it for it in choreographies().glob("*.png")}
    if name not in pictures:
        raise AbsentError("the guide has no such picture", place=name[:60])
    return FileResponse(pictures[name])


@cache
def _page(name: str) -> list[markdown.Node]:
    path = _TOPICS[name][0]
    text = files("lanindex").joinpath(path).read_text(encoding="utf-8")
    nodes = markdown.tree(text, lambda link: _address(link, path))
    return [_with_patterns(it) if it[0] == "pre" else it for it in nodes]


def _address(link: str, page: str) -> str:
    """Return where a link of a page leads to: another topic, a heading, a picture, another site."""
    if link.startswith(("http:", "https:", "#")):
        return link
    if link.endswith(".png"):
        return f"/api/help/pictures/{posixpath.basename(link)}"
    path, mark, heading = link.partition("#")
    there = posixpath.normpath(posixpath.join(posixpath.dirname(page), path))
    names = [name for name, (own, _) in _TOPICS.items() if own == there]
    return f"/help/{names[0]}{mark}{heading}" if names else ""


def _with_patterns(block: list[Any]) -> markdown.Node:
    """Return a block of code whose patterns can be searched for."""
    tag, attributes, text = block
    nodes: list[markdown.Node] = []
    for line in text.split("\n"):
        pattern = _pattern_of(line, attributes["lang"])
        nodes.append(line)
        if pattern:
            address = "/search?" + urlencode({"q": pattern})
            said = f"Try it: {pattern}"
            nodes += ["  ", ["a", {"class": "try", "href": address, "aria-label": said}, "Try it"]]
        nodes.append("\n")
    return [tag, {}, *nodes[:-1]]


def _pattern_of(line: str, lang: str) -> str:
    """Return the pattern that stands in a line of code; empty where none does."""
    from lanindex.pipeline.search import query_of

    if searched := _SEARCHED.match(line):
        text = searched[1]
    elif lang in ("", "text"):
        text = _APART.split(line, maxsplit=1)[0]
    else:
        return ""
    try:
        query_of(text)
    except PatternError:
        return ""
    return text
