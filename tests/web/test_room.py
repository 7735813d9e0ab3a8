"""Who may import the room, and that it says what it needs."""

from __future__ import annotations

import ast
import json
import sys

import pytest
from support.tree import ROOTS, run_python

from sloop_ppl.cli import main


def imports(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {n.module or "" for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)}


def test_only_the_command_line_imports_it_and_it_imports_no_command():
    for package, folder in ROOTS.items():
        for path in folder.rglob("*.py"):
            room = ".".join((package, *path.relative_to(folder).parts[:-1]))
            if room == "sloop_ppl" and path.name == "__init__.py":
                continue  # the names of the package
            used = imports(path)
            if not room.startswith(("sloop_ppl.web", "sloop_ppl.cli")):
                assert not [m for m in used if m.startswith("sloop_ppl.web")], path
            if room.startswith("sloop_ppl.web"):
                assert not [m for m in used if m.startswith("sloop_ppl.cli")], path


def test_a_page_file_needs_no_server(tmp_path):
    code = (
        "import json, sys\n"
        "from sloop_ppl.cli import main\n"
        "try:\n"
        "    main(['infer', 'the bike is near ivy', '--map', 'cleveland', '--html', 'a.html'])\n"
        "except SystemExit as end:\n"
        "    assert not end.code\n"
        "print(json.dumps(sorted(sys.modules)))\n"
    )
    loaded = json.loads(run_python(code, tmp_path).splitlines()[-1])
    assert sorted(set(loaded) & {"starlette", "uvicorn", "anywidget", "numba", "pomdp_py"}) == []
    assert (tmp_path / "a.html").exists()


@pytest.mark.parametrize("missing", ["starlette", "uvicorn"])
def test_what_is_not_installed_is_named(missing, monkeypatch, capsys):
    from sloop_ppl.cli import _web

    monkeypatch.setattr(_web, "find_spec", lambda name: None if name == missing else name)
    with pytest.raises(SystemExit) as end:
        main(["serve", "--port", "0"])
    assert end.value.code == 2
    assert capsys.readouterr().err == (
        f"sloop: The workbench needs {missing}, which is not installed; run pip install "
        "'sloop-ppl[web]'\n"
    )


def test_a_taken_port_is_named(capsys):
    import socket

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(SystemExit) as end:
            main(["serve", "--port", str(port)])
    assert end.value.code == 2
    assert f"sloop: Port {port} of 127.0.0.1 cannot be had: " in capsys.readouterr().err


def test_ctrl_c_ends_it_and_the_addresses_are_printed(tmp_path):
    import re
    import signal
    import subprocess
    import urllib.request

    code = "import sys; from sloop_ppl.cli import main; main(sys.argv[1:])"
    server = subprocess.Popen(
        [sys.executable, "-u", "-c", code, "serve", "--port", "0"],
        cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    first, second = server.stdout.readline(), server.stdout.readline()
    address = re.fullmatch(r"Workbench: (http://127\.0\.0\.1:\d+/)\?token=\S+\n", first)
    assert re.search(r"/collect\?token=\S+", second)
    assert b"workbench.js" in urllib.request.urlopen(address[1], timeout=60).read()
    server.send_signal(signal.SIGINT)
    _, errors = server.communicate(timeout=60)
    assert "Traceback" not in errors
    assert server.returncode in (0, 130)
    assert list(tmp_path.iterdir()) == []  # nothing is kept before there is something to keep
