"""The verb that serves the page."""

from __future__ import annotations

import sys
import webbrowser
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory

import lanindex
from lanindex.app import options
from lanindex.app.options import argument, flag, option
from lanindex.errors import UsageError, extra


def serve(
    library: str = argument(
        options.DB, "[LIBRARY]", "The library to show, a path or URL.", envvar="LANINDEX_DB"
    ),
    host: str = option("127.0.0.1", "ADDRESS", "Where to listen; 0.0.0.0: for other machines."),
    port: int = option(8421, "N", "The port; 0: a free one.", min=0, max=65535),
    read_only: bool = flag("--read-only", "Let nobody change the library."),
    no_open: bool = flag("--no-open", "Do not open a browser."),
    *,
    words: options.Words = None,
    out: options.ColorOut,
) -> int:
    """Show a library in a browser: search, watch, read and write movement.

    The link that is printed lets a browser in, once and for all; who has it can change the
    library, unless it is served with --read-only. Ctrl-C ends it.
    """
    with extra("web", "serve", UsageError):
        from lanindex.web.server import serve

    def ready(link: str) -> None:
        out.line(link)
        sys.stdout.flush()
        if not no_open and out.terminal:
            webbrowser.open(_page_to(link, folder))

    with (
        TemporaryDirectory(prefix="lanindex-") as folder,
        lanindex.open_library(
            library, create=not read_only, readonly=read_only, words=words, note=out.note
        ) as opened,
    ):
        serve(opened, host=host, port=port, readonly=read_only, ready=ready)
    return 0


def _page_to(link: str, folder: str) -> str:
    """Return the address of a page that leads to a link, and that nobody else can read.

    All who use the machine can read a browser's command line; with the link they would be let in.
    """
    page = Path(folder, "open.html")
    page.touch(mode=0o600)
    page.write_text(
        f'<!doctype html><meta http-equiv="refresh" content="0; url={escape(link)}">'
        f'<title>LanIndex</title><a href="{escape(link)}">Open LanIndex</a>\n'
    )
    return page.as_uri()
