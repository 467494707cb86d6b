"""Looking into a library imports neither SQLAlchemy nor Alembic: they take longer than the look."""

import subprocess
import sys

from sample import fill

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
    command = [sys.executable, "-c", LOOK, str(tmp_path / "some.db")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("[]\n", "")
