"""Measure importing, loading and asking maps, against the figures they have to meet.

Run: python benchmarks/bench_maps.py [--osm ../shared/data/osm] [--rounds 5]

Times are wall times in seconds, the least of the rounds and, in brackets, the median; memory is the
peak of a process that does nothing else. Imports are measured in new processes, Python's start and
the imports of libraries included. Without the extracts only the bundled maps are measured.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).parents[1]
_CHILD = """
import json, sys, time
start = time.perf_counter()
from sloop_ppl.maps.osm import import_osm
from sloop_ppl.maps import write_map
ready = time.perf_counter()
path, out, patch = sys.argv[1], sys.argv[2], json.loads(sys.argv[3])
city, report = import_osm(path, **patch)
write_map(city, out)
done = time.perf_counter()
print(json.dumps({"libraries": ready - start, "work": done - ready,
    "landmarks": len(city.landmarks), "peak_mb": peak_mb()}))
"""
# The peak of this process alone: getrusage would count that of the process it was forked from.
_PEAK = """
def peak_mb():
    with open("/proc/self/status") as status:
        return next(int(l.split()[1]) for l in status if l.startswith("VmHWM")) / 1024
"""


def main() -> None:
    """Print every figure, with what it has to meet."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--osm", type=Path, default=ROOT.parent / "shared" / "data" / "osm")
    options.add_argument("--rounds", type=int, default=5)
    given = options.parse_args()
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}")
    bench_loading(given.rounds)
    bench_fields(given.rounds)
    bench_large_grid()
    if not given.osm.exists():
        print(f"no extracts in {given.osm}: imports not measured")
        return
    bench_imports(given.osm, given.rounds)
    bench_questions(given.osm, given.rounds)


def bench_loading(rounds: int) -> None:
    """Load each bundled map, the libraries being there."""
    from sloop_ppl.maps import bundled_maps, load_map

    load_map("cleveland")  # pyproj and the schema are ready after the first
    slowest = max(bundled_maps(), key=lambda name: least(lambda: load_map(name), 1))
    show("load a bundled map, the slowest", timed(lambda: load_map(slowest), rounds), "0.050")
    child = (
        "import time, sloop_ppl.maps, pyproj; t = time.perf_counter(); "
        "sloop_ppl.maps.load_map('denver'); print(time.perf_counter() - t)"
    )
    firsts = [float(run(["-c", child])) for _ in range(rounds)]
    show("load a bundled map, the first in a process", firsts, "0.050")


def bench_fields(rounds: int) -> None:
    """Compute every field of 100 landmarks on 401 x 401 cells, nothing cached."""
    import shapely

    from sloop_ppl.maps import CityMap, Grid, Landmark, load_map
    from sloop_ppl.maps.city import FIELDS

    grid = Grid.square(1000.0)
    lots = []
    for i in range(100):
        x, y = -900 + 180 * (i % 10), -900 + 180 * (i // 10)
        shape = shapely.box(x, y, x + 40, y + 25) if i % 2 else shapely.LineString(
            [(x, -1000), (x + 80, 1000)]
        )  # fmt: skip
        lots.append(Landmark(f"L{i}", "building" if i % 2 else "street", shape, width_m=8.0))

    def all_fields() -> None:
        FIELDS.clear()
        city = CityMap("large", grid, tuple(lots))
        for landmark in lots:
            touch(city, landmark.id)

    show(f"all fields of 100 landmarks on {grid.shape}", timed(all_fields, rounds), "1.5")
    small = load_map("cleveland")

    def one_map() -> None:
        FIELDS.clear()
        for landmark in small.with_grid(small.grid).landmarks:
            touch(small, landmark.id)

    show("all fields of the 61 landmarks of cleveland", timed(one_map, rounds), "")


def bench_large_grid() -> None:
    """Report what 50 landmarks' fields take on 1001 x 1001 cells, in a process of their own."""
    child = (
        f"import shapely, time\n{_PEAK}"
        "from sloop_ppl.maps import CityMap, Grid, Landmark\n"
        "lots = tuple(Landmark(f'B{i}', 'building', shapely.box(i, i, i + 30, i + 20))"
        " for i in range(0, 2000, 4))\n"
        "city = CityMap('large', Grid.square(2500.0), lots)\n"
        "before, t = peak_mb(), time.perf_counter()\n"
        "city.fields('B0').distance_m, city.fields('B0').bearing_rad\n"
        "one = time.perf_counter() - t\n"
        "for m in lots[:50]: f = city.fields(m.id); f.distance_m, f.bearing_rad\n"
        "print(one, before, peak_mb())"
    )
    one, before, after = run(["-c", child]).split()
    print(
        f"1001 x 1001 cells, 500 landmarks: {float(before):.0f} MB before any field, "
        f"{float(one):.3f} s for those of one, {float(after):.0f} MB after those of 50"
    )


def bench_imports(folder: Path, rounds: int) -> None:
    """Import two patches and every extract, each in new processes."""
    patches = [
        ("200 m of helsinki", "helsinki.osm.pbf", {"centre": [60.1699, 24.9384], "side_m": 200}, 5),
        (
            "2 km of baltimore",
            "baltimore.osm.pbf",
            {"centre": [39.285, -76.59], "side_m": 2000},
            30,
        ),
    ]
    patches += [
        (f"all of {path.name}", path.name, {"everything": True}, None)
        for path in sorted(folder.glob("*.osm*"))
    ]
    with tempfile.TemporaryDirectory() as scratch:
        for what, name, patch, limit in patches:
            out = str(Path(scratch) / "city.geojson")
            arguments = ["-c", _PEAK + _CHILD, str(folder / name), out, json.dumps(patch)]
            told = [json.loads(run(arguments)) for _ in range(rounds if limit else 1)]
            seconds = [t["libraries"] + t["work"] for t in told]
            peak = max(t["peak_mb"] for t in told)
            size = f"{told[0]['landmarks']} landmarks, {peak:.0f} MB (limit 1000 MB)"
            show(f"import {what}: {size}", seconds, str(limit or ""))


def bench_questions(folder: Path, rounds: int) -> None:
    """Ask a large map."""
    from sloop_ppl.maps.osm import import_osm

    city, _ = import_osm(folder / "baltimore.osm.pbf", everything=True)
    buildings = city.of_kind("building")
    print(f"asking {city}:")
    asked: list[tuple[str, Callable[[], object]]] = [
        ("bearing to the nearest path of 500 buildings",
         lambda: [city.bearing_to_nearest_path(b.id) for b in buildings[:500]]),
        ("frontage of 500 buildings", lambda: [city.frontage(b.id) for b in buildings[:500]]),
        ("nearest of all landmarks to 500 points",
         lambda: [city.nearest(7.0 * i, 3.0 * i, city.landmarks) for i in range(500)]),
        ("landmarks within 50 m of 500 points",
         lambda: [city.landmarks_near(7.0 * i, 3.0 * i) for i in range(500)]),
        ("find a name", lambda: city.find("Pratt Street")),
        ("find a misspelt name", lambda: city.find("Prat Stret")),
        ("a window of 200 m", lambda: city.window((0.0, 0.0), 200.0)),
    ]  # fmt: skip
    for what, ask in asked:
        ask()
        show(f"  {what}", timed(ask, rounds), "")


def touch(city: object, landmark_id: str) -> None:
    """Ask for every field of a landmark."""
    fields = city.fields(landmark_id)  # type: ignore[attr-defined]
    _ = fields.distance_m, fields.nearest, fields.bearing_rad, fields.from_centroid_m


def timed(work: Callable[[], object], rounds: int) -> list[float]:
    """Return the seconds that each round of some work takes."""
    seconds = []
    for _ in range(rounds):
        start = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - start)
    return seconds


def least(work: Callable[[], object], rounds: int) -> float:
    """Return the seconds of the quickest round."""
    return min(timed(work, rounds))


def run(arguments: list[str]) -> str:
    """Run Python in a new process and return what it prints."""
    return subprocess.run(
        [sys.executable, *arguments], check=True, capture_output=True, text=True
    ).stdout


def show(what: str, seconds: list[float], limit: str) -> None:
    """Print a figure, and whether its median meets the limit."""
    median = statistics.median(seconds)
    verdict = (
        "" if not limit else f", limit {limit} s: {'met' if median < float(limit) else 'NOT MET'}"
    )
    print(f"{what}: {min(seconds):.4f} s ({median:.4f} s){verdict}")


if __name__ == "__main__":
    main()
