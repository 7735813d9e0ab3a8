"""Measure reading: how fast, and how well, against the figures it has to meet.

Run: python benchmarks/bench_language.py [--descriptions ../shared/data/descriptions] [--nlp PATH]
         [--quick]

Speed is in descriptions per second of processor time on one core, best of the rounds, first with
texts the parser has met (warm caches) and then with new slips in every round. Without the published
descriptions only the bundled examples and the hard set are read. --quick shows that the benchmark
runs: a few texts, the bundled examples in place of the published descriptions.
"""

from __future__ import annotations

import argparse
import os
import platform
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from sloop_ppl.eval import AnnotatedDescription, bundled_examples, read_descriptions, score_parser
from sloop_ppl.eval._corruption import misspell
from sloop_ppl.language import Parser, dependency_parser, parse
from sloop_ppl.maps import bundled_maps, load_map

ROOT = Path(__file__).parents[1]
HARD = ROOT / "tests" / "language" / "data"


def main() -> None:
    """Print every figure, with what it has to meet."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    shared = ROOT.parent / "shared" / "data" / "descriptions"
    options.add_argument("--descriptions", type=Path, default=shared)
    options.add_argument("--nlp", help="a CLEAR-label spaCy pipeline, for the paper's rule")
    options.add_argument("--rounds", type=int, default=5)
    options.add_argument("--quick", action="store_true", help="show that it runs, in seconds")
    given = options.parse_args()
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}")
    few = slice(8 if given.quick else None)
    descriptions = list(bundled_examples())[few]
    if given.quick:
        bench_quality("bundled", descriptions, given.nlp)
    elif given.descriptions.is_dir():
        published = list(read_descriptions(sorted(given.descriptions.glob("*.jsonl"))))
        bench_quality("published", published, given.nlp)
        descriptions += published
    else:
        print(f"no descriptions in {given.descriptions}: not scored")
    for part in ("dev", "scored"):
        score = score_parser(read_descriptions(HARD / f"hard_{part}.jsonl")[few])
        print(f"hard set, {part}: tuple {score.tuple_f1:.4f} over {score.n} (.93 on scored)")
    bench_speed(descriptions, 1 if given.quick else given.rounds)
    bench_length(200 if given.quick else 10_000)


def bench_quality(name: str, descriptions: Sequence[AnnotatedDescription], nlp: str | None) -> None:
    """Score the rules plainly, on merged maps and with slips, and the paper's rule beside them."""
    maps = [load_map(m) for m in bundled_maps()]
    plain = score_parser(descriptions)
    print(
        f"{name}: tuple {plain.tuple_f1:.4f} (.97), class {plain.class_f1:.4f} (.98), "
        f"pair {plain.pair_f1:.4f} (.99) over {plain.n}"
    )
    print(
        f"{name}, merged maps: tuple {score_parser(descriptions, merged=maps).tuple_f1:.4f} (.96)"
    )
    slips = [
        score_parser(descriptions, misspelt=0.15, rng=np.random.default_rng(seed)).tuple_f1
        for seed in range(5)
    ]
    print(f"{name}, 15 % misspelt: tuple {slips[0]:.4f} (.93), seeds 0-4 mean {np.mean(slips):.4f}")
    if nlp is not None:
        rules: dict[str, Parser] = {
            "paper's rule": dependency_parser(nlp, every_path=True),
            "within clauses": dependency_parser(nlp),
        }
        for rule, parser in rules.items():
            score = score_parser(descriptions, parser=parser)
            print(f"{name}, {rule}: tuple {score.tuple_f1:.4f}, pair {score.pair_f1:.4f}")


def bench_speed(descriptions: Sequence[AnnotatedDescription], rounds: int) -> None:
    """Read all texts over and over, on one core."""
    city = load_map("cleveland")
    maps = {name: load_map(name) for name in bundled_maps()}
    texts = [(s.text, maps[s.map]) for s in descriptions]
    parse("The red bike is near Ivy", city)
    warm, fresh = [], []
    for k in range(rounds):
        rng = np.random.default_rng(k)
        warm.append(_per_second([t for t in texts for _ in range(5)]))
        fresh.append(_per_second([(misspell(t, 0.15, rng=rng), m) for t, m in texts]))
    words = np.mean([len(t.split()) for t, _ in texts])
    print(
        f"{max(warm):.0f} descriptions/s warm, {max(fresh):.0f}/s with new slips (500), "
        f"{words:.0f} words each, {len(city.landmarks)} landmarks"
    )


def _per_second(texts: Sequence[tuple[str, object]]) -> float:
    start = time.process_time()
    for text, city in texts:
        parse(text, city)  # type: ignore[arg-type]
    return len(texts) / (time.process_time() - start)


def bench_length(words: int) -> None:
    """Read a text of so many words and one of four times as many."""
    city = load_map("cleveland")
    sentence = "The red bike is behind Velvet Dog and the green car is west of the Hat Factory. "
    took = []
    for count in (words, 4 * words):
        text = sentence * (count // len(sentence.split()))
        start = time.process_time()
        parse(text, city)
        took.append(time.process_time() - start)
    line = f"{words:,} words in {took[0]:.2f} s" + (" (2)" if words == 10_000 else "")
    print(f"{line}, four times as many in {took[1] / took[0]:.1f} x")


if __name__ == "__main__":
    main()
