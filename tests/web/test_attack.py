"""What callers do who mean no good, or have bad luck: real servers, connections byte by byte."""

from __future__ import annotations

import asyncio
import http.client
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Coroutine, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from io import BytesIO
from itertools import count
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, TypeVar
from urllib.parse import parse_qs, urlsplit
from zipfile import ZipFile

import pytest
from page_client import serving

import lanindex
from lanindex.web import routes, uploads
from lanindex.web.jobs import Jobs

if TYPE_CHECKING:
    from collections.abc import Callable

    from playwright.sync_api import Page


T = TypeVar("T")


class Caller:
    """Somebody who asks the server of a link."""

    def __init__(self, link: str) -> None:
        parts = urlsplit(link)
        assert parts.port is not None
        self.port = parts.port
        self.token = parse_qs(parts.query)["token"][0]
        self.own = f"Host: 127.0.0.1:{self.port}\r\nAuthorization: Bearer {self.token}\r\n".encode()

    def ask(self, method: str, path: str, body: Any = None) -> tuple[int, bytes]:
        """Return the status and the body of an answer."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        content = body if body is None or isinstance(body, bytes) else json.dumps(body)
        headers = {"authorization": f"Bearer {self.token}"}
        connection.request(method, path, content, headers)
        answer = connection.getresponse()
        found = answer.status, answer.read()
        connection.close()
        return found

    def get(self, path: str) -> Any:
        """Return the JSON of an answer that is a success."""
        status, content = self.ask("GET", path)
        assert status == 200, content
        return json.loads(content)

    def connect(self, *sent: bytes) -> socket.socket:
        """Return a connection over which something was sent."""
        connection = socket.create_connection(("127.0.0.1", self.port), timeout=60)
        connection.sendall(b"".join(sent))
        return connection

    def raw(self, *sent: bytes) -> bytes:
        """Return what comes back for some bytes, to its end."""
        with self.connect(*sent) as connection:
            parts = []
            try:
                while part := connection.recv(1 << 16):
                    parts.append(part)
            except ConnectionResetError:  # more was sent than was read
                pass
        return b"".join(parts)

    def job(self, path: str, body: Any) -> str:
        """Begin a job and return its number."""
        status, content = self.ask("POST", path, body)
        assert status == 200, content
        return str(json.loads(content)["job"])

    def end(self, job: str) -> dict[str, Any]:
        """Return the last state of a job."""
        _, told = self.ask("GET", f"/api/jobs/{job}/events")
        state: dict[str, Any] = json.loads(told.decode().strip().rpartition("data: ")[2])
        return state


@contextmanager
def called(library: Path, *options: str) -> Iterator[Caller]:
    with serving(library, *options) as link:
        yield Caller(link)


@pytest.fixture
def own(corpus_library: Path, tmp_path: Path) -> Path:
    """Return a library in a folder of its own, which a test may change."""
    (tmp_path / "home").mkdir()
    return Path(shutil.copy(corpus_library, tmp_path / "home" / "own.db"))


@pytest.fixture(scope="module")
def caller(corpus_library: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Caller]:
    """Return a caller of a server that all tests of this module share."""
    own = tmp_path_factory.mktemp("shared") / "own.db"
    shutil.copy(corpus_library, own)
    with called(own) as caller:
        yield caller


CLOSE = b"Connection: close\r\n\r\n"


@pytest.mark.parametrize(
    ("request_", "status"),
    [
        (b"GET http://evil.example/api/library HTTP/1.1\r\nHost: evil.example\r\n", 421),
        (b"GET /api/library HTTP/1.0\r\n", 421),
        (b"GET /api/library HTTP/1.1\r\nHost: \xff\xfe\r\n", 421),
        (b"GET / HTTP/1.1\r\nHost: evil.example\r\nOWN", 400),
        (b"POST /api/names HTTP/1.1\r\nOrigin: http://[::1\r\nContent-Length: 0\r\nOWN", 403),
        (
            b"POST /api/names HTTP/1.1\r\nOrigin: http://evil.example\r\nContent-Length: 0\r\nOWN",
            403,
        ),
        (b"GET /api/library HTTP/1.1\r\nSec-Fetch-Site: cross-site\r\nOWN", 403),
        (
            b"GET /api/library HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\nAuthorization: Bearer \xff\r\n",
            401,
        ),
        (
            b"GET /api/library HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\nCookie: lanindex-PORT=\xff\r\n",
            401,
        ),
        (b"GET /?token=%ff%fe HTTP/1.1\r\nOWN", 403),
        (b"\x16\x03\x01\x02\x00\x01\x00", 400),
        (b"GET /" + b"a" * 200_000 + b" HTTP/1.1\r\nOWN", 400),
        (b"GET / HTTP/1.1\r\nX: " + b"a" * 2_000_000 + b"\r\nOWN", 400),
        (b"PUT /api/uploads/x.bvh HTTP/1.1\r\nContent-Length: -5\r\nOWN", 400),
        (b"PUT /api/uploads/x.bvh HTTP/1.1\r\nContent-Length: 99999999999999999999\r\nOWN", 400),
        (b"PUT /api/uploads/x.bvh HTTP/1.1\r\nTransfer-Encoding: chunked\r\nOWN\r\nzz", 400),
    ],
)
def test_requests_that_no_page_sends_are_refused(
    caller: Caller, request_: bytes, status: int
) -> None:
    sent = request_.replace(b"OWN", caller.own).replace(b"PORT", str(caller.port).encode())
    answer = caller.raw(sent, CLOSE)
    assert answer.startswith(f"HTTP/1.1 {status} ".encode()), answer[:200]


@pytest.mark.parametrize(
    "path",
    [
        "/static/../server.py",
        "/static/..%2f..%2fserver.py",
        "/static//etc/passwd",
        "/api/names/..%2f..%2fetc%2fpasswd",
        "/api/names/..",
        "/api/profiles/..",
        "/api/profiles/..%2f..%2fetc",
        "/api/profiles/%00",
        "/api/help/..",
        "/api/help/%00",
        "/api/words/..",
        "/api/exports/..%2f../file",
        "/api/jobs/../events",
        "/api/captures/1/staff?parts=../../etc",
    ],
)
def test_no_path_leads_anywhere_else(caller: Caller, path: str) -> None:
    status, content = caller.ask("GET", path)
    assert status in (400, 404)
    assert b"root:" not in content
    assert b"import" not in content


@pytest.mark.parametrize(
    ("path", "body"),
    [
        ("/api/parse", b'{"text":' + b"[" * 200_000),
        ("/api/parse", b'{"text":' + b"[" * 900 + b"]" * 900 + b"}"),
        ("/api/parse", b"1e999"),
        ("/api/text", b'{"tree":' + b'{"a":' * 900 + b"1" + b"}" * 900 + b"}"),
        ("/api/names", b'{"text":"\\ud800"}'),
        ("/api/names", b'{"text":"\xed\xa0\x80"}'),
        ("/api/searches", b'{"like":"/etc/passwd"}'),
        ("/api/searches", b'{"like":"../own.db"}'),
        ("/api/searches", b'{"like":"http://127.0.0.1/a.bvh"}'),
        ("/api/searches", b'{"pattern":"@/etc/passwd"}'),
        ("/api/searches", b'{"pattern":"' + b"(" * 9000 + b'"}'),
        ("/api/searches", b'{"pattern":"' + b"r_arm high or " * 9000 + b'"}'),
        ("/api/ingests", b'{"files":{"a":"../own.db"}}'),
        ("/api/ingests", b'{"files":{"a":"/etc/passwd"}}'),
        ("/api/ingests", b'{"files":{"a":"\\u0000"}}'),
        ("/api/ingests", b'{"files":{"a":"' + b"a" * 9000 + b'"}}'),
        ("/api/captures/1/encode", b'{"profile":"../../../etc","parts":["r_arm"]}'),
        ("/api/captures/1/encode", b'{"parts":["r_arm"],"from":1e308,"to":1e309}'),
        ("/api/profiles", b'{"name":""}'),
        ("/api/exports", b'{"hits":[{}],"kind":"../x"}'),
        ("/api/captures/remove", b'{"captures":[99999999999999999999]}'),
    ],
)
def test_bodies_that_no_page_sends_are_refused(caller: Caller, path: str, body: bytes) -> None:
    status, content = caller.ask("POST", path, body)
    assert status in (400, 404), content
    assert json.loads(content)["error"]["found"]


def test_an_export_names_captures_of_the_library_alone(caller: Caller) -> None:
    away = {"capture": "/etc/passwd", "capture_id": 1, "start_frame": 0, "end_frame": 5}
    job = caller.job("/api/exports", {"hits": [away]})
    assert caller.end(job)["state"] == "failed"
    assert caller.ask("GET", f"/api/exports/{job}/file")[0] >= 400


def test_the_files_of_an_export_have_safe_names_and_are_gone_with_the_server(
    own: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    before = _tail(tmp_path)
    with called(own) as caller:
        search = caller.job("/api/searches", {"pattern": "arms high"})
        caller.end(search)
        hits = caller.get(f"/api/searches/{search}/hits?n=3")["hits"]
        job = caller.job("/api/exports", {"hits": hits})
        assert caller.end(job)["state"] == "done"
        _, content = caller.ask("GET", f"/api/exports/{job}/file")
        names = ZipFile(BytesIO(content)).namelist()
        assert names
        assert not [it for it in names if it.startswith(("/", "\\")) or ".." in it]
    assert _tail(tmp_path) == before
    assert {it.name for it in own.parent.iterdir()} == {"own.db"}


def test_nothing_is_written_anywhere_where_a_library_is_only_shown(own: Path) -> None:
    before = {it: it.read_bytes() for it in own.parent.rglob("*")}
    with called(own, "--read-only") as caller:
        for method, path, body in [
            ("PUT", "/api/uploads/x.bvh", b"HIERARCHY"),
            ("POST", "/api/names", {"text": "r_arm"}),
            ("POST", "/api/profiles", {"name": "x"}),
            ("POST", "/api/ingests", {"choreographies": True}),
            ("POST", "/api/scores/store", {"score": {}}),
            ("POST", "/api/captures/remove", {"captures": [1]}),
            ("PATCH", "/api/captures", {"changes": [{"captures": [1], "label": "x"}]}),
        ]:
            assert caller.ask(method, path, body)[0] == 403
        search = caller.job("/api/searches", {"pattern": "arms high"})
        assert caller.end(search)["state"] == "done"
        hits = caller.get(f"/api/searches/{search}/hits?n=2")["hits"]
        assert caller.end(caller.job("/api/exports", {"hits": hits}))["state"] == "done"
        for path in ("/api/captures/1/pose", "/api/captures/1/staff", "/api/words/wave/example"):
            assert caller.ask("GET", path)[0] == 200
    assert {it: it.read_bytes() for it in own.parent.rglob("*")} == before


def _tail(folder: Path) -> list[str]:
    return sorted(it.name for it in folder.glob("*")) if folder.exists() else []


def _until(true: Callable[[], bool], seconds: float = 10) -> None:
    stop = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < stop
        time.sleep(0.02)


def test_an_upload_that_breaks_off_leaves_nothing(own: Path) -> None:
    sent = own.with_name("own-captures")
    with called(own) as caller:
        put = b"PUT /api/uploads/x.bvh HTTP/1.1\r\n" + caller.own
        with caller.connect(put, b"Content-Length: 500000\r\n\r\n", b"x" * 1000):
            _until(lambda: len(_tail(sent)) == 1)
            assert caller.ask("GET", "/api/library")[0] == 200
        _until(lambda: _tail(sent) == [])


def test_a_server_that_starts_leaves_alone_what_is_being_sent_to_another(own: Path) -> None:
    sent = own.with_name("own-captures")
    with called(own) as caller:
        put = b"PUT /api/uploads/x.bvh HTTP/1.1\r\nContent-Length: 10\r\nConnection: close\r\n"
        with caller.connect(put, caller.own, b"\r\n12345") as connection:
            _until(lambda: len(_tail(sent)) == 1)
            with called(own) as other:
                assert other.get("/api/library")["captures"] == len(_captures(own))
                connection.sendall(b"67890")
                assert connection.recv(1000).startswith(b"HTTP/1.1 200 ")
        assert (sent / "x.bvh").read_bytes() == b"1234567890"


def _captures(path: Path) -> list[str]:
    with lanindex.open_library(path, readonly=True) as library:
        return sorted(it.path for it in library.captures())


@dataclass
class Sent:
    """A request whose body comes in parts, each after a while."""

    parts: Iterable[bytes]
    wait: float = 0
    headers: dict[str, str] = field(default_factory=dict)

    async def stream(self) -> AsyncIterator[bytes]:
        """Yield the parts."""
        for part in self.parts:
            yield part
            await asyncio.sleep(self.wait)


def _ran(work: Coroutine[Any, Any, T]) -> T:
    """Return what work comes to; in a thread, since a browser may have a loop in this one."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, work).result()


def _written(own: Path, sent: Sent) -> list[str]:
    """Return what is left in the folder of uploads of a body that must be refused."""
    folder = own.with_name("own-captures")
    with pytest.raises(lanindex.LanindexError) as error:
        _ran(uploads._written(sent, folder))  # type: ignore[arg-type]
    return [error.value.found, *_tail(folder)]


def test_a_file_without_a_length_is_stopped_at_the_limit(
    own: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(uploads, "LARGEST", 100_000)
    taken = count()
    endless = (b"x" * 10_000 for _ in taken)
    assert _written(own, Sent(endless)) == ["a file that is too long"]
    assert next(taken) == 11


def test_a_file_that_trickles_is_given_up(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(uploads, "PATIENCE", 0.05)
    assert _written(own, Sent([b"x"] * 9, wait=5)) == ["the file came too slowly"]


def test_a_request_that_trickles_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(routes, "PATIENCE", 0.05)
    trickle: Any = Sent([b"{", *[b" "] * 9], wait=0.02)
    with pytest.raises(lanindex.LanindexError, match="came too slowly"):
        _ran(routes._body(trickle))
    whole: Any = Sent([b'{"text":', b'"r_arm"}'])
    assert _ran(routes._body(whole)) == {"text": "r_arm"}


def test_a_job_that_nobody_follows_is_broken_off_and_one_that_goes_on_is_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class Endless:
        state = "running"

        def cancel(self) -> None:
            self.state = "cancelled"

        def told(self) -> dict[str, Any]:
            return {}

    monkeypatch.setattr("lanindex.web.jobs.LEFT", 0.2)
    jobs = Jobs()
    left, followed, ingest = Endless(), Endless(), Endless()
    jobs.begin("left", lambda: left)
    number = jobs.begin("followed", lambda: followed)
    jobs.begin("ingest", lambda: ingest, goes_on=True)

    async def follow() -> None:
        watch = asyncio.create_task(jobs.watch())
        for _ in range(50):
            jobs.follow(number)
            await asyncio.sleep(0.01)
        watch.cancel()

    _ran(follow())
    assert [it.state for it in (left, followed, ingest)] == ["cancelled", "running", "running"]


def _ended(found: int) -> Any:
    return SimpleNamespace(state="done", found=found)


def test_searches_that_have_ended_keep_so_many_hits_and_the_last_one_all(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("lanindex.web.jobs.MOST_HITS", 100)
    jobs = Jobs()
    first, second = (jobs.begin(name, lambda: _ended(40)) for name in ("first", "second"))
    assert jobs.begin("first", lambda: _ended(40)) == first
    large = jobs.begin("large", lambda: _ended(60))
    assert [jobs.get(it).found for it in (first, large)] == [40, 60]
    with pytest.raises(lanindex.LanindexError, match="not kept any more"):
        jobs.get(second)
    assert jobs.begin("second", lambda: _ended(1000)) != second
    with pytest.raises(lanindex.LanindexError, match="Ask for it again"):
        jobs.get(large)
    assert len(jobs._jobs) == 1


def test_so_many_jobs_run_at_once_and_one_more_is_told_why_not() -> None:
    jobs = Jobs()
    running: Any = SimpleNamespace(state="running")
    for number in range(8):
        jobs.begin(number, lambda: running)
    with pytest.raises(lanindex.LanindexError, match="8 jobs are running already") as error:
        jobs.begin("more", lambda: running)
    assert error.value.remedy == "Wait until one of them ends."
    running.state = "done"
    assert jobs.begin("more", lambda: running)


def test_who_asks_for_nothing_is_hung_up_on(monkeypatch: pytest.MonkeyPatch) -> None:
    from uvicorn import Config

    from lanindex.web import process

    monkeypatch.setattr(process, "PATIENCE", 0.2)

    async def app(scope: Any, receive: Any, send: Any) -> None:
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await asyncio.sleep(0.6)  # an answer may take its time
        await send({"type": "http.response.body", "body": b"answer"})

    async def said(*parts: bytes) -> bytes:
        server = process.Server(
            Config(app, http=process.Connection, lifespan="off", log_level="error", port=0),
            type("Site", (), {"close": lambda self: None})(),
        )
        listener = socket.create_server(("127.0.0.1", 0))
        serves = asyncio.create_task(server.serve(sockets=[listener]))
        reader, writer = await asyncio.open_connection(*listener.getsockname())
        for part in parts:
            writer.write(part)
            await asyncio.sleep(0.05)
        found = b""
        with suppress(ConnectionResetError):  # hung up while more was sent
            found = await asyncio.wait_for(reader.read(), 10)
        writer.close()
        server.should_exit = True
        await serves
        return found

    request = b"GET / HTTP/1.1\r\nHost: x\r\n"
    assert _ran(said(request, *[b"X: y\r\n"] * 3)) == b""
    assert b"answer" in _ran(said(request, b"\r\n", request))


@pytest.mark.slow
def test_a_thousand_connections_and_streams_do_not_keep_others_out(own: Path) -> None:
    resource = pytest.importorskip("resource")
    now, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    if 0 <= most < 2500:
        pytest.skip("this machine allows fewer open files")
    resource.setrlimit(resource.RLIMIT_NOFILE, (256, most))
    try:
        with called(own) as caller:
            resource.setrlimit(resource.RLIMIT_NOFILE, (2500, most))
            sent = caller.job("/api/searches", {"pattern": "arms high"})
            stream = f"GET /api/jobs/{sent}/events HTTP/1.1\r\n".encode() + caller.own + b"\r\n"
            held = [caller.connect(b"GET / HTTP/1.1\r\nX: ") for _ in range(1000)]
            held += [caller.connect(stream) for _ in range(1000)]
            start = time.monotonic()
            assert caller.ask("GET", "/api/library")[0] == 200
            assert caller.ask("GET", "/api/captures")[0] == 200
            assert time.monotonic() - start < 30
            for connection in held:
                connection.close()
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (now, most))


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_it_ends_at_once_whoever_follows_a_job(own: Path, sent: signal.Signals) -> None:
    command = [sys.executable, "-m", "lanindex", "serve", str(own), "--port", "0", "--no-open"]
    with subprocess.Popen(command, stdout=-1, stderr=-1, text=True, cwd=own.parent) as process:
        assert process.stdout is not None
        caller = Caller(process.stdout.readline().strip())
        job = caller.job("/api/ingests", {"choreographies": True})
        with caller.connect(
            f"GET /api/jobs/{job}/events HTTP/1.1\r\n".encode(), caller.own, b"\r\n"
        ) as stream:
            assert stream.recv(10)
            start = time.monotonic()
            process.send_signal(sent)
            said = process.communicate(timeout=20)[1]
    assert time.monotonic() - start < 10  # on a busy machine
    assert process.returncode == 130
    assert said == "lanindex: interrupted\n"


SLOW = """
import sys, time
from lanindex.app.cli import main
from lanindex.web import captures
captures.library = lambda call: time.sleep(60)
main()
"""


@pytest.mark.slow
def test_it_ends_while_somebody_waits_for_an_answer(own: Path) -> None:
    command = [sys.executable, "-c", SLOW, "serve", str(own), "--port", "0", "--no-open"]
    with subprocess.Popen(command, stdout=-1, stderr=-1, text=True, cwd=own.parent) as process:
        assert process.stdout is not None
        caller = Caller(process.stdout.readline().strip())
        with caller.connect(b"GET /api/library HTTP/1.1\r\n", caller.own, b"\r\n"):
            assert caller.get("/api/captures")["all"] > 5
            process.send_signal(signal.SIGINT)
            said = process.communicate(timeout=20)[1]
    assert process.returncode == 130
    assert said == "lanindex: interrupted\n"


def test_a_port_that_is_taken_is_said(own: Path, caller: Caller) -> None:
    command = [sys.executable, "-m", "lanindex", "serve", str(own), "--port", str(caller.port)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 2
    assert "Address already in use" in done.stderr
    assert "--port 0" in done.stderr


@pytest.mark.parametrize("how", ["gone", "replaced", "no library"])
def test_a_library_that_goes_away_is_told_in_a_sentence(own: Path, how: str) -> None:
    with called(own) as caller:
        assert caller.get("/api/library")["captures"] > 5
        if how == "gone":
            own.unlink()
        elif how == "replaced":
            os.replace(shutil.copy(own, own.with_name("other.db")), own)
        else:
            own.write_bytes(b"no library at all" * 100_000)
        asked: list[tuple[str, str, Any]] = [
            ("GET", "/api/library", None),
            ("GET", "/api/captures/1", None),
            ("PATCH", "/api/captures", {"changes": [{"captures": [1], "label": "x"}]}),
            ("POST", "/api/searches", {"pattern": "arms high"}),
        ]
        for method, path, body in asked:
            status, content = caller.ask(method, path, body)
            assert status == 409, content
            assert "server failed" not in json.loads(content)["error"]["found"]
        assert caller.ask("GET", "/")[0] == 200


def test_a_capture_that_is_removed_or_whose_file_is_gone_is_told(own: Path) -> None:
    with called(own) as caller:
        source = own.with_name("away.bvh")
        corpus = Path(__file__).parents[2] / "corpus"
        shutil.copy(corpus / "compass.bvh", source)
        with lanindex.open_library(own) as library:
            library.ingest(source)
            number = library.capture(str(source)).id
        assert caller.get(f"/api/captures/{number}/figure")["frames"]
        source.write_bytes(b"something else")
        for path in ("figure", "motion/0", "pose"):
            status, content = caller.ask("GET", f"/api/captures/{number}/{path}")
            assert 400 <= status < 500, (path, content)
        source.unlink()
        for path in ("figure", "motion/0", "pose"):
            status, content = caller.ask("GET", f"/api/captures/{number}/{path}")
            assert 400 <= status < 500, (path, content)
        assert caller.ask("GET", f"/api/captures/{number}/staff")[0] == 200
        with lanindex.open_library(own) as library:
            library.remove(number)
        for path in ("", "/staff", "/figure", "/pose"):
            assert caller.ask("GET", f"/api/captures/{number}{path}")[0] == 404


@pytest.mark.slow
def test_a_server_that_is_killed_during_an_ingest_leaves_a_whole_library(
    own: Path, tmp_path: Path
) -> None:
    corpus = Path(__file__).parents[2] / "corpus"
    command = [sys.executable, "-m", "lanindex", "serve", str(own), "--port", "0", "--no-open"]
    with subprocess.Popen(command, stdout=-1, text=True, cwd=own.parent) as process:
        assert process.stdout is not None
        caller = Caller(process.stdout.readline().strip())
        before = caller.get("/api/library")["captures"]
        files = {}
        for number, path in enumerate(sorted(corpus.glob("*.bvh")) * 5):
            name = f"{number} {path.name}"
            status, content = caller.ask(
                "PUT", f"/api/uploads/{number}%20{path.name}", path.read_bytes()
            )
            assert status == 200
            files[name] = json.loads(content)["name"]
        caller.job("/api/ingests", {"files": files})
        half = caller.connect(
            b"PUT /api/uploads/x.bvh HTTP/1.1\r\nContent-Length: 9\r\n", caller.own, b"\r\nx"
        )
        _until(lambda: caller.get("/api/library")["captures"] > before, 60)
        process.kill()
        half.close()
    with called(own) as caller:
        found = caller.get("/api/captures?n=200")["captures"]
        assert before < len(found) < before + len(files)
        for capture in found:
            assert caller.ask("GET", f"/api/captures/{capture['capture_id']}/staff")[0] == 200
    done = subprocess.run(
        [sys.executable, "-m", "lanindex", "db", "check", "--db", str(own)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr


SCRIPT = '<img src=x onerror="document.title=1"><script>document.title=1</script>'


@pytest.mark.slow
def test_scripts_in_labels_names_and_patterns_are_text(
    own: Path, own_page: Callable[..., Page]
) -> None:
    with lanindex.open_library(own) as library:
        odd = own.with_name("<img src=x onerror=document.title=1>.lnd")
        shutil.copy(next(iter((Path(__file__).parents[2] / "corpus").glob("*.lnd"))), odd)
        library.ingest(odd)
        number = library.capture(str(odd)).id
        for capture in library.captures():
            library.label(capture.id, SCRIPT, {"evil": SCRIPT})
    page = own_page(own, "/")
    site = page.url.rpartition("/")[0]
    for address in ("/", f"/captures/{number}", "/search?q=arms%20high"):
        page.goto(site + address)
        page.get_by_text("onerror").first.wait_for(state="attached")
        assert page.locator("img[src=x]").count() == 0
        assert page.title() != "1"
