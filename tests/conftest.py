"""Keep the machine code of each process of a test run apart.

numba saves what it compiles in two steps, between which another process may load what an older
version of the source left behind.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

_WORKER = os.environ.get("PYTEST_XDIST_WORKER")
if _WORKER is not None:
    _KEPT = Path(__file__).parent.parent / ".pytest_cache" / "numba" / _WORKER
    os.environ.setdefault("NUMBA_CACHE_DIR", str(_KEPT))


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--fuzz-rounds",
        type=int,
        default=1,
        help="How many times as many damaged files tests/fuzz reads.",
    )
    parser.addoption(
        "--pictures",
        default=None,
        help="Folder into which tests/web puts the pictures of docs/workbench.md.",
    )
