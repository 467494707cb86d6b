"""A browser, and the tools that check and bundle the page's scripts."""

from __future__ import annotations

import fcntl
import hashlib
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import pytest
from figure_page import Walker, served
from page_client import asking, serving
from starlette.testclient import TestClient

import lanindex

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page
    from postgres_server import Server

HERE = Path(__file__).parent
WAIT = 240  # seconds for the registry of npm, at most
PATIENCE = 60_000  # milliseconds that a page may take for anything, on a machine that does more
ARGUMENTS = (
    "--headless",
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-gpu",
    "--enable-unsafe-swiftshader",  # WebGL without a graphics card
)


def missing(what: str) -> NoReturn:
    """Skip what this machine cannot try; CI must try all."""
    if os.environ.get("CI") == "true":
        pytest.fail(f"{what}: CI must not skip the tests of the page")
    pytest.skip(what)


@pytest.fixture(scope="session")
def static() -> Path:
    """Return the folder of what the page is made of."""
    return HERE.parent.parent / "lanindex" / "web" / "static"


@pytest.fixture(scope="session")
def node_modules() -> Path:
    """Return a folder with the packages of package.json, which all test processes share."""
    npm = shutil.which("npm")
    if npm is None:
        missing("npm is not installed")
    wanted = (HERE / "package.json").read_bytes()
    name = f"lanindex-npm-{os.getuid()}-{hashlib.sha256(wanted).hexdigest()[:16]}"
    folder = Path(tempfile.gettempdir()) / name
    folder.mkdir(mode=0o700, exist_ok=True)
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "installed").exists():
            (folder / "package.json").write_bytes(wanted)
            command = [npm, "install", "--no-audit", "--no-fund", "--ignore-scripts"]
            try:
                done = subprocess.run(
                    command, cwd=folder, capture_output=True, text=True, check=False, timeout=WAIT
                )
            except subprocess.TimeoutExpired:
                missing(f"npm did not install its packages within {WAIT} s")
            if done.returncode:
                missing(f"npm installs nothing: {done.stderr.strip()[-400:]}")
            (folder / "installed").touch()
    return folder / "node_modules"


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Return a Chromium without a window, for all tests of a process."""
    path = shutil.which("chromium")
    if path is None:
        missing("Chromium is not installed: apt-get install chromium")
    try:
        from playwright.sync_api import expect, sync_playwright
    except ImportError as error:
        missing(f"{error}: pip install playwright")
    expect.set_options(timeout=PATIENCE)
    with sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=path, args=list(ARGUMENTS))
        yield found
        found.close()


@pytest.fixture(scope="session")
def corpus_library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a library of the corpus; tests that change it take a copy."""
    path = tmp_path_factory.mktemp("library") / "dances.db"
    corpus = HERE.parent.parent / "corpus"
    with lanindex.open_library(path, create=True) as library:
        library.ingest(corpus, labels=corpus / "labels.csv")
    return path


@pytest.fixture(scope="session")
def library(corpus_library: Path) -> Iterator[lanindex.Library]:
    """Return the corpus's library, opened to be read; some modules have another one."""
    with lanindex.open_library(corpus_library, readonly=True) as opened:
        yield opened


@pytest.fixture(scope="session")
def corpus_database(server: Server) -> str:
    """Return the name of a database with a library of the corpus, of which others are copies."""
    with server.connect(autocommit=True) as link:
        link.execute("CREATE DATABASE dances")
    corpus = HERE.parent.parent / "corpus"
    with lanindex.open_library(server.address("dances"), create=True) as library:
        library.ingest(corpus, labels=corpus / "labels.csv")
    return "dances"


@pytest.fixture
def new_address(server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Return the URL of a database that is empty."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    with server.connect(autocommit=True) as link:
        link.execute("CREATE DATABASE new")
        yield server.address("new")
        link.execute("DROP DATABASE new WITH (FORCE)")


@pytest.fixture
def own_address(
    server: Server, corpus_database: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[str]:
    """Return the URL of a copy of that library, which a test may change."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    with server.connect(autocommit=True) as link:
        link.execute(f"CREATE DATABASE own TEMPLATE {corpus_database}")
        yield server.address("own")
        link.execute("DROP DATABASE own WITH (FORCE)")


@pytest.fixture
def own_library(corpus_library: Path, tmp_path: Path) -> Iterator[lanindex.Library]:
    """Return a copy of the corpus's library, which a test may change."""
    own = shutil.copy(corpus_library, tmp_path / "own.db")
    with lanindex.open_library(own) as opened:
        yield opened


@pytest.fixture
def ask(library: lanindex.Library) -> Iterator[TestClient]:
    """Return a caller of the library's page, without a browser."""
    with asking(library) as client:
        yield client


@pytest.fixture(scope="session")
def link(corpus_library: Path) -> Iterator[str]:
    """Return the link of a server of the corpus, which no test changes."""
    with serving(corpus_library) as link:
        yield link


@pytest.fixture
def opened(browser: Browser, link: str) -> Iterator[Callable[..., Page]]:
    """Return what opens an address of the corpus's page in a browser that has been let in.

    The test fails if the page reports an error, or breaks its own policy.
    """
    with pages(browser) as open_page:

        def opened(address: str = "/", **options: object) -> Page:
            return open_page(link, address, **options)

        yield opened


@pytest.fixture
def own_page(browser: Browser) -> Iterator[Callable[..., Page]]:
    """Return what serves a library of the test's own and opens an address of its page."""
    with ExitStack() as servers, pages(browser) as open_page:

        def open_own(library: Path | str, address: str = "/", *options: str, **how: object) -> Page:
            return open_page(servers.enter_context(serving(library, *options)), address, **how)

        yield open_own


@pytest.fixture
def tabbed() -> Callable[[Page, str], None]:
    """Return what goes by Tab to what is called something, on or back."""

    def go(page: Page, name: str, key: str = "Tab") -> None:
        called = "() => { const it = document.activeElement;"
        called += " return it.ariaLabel || it.textContent || it.value; }"
        for _ in range(120):
            page.keyboard.press(key)
            if (page.evaluate(called) or "").strip().startswith(name):
                return
        raise AssertionError(f"{key} does not come to {name}")

    return go


@contextmanager
def pages(browser: Browser) -> Iterator[Callable[..., Page]]:
    """Yield what opens a link, then an address of its server, in a browser of its own."""
    contexts, said = [], list[str]()

    def opened(link: str, address: str = "", **options: object) -> Page:
        context = browser.new_context(**options)  # type: ignore[arg-type]
        context.set_default_timeout(PATIENCE)
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("console", lambda it: said.append(it.text) if it.type == "error" else None)
        page.goto(link)
        if address:
            page.goto(link.partition("/?")[0] + address)
        return page

    yield opened
    for context in contexts:
        context.close()
    assert said == []


@pytest.fixture(scope="session")
def walker() -> Walker:
    """Return a capture that walks."""
    return Walker(HERE.parent.parent / "corpus" / "marching.bvh")


@pytest.fixture(scope="session")
def address(static: Path, walker: Walker) -> Iterator[str]:
    """Return the address of a page with a figure and a staff alone."""
    with served(static, walker) as address:
        yield address


@pytest.fixture
def played(browser: Browser, address: str) -> Iterator[Callable[..., Page]]:
    """Return what opens that page, with a figure in space or flat."""
    with pages(browser) as open_page:

        def played(kind: str = "canvas", **options: object) -> Page:
            size = {"width": 900, "height": 640}
            page = open_page(f"{address}?figure={kind}", **{"viewport": size} | options)
            page.wait_for_selector("body[data-ready]")
            return page

        yield played


@pytest.fixture(scope="session")
def violations(node_modules: Path) -> Callable[[Page], list[str]]:
    """Return what tells by what a page shuts people out, by axe-core."""
    axe = (node_modules / "axe-core" / "axe.min.js").read_text()

    def found(page: Page) -> list[str]:
        page.evaluate(axe + "; undefined")
        told = page.evaluate("axe.run().then((it) => it.violations)")
        return [f"{it['id']}: {node['html']}" for it in told for node in it["nodes"]]

    return found
