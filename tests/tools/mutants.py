"""Change the code in one place, run its tests, and see whether they notice.

Run it with ``make mutants``; it needs the extra ``mutants``. The places are drawn with a seed, the
changes are those of cosmic-ray. The work is done on a copy of the tree, and every verdict is kept
at once: a run that was stopped goes on where it was.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import difflib
import hashlib
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import parso
from cosmic_ray.ast import ast_nodes
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Group:
    """Modules and the tests that should notice a change in them, the quickest first."""

    sources: tuple[str, ...]
    tests: tuple[str, ...]
    left_out: str = ""


GROUPS = {
    "grid": Group(
        ("sloop_ppl/maps/grid.py",),
        ("tests/maps/test_grid.py", "tests/maps/test_rasterise.py", "tests/maps/test_city.py"),
    ),
    "likelihoods": Group(
        ("models/likelihoods/*.py", "models/_reference_regions.py"),
        (
            "tests/models/test_distance.py",
            "tests/models/test_reference_regions.py",
            "tests/models/test_cosine.py",
            "tests/models/test_kernels.py",
            "tests/parity",
            "tests/models/test_marginal.py",
            "tests/models/test_learned_frames.py",
            "tests/protocols/test_likelihoods.py",
        ),
        left_out="quadrature and neural",  # half a second each, of a sum that no formula stands for
    ),
    "program": Group(
        ("models/program.py",),
        (
            "tests/parity",
            "tests/models/test_program.py",
            "tests/models/test_denial.py",
            "tests/models/test_speaker.py",
            "tests/models/test_latents.py",
            "tests/inference/test_shared_frames.py",
            "tests/models/test_pyro_tools.py",
            "tests/inference/test_exact.py",
            "tests/inference/test_engines.py",
        ),
    ),
    "belief update": Group(
        ("sloop_ppl/planning/belief.py", "sloop_ppl/planning/sensors.py"),
        (
            "tests/planning/test_belief.py",
            "tests/planning/test_sensing.py",
            "tests/planning/test_detection.py",
            "tests/planning/test_sharpening.py",
            "tests/planning/test_models.py",
            "tests/planning/test_obstacles.py",
            "tests/planning/test_own_sensors.py",
        ),
    ),
    "linking": Group(
        ("sloop_ppl/language/linking.py",),
        (
            "tests/language/test_linking.py",
            "tests/language/test_parse.py",
            "tests/language/test_pipeline.py",
            "tests/eval/test_parsing.py",
            "tests/language",
        ),
    ),
    "scores": Group(
        ("eval/_belief_scores.py", "eval/_breakdown.py", "eval/parsing.py"),
        (
            "tests/eval/test_regions.py",
            "tests/eval/test_breakdown.py",
            "tests/eval/test_parsing.py",
            "tests/eval/test_quality.py",
            "tests/packaging/test_frozen.py",
        ),
    ),
}

NAMED = (
    ("scores", "eval/_belief_scores.py", "NEAR_M = 15.0", "NEAR_M = 20.0"),
    (
        "linking",
        "sloop_ppl/language/linking.py",
        "best.coverage - fit.coverage < 0.02",
        "True",
    ),
    ("linking", "sloop_ppl/language/linking.py", "fit.first, fit.landmark\n", "fit.first, 0\n"),
)
"""Changes that once went unnoticed, tried in every run."""

EXPLAINED = (
    ("strict=False", "only a fault of ours would give zip tables of other lengths"),
    ("_MOST_DIMS = ", "a limit on sites below torch's own; one more or less is as good"),
    ("_DEEP = ", "any depth does that keeps products above 1e-300"),
    (" + 1, 1))", "a larger window round the fan, whose cells are asked one by one"),
    ("whole <= len(order)", "a belief sums to one, which is above each level"),
    ("kappa < _NARROW_KAPPA", "either way of summing is right at the border of the two"),
    ("over(count, -0.5)", "half a step back round the circle, or on, is the same directions"),
    ("0, len(x) // 1)", "the neighbours of a cell are kept on the map once more below"),
    ("3 * math.pi / _PEAK_FRONTS", "the greatest g is over cells too, and stays the same"),
)
"""Changes that no test can notice, by a part of the changed line, and why."""

# They put one name for another at random, or mean the same wherever they are likely to stand.
_LEFT_OUT = ("VariableReplacer", "VariableInserter", "_Is_Eq", "_Eq_Is", "_NotEq_IsNot")


@dataclass(frozen=True)
class Mutant:
    """One change: the module as it would be, and where it differs."""

    group: str
    path: str
    line: int
    name: str
    code: str

    @property
    def key(self) -> str:
        """Return what it is known by, as long as the module and the change stay the same."""
        return hashlib.sha256(f"{self.path}\0{self.code}".encode()).hexdigest()[:16]

    def diff(self) -> str:
        """Return the lines that differ."""
        before = (ROOT / self.path).read_text().splitlines()
        lines = difflib.unified_diff(before, self.code.splitlines(), lineterm="", n=0)
        return "\n".join(line for line in lines if line[:3] not in ("---", "+++"))


def places(path: str) -> dict[tuple[Any, ...], list[tuple[str, int]]]:
    """Return where a module can be changed, and how: (start, end, kind) -> (operator, n-th)."""
    source = (ROOT / path).read_text()
    skipped = list(_unread(source))
    found: dict[tuple[Any, ...], list[tuple[str, int]]] = {}
    tree = parso.parse(source)
    for name in operator_names():
        if name.endswith(_LEFT_OUT):
            continue
        operator = get_operator(name)()
        positions = (p for node in ast_nodes(tree) for p in operator.mutation_positions(node))
        for n, (start, end) in enumerate(positions):
            if not any(low <= start < high for low, high in skipped):
                kind = name.split("/")[-1].split("_")[0]
                found.setdefault((start, end, kind), []).append((name, n))
    return found


def _unread(source: str) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    """Yield the spans of annotations, which are never evaluated."""
    for node in ast.walk(ast.parse(source)):
        for field in ("annotation", "returns"):
            part = getattr(node, field, None)
            if isinstance(part, ast.expr):
                yield (
                    (part.lineno, part.col_offset),
                    (part.end_lineno or 0, part.end_col_offset or 0),
                )


def draw(group: str, count: int, seed: int) -> list[Mutant]:
    """Return mutants of a group: places are drawn without repetition, at each one of its changes.

    Drawing changes at once would mean arithmetic for the most part, of which there are eleven to a
    sign and two to a number.
    """
    paths = sorted(
        str(path.relative_to(ROOT))
        for pattern in GROUPS[group].sources
        for path in ROOT.glob(pattern)
    )
    options = [(path, *item) for path in paths for item in sorted(places(path).items())]
    rng = random.Random(f"{seed} {group}")
    rng.shuffle(options)
    mutants = []
    for path, (start, _, _), changes in options[:count]:
        name, n = rng.choice(changes)
        code = mutate_code((ROOT / path).read_text(), get_operator(name)(), n)
        if code is not None:
            mutants.append(Mutant(group, path, start[0], name.split("/")[-1], code))
    return mutants


def named() -> list[Mutant]:
    """Return the mutants that are always tried."""
    mutants = []
    for group, path, old, new in NAMED:
        source = (ROOT / path).read_text()
        if source.count(old) != 1:
            raise SystemExit(f"{path} has {old!r} {source.count(old)} times; mend NAMED")
        line = source[: source.index(old)].count("\n") + 1
        mutants.append(Mutant(group, path, line, "named", source.replace(old, new)))
    return mutants


@contextlib.contextmanager
def copied_tree() -> Iterator[Path]:
    """Give a copy of the tree that may be changed; the package's rooms are linked into it."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT, check=True, capture_output=True, text=True,
    )  # fmt: skip
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        tree = Path(folder).resolve()
        for name in filter(None, listed.stdout.split("\0")):
            if (ROOT / name).is_file():
                (tree / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, tree / name)
        for room in ("models", "inference", "eval"):
            link = tree / "sloop_ppl" / room
            if not link.exists():
                link.symlink_to(tree / room, target_is_directory=True)
        yield tree


def run_tests(tree: Path, group: str, log: Path, limit_s: float) -> str:
    """Return "passed", "failed" or "timeout", of a group's tests in a forked process."""
    child = os.fork()
    if child == 0:
        code = 70
        try:
            os.setsid()
            with log.open("wb") as out:
                os.dup2(out.fileno(), 1)
                os.dup2(out.fileno(), 2)
            resource.setrlimit(resource.RLIMIT_AS, (24 << 30, 24 << 30))
            code = _in_child(tree, group)
        finally:
            os._exit(code)
    end = time.monotonic() + limit_s
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            _kill(child)
            return "passed" if os.waitstatus_to_exitcode(status) == 0 else "failed"
        time.sleep(0.05)
    _kill(child)
    os.waitpid(child, 0)
    return "timeout"


def _kill(leader: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(leader, signal.SIGKILL)


def _in_child(tree: Path, group: str) -> int:
    import pytest

    os.chdir(tree)
    os.environ["PYTHONPATH"] = os.pathsep.join([str(tree), *_python_path()])
    sys.dont_write_bytecode = True  # a module may change twice within the second of its stamp
    sys.path.insert(0, str(tree))
    import sloop_ppl

    if not Path(sloop_ppl.__file__).is_relative_to(tree):
        return 71
    options = ["-x", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-m", "not slow"]
    options += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]
    options.append("--hypothesis-seed=0")
    if GROUPS[group].left_out:
        options += ["-k", f"not ({GROUPS[group].left_out})"]
    return int(pytest.main([*options, *GROUPS[group].tests]))


def _python_path() -> list[str]:
    return [part for part in os.environ.get("PYTHONPATH", "").split(os.pathsep) if part]


def preload() -> None:
    """Import what takes long, so that each forked process has it."""
    import numba  # noqa: F401
    import pyro  # noqa: F401
    import pytest  # noqa: F401
    import scipy.stats  # noqa: F401
    import shapely  # noqa: F401
    import spacy  # noqa: F401
    import torch

    torch.set_num_threads(1)
    if "sloop_ppl" in sys.modules:
        raise SystemExit("sloop_ppl is loaded already, so that no change would be seen")


def main() -> None:
    """Draw, try and report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--count", type=int, default=300, help="mutants, the same of each group")
    parser.add_argument("--minutes", type=float, default=1e9, help="stop after that long")
    parser.add_argument("--again", action="store_true", help="try the survivors again")
    parser.add_argument("--report", action="store_true", help="only say what is known")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "mutants")
    given = parser.parse_args()

    per_group = -(-given.count // len(GROUPS))
    drawn = [draw(group, per_group, given.seed) for group in GROUPS]
    mutants = named()
    for turn in range(per_group):  # by turns, so that a part of them is fair to all groups
        mutants += [each[turn] for each in drawn if turn < len(each)]
    given.out.mkdir(parents=True, exist_ok=True)
    kept = given.out / f"seed-{given.seed}.jsonl"
    known = _known(kept)
    if not given.report:
        _try_all(mutants, known, kept, given)
    _report(mutants, known, given.seed)


def _known(kept: Path) -> dict[str, str]:
    lines = kept.read_text().splitlines() if kept.exists() else []
    return {entry["key"]: entry["verdict"] for entry in map(json.loads, lines)}


def _try_all(
    mutants: list[Mutant], known: dict[str, str], kept: Path, given: argparse.Namespace
) -> None:
    todo = [
        mutant
        for mutant in mutants
        if mutant.key not in known or (given.again and known[mutant.key] == "survived")
    ]
    end = time.monotonic() + 60 * given.minutes
    preload()
    with copied_tree() as tree, kept.open("a") as out:
        limits = {}
        for group in dict.fromkeys(mutant.group for mutant in todo):
            start = time.monotonic()
            log = given.out / f"unchanged-{group.replace(' ', '-')}.txt"
            if run_tests(tree, group, log, 1800) != "passed":
                raise SystemExit(f"The tests of {group} fail on the unchanged code: {log}")
            took = time.monotonic() - start
            limits[group] = 15 + 4 * took
            print(f"unchanged {group}: {took:.1f} s", flush=True)
        for i, mutant in enumerate(todo):
            if time.monotonic() > end:
                print(f"Time is up: {len(todo) - i} are left; run it again to go on")
                break
            verdict, took = _verdict(tree, mutant, given.out / "last.txt", limits[mutant.group])
            known[mutant.key] = verdict
            out.write(json.dumps({"key": mutant.key, "verdict": verdict}) + "\n")
            out.flush()
            where = f"{mutant.path}:{mutant.line} {mutant.name}"
            print(f"{i + 1}/{len(todo)} {verdict} {took:.1f} s {where}", flush=True)


def _verdict(tree: Path, mutant: Mutant, log: Path, limit_s: float) -> tuple[str, float]:
    file = tree / mutant.path
    before, start = file.read_bytes(), time.monotonic()
    try:
        file.write_text(mutant.code)
        result = run_tests(tree, mutant.group, log, limit_s)
    finally:
        file.write_bytes(before)
        shutil.copystat(ROOT / mutant.path, file)
    names = {"passed": "survived", "failed": "killed", "timeout": "timeout"}
    return names[result], time.monotonic() - start


def _report(mutants: list[Mutant], known: dict[str, str], seed: int) -> None:
    print(f"\nseed {seed}; {sum(m.key in known for m in mutants)} of {len(mutants)} tried")
    print(f"{'group':15} {'tried':>6} {'killed':>7} {'timeout':>8} {'survived':>9}  share noticed")
    total: Counter[str] = Counter()
    for group in GROUPS:
        counts = Counter(known[m.key] for m in mutants if m.group == group and m.key in known)
        total += counts
        _line(group, counts)
    _line("all", total)
    for mutant in mutants:
        if known.get(mutant.key) == "survived":
            diff = mutant.diff()
            why = [reason for part, reason in EXPLAINED if part in diff.split("\n+")[-1]]
            verdict = f"no difference ({why[0]})" if why else "survived"
            print(f"\n{verdict}: {mutant.path}:{mutant.line} {mutant.name}\n{diff}")


def _line(name: str, counts: Counter[str]) -> None:
    tried = sum(counts.values())
    share = (tried - counts["survived"]) / tried if tried else 0.0
    print(
        f"{name:15} {tried:6} {counts['killed']:7} {counts['timeout']:8} "
        f"{counts['survived']:9}  {share:.3f}"
    )


if __name__ == "__main__":
    main()
