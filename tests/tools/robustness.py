"""Measure how the program takes damaged input and signals.

``python tests/tools/robustness.py KIND N [FIRST]`` tries the cases from FIRST (0) on, of KIND

- ``sentences``, mutated and read, every 25th inferred;
- ``maps``, damaged map files, OpenStreetMap XML and Overpass JSON in turn, every tenth inferred on;
- ``signals``, searches and sweeps that are stopped at random moments.

Damaged files of other kinds are ``pytest tests/fuzz --fuzz-rounds N``. The last line is JSON; the
exit code is 1 where anything but an error of the program's own came out, a belief was not finite,
something was lost or a process was left.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import psutil

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

SIGNALS = [signal.SIGTERM, signal.SIGINT, signal.SIGKILL]
ODD_WORDS = (
    "not", "or", "between", "the", "12", "1e9", "-3", "m", "km", "half", "\u202e", "\u200b", "🚲",
    "ﬁ", "ＮＯＲＴＨ", "нет", "北", "i̇", "a" * 400, "((", "&", "of of", "…", "\0", "nor", "Map",
    "it", "I", "you",
)  # fmt: skip


def mutated_sentence(texts: list[str], names: list[str], rng: random.Random) -> str:
    """Return a sentence with words or bytes changed, put in, taken out or repeated."""
    from tests.support.damage import damaged_bytes

    words = rng.choice(texts).split(" ")
    for _ in range(rng.randint(1, 6)):
        at, what = rng.randrange(len(words) or 1), rng.random()
        if what < 0.2:
            words[at : at + rng.randint(1, 3)] = []
        elif what < 0.4:
            words.insert(at, rng.choice(ODD_WORDS))
        elif what < 0.6:
            words.insert(at, rng.choice(names))
        elif what < 0.8:
            words[at:at] = rng.choice(texts).split(" ")[: rng.randint(1, 9)]
        else:
            rng.shuffle(words)
    text = " ".join(words)
    if rng.random() < 0.25:
        text = damaged_bytes(text.encode(), rng).decode("utf-8", "replace")
    return text


def check_description(description: object) -> None:
    """Refuse what no reader may return."""
    known = description.to_json()  # type: ignore[attr-defined]
    json.dumps(known, allow_nan=False)
    size = len(known["text"])
    for relation in known["relations"]:
        assert 0 <= relation["confidence"] <= 1, relation
        for start, end in filter(None, relation["spans"].values()):
            assert 0 <= start < end <= size, relation
    assert sum(reading["p"] for reading in known["readings"]) <= 1 + 1e-5  # rounded


def check_posterior(posterior: object) -> None:
    """Refuse a belief that is none."""
    import numpy as np

    for target in posterior.targets:  # type: ignore[attr-defined]
        belief = posterior.belief(target)  # type: ignore[attr-defined]
        assert np.isfinite(belief).all(), target
        assert (belief >= 0).all(), target
        assert math.isclose(float(belief.sum()), 1, rel_tol=1e-6), target


def sentences(cases: range) -> Iterator[Callable[[], None]]:
    """Yield a reading of each mutated sentence."""
    from sloop_ppl.bridge.facade import infer, parse
    from sloop_ppl.eval import bundled_examples
    from sloop_ppl.maps import bundled_maps, load_map

    cities = [load_map(name) for name in bundled_maps()]
    texts = [annotated.text for annotated in bundled_examples()]
    for path in sorted((ROOT / "tests" / "language" / "data").glob("*.txt")):
        rows = [line.split("|") for line in path.read_text("utf-8").splitlines()]
        texts += [max(row, key=len).strip() for row in rows if row[0][:1] != "#"]
    texts = [text for text in texts if text]
    names = [m.name for city in cities for m in city.landmarks if m.name]
    for seed in cases:
        rng = random.Random(seed)
        city, text = rng.choice(cities), mutated_sentence(texts, names, rng)

        def read(city: object = city, text: str = text, seed: int = seed) -> None:
            description = parse(text, city)
            check_description(description)
            if seed % 25 == 0 and description.relations:
                check_posterior(infer(description, city, hearer=(0.0, 0.0)))

        yield read


def maps(cases: range) -> Iterator[Callable[[], None]]:
    """Yield an import or a reading of each damaged map."""
    from sloop_ppl.bridge.facade import infer
    from sloop_ppl.errors import NoRelationFound
    from sloop_ppl.maps import from_geojson, load_map, read_map, to_geojson
    from sloop_ppl.maps.osm import import_osm
    from tests.support.damage import damaged_bytes, damaged_json
    from tests.support.osm_block import block

    whole = to_geojson(load_map("austin"))
    overpass = json.dumps(
        {
            "elements": [
                {"type": "node", "id": 1, "lat": 41.5, "lon": -81.7, "tags": {"shop": "bakery"}},
                {
                    "type": "way", "id": 2, "tags": {"building": "yes", "name": "Mill"},
                    "geometry": [
                        {"lat": 41.5 + y, "lon": -81.7 + x}
                        for x, y in ((0, 0), (2e-4, 0), (2e-4, 2e-4), (0, 2e-4), (0, 0))
                    ],
                },
            ]
        }
    )  # fmt: skip
    folder = Path(tempfile.mkdtemp())
    sources = [("map.geojson", json.dumps(whole)), ("a.osm", block().text()), ("o.json", overpass)]
    for seed in cases:
        rng = random.Random(seed)
        name, text = sources[seed % 3]
        data = damaged_json(text, rng) if name != "a.osm" else damaged_bytes(text.encode(), rng)

        def read(name: str = name, data: bytes = data, seed: int = seed) -> None:
            path = folder / name
            path.write_bytes(data)
            if name == "map.geojson":
                city = read_map(path)
            else:
                city, _ = import_osm(path, everything=True, allow_incomplete=True)
            again = from_geojson(json.loads(json.dumps(to_geojson(city))))  # nothing is lost
            assert [m.id for m in again.landmarks] == [m.id for m in city.landmarks]
            if seed % 10 == 0 and city.landmarks and city.grid.size < 10_000:
                with contextlib.suppress(NoRelationFound):
                    check_posterior(infer(f"the red bike is near {city.landmarks[0].label}", city))

        yield read


def measured(cases: Iterator[Callable[[], None]]) -> dict[str, int]:
    """Return how many cases were taken, refused in one line, or went wrong."""
    from sloop_ppl.errors import SloopError

    outcomes: Counter[str] = Counter()
    for number, case in enumerate(cases, 1):
        if number % 5000 == 0:
            print(f"{number}: {dict(outcomes)}", flush=True)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                case()
            outcomes["taken"] += 1
        except SloopError as error:
            one_line = "\n" not in str(error) and len(str(error)) < 5000
            outcomes["refused" if one_line else "refused in a long message"] += 1
        except Exception as error:
            outcomes[f"wrong: {type(error).__name__}"] += 1
            if outcomes[f"wrong: {type(error).__name__}"] <= 10:
                print(f"case {number - 1}: {type(error).__name__}: {str(error)[:300]!r}")
    return dict(outcomes)


def signals(cases: range) -> dict[str, int]:
    """Stop searches and sweeps in turn; return how many ended as they should."""
    outcomes: Counter[str] = Counter()
    for number in cases:
        rng = random.Random(number)
        with tempfile.TemporaryDirectory() as name:
            stop = SIGNALS[number // 2 % len(SIGNALS)]
            fault = (stopped_sweep if number % 2 else stopped_search)(Path(name), stop, rng)
        outcomes["wrong" if fault else "as it should"] += 1
        print(f"case {number} ({stop.name}): {fault or 'as it should'}", flush=True)
    return dict(outcomes)


def started(*words: str) -> subprocess.Popen[str]:
    """Start the program."""
    code = "from sloop_ppl.cli import main; main()"
    asked = [sys.executable, "-c", code, *words]
    pipe = subprocess.PIPE
    return subprocess.Popen(asked, stdout=subprocess.DEVNULL, stderr=pipe, text=True, cwd=ROOT)


def fault_of(process: subprocess.Popen[str], stop: signal.Signals) -> str:
    """Send a signal; return what is wrong with how the process and its children end."""
    children = psutil.Process(process.pid).children(recursive=True)
    process.send_signal(stop)
    try:
        _, err = process.communicate(timeout=20)
    except subprocess.TimeoutExpired:
        process.kill()
        return "still running after 20 s"
    _, alive = psutil.wait_procs(children, timeout=10)
    for child in alive:
        child.kill()
    wanted = {signal.SIGTERM: 143, signal.SIGINT: 130, signal.SIGKILL: -9}[stop]
    if process.returncode not in (wanted, 0):  # 0: it was done just then
        return f"exit code {process.returncode}; {err[-300:]!r}"
    if "Traceback" in err:
        return f"a traceback: {err[-600:]!r}"
    return f"{len(alive)} processes left" if alive else ""


def stopped_search(folder: Path, stop: signal.Signals, rng: random.Random) -> str:
    """Stop a search after some of its steps."""
    out = folder / "e.json"
    process = started(
        "search", "The green Toyota is behind Velvet Dog.", "--map", "cleveland", "--sims", "3000",
        "--planner", "pomcp", "--steps", "150", "--out", str(out), "--seed", str(rng.randrange(99)),
    )  # fmt: skip
    steps, wanted = 0, rng.randint(1, 4)
    while steps < wanted and process.stderr is not None:
        line = process.stderr.readline()
        if not line:
            break
        steps += line[:3].strip().isdigit()
    time.sleep(rng.uniform(0, 0.3))
    fault = fault_of(process, stop)
    if fault or stop == signal.SIGKILL:
        return fault or ("half a file was left" if out.exists() and not whole(out) else "")
    return (
        "" if whole(out) and json.loads(out.read_text())["steps"] >= wanted else "steps were lost"
    )


def whole(path: Path) -> bool:
    """Tell whether a file is whole JSON."""
    try:
        return isinstance(json.loads(path.read_text()), dict)
    except (OSError, ValueError):
        return False


def stopped_sweep(folder: Path, stop: signal.Signals, rng: random.Random) -> str:
    """Stop a sweep of two workers after some of its trials, and go on with it."""
    from support.small_sweeps import write_lines

    from sloop_ppl.eval._trial_files import read_trials

    write_lines(folder / "said.jsonl")
    run = folder / "run"
    asked = [
        "eval", "search", str(folder / "said.jsonl"), "--out", str(run), "--workers", "2",
        "--models", "uniform,keyword", "--starts", "4", "--sims", "1500", "--ranges", "3",
    ]  # fmt: skip
    process = started(*asked)
    wanted, end = rng.randint(1, 8), time.monotonic() + 600
    while process.poll() is None and time.monotonic() < end:
        if sum(p.read_bytes().count(b"\n") for p in run.glob("parts/*.jsonl")) >= wanted:
            break
        time.sleep(0.02)
    fault = fault_of(process, stop)
    kept = read_trials(run / "parts")
    if fault or len(kept) < wanted:
        return fault or f"{len(kept)} trials of {wanted} are there"
    again = started(*asked)
    _, err = again.communicate(timeout=1800)
    after = read_trials(run / "parts")
    done = {t.key: t.to_json() for t in after}
    if again.returncode or len(after) != 24:
        return f"gone on with: code {again.returncode}, {len(after)} trials; {err[-300:]!r}"
    return "" if all(done[t.key] == t.to_json() for t in kept) else "trials were changed"


def main() -> None:
    """Measure what is asked for."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    # What a shell starts in the background ignores Ctrl-C, and so would all that it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    kind, count, first = sys.argv[1], int(sys.argv[2]), int([*sys.argv, "0"][3])
    cases = range(first, first + count)
    begun = time.monotonic()
    if kind == "signals":
        outcomes = signals(cases)
    else:
        outcomes = measured({"sentences": sentences, "maps": maps}[kind](cases))
    seconds = round(time.monotonic() - begun)
    print(json.dumps({"kind": kind, "first": first, "n": count, **outcomes, "seconds": seconds}))
    sys.exit(any(name not in ("taken", "refused", "as it should") for name in outcomes))


if __name__ == "__main__":
    main()
