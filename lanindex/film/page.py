"""Hits as one page of HTML that asks nobody for anything: click a hit, and it plays.

The page, its style and its script stand in ``page.html``. What is put into it is escaped text,
SVG of our own, numbers, and the places of joints as base64 of int16: nothing in it can end a tag.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from pathlib import Path
from string import Template

from lanindex.draw import svg
from lanindex.film.shot import Shot

HITS = 1000
"""Hits of a page, where nobody says how many."""


def page(shots: Sequence[Shot], title: str) -> str:
    """Return hits as a page."""
    template = Template(Path(__file__).with_name("page.html").read_text("utf-8"))
    count = f"{len(shots)} hit{'s' * (len(shots) != 1)}"
    cards = "".join(map(_card, shots))
    return template.substitute(title=svg.text_of(title), count=count, cards=cards)


def _card(shot: Shot) -> str:
    """Return a hit: a button that plays it, where there is something to play."""
    find = svg.text_of(f"{shot.path} {shot.label}".lower())
    said = svg.text_of(" \u00b7 ".join(filter(None, (shot.when, shot.label, shot.words))))
    tag = "button" if shot.played else "div"
    kind = ' type="button"' if shot.played else ""
    trouble = f'<span class="trouble">{svg.text_of(shot.trouble)}</span>' if shot.trouble else ""
    seen = "".join(
        f'<span class="{name}">{svg.write(picture)}</span>'
        for name, picture in (("poses", shot.poses), ("staff", shot.staff))
        if picture
    )
    return (
        f'<li data-find="{find}"><{tag} class="hit"{kind}{_data(shot)}>'
        f'<span class="path">{svg.text_of(shot.path)}</span><span class="said">{said}</span>'
        f'{trouble}<span class="seen">{seen}</span></{tag}></li>\n'
    )


def _data(shot: Shot) -> str:
    """Return what the script reads of a hit, as attributes."""
    if shot.played is None:
        return ""
    played = shot.played
    data = {
        "joints": b64encode(played.places.astype("<i2").tobytes()).decode(),
        "count": played.places.shape[1],
        "bones": " ".join(f"{inner},{outer},{kind}" for inner, outer, kind in played.bones),
        "head": played.head,
        "seconds": f"{played.seconds:g}",
        "start": f"{played.start:g}",
        "from": f"{played.hit[0]:g}",
        "to": f"{played.hit[1]:g}",
        "turn": f"{played.turn:g}",
        "base": shot.base,
        "beat": shot.beat,
    }
    return "".join(f' data-{name}="{it}"' for name, it in data.items())
