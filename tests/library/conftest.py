"""Libraries in SQLite and in PostgreSQL; folders and users for those that may not be written."""

import codecs
import os
import tempfile
from contextlib import contextmanager
from pathlib import Path
from uuid import uuid4

import pytest

from lanindex.library import connect


def pytest_generate_tests(metafunc):
    """Run each test of libraries in SQLite and in PostgreSQL, but for those marked ``sqlite``."""
    if "database" in metafunc.fixturenames:
        only = metafunc.definition.get_closest_marker("sqlite")
        metafunc.parametrize("database", ["sqlite", *["postgres"] * (only is None)], indirect=True)


@pytest.fixture(autouse=True)
def database(request, monkeypatch):
    """Keep libraries in files, or each of them in a schema of a server."""
    if request.param == "sqlite":
        yield request.param
        return
    running, names = request.getfixturevalue("server"), {}

    def in_schema(text):
        path = f"{text} {len(names)}" if text == connect.MEMORY else os.path.abspath(text)
        if path not in names:
            names[path] = f"l{uuid4().hex}"
            with running.connect(autocommit=True) as connection:
                connection.execute(f"CREATE SCHEMA {names[path]}")
        return connect.Target(text, running.url(names[path]), None)

    monkeypatch.setattr(connect, "in_file", in_schema)
    yield request.param
    with running.connect(autocommit=True) as connection:
        for name in names.values():
            connection.execute(f"DROP SCHEMA {name} CASCADE")


@contextmanager
def without_rights():
    """Give up the rights of root, to which every file is open, for a while."""
    if os.geteuid() != 0:
        yield
        return
    os.seteuid(65534)
    try:
        yield
    finally:
        os.seteuid(0)


@pytest.fixture
def common_user():
    """Return a context in which files have the rights that they say."""
    codecs.lookup("utf-32-le")  # Python imports it on first use, from a folder that may be root's
    return without_rights


@pytest.fixture
def folder():
    """Return a folder that every user can reach."""
    with tempfile.TemporaryDirectory() as name:
        os.chmod(name, 0o777)
        yield Path(name)
        os.chmod(name, 0o777)
