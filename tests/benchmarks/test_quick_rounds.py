"""Every benchmark runs a quick round and prints its figures, so that none rots unseen.

What is timed is not looked at: on little input, beside other tests, it means nothing.
"""

import os
import re
import subprocess
import sys

import pytest
from support.tree import ROOT

BENCHMARKS = ROOT / "benchmarks"
SLOW = {
    "bench_scale.py",
    "bench_search.py",
    "peers.py",
    "bench_start.py",
    "bench_sweep.py",
    "bench_web.py",
}  # they start processes, and may have to compile
FIGURES = {
    "bench_asking.py": (
        "candidates at 41 x 41, CPU: first",
        "candidates at 401 x 401, CPU: first",
        "a decision of fast that weighs questions, CPU:",
        "targets, answerer a: log score",
        "gain of each question",
    ),
    "bench_frames.py": ("one of cleveland", "the first of cleveland", "10 of 5 bundled maps"),
    "bench_inference.py": (
        "exact, 41 x 41, 3 frame relations",
        "exact / bare torch",
        "total variation between exact and bare torch",
        "20 descriptions in one batch, each",
        "descriptions one at a time, each",
        "exact, 401 x 401",
        "memory of exact, 401 x 401",
        "first description of these grounds",
        "| enumerate |",
        "importance, 1000 draws",
    ),
    "bench_language.py": (
        "bundled: tuple",
        "bundled, merged maps: tuple",
        "bundled, 15 % misspelt: tuple",
        "hard set, dev: tuple",
        "hard set, scored: tuple",
        "descriptions/s warm,",
        "words in",
    ),
    "bench_maps.py": (
        "load a bundled map, the slowest",
        "load a bundled map, the first in a process",
        "all fields of 100 landmarks",
        "all fields of the 61 landmarks of cleveland",
        "500 landmarks:",
        "import 80 m of a block: 6 landmarks",
        "import all of block.osm: 6 landmarks",
        "frontage of 4 buildings",
        "find a misspelt name",
        "a window of 200 m",
    ),
    "bench_scale.py": (
        "set-up of fast",
        "first plan of fast",
        "search to the first step",
        "peak memory of planner",
        "exact, 481 x 481, 3 frame relations",
        "coarse to fine, 481 x 481, a corner of two streets",
        "county of",
        "peak memory of county",
        "texts, reading included, 1 workers",
        "texts, reading included, 2 workers",
    ),
    "bench_search.py": (
        "bundled",
        "pouct / bundled",
        "fast / bundled",
        "fast / pouct",
        "belief update, 401 x 401",
        "simulations, published",
        "simulations, informed",
        "first plan of fast",
        "first plan of informed",
        "peak memory of fast",
        "peak memory of informed",
        "peak memory of this process",
    ),
    "bench_start.py": (
        "sloop list",
        "sloop parse",
        "sloop infer  ",
        "sloop infer --figure",
        "import sloop_ppl; parse; infer",
        "later answers with report",
    ),
    "bench_sweep.py": (
        "whole sweep, 2 workers",
        "a trial",
        "1 workers",
        "2 workers",
        "two workers / one",
    ),
    "double_counting.py": (
        "| sloop-m4 | none |",
        "| sloop-m4 | temper .5 |",
        "| sloop-m4 | error_m 10 |",
        "| student-vonmises product | none |",
        "| student-vonmises product | temper .5 |",
        "| student-vonmises product | error_m 10 |",
    ),
    "peers.py": (
        "simulations, pomdp-py on its bundled domain",
        "simulations, NativePouct of sloop_ppl",
        "Tiger, depth 30, POUCT of pomdp-py",
        "Tiger, depth 30, NativePouct of sloop_ppl",
        "three fronts, 41 x 41, exact of sloop_ppl",
        "import of block.osm, import_osm of sloop_ppl",
    ),
    "search_quality.py": (
        "| greedy |",
        "| random |",
        "| pouct:10 |",
        "| fast:10:published |",
        "| fast:10 |",
    ),
    "bench_web.py": (
        "typed to drawn",
        "2 users at once",
        "memory of the server's processes",
    ),
}
"""What a benchmark prints a figure behind; one that is not listed need only print some figure."""

SCRIPTS = sorted(path.name for path in BENCHMARKS.glob("*.py"))


def quick_round(path, cwd):
    """Run a benchmark's quick round in another folder; return what it prints."""
    assert '"--quick"' in path.read_text(encoding="utf-8"), (
        f"{path.name} has no quick round, so nothing tells when it stops working; give it an "
        "option --quick that runs every part on tiny inputs in seconds, without network or other "
        "files"
    )
    paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    done = subprocess.run(
        [sys.executable, path, "--quick"],
        cwd=cwd, env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
        capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, f"{path.name} --quick fails: {done.stderr}"
    wrong = [line for line in done.stdout.splitlines() if re.search(r"\b(nan|inf)\b", line, re.I)]
    assert not wrong, f"{path.name} --quick prints what is no number: {wrong}"
    return done.stdout


def has_figure(what, printed):
    """Tell whether some line has a number behind these words."""
    return re.search(rf"^.*{re.escape(what)}.*\d", printed, re.MULTILINE) is not None


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] if name in SLOW else []) for name in SCRIPTS],
)
def test_a_quick_round_prints_every_figure(name, tmp_path):
    printed = quick_round(BENCHMARKS / name, tmp_path)
    missing = [what for what in FIGURES.get(name, ("",)) if not has_figure(what, printed)]
    assert not missing, f"{name} --quick prints no figure for {missing}: {printed}"
    assert list(tmp_path.iterdir()) == []  # and leaves nothing behind


def test_every_benchmark_that_is_looked_for_is_there():
    assert set(FIGURES) | SLOW <= set(SCRIPTS)


@pytest.mark.parametrize(
    ("code", "told"),
    [
        ("print(1.5)", "new.py has no quick round.*give it an option --quick"),
        ('assert "--quick" == 1', "new.py --quick fails: Traceback"),
        ('"--quick"; print("ratio: nan")', "new.py --quick prints what is no number: .*ratio: nan"),
    ],
)
def test_a_benchmark_that_rots_is_told_of(code, told, tmp_path):
    path = tmp_path / "new.py"
    path.write_text(code, encoding="utf-8")
    with pytest.raises(AssertionError, match=told):
        quick_round(path, tmp_path)
