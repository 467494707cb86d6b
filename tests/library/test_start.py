"""What takes longer to import than the work is not imported: SQLAlchemy for a look, a search for
a process of an ingest.
"""

import subprocess
import sys

import pytest
from sample_library import fill, name_of

LOOK = """
import sys
from lanindex.library.store import Store
with Store.open(sys.argv[1], readonly=True) as library:
    assert len(list(library.tracks(parts=["head"]))) == 2
    library.captures(), library.parts(), library.known(), library.score(1), library.stats()
print([name for name in ("sqlalchemy", "alembic", "numba", "scipy") if name in sys.modules])
"""


def test_a_look_imports_little(tmp_path):
    fill(tmp_path / "some.db", 2)
    command = [sys.executable, "-c", LOOK, name_of(tmp_path / "some.db")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("[]\n", "")


INGEST = """
import sys
from lanindex.pipeline import prepare
print([name for name in sys.modules if name.startswith(("lanindex.search", "sqlalchemy", "numba"))])
"""


@pytest.mark.sqlite  # about no library
def test_a_process_of_an_ingest_imports_little():
    done = subprocess.run([sys.executable, "-c", INGEST], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("[]\n", "")
