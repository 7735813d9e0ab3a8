"""Who gets in, what is refused, and that nothing a client sends names a file."""

from __future__ import annotations

import json
import socket
import time

import pytest
from support.web_server import GUEST, TOKEN

from sloop_ppl.web import _limits

STATE = {"map": "cleveland", "text": "the green toyota is behind velvet dog"}


@pytest.mark.parametrize("path", ["/api/start", "/api/map/cleveland", "/api/frames/queue"])
def test_nothing_is_had_without_the_token(server, path):
    assert server.ask("GET", path, token=None)[0] == 401
    assert server.ask("GET", path, token="wrong")[0] == 401
    assert server.ask("GET", path)[0] == 200


def test_a_page_takes_the_token_out_of_its_address(server):
    status, headers, _ = server.ask("GET", f"/?token={TOKEN}&a=1", token=None)
    assert (status, headers["location"]) == (303, "/?a=1")
    assert "HttpOnly" in headers["set-cookie"]
    assert "SameSite=strict" in headers["set-cookie"]
    cookie = headers["set-cookie"].partition(";")[0]
    assert server.ask("GET", "/api/start", token=None, headers={"cookie": cookie})[0] == 200
    _, headers, _ = server.ask("GET", "/?token=wrong", token=None)
    assert "set-cookie" not in headers


def test_guests_get_no_further_than_to_describe(server):
    assert server.json("POST", "/api/collect/guest/join", {}, token=GUEST)[0] == 200
    assert server.ask("GET", "/api/map/cleveland", token=GUEST)[0] == 200
    for path in ("/api/start", "/api/collect/progress", "/api/frames/queue"):
        assert server.ask("GET", path, token=GUEST)[0] == 401
    assert server.ask("POST", "/api/belief", STATE, token=GUEST)[0] == 401
    # A path that begins like an allowed one but goes elsewhere is not followed.
    assert server.ask("GET", "/api/map/../start", token=GUEST)[0] in (401, 404)


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "10.0.0.7", "[", ""])
def test_another_host_is_refused(server, host):
    assert server.ask("GET", "/", headers={"host": host})[0] in (400, 421)


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1", "[::1]"])
def test_this_machine_has_several_names(server, host):
    assert server.ask("GET", "/", headers={"host": f"{host}:{server.port}"})[0] == 200


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"origin": "http://127.0.0.1:1"},
        {"sec-fetch-site": "cross-site"},
        {"sec-fetch-site": "same-site"},
    ],
)
def test_other_sites_cannot_post(server, headers):
    status, answer = server.json("POST", "/api/belief", STATE, headers=headers)
    assert (status, answer) == (403, {"error": "The request comes from another site"})


def test_our_own_page_can_post(server):
    headers = {"origin": server.url, "sec-fetch-site": "same-origin"}
    assert server.ask("POST", "/api/belief", STATE, headers=headers)[0] == 200


def test_a_form_of_another_site_is_no_json(server):
    raw = json.dumps(STATE).encode()
    for kind in ("text/plain", "application/x-www-form-urlencoded", ""):
        status, _, _ = server.ask("POST", "/api/belief", raw=raw, headers={"content-type": kind})
        assert status == 415


def test_every_answer_forbids_what_is_not_of_this_server(server):
    for path in ("/", "/frames", "/static/view.js", "/api/start", "/nowhere", "/static/nothing"):
        _, headers, _ = server.ask("GET", path)
        policy = headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["referrer-policy"] == "no-referrer"
        assert "access-control-allow-origin" not in headers


@pytest.mark.parametrize(
    "path",
    [
        "/static/../application.py", "/static/..%2f..%2f__init__.py", "/static/%2e%2e/x",
        "/static//etc/passwd", "/static/page.html/../style.css", "/static/.", "/api/map/..%2f..",
        "/api/map/%2fetc%2fpasswd", "/api/export/..%2fx",
    ],
)  # fmt: skip
def test_no_path_leads_to_a_file(server, path):
    status, _, content = server.ask("GET", path)
    assert status in (404, 405)
    assert b"root:" not in content
    assert b"import" not in content


@pytest.mark.parametrize("field", ["model", "frames", "prior"])
@pytest.mark.parametrize("name", ["/etc/passwd", "evil.py:MODEL", "../../x.nc"])
def test_a_page_cannot_choose_a_file(server, field, name):
    status, answer = server.json("POST", "/api/belief", {**STATE, field: name})
    assert status == 422
    assert "is unknown" in answer["error"]


def test_a_map_is_chosen_by_key_not_by_path(server, tmp_path):
    from importlib.resources import files

    path = str(files("sloop_ppl") / "data" / "maps" / "cleveland.geojson")
    status, answer = server.json("POST", "/api/belief", {**STATE, "map": path})
    assert (status, list(answer)) == (404, ["error"])


def test_names_of_dropped_maps_are_only_texts(server):
    from importlib.resources import files

    content = (files("sloop_ppl") / "data" / "maps" / "austin.geojson").read_bytes()
    name = "../../<img src=x onerror=alert(1)>"
    query = "/api/maps?name=..%2F..%2F%3Cimg%20src%3Dx%20onerror%3Dalert(1)%3E"
    status, _, body = server.ask("POST", query, raw=content)
    assert status == 200
    answer = json.loads(body)
    assert {"key": answer["key"], "name": name} in answer["maps"]
    assert server.json("GET", f"/api/map/{answer['key']}")[1]["name"] == name


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"no map at all",
        b'{"type": "FeatureCollection", "features": [' + b"[" * 5000,
        b"\x00\x01\x02" * 1000,
        b"<?xml version='1.0'?><!DOCTYPE a [<!ENTITY x 'xxxx'>]><osm>&x;</osm>",
    ],
)
def test_what_is_no_map_is_refused_in_one_line(server, content):
    status, answer = server.json("POST", "/api/maps?name=bad", raw=content)
    assert status == 422
    assert "\n" not in answer["error"]
    assert "/tmp" not in answer["error"]


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"text": "x" * (_limits.MOST_TEXT + 1)}, "text"),
        ({"evidence": [{"target": "A", "at": [0, 0]}] * 101}, "evidence"),
        ({"off": list(range(65))}, "off"),
        ({"text": 7}, "text"),
        ({"unknown": 1}, "line"),
        ({"area": [0, 0, 1]}, "area"),
        ({"area": [1e9, 0, 1, 1]}, "area"),
    ],
)
def test_a_state_is_bounded(server, changes, field):
    status, answer = server.json("POST", "/api/belief", {**STATE, **changes})
    assert status == 400
    assert field in answer["error"]


@pytest.mark.parametrize(
    "changes", [{"sims": 10**9}, {"steps": 10**6}, {"seed": -1}, {"range_cells": 1e9}]
)
def test_a_search_is_bounded(server, changes):
    status, _ = server.json("POST", "/api/search", {"state": STATE, **changes})
    assert status == 400


@pytest.mark.parametrize("text", ["", "[", "NaN", '{"a": 1e999}', "[" * 1000, "\udcff"])
def test_what_is_no_json_is_refused(server, text):
    raw = text.encode("utf-8", "surrogatepass")
    status, answer = server.json(
        "POST", "/api/belief", raw=raw, headers={"content-type": "application/json"}
    )
    assert status == 400
    assert "\n" not in answer["error"]


def test_an_oversized_body_is_not_read(server):
    headers = {"content-type": "application/json"}
    raw = b" " * (_limits.MOST_BODY_BYTES + 1)
    assert server.ask("POST", "/api/belief", raw=raw, headers=headers)[0] == 413
    claimed = {**headers, "content-length": str(10**12)}
    assert server.ask("POST", "/api/belief", raw=b"{", headers=claimed)[0] == 413


def test_an_oversized_body_in_pieces_is_stopped(server):
    """Chunked: no length is declared, so it is counted while it comes."""
    with socket.create_connection(("127.0.0.1", server.port), timeout=20) as connection:
        connection.sendall(
            f"POST /api/belief HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n"
            f"Authorization: Bearer {TOKEN}\r\nContent-Type: application/json\r\n"
            "Transfer-Encoding: chunked\r\n\r\n".encode()
        )
        piece = b"4000\r\n" + b" " * 0x4000 + b"\r\n"
        for _ in range(_limits.MOST_BODY_BYTES // 0x4000 + 1):
            connection.sendall(piece)
        assert connection.recv(4096).startswith(b"HTTP/1.1 413")


def test_a_body_that_never_comes_is_given_up(server, monkeypatch):
    monkeypatch.setattr(_limits, "SECONDS_FOR_A_BODY", 0.3)
    with socket.create_connection(("127.0.0.1", server.port), timeout=20) as connection:
        connection.sendall(
            f"POST /api/belief HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n"
            f"Authorization: Bearer {TOKEN}\r\nContent-Type: application/json\r\n"
            "Content-Length: 100\r\n\r\n{".encode()
        )
        assert connection.recv(4096).startswith(b"HTTP/1.1 408")
    assert server.json("POST", "/api/belief", STATE)[0] == 200


def test_only_a_few_searches_run_at_a_time(server, monkeypatch):
    monkeypatch.setattr(_limits, "MOST_STREAMS", 0)
    status, answer = server.json("POST", "/api/search", {"state": STATE})
    assert status == 429
    assert "wait" in answer["error"]


def test_no_secret_is_logged(server, caplog, capfd):
    for path in (f"/?token={TOKEN}", f"/api/nowhere?token={TOKEN}"):
        server.ask("GET", path)
    server.ask("POST", "/api/belief", {**STATE, "model": "none"})
    time.sleep(0.05)
    written = caplog.text + "".join(capfd.readouterr())
    assert TOKEN not in written
    assert TOKEN not in repr(server.settings)
    assert GUEST not in repr(server.settings)
