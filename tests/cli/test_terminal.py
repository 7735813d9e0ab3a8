"""How commands behave at a terminal: pipes that close, narrow encodings, Ctrl-C, bare calls."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

SLOOP = [sys.executable, "-c", "from sloop_ppl.cli import main; main()"]


def test_a_reader_that_leaves_is_no_crash():
    command = subprocess.Popen(
        [*SLOOP, "map", "show", "cleveland"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    command.stdout.close()
    err = command.stderr.read()
    command.stderr.close()
    assert command.wait() == 0
    assert err == b""


@pytest.mark.slow
def test_a_terminal_without_curly_quotes_shows_question_marks():
    done = subprocess.run(
        [*SLOOP, "parse", "the red bike is near Ivy", "--map", "cleveland"],
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
        capture_output=True,
    )
    assert done.returncode == 0, done.stderr
    assert b"?Ivy?" in done.stdout


@pytest.mark.parametrize("arguments", [[], ["map"]])
def test_a_bare_call_shows_help(arguments):
    done = subprocess.run([*SLOOP, *arguments], capture_output=True, text=True)
    assert done.returncode == 0
    assert "Usage: sloop" in done.stdout
    assert done.stderr == ""


@pytest.mark.slow
def test_ctrl_c_ends_with_130_and_one_line():
    command = subprocess.Popen(
        [*SLOOP, "search", "the red bike is near Ivy", "--map", "cleveland", "--sims", "20000",
         "--place", "RedBike=90,-90", "--start", "-90,90"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    first = command.stderr.readline()  # the search is under way
    assert "at (" in first
    time.sleep(0.1)
    command.send_signal(signal.SIGINT)
    _, err = command.communicate()
    assert command.returncode == 130
    assert err.endswith("sloop: stopped\n")
    assert "Traceback" not in err
