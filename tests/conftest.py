"""Make test runs alike: machine code apart for each process, and Ctrl-C as at a terminal.

numba saves what it compiles in two steps, between which another process may load what an older
version of the source left behind. A shell starts background jobs with Ctrl-C ignored, which the
commands that tests start would inherit.
"""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

_WORKER = os.environ.get("PYTEST_XDIST_WORKER")
if _WORKER is not None:
    _KEPT = Path(__file__).parent.parent / ".pytest_cache" / "numba" / _WORKER
    os.environ.setdefault("NUMBA_CACHE_DIR", str(_KEPT))

if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


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
