"""Where the benchmarks find the real captures, and what stands beside the tests."""

import os
import sys
from importlib import import_module
from pathlib import Path

HERE = Path(__file__).resolve().parent
CAPTURES = Path(os.environ.get("LANINDEX_CAPTURES") or HERE.parents[2] / "shared" / "captures")

sys.path.insert(0, str(HERE.parent))
changed = import_module("motions")
