"""A caller of a library's page, without a browser."""

from starlette.testclient import TestClient

import lanindex
from lanindex.web.server import Site, application

HOST, TOKEN = "127.0.0.1:8421", "token"


def asking(library: lanindex.Library, *, readonly: bool = False) -> TestClient:
    site = Site(library, readonly=readonly)
    app = application(site, token=TOKEN, host="127.0.0.1", port=8421)
    headers = {"authorization": f"Bearer {TOKEN}"}
    return TestClient(app, base_url=f"http://{HOST}", headers=headers)
