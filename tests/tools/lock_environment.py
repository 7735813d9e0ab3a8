"""Write requirements.lock: the versions of this environment, with the hashes of their files.

Run with the environment that the tests passed in (``make lock``). PyTorch and what only it brings
are left out: which build of it is installed is chosen by TORCH of the Makefile.
"""

from __future__ import annotations

import platform
import re
import subprocess
import sys
import tempfile
from importlib.metadata import distributions
from pathlib import Path

ROOT = Path(__file__).parents[2]
LOCK = ROOT / "requirements.lock"
HEAD = """\
# The environment that the tests are run in: Python 3.11 on Linux, with .[dev]. Made by `make lock`.
# PyTorch is installed before it (TORCH in the Makefile), so that its build can be chosen.
"""
_PYTORCH = re.compile(r"(torch|triton|nvidia-.*|cuda-.*)==")


def main() -> None:
    """Compile pyproject.toml with what is installed as constraints."""
    known = {d.metadata["Name"]: d.version.partition("+")[0] for d in distributions()}
    with tempfile.TemporaryDirectory() as folder:
        constraints, out = Path(folder, "constraints.txt"), Path(folder, "lock.txt")
        constraints.write_text("".join(f"{n}=={v}\n" for n, v in known.items() if n != "uv"))
        asked = [
            *(sys.executable, "-m", "uv", "pip", "compile", "pyproject.toml", "--extra", "dev"),
            *(
                "--python-version",
                platform.python_version(),
                "--generate-hashes",
                "--no-annotate",
                "--no-header",
            ),
            *("--quiet", "--constraint", str(constraints), "--output-file", str(out)),
        ]
        subprocess.run(asked, cwd=ROOT, check=True)
        entries = re.split(r"\n(?=\S)", out.read_text().strip())
    kept = [entry for entry in entries if not _PYTORCH.match(entry)]
    LOCK.write_text(HEAD + "\n".join(kept) + "\n")
    print(f"{LOCK.name}: {len(kept)} packages")


if __name__ == "__main__":
    main()
