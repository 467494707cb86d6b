"""Who is let in: by host, origin, token and method."""

import pytest
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route
from starlette.testclient import TestClient

from lanindex.web.guard import Guard

HOST = "127.0.0.1:8421"
TOKEN = "right-token"
COOKIE = {"lanindex-8421": TOKEN}


async def answer(request: Request) -> Response:
    return PlainTextResponse("inside")


def client(host: str = "127.0.0.1", cookies: dict[str, str] | None = None) -> TestClient:
    guard = Middleware(Guard, token=TOKEN, host=host, port=8421)
    routes = [Route(path, answer, methods=["GET", "POST"]) for path in ("/", "/search", "/api/it")]
    app = Starlette(routes=routes, middleware=[guard])
    own = TestClient(app, base_url=f"http://{HOST}", follow_redirects=False)
    own.cookies.update(cookies or {})
    return own


def test_the_page_needs_no_token_and_what_it_shows_does() -> None:
    assert client().get("/").text == "inside"
    refused = client().get("/api/it")
    assert refused.status_code == 401
    assert "lanindex serve" in refused.json()["error"]["remedy"]
    assert client(cookies=COOKIE).get("/api/it").text == "inside"
    assert client(cookies={"lanindex-8421": "wrong"}).get("/api/it").status_code == 401
    assert client(cookies={"lanindex-8422": TOKEN}).get("/api/it").status_code == 401


def test_the_link_sets_a_cookie_that_no_script_reads_and_no_site_sends() -> None:
    answer = client().get(f"/search?q=r_arm&token={TOKEN}&hit=3")
    assert answer.status_code == 303
    assert answer.headers["location"] == "/search?q=r_arm&hit=3"
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    assert client().get("/?token=wrong").status_code == 403


def test_an_address_of_two_slashes_leads_to_no_other_host() -> None:
    away = client().get(f"http://{HOST}//evil.example/?token={TOKEN}")
    assert away.status_code == 303
    assert away.headers["location"].startswith("/evil.example")


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:8421", "127.0.0.1", "127.0.0.1:80", "[::1]:80", ""]
)
def test_foreign_hosts_are_refused(host: str) -> None:
    for path in ("/", "/api/it"):
        answer = client(cookies=COOKIE).get(path, headers={"host": host})
        assert answer.status_code == 421


def test_any_address_of_the_machine_will_do_where_it_listens_on_all() -> None:
    bearer = {"authorization": f"Bearer {TOKEN}"}
    for host, status in (("192.168.1.7:8421", 200), ("evil.example:8421", 421)):
        answer = client("0.0.0.0").get("/api/it", headers={"host": host, **bearer})
        assert answer.status_code == status


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_other_sites_may_link_to_the_page_and_do_nothing_else(site: str) -> None:
    inside = client(cookies=COOKIE)
    navigation = {"sec-fetch-site": site, "sec-fetch-mode": "navigate"}
    assert inside.get("/search", headers=navigation).status_code == 200
    assert inside.get("/api/it", headers=navigation).status_code == 403
    assert inside.get("/search", headers={"sec-fetch-site": site}).status_code == 403
    assert inside.post("/search", headers=navigation).status_code == 403
    assert inside.post("/api/it", headers={"sec-fetch-site": site}).status_code == 403


def test_a_change_must_say_where_it_comes_from() -> None:
    inside = client(cookies=COOKIE)
    assert inside.post("/api/it", headers={"origin": f"http://{HOST}"}).status_code == 200
    assert inside.post("/api/it", headers={"sec-fetch-site": "same-origin"}).status_code == 200
    for origin in ("http://evil.example", "null", "http://127.0.0.1:8422"):
        assert inside.post("/api/it", headers={"origin": origin}).status_code == 403
    assert inside.post("/api/it").status_code == 401
    assert client().post("/api/it", headers={"authorization": f"Bearer {TOKEN}"}).is_success


def test_every_answer_has_the_headers_that_keep_scripts_out() -> None:
    for path in ("/", "/api/it", "/?token=wrong"):
        answer = client().get(path)
        policy = answer.headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert "require-trusted-types-for 'script'" in policy
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert answer.headers["cache-control"] == "no-store"
