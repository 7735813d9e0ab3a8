"""benchmarks/results.sh asks `sloop` only for what there is.

Its commands take twenty minutes, so they are written down by a stand-in and only read by `sloop`.
"""

import json
import shutil
import subprocess
import sys

import pytest
import typer
from support.tree import ROOT

from sloop_ppl.cli.app import app
from sloop_ppl.eval._quality_files import models_named
from sloop_ppl.eval.trials import Searching

SCRIPT = ROOT / "benchmarks" / "results.sh"
STAND_IN = """#!{python}
import json, sys
with open({log!r}, "a") as log:
    log.write(json.dumps(sys.argv[1:]) + "\\n")
if "--docs" in sys.argv:
    with open(sys.argv[sys.argv.index("--docs") + 1], "w") as page:
        page.write("# Results\\n\\n## In short\\n\\n$5 `a`\\n")
"""

pytestmark = pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")


def commands(tmp_path):
    """Run the script with a stand-in for `sloop`; return the arguments of each call."""
    sloop, log = tmp_path / "sloop", tmp_path / "log"
    sloop.write_text(STAND_IN.format(python=sys.executable, log=str(log)), encoding="utf-8")
    sloop.chmod(0o755)
    for name in ("a.jsonl", "b.jsonl"):
        (tmp_path / name).touch()
    (tmp_path / "docs").mkdir()
    done = subprocess.run(
        ["bash", SCRIPT, str(tmp_path / "*.jsonl"), tmp_path / "runs", sloop],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()]


def read(arguments):
    """Return the command and the options that `sloop` reads from arguments, without running it."""
    found = []
    command = typer.main.get_command(app)

    def note(group, names):
        for name, inner in group.commands.items():
            if hasattr(inner, "commands"):
                note(inner, (*names, name))
            else:
                inner.callback = lambda _name=(*names, name), **options: found.append(
                    (" ".join(_name), options)
                )

    note(command, ())
    command.main(arguments, prog_name="sloop", standalone_mode=False)
    (told,) = found
    return told


def test_every_command_of_the_script_is_one_that_sloop_reads(tmp_path):
    told = [read(arguments) for arguments in commands(tmp_path)]
    names = [name for name, _ in told]
    assert names[:2] == ["eval describe", "eval quality"]
    assert set(names) == {"eval describe", "eval quality", "eval search", "eval report"}
    for name, options in told:
        if "files" in options:
            assert [path.name for path in options["files"]] == ["a.jsonl", "b.jsonl"]
        if options.get("models"):
            models_named(options["models"])
        if name == "eval search":
            Searching(options["planner"], options["sims"], options["rollout"])
    runs = {options["out"].name for name, options in told if name == "eval search"}
    reported = {path.name for name, options in told if name == "eval report"
                for path in options["folders"]}  # fmt: skip
    assert reported == runs
    page = (tmp_path / "docs" / "results.md").read_text(encoding="utf-8")
    title, link, rest = page.split("\n\n", 2)
    assert title == "# Results"
    assert link.startswith("[Evaluation](evaluation.md)")
    assert rest == "## In short\n\n$5 `a`\n"


def test_an_option_that_sloop_lacks_is_told_of():
    with pytest.raises(Exception, match="--no-such"):
        read(["eval", "describe", "a.jsonl", "--no-such"])
