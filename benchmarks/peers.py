"""Put sloop_ppl beside its peers, each on a task that both have, and print ratios.

Run, in an environment of its own:

    python3.11 -m venv peers && peers/bin/pip install torch  # the build for CPUs, see the README
    peers/bin/pip install . "numba<0.62" POMDPPlanners numpyro funsor osmnx
    peers/bin/python benchmarks/peers.py [planner|tiger|enumeration|import ...] [--rounds 5]

Contenders take turns, once a round, in one process and one thread; times are processor time, the
median of the rounds, and ratios are medians over rounds. What is not installed is said and left
out. What each ratio leaves out of account stands in docs/performance.md. --quick shows that it
runs, with whatever peers are there.
"""

from __future__ import annotations

import argparse
import importlib.util
import math
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault(
    "XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
)
ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "examples")]

Contender = Callable[[], object]


def main() -> None:
    """Run the comparisons that are asked for."""
    parts = {"planner": planner, "tiger": tiger, "enumeration": enumeration, "import": import_map}
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("parts", nargs="*", help=f"of {', '.join(parts)}; all when none is named")
    options.add_argument("--rounds", type=int, default=5)
    options.add_argument("--quick", action="store_true", help="show that it runs, in seconds")
    given = options.parse_args()
    for name in given.parts or parts:
        if name not in parts:
            options.error(f"there is no part {name}")
        parts[name](1 if given.quick else given.rounds, given.quick)


def has(package: str, what: str) -> bool:
    """Tell whether a package is there; say so where it is not."""
    if importlib.util.find_spec(package) is None:
        print(f"{what}: {package} is not installed, 0 rounds")
        return False
    return True


def compare(
    what: str, rounds: int, contenders: dict[str, tuple[Contender, float]], unit: str
) -> None:
    """Print how much each contender does a processor second, and its ratio to the first."""
    done: dict[str, list[float]] = {name: [] for name in contenders}
    for _ in range(rounds):
        for name, (run, amount) in contenders.items():
            begun = time.process_time()
            run()
            done[name].append(amount / (time.process_time() - begun))
    first, *_ = done.values()
    for name, rates in done.items():
        ratio = statistics.median(a / b for a, b in zip(rates, first, strict=True))
        print(
            f"{what}, {name}: {statistics.median(rates):,.4g} {unit} a CPU second, x {ratio:,.3g}"
        )


def planner(rounds: int, quick: bool) -> None:
    """Plan once on pomdp-py's bundled multi-object search, and on ours of the same size."""
    from benchmarks import bench_search as bench

    few, some = (20, 200) if quick else (200, 20_000)
    contenders = {
        "pomdp-py on its bundled domain": (bench.bundled(few), few),
        "pomdp-py on sloop_ppl's models": (bench.ours("pouct", some // 10), some // 10),
        "NativePouct of sloop_ppl": (bench.ours("fast", some), some),
    }
    compare("multi-object search, 41 x 41, simulations", rounds, contenders, "simulations")


def tiger(rounds: int, quick: bool) -> None:
    """Plan once on Tiger, depth 30, from an even belief."""
    import fast_tiger

    few, some = (50, 500) if quick else (1000, 100_000)
    contenders: dict[str, tuple[Contender, float]] = {}
    from pomdp_py import POUCT, Histogram
    from pomdp_py.problems.tiger.tiger_problem import TigerProblem, TigerState

    even = Histogram({TigerState("tiger-left"): 0.5, TigerState("tiger-right"): 0.5})

    def theirs() -> object:
        problem = TigerProblem(0.15, TigerState("tiger-left"), even)
        agent = problem.agent
        solver = POUCT(
            max_depth=30, discount_factor=0.95, num_sims=few, exploration_const=50,
            rollout_policy=agent.policy_model,
        )  # fmt: skip
        return solver.plan(agent)

    contenders["POUCT of pomdp-py"] = theirs, few
    if has("POMDPPlanners", "Tiger"):
        contenders["POMCP of POMDPPlanners"] = pomdpplanners(few), few
    contenders["NativePouct of sloop_ppl"] = our_tiger(fast_tiger, some), some
    compare("Tiger, depth 30", rounds, contenders, "simulations")


def our_tiger(module: Any, sims: int) -> Contender:
    """Return a function that plans once on the tiger of examples/fast_tiger.py."""
    import numpy as np

    from sloop_ppl.planning import NativePouct

    settings = {"sims": sims, "depth": 30, "discount": 0.95, "exploration": 110.0}
    solver = NativePouct(module.Tiger(), rng=np.random.default_rng(0), **settings)

    def run() -> object:
        solver.forget()
        return solver.plan(None)

    run()  # what is compiled is compiled
    return run


def pomdpplanners(sims: int) -> Contender:
    """Return a function that plans once on the Tiger of POMDPPlanners, by its POMCP."""
    from POMDPPlanners.core.belief import get_initial_belief
    from POMDPPlanners.environments.tiger_pomdp import TigerPOMDP
    from POMDPPlanners.planners.mcts_planners.pomcp import POMCP

    environment = TigerPOMDP(discount_factor=0.95)
    solver = POMCP(
        environment=environment, discount_factor=0.95, depth=30, exploration_constant=110.0,
        name="POMCP", n_simulations=sims,
    )  # fmt: skip
    belief = get_initial_belief(environment, n_particles=100)
    return lambda: solver.action(belief)


def enumeration(rounds: int, quick: bool) -> None:
    """Sum the same latents out of the same tables: three fronts of 72 angles, and the cell."""
    import numpy as np

    import sloop_ppl as sloop
    from sloop_ppl.inference import Enumerate, infer_description
    from sloop_ppl.language import Description, SpatialRelation, TargetObject
    from sloop_ppl.models import preset

    city = sloop.load_map("cleveland")
    phrases = (("behind", "VelvetDog"), ("left", "Ivy"), ("front", "Rumor"))
    relations = tuple(SpatialRelation("Car", word, (ground,)) for word, ground in phrases)
    said = Description("", city.name, (TargetObject("Car"),), relations)

    plain = replace(preset("bayes"), temper=0.0)  # a power of a sum is no sum of a program's sites

    def ours(engine: Any) -> Contender:
        return lambda: infer_description(said, city, plain, engine)[0].belief("Car")

    bins = 24 if quick else 72
    contenders: dict[str, tuple[Contender, float]] = {
        "Pyro, every latent enumerated (engine enumerate)": (ours(Enumerate(bins)), 1),
        "exact of sloop_ppl": (ours("exact"), 1),
    }
    if has("numpyro", "enumeration") and has("funsor", "enumeration"):
        contenders["NumPyro, the same tables given, jit"] = numpyro_sums(said, city, plain, bins), 1
    compare("three fronts, 41 x 41", rounds, contenders, "posteriors")
    belief = ours("exact")()
    for name, (run, _) in contenders.items():
        apart = 0.5 * float(np.abs(np.asarray(run()).reshape(belief.shape) - belief).sum())
        print(f"three fronts, 41 x 41, {name}: total variation {apart:.1e} to exact")


def numpyro_sums(said: Any, city: Any, model: Any, bins: int) -> Contender:
    """Return NumPyro's posterior of the cell, from tables of each phrase by front and cell."""
    import jax
    import jax.numpy as jnp
    import numpy as np
    import numpyro
    import numpyro.distributions as dist
    from numpyro.contrib.funsor import config_enumerate, enum, log_density

    from sloop_ppl.inference import infer_description
    from sloop_ppl.inference._phrase_tables import PhraseTables

    jax.config.update("jax_enable_x64", True)
    factor = infer_description(said, city, model)[0].factors[0]
    tables, fronts = [], []
    for relation in factor.relations("Car"):
        own = PhraseTables(factor.data, relation)
        angles, log_mass = own.phrase.bins(bins)
        given = own.log_phi_given_frame(np.asarray(angles).reshape(-1))
        tables.append(jnp.asarray(given.numpy().reshape(bins, -1)))
        fronts.append(jnp.asarray(np.asarray(log_mass).reshape(-1)))

    def program(logits: Any) -> None:
        cell = numpyro.sample("cell", dist.Categorical(logits=logits))
        for j, (table, log_mass) in enumerate(zip(tables, fronts, strict=True)):
            front = numpyro.sample(f"front_{j}", dist.Categorical(logits=log_mass))
            numpyro.factor(f"holds_{j}", table[front, cell])

    def log_z(logits: Any) -> Any:
        return log_density(enum(config_enumerate(program), -1), (logits,), {}, {})[0]

    size = city.grid.size
    uniform = jnp.full(size, -math.log(size))
    # d log Z / d logits is the posterior of the cell less its prior.
    change = jax.jit(jax.grad(log_z))
    change(uniform).block_until_ready()  # what is compiled is compiled
    return lambda: np.asarray(change(uniform)) + 1 / size


def import_map(rounds: int, quick: bool) -> None:
    """Import the same OpenStreetMap XML: all features."""
    sys.path.insert(0, str(ROOT / "tests"))
    from support.osm_block import block

    del quick
    from sloop_ppl.maps.osm import import_osm

    with tempfile.TemporaryDirectory() as folder:
        path = Path(os.environ.get("SLOOP_OSM", Path(folder) / "block.osm"))
        if not path.exists():
            block().write(path)
        contenders: dict[str, tuple[Contender, float]] = {
            "import_osm of sloop_ppl": (lambda: import_osm(path, everything=True), 1)
        }
        if has("osmnx", "import"):
            import osmnx

            contenders["features_from_xml of osmnx"] = (
                lambda: osmnx.features_from_xml(
                    path, tags={"building": True, "highway": True, "amenity": True}
                ),
                1,
            )
        compare(f"import of {path.name}", rounds, contenders, "imports")


if __name__ == "__main__":
    main()
