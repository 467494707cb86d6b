"""Folders and users for libraries that may not be written."""

import codecs
import os
import tempfile
from contextlib import contextmanager
from pathlib import Path

import pytest


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
