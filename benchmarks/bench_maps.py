"""Measure importing, loading and asking maps, against the figures they have to meet.

Run: python benchmarks/bench_maps.py [--osm ../shared/data/osm] [--rounds 5] [--quick]

Times are wall times in seconds, the least of the rounds and, in brackets, the median; memory is the
peak of a process that does nothing else. Imports are measured in new processes, Python's start and
the imports of libraries included. Without the extracts only the bundled maps are measured. --quick
shows that the benchmark runs: small grids, one round, an extract of a block that it writes itself.
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
Patch = tuple[str, str, dict[str, object], int | None]
"""What it is called, the extract's name, what is asked of `import_osm`, and a limit in seconds."""

PATCHES: list[Patch] = [
    ("200 m of helsinki", "helsinki.osm.pbf", {"centre": [60.1699, 24.9384], "side_m": 200}, 5),
    ("2 km of baltimore", "baltimore.osm.pbf", {"centre": [39.285, -76.59], "side_m": 2000}, 30),
]


def main() -> None:
    """Print every figure, with what it has to meet."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--osm", type=Path, default=ROOT.parent / "shared" / "data" / "osm")
    options.add_argument("--rounds", type=int, default=5)
    options.add_argument("--quick", action="store_true", help="show that it runs, in seconds")
    given = options.parse_args()
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}")
    if given.quick:
        quick_round()
        return
    bench_loading(given.rounds)
    bench_fields(given.rounds, 1000.0)
    bench_large_grid(2500.0)
    if not given.osm.exists():
        print(f"no extracts in {given.osm}: imports not measured")
        return
    bench_imports(given.osm, PATCHES, given.rounds)
    bench_questions(given.osm / "baltimore.osm.pbf", 500, given.rounds)
    bench_streets(given.osm / "helsinki.osm.pbf", (60.1699, 24.9384), 1000.0, given.rounds)


def quick_round() -> None:
    """Run every part once on little."""
    bench_loading(1)
    bench_fields(1, 100.0)
    bench_large_grid(250.0)
    with tempfile.TemporaryDirectory() as scratch:
        block = Path(scratch) / "block.osm"
        block.write_text(block_text(), encoding="utf-8")
        lon, lat = _lonlat(0, 0)
        patches = [("80 m of a block", block.name, {"centre": [lat, lon], "side_m": 80}, 5)]
        bench_imports(block.parent, patches, 1)
        bench_questions(block, 5, 1)
        bench_streets(block, (lat, lon), 80.0, 1)


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


def bench_fields(rounds: int, half_m: float) -> None:
    """Compute every field of 100 landmarks on the cells of a square, nothing cached."""
    import shapely

    from sloop_ppl.maps import CityMap, Grid, Landmark, load_map
    from sloop_ppl.maps.city import FIELDS

    grid = Grid.square(half_m)
    lots = []
    for i in range(100):
        x, y = half_m * (-0.9 + 0.18 * (i % 10)), half_m * (-0.9 + 0.18 * (i // 10))
        shape = shapely.box(x, y, x + 0.04 * half_m, y + 0.025 * half_m) if i % 2 else (
            shapely.LineString([(x, -half_m), (x + 0.08 * half_m, half_m)])
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


def bench_large_grid(half_m: float) -> None:
    """Report what 50 landmarks' fields take on the cells of a square, in a process of their own."""
    child = (
        f"import shapely, time\n{_PEAK}"
        "from sloop_ppl.maps import CityMap, Grid, Landmark\n"
        "lots = tuple(Landmark(f'B{i}', 'building', shapely.box(i, i, i + 30, i + 20))"
        " for i in range(0, 2000, 4))\n"
        f"city = CityMap('large', Grid.square({half_m}), lots)\n"
        "before, t = peak_mb(), time.perf_counter()\n"
        "city.fields('B0').distance_m, city.fields('B0').bearing_rad\n"
        "one = time.perf_counter() - t\n"
        "for m in lots[:50]: f = city.fields(m.id); f.distance_m, f.bearing_rad\n"
        "print(one, before, peak_mb(), *city.grid.shape)"
    )
    one, before, after, rows, columns = run(["-c", child]).split()
    print(
        f"{rows} x {columns} cells, 500 landmarks: {float(before):.0f} MB before any field, "
        f"{float(one):.3f} s for those of one, {float(after):.0f} MB after those of 50"
    )


def bench_imports(folder: Path, patches: list[Patch], rounds: int) -> None:
    """Import some patches and every extract, each in new processes."""
    patches = patches + [
        (f"all of {path.name}", path.name, {"everything": True}, None)
        for path in sorted(folder.glob("*.osm*"))
    ]
    with tempfile.TemporaryDirectory() as scratch:
        for what, name, patch, limit in patches:
            out = str(Path(scratch) / "city.geojson")
            arguments = ["-c", _PEAK + _CHILD, str(folder / name), out, json.dumps(patch)]
            runs = [json.loads(run(arguments)) for _ in range(rounds if limit else 1)]
            seconds = [t["libraries"] + t["work"] for t in runs]
            peak = max(t["peak_mb"] for t in runs)
            size = f"{runs[0]['landmarks']} landmarks, {peak:.0f} MB (limit 1000 MB)"
            show(f"import {what}: {size}", seconds, str(limit or ""))


def bench_questions(extract: Path, count: int, rounds: int) -> None:
    """Ask the map of an extract about so many buildings and points."""
    from sloop_ppl.maps.osm import import_osm

    city, _ = import_osm(extract, everything=True)
    buildings = city.of_kind("building")[:count]
    print(f"asking {city}:")
    asked: list[tuple[str, Callable[[], object]]] = [
        (f"bearing to the nearest path of {len(buildings)} buildings",
         lambda: [city.bearing_to_nearest_path(b.id) for b in buildings]),
        (f"frontage of {len(buildings)} buildings",
         lambda: [city.frontage(b.id) for b in buildings]),
        (f"nearest of all landmarks to {count} points",
         lambda: [city.nearest(7.0 * i, 3.0 * i, city.landmarks) for i in range(count)]),
        (f"landmarks within 50 m of {count} points",
         lambda: [city.landmarks_near(7.0 * i, 3.0 * i) for i in range(count)]),
        ("find a name", lambda: city.find("Pratt Street")),
        ("find a misspelt name", lambda: city.find("Prat Stret")),
        ("a window of 200 m", lambda: city.window((0.0, 0.0), 200.0)),
    ]  # fmt: skip
    for what, ask in asked:
        ask()
        show(f"  {what}", timed(ask, rounds), "")


def bench_streets(extract: Path, centre: tuple[float, float], side_m: float, rounds: int) -> None:
    """Find streets, crossings and blocks of a patch, nothing cached, and tables of its cells."""
    from sloop_ppl.maps import block_table, edge_tables, street_network, street_tables
    from sloop_ppl.maps.city import FIELDS
    from sloop_ppl.maps.osm import import_osm
    from sloop_ppl.maps.street_network import NETWORKS

    city, _ = import_osm(extract, centre=centre, side_m=side_m)
    named = next(m for m in city.of_kind("street") if m.name)

    def network() -> None:
        NETWORKS.clear()
        street_network(city.with_grid(city.grid))

    def tables(ask: Callable[[], object]) -> Callable[[], object]:
        def cold() -> object:
            FIELDS.clear()
            return ask()

        return cold

    print(f"streets of {city}:")
    show("  streets, crossings and blocks", timed(network, rounds), "1")
    show("  blocks of the cells", timed(tables(lambda: block_table(city)), rounds), "")
    show("  places along the blocks' edges", timed(tables(lambda: edge_tables(city)), rounds), "")
    show("  all of one street", timed(tables(lambda: street_tables(city, named.id)), rounds), "")


def block_text() -> str:
    """Return an extract of two streets and four buildings in OpenStreetMap's XML."""
    ways = [
        ([(-60, 0), (60, 0)], {"highway": "residential", "name": "Pratt Street"}),
        ([(0, -60), (0, 60)], {"highway": "residential", "name": "Light Street"}),
    ]
    for x, y in ((-30, -25), (15, -25), (-30, 15), (15, 15)):
        corners = [(x, y), (x + 15, y), (x + 15, y + 10), (x, y + 10)]
        ways.append(([*corners, corners[0]], {"building": "yes", "name": f"House {len(ways) - 1}"}))
    places = list(dict.fromkeys(place for way, _ in ways for place in way))
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', '<osm version="0.6">']
    for number, (lon, lat) in enumerate((_lonlat(*place) for place in places), start=1):
        lines.append(f'<node id="{number}" version="1" lat="{lat:.7f}" lon="{lon:.7f}"/>')
    for number, (way, tags) in enumerate(ways, start=1):
        nodes = "".join(f'<nd ref="{places.index(place) + 1}"/>' for place in way)
        tag_lines = "".join(f'<tag k="{key}" v="{value}"/>' for key, value in tags.items())
        lines.append(f'<way id="{number}" version="1">{nodes}{tag_lines}</way>')
    return "\n".join([*lines, "</osm>", ""])


def _lonlat(x: float, y: float) -> tuple[float, float]:
    """Return longitude and latitude of a place in metres from the middle of the block."""
    from sloop_ppl.maps import Grid

    lon, lat = Grid.square(100.0, 5.0, (39.285, -76.59)).to_lonlat(x, y)
    return float(lon), float(lat)


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
