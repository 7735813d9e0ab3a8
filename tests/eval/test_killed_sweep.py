"""Nothing that was done is lost when workers and drivers are killed."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from support.small_sweeps import write_lines

from sloop_ppl.errors import OutputError
from sloop_ppl.eval import _driver_watch
from sloop_ppl.eval._driver_watch import wait_for_workers

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


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="there is no SIGKILL here")
@pytest.mark.parametrize("stop", [signal.SIGKILL, signal.SIGTERM])
def test_workers_end_with_their_driver_and_hold_its_folder_until_then(tmp_path, stop):
    write_lines(tmp_path / "said.jsonl")
    asked = [
        sys.executable, "-c", "from sloop_ppl.cli import main; main()", "eval", "search",
        str(tmp_path / "said.jsonl"), "--out", str(tmp_path / "run"), "--workers", "2",
        "--models", "uniform,sloop", "--starts", "40", "--sims", "2000",
    ]  # fmt: skip
    driver = subprocess.Popen(asked, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    end = time.monotonic() + 120
    while not list(tmp_path.glob("run/parts/*.jsonl")):
        assert driver.poll() is None, driver.stderr.read()
        assert time.monotonic() < end
        time.sleep(0.05)
    workers = psutil.Process(driver.pid).children(recursive=True)
    assert workers
    driver.send_signal(stop)
    driver.wait(20)
    driver.stderr.close()
    assert driver.returncode == (143 if stop == signal.SIGTERM else -stop)
    wait_for_workers(tmp_path / "run")  # as the next driver does
    before = {part: part.read_bytes() for part in tmp_path.glob("run/parts/*.jsonl")}
    _, alive = psutil.wait_procs(workers, timeout=5)
    assert not alive
    assert {part: part.read_bytes() for part in before} == before  # none wrote on


def test_a_driver_waits_for_the_workers_of_another_and_then_says_so(tmp_path, monkeypatch):
    fcntl = pytest.importorskip("fcntl")
    monkeypatch.setattr(_driver_watch, "_PATIENCE_S", 0.3)
    wait_for_workers(tmp_path)
    with (tmp_path / ".workers.lock").open("a") as lock:
        fcntl.flock(lock, fcntl.LOCK_SH)
        with pytest.raises(OutputError, match="still write to"):
            wait_for_workers(tmp_path)
    wait_for_workers(tmp_path)


@pytest.mark.skipif(os.name == "nt", reason="workers are not watched there")
def test_a_process_ends_once_its_driver_is_gone():
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    code = (
        "import socket, time\n"
        "from sloop_ppl.eval._driver_watch import Driver, end_with\n"
        f"end_with(Driver({gone.pid}, socket.gethostname()))\n"
        "time.sleep(60)"
    )
    asked = [sys.executable, "-c", code]
    worker = subprocess.run(asked, capture_output=True, timeout=50, check=False)
    assert (worker.returncode, worker.stderr) == (1, b"")
