"""Callers of a library's page without a browser, and servers in processes of their own."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from starlette.testclient import TestClient

import lanindex
from lanindex.web.server import Site, application

HOST, TOKEN = "127.0.0.1:8421", "token"

DROP = """(files) => {
    const dropped = new DataTransfer();
    for (const [name, text] of files) dropped.items.add(new File([text], name));
    for (const type of ["dragover", "drop"]) {
        const how = { dataTransfer: dropped, bubbles: true, cancelable: true };
        document.querySelector("main").dispatchEvent(new DragEvent(type, how));
    }
}"""
"""Drops files, each with its name and text, onto the page."""


def asking(library: lanindex.Library, *, readonly: bool = False) -> TestClient:
    site = Site(library, readonly=readonly)
    app = application(site, token=TOKEN, host="127.0.0.1", port=8421)
    headers = {"authorization": f"Bearer {TOKEN}"}
    return TestClient(app, base_url=f"http://{HOST}", headers=headers)


@contextmanager
def serving(library: Path | str, *options: str) -> Iterator[str]:
    """Serve a library in a process of its own, and yield the link that lets in."""
    command = [sys.executable, "-m", "lanindex", "serve", str(library), "--port", "0", "--no-open"]
    process = subprocess.Popen(
        [*command, *options],
        cwd=library.parent if isinstance(library, Path) else None,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])},
    )
    try:
        assert process.stdout is not None
        link = process.stdout.readline().strip()
        assert link.startswith("http://127.0.0.1:"), process.communicate()[1]
        yield link
    finally:
        process.terminate()
        said = process.communicate(timeout=20)[1]
    assert "Traceback" not in said, said
