"""Lines are added whole, by many at a time, and survive what a crash leaves."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from sloop_ppl._journal import Journal
from sloop_ppl.errors import InputError

WRITE = """
import sys
from pathlib import Path
from sloop_ppl._journal import Journal
journal = Journal(Path(sys.argv[1]))
for i in range(60):
    journal.append({"by": sys.argv[2], "i": i, "text": "x" * 500})
"""


def test_processes_write_one_after_the_other(tmp_path):
    path = tmp_path / "folder" / "kept.jsonl"
    writers = [subprocess.Popen([sys.executable, "-c", WRITE, str(path), str(n)]) for n in range(3)]
    assert [writer.wait() for writer in writers] == [0, 0, 0]
    found = Journal(path).records()
    for n in range(3):
        assert [r["i"] for r in found if r["by"] == str(n)] == list(range(60))


@pytest.mark.parametrize("rest", ['{"half": "a li', "x" * 10_000, "é"[:1]])
def test_half_a_line_is_no_line_and_does_not_spoil_the_next(tmp_path, rest):
    path = tmp_path / "kept.jsonl"
    journal = Journal(path)
    journal.append({"n": 1, "name": "ü“"})
    with path.open("ab") as file:
        file.write(rest.encode())
    assert journal.records() == [{"n": 1, "name": "ü“"}]
    journal.append({"n": 2})
    assert [r["n"] for r in journal.records()] == [1, 2]
    assert [json.loads(line)["n"] for line in path.read_text().splitlines()] == [1, 2]


def test_no_file_has_no_lines_and_a_bad_line_is_named(tmp_path):
    path = tmp_path / "kept.jsonl"
    assert Journal(path).records() == []
    path.write_text('{"n": 1}\n[2]\n')
    with pytest.raises(InputError, match=r"kept.jsonl:2: is no JSON object"):
        Journal(path).records()
