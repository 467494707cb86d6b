"""A page with a figure and a staff alone, and a server of made-up data for it."""

import json
import math
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import cached_property
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from urllib.parse import parse_qs, urlsplit

import numpy as np

import lanindex
from lanindex.draw import draw, svg
from lanindex.draw.staff import BEAT, MARGIN, START
from lanindex.film.figure import Figure, figure
from lanindex.film.tiles import SECONDS, described, packed

HERE = Path(__file__).parent / "web"
TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css"}
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
    "connect-src 'self'; require-trusted-types-for 'script'; trusted-types svg"
)
CIRCLE = 1800.0  # mm, the radius of the way that the walker goes
PACE = 900.0  # mm a second


def walked(body: Figure) -> Figure:
    """Return a body that marches on a place, on its way round a circle."""
    angle = np.arange(len(body)) / float(body.rate) * PACE / CIRCLE
    sin, cos, zero, one = np.sin(angle), np.cos(angle), 0 * angle, 1 + 0 * angle
    turned = np.stack([cos, zero, -sin, zero, one, zero, sin, zero, cos], axis=1).reshape(-1, 3, 3)
    places = np.einsum("fji,fki->fkj", turned.transpose(0, 2, 1), body.places)
    places += CIRCLE * np.stack([-cos, zero, sin], axis=1)[:, None]
    return replace(body, places=places.astype(np.float32))


class Walker:
    """What a server tells of a capture: its figure, tiles and staff."""

    def __init__(self, source: Path) -> None:
        self.motion = lanindex.read(source)
        self.body = walked(figure(self.motion))
        self.tile = math.ceil(SECONDS * float(self.body.rate))

    @cached_property
    def score(self) -> lanindex.Score:
        return lanindex.encode(self.motion)

    def description(self) -> bytes:
        told = {
            "rate": float(self.body.rate),
            "frames": len(self.body),
            "tile": self.tile,
            "floor": float(np.nanmin(self.body.places[..., 1])),
            **described(self.body),
        }
        return json.dumps(told).encode()

    def piece(self, number: int) -> bytes:
        return packed(self.body.places[number * self.tile : (number + 1) * self.tile])

    def staff(self, zoom: float) -> bytes:
        seconds, beat = len(self.body) / float(self.body.rate), round(BEAT * zoom)
        picture = draw(self.score, bars=None, seconds=True, beat=beat)
        base = 2 * MARGIN + max(round(seconds * beat), beat)
        told = {
            "svg": svg.write(picture),
            "times": [0, seconds],
            "ys": [base, base - seconds * beat],
            "names": base + 2 * MARGIN + START - MARGIN // 2,
        }
        return json.dumps(told).encode()


@contextmanager
def served(static: Path, walker: Walker) -> Iterator[str]:
    """Serve the page while a block runs, and yield its address."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            address = urlsplit(self.path)
            name, query = address.path, parse_qs(address.query)
            kind, body = "application/json", b""
            if name.startswith("/api/captures/1/motion/"):
                kind, body = "application/octet-stream", walker.piece(int(name.rpartition("/")[2]))
            elif name == "/api/captures/1/figure":
                body = walker.description()
            elif name == "/api/captures/1/staff":
                body = walker.staff(float(query["zoom"][0]))
            else:
                folder = static if name.startswith("/static/") else HERE
                path = folder / name.removeprefix("/static").lstrip("/")
                if path.is_file():
                    kind, body = TYPES[path.suffix], path.read_bytes()
            self.send_response(200 if body else 404)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(body)))
            self.send_header("Content-Security-Policy", POLICY)
            with suppress(ConnectionError):  # the page has given up meanwhile
                self.end_headers()
                self.wfile.write(body)

        def log_message(self, *_: object) -> None:
            """Say nothing."""

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = Thread(target=server.serve_forever)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/harness.html"
    finally:
        server.shutdown()
        thread.join()
        server.server_close()
