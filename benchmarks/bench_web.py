"""Measure how soon the workbench shows a belief, alone and with many users, and its memory.

Run: python benchmarks/bench_web.py [--map FILE] [--quick]

A server is started as `sloop serve` starts it. In Chromium, where there is one, a sentence is put
into the text box and the clock runs until the picture of the belief has changed and been painted:
on a bundled map, and on one of a kilometre in cells of 5 m (--map, else cleveland's landmarks on
so large a grid). Then 20 users send sentences to the bundled maps one after the other without a
pause; what they get is compared with what each sentence gets alone. Memory is the resident share of
the server's processes, what they have in common counted once (Linux: PSS).
--quick shows that the benchmark runs: two sentences, two users.
"""

from __future__ import annotations

import argparse
import http.client
import json
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from itertools import product
from pathlib import Path

import numpy as np

import sloop_ppl as sloop
from sloop_ppl.maps import Grid, bundled_maps, write_map

WORDS = ("near", "behind", "in front of", "left of", "north of", "at")
SMALL_MS, LARGE_MS, MANY_S, MEMORY_GB = 150, 500, 1.5, 1.5
USERS, EACH = 20, 10

DRAWN = """text => new Promise((done, failed) => {
    setTimeout(() => failed(new Error("nothing was drawn in a minute")), 60_000);
    const box = document.getElementById("text");
    const belief = document.querySelector("#map-a .belief");
    const seen = new MutationObserver(() => {
        seen.disconnect();
        requestAnimationFrame(() => setTimeout(() => done(performance.now() - begun)));
    });
    seen.observe(belief, { childList: true });
    box.value = text;
    const begun = performance.now();
    box.dispatchEvent(new Event("input", { bubbles: true }));
})"""


def sentences(city, count):
    """Return sentences about named places of a map, all different."""
    names = [m.name for m in city.landmarks if m.name and m.kind in ("building", "poi", "park")]
    made = [f"The green Toyota is {word} {name}." for name, word in product(names, WORDS)]
    order = np.random.default_rng(0).permutation(len(made))
    return [made[i] for i in order[:count]]


def kilometre(folder):
    """Write cleveland's landmarks on a grid of a kilometre and return the path."""
    city = sloop.load_map("cleveland")
    grid = Grid(-500, -500, 500, 500, 5.0, city.grid.centre)
    path = Path(folder) / "kilometre.geojson"
    write_map(city.with_grid(grid), path)
    return str(path)


class Served:
    """A server in a process of its own."""

    def __init__(self, folder, map_file):
        code = "import sys; from sloop_ppl.cli import main; main(sys.argv[1:])"
        command = [sys.executable, "-c", code, "serve", "--port", "0", "--folder", folder]
        command += ["--map", "cleveland", "--map", map_file]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.address = re.search(r"http\S+", self.process.stdout.readline())[0]
        self.port = int(re.search(r":(\d+)/", self.address)[1])
        self.token = self.address.partition("token=")[2]

    def ask(self, state):
        """Return what is believed."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=120)
        headers = {"authorization": f"Bearer {self.token}", "content-type": "application/json"}
        connection.request("POST", "/api/belief", json.dumps(state), headers)
        answer = connection.getresponse().read()
        connection.close()
        return json.loads(answer)["belief"]

    def memory_gb(self):
        """Return the memory of all its processes, or None where the system does not tell."""
        import psutil

        root = psutil.Process(self.process.pid)
        infos = [p.memory_full_info() for p in (root, *root.children(recursive=True))]
        return sum(i.pss for i in infos) / 2**30 if hasattr(infos[0], "pss") else None

    def stop(self):
        """End it."""
        self.process.terminate()
        self.process.wait()


def drawn_ms(served, key, texts):
    """Return how long each sentence takes to be drawn in Chromium, the first three left out."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        page = browser.new_page(viewport={"width": 1280, "height": 860})
        page.goto(served.address)
        page.locator("body[data-ready]").wait_for(timeout=120_000)
        if key != "cleveland":
            page.select_option("#map", key)
            name = page.locator("#map option:checked").inner_text()
            page.locator(f"#map-a svg[aria-label*='{name}']").wait_for(timeout=120_000)
        idle = page.locator("#maps[aria-busy=false]")
        idle.wait_for(state="attached", timeout=120_000)
        found = []
        for text in texts:
            found.append(page.evaluate(DRAWN, text))
            idle.wait_for(state="attached", timeout=120_000)
        browser.close()
    return found[3:]


def many(served, users, each):
    """Return the seconds of each answer to many users, and whether all got what they should."""
    asked = []
    for name in bundled_maps():
        asked += [{"map": name, "text": t} for t in sentences(sloop.load_map(name), 60)]
    asked = [asked[i] for i in np.random.default_rng(1).permutation(len(asked))][: users * each]
    taken, answers = [], [None] * len(asked)

    def user(number):
        for i in range(number, len(asked), users):
            begun = time.perf_counter()
            answers[i] = served.ask(asked[i])
            taken.append(time.perf_counter() - begun)

    threads = [threading.Thread(target=user, args=(n,)) for n in range(users)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    # A blank more, so that it is inferred anew.
    alone = [served.ask({**state, "text": state["text"] + " "}) for state in asked]
    return taken, answers == alone


def main():
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--map", help="a map of a kilometre")
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    count, users, each = (5, 2, 2) if options.quick else (43, USERS, EACH)
    with tempfile.TemporaryDirectory() as folder:
        large = options.map or kilometre(folder)
        served = Served(folder, large)
        try:
            served.ask({"map": "cleveland", "text": "the red bike is near ivy"})
            if shutil.which("chromium"):
                for name, key, most in (
                    ("bundled map", "cleveland", SMALL_MS),
                    ("a kilometre", sloop.load_map(large).digest, LARGE_MS),
                ):
                    city = sloop.load_map("cleveland" if key == "cleveland" else large)
                    ms = drawn_ms(served, key, sentences(city, count))
                    print(
                        f"typed to drawn, {name} {city.grid.shape}: median {np.median(ms):.0f} ms, "
                        f"p95 {np.quantile(ms, 0.95):.0f} ms of {len(ms)} (limit {most} ms)"
                    )
            else:
                print("typed to drawn: not measured, there is no Chromium")
            taken, equal = many(served, users, each)
            print(
                f"{users} users at once: p95 {np.quantile(taken, 0.95):.2f} s of {len(taken)} "
                f"answers (limit {MANY_S} s), {'equal' if equal else 'NOT EQUAL'} to those alone"
            )
            memory = served.memory_gb()
            used = "not reported by this system" if memory is None else f"{memory:.2f} GB"
            print(f"memory of the server's processes: {used} (limit {MEMORY_GB} GB)")
        finally:
            served.stop()


if __name__ == "__main__":
    main()
