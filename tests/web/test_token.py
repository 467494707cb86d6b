"""The token that lets in: where it must not be seen."""

import signal
import stat
import subprocess
from collections.abc import Iterator
from http.client import HTTPConnection
from pathlib import Path
from typing import TYPE_CHECKING

import command
import pytest
from playwright.sync_api import expect

from lanindex.app.commands.serve import _page_to

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page


@pytest.fixture
def page(browser: "Browser") -> Iterator["Page"]:
    """Return a page of a browser that has not been let in."""
    context = browser.new_context()
    yield context.new_page()
    context.close()


def test_a_browser_is_given_a_page_that_only_its_user_can_read(
    corpus_library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = list[tuple[str, str, int]]()

    def opened(address: str) -> None:
        page = Path(address.removeprefix("file://"))
        found.append((address, page.read_text(), stat.S_IMODE(page.stat().st_mode)))

    monkeypatch.setattr("webbrowser.open", opened)
    monkeypatch.setattr("lanindex.web.process.Server.run", lambda _, sockets: sockets[0].close())
    link = command.shown("serve", corpus_library, "--port", "0", "--read-only").strip()
    ((address, text, mode),) = found
    token = link.partition("token=")[2]
    assert len(token) == 32
    assert token not in address
    assert f'url={link}"' in text
    assert mode == 0o600
    assert not Path(address.removeprefix("file://")).exists()


def test_that_page_leads_into_the_library(link: str, page: "Page", tmp_path: Path) -> None:
    page.goto(_page_to(link, str(tmp_path)))
    page.get_by_role("link", name="compass.bvh").wait_for()


def test_the_page_does_not_hold_the_token_or_hand_it_on(link: str, page: "Page") -> None:
    token = link.partition("token=")[2]
    asked = []
    page.on("request", lambda it: asked.append(it))
    page.goto(link)
    page.get_by_role("link", name="compass.bvh").wait_for()
    page.get_by_role("link", name="compass.bvh").click()
    expect(page.locator(".staff-layer svg").first).to_be_visible()
    held = "JSON.stringify([document.cookie, localStorage, sessionStorage, history.state])"
    assert token not in page.url + page.content() + page.evaluate(held)
    assert [it.url for it in asked if token in it.url] == [link]
    assert not any(it.all_headers().get("referer") for it in asked)


def test_the_token_is_printed_once_and_never_logged(corpus_library: Path) -> None:
    words = ["serve", str(corpus_library), "--port", "0", "--read-only", "--no-open"]
    started = [*command.COMMAND, *words]
    with subprocess.Popen(started, stdout=-1, stderr=subprocess.STDOUT, text=True) as process:
        assert process.stdout is not None
        link = process.stdout.readline().strip()
        site, _, token = link.partition("/?token=")
        for path, status in (("/", 303), ("/api/library", 401), ("/static/x", 303)):
            connection = HTTPConnection(site.partition("//")[2])
            connection.request("GET", f"{path}?token={token}")
            answer = connection.getresponse()
            assert answer.status == status
            assert token.encode() not in answer.read()
            connection.close()
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=20)[0]
    assert said == "lanindex: interrupted\n"
