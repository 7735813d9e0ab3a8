"""`sloop fly --serve PORT`: a client on a socket flies the drone of a sentence's world."""

from __future__ import annotations

import contextlib
import re
import signal
import subprocess
import sys

import pytest

pytest.importorskip("msgpack", reason="the server needs msgpack")

from bare_client import BareClient

FLY = ["fly", "the red car is in Annie's House", "--map", "suburb", "--place", "RedCar=-17.5,52.5"]


@contextlib.contextmanager
def served(*arguments):
    """Run `sloop fly --serve` until Ctrl-C; give its port and what it said, which goes on."""
    code = "import sys; from sloop_ppl.cli import main; main(sys.argv[1:])"
    command = [sys.executable, "-c", code, *FLY, "--serve", "0", *arguments]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        lines, port = [], None
        for line in process.stderr:
            lines.append(line)
            if found := re.search(r"127\.0\.0\.1:(\d+)", line):
                port = int(found[1])
                break
        assert port, "".join(lines)
        try:
            yield port, lines
        finally:
            process.send_signal(signal.SIGINT)
            lines += process.stderr
            lines.append(f"exit code {process.wait(20)}")


def test_a_client_flies_the_drone_until_ctrl_c():
    start = ["--start", "-2.5,-2.5", "--wind", "0", "--seed", "3"]
    with served(*start) as (port, said):
        assert "RedCar stands at (-17.5, 52.5)\n" in said
        client = BareClient(port)
        with contextlib.closing(client.raw):
            assert "RedCar" in client.simListSceneObjects(".*")
            ground = client.simGetVehiclePose("").position
            # x of the client is north, y east, z down
            assert (ground.x_val, ground.y_val) == pytest.approx((-2.5, -2.5), abs=0.5)
            assert ground.z_val > -0.5
            client.enableApiControl(True, "")
            client.takeoffAsync(20, "").get()
            assert client.simGetVehiclePose("").position.z_val < -1
    assert said[-2:] == ["sloop: stopped\n", "exit code 130"], "".join(said)


def test_a_taken_port_is_one_line():
    code = "import sys; from sloop_ppl.cli import main; main(sys.argv[1:])"
    with served() as (port, _):
        second = subprocess.run(
            [sys.executable, "-c", code, *FLY, "--serve", str(port)], capture_output=True, text=True
        )
    assert second.returncode == 2
    assert str(port) in second.stderr.splitlines()[-1]
    assert "Traceback" not in second.stderr
