"""Nothing that was done is lost when workers and drivers are killed."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="there is no SIGKILL here")
def test_ten_kills_change_nothing(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "tests.support.killed_sweep", str(tmp_path)],
        cwd=ROOT,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout.splitlines()[-1])
    assert told["status"] == 0, done.stderr
    assert len(told["kept"]) == 10
    assert told["kept"] == sorted(told["kept"])  # each kill found more done than the one before
    assert told["kept"][-1] < told["trials"] + 10
    assert told["same"]
