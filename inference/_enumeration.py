"""Run the program with its discrete sites enumerated and read the tables off its trace."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from threading import RLock

import numpy as np
import pyro
import torch
from pyro import poutine
from pyro.infer import config_enumerate
from torch import Tensor

from sloop_ppl.errors import ProgramError
from sloop_ppl.inference.joint import LogTable, sum_product
from sloop_ppl.models import Program

__all__ = ["PYRO_LOCK", "description_tables", "enumerated_sites", "seeded_torch"]

PYRO_LOCK = RLock()
"""Held while a program runs: Pyro's stack of handlers and torch's generator are one per process."""

DRAW = "draw"
"""Name of the axis of draws that sites are conditioned on."""


def enumerated_sites(
    program: Program,
    given: Mapping[str, Tensor] | None = None,
    only: Callable[[str], bool] = lambda name: True,  # noqa: ARG005
) -> dict[str, LogTable]:
    """Return the log probability of each site of a program, its discrete latents enumerated.

    Parameters
    ----------
    program
        The program; gradients flow into the numbers of its model.
    given
        Continuous site -> n values it is conditioned on, shape (n,), n alike for all.
    only
        Tells of a site's name whether its table is wanted.

    Returns
    -------
    dict of LogTable
        Site -> table over the latents it depends on, and ``"draw"`` when values are given.

    Notes
    -----
    One at a time under `PYRO_LOCK`.
    """
    first = 0 if given is None else 1

    def conditioned() -> None:
        if given is None:
            program()
            return
        count = len(next(iter(given.values()))) if given else 1
        with pyro.plate(DRAW, count, dim=-1), poutine.condition(data=dict(given)):
            program()

    with PYRO_LOCK, pyro.validation_enabled(False), mistakes():
        enumerated = poutine.enum(config_enumerate(conditioned), first_available_dim=-1 - first)
        trace = poutine.trace(enumerated).get_trace()
    # Every enumerated site has an id, and every site knows which id lies along which dim: those of
    # sites that lie in another's loop are used again.
    sites = {name: site for name, site in trace.nodes.items() if site["type"] == "sample"}
    called = {
        site["infer"]["_dim_to_id"][site["infer"]["_enumerate_dim"]]: name
        for name, site in sites.items()
        if site["infer"].get("_enumerate_dim") is not None
    }
    tables = {}
    for name, site in sites.items():
        if only(name):
            log_p = site["fn"].log_prob(site["value"])
            dims = {dim: called[at] for dim, at in site["infer"].get("_dim_to_id", {}).items()}
            if first:
                dims[-1] = DRAW
            kept = [dim for dim in range(-log_p.dim(), 0) if log_p.shape[dim] > 1]
            tables[name] = LogTable(tuple(dims[dim] for dim in kept), log_p.squeeze())
    return tables


def description_tables(
    program: Program, given: Mapping[str, Tensor] | None = None
) -> tuple[Tensor, ...]:
    """Return how a description weighs component and cell of each target.

    Parameters
    ----------
    given
        As for `enumerated_sites`.

    Returns
    -------
    tuple of Tensor
        One table per target, shape (V..., K, S), with an axis for n values before the others when
        they are given. The priors of cells and of shared latents are left out, so that zeros in
        them can be put back without dividing by zero; all latents of one phrase are summed out.
    """
    data = program.data
    shared = tuple(latent.name for latent in data.shared)
    left_out = {*shared, *data.number_priors, *(f"{target}/cell" for target in data.targets)}
    if given is not None:
        left_out |= set(given)
    sites = enumerated_sites(program, given, lambda name: name not in left_out)
    found = []
    for i, target in enumerate(data.targets):
        own = {u.name for relation in data.relations[i] for u in data.phrase(relation).own}
        factors = [t for name, t in sites.items() if name in own or name.startswith(f"{target}/")]
        keep = (*shared, f"{target}/component", f"{target}/cell")
        if given is not None:
            keep = (DRAW, *keep)
        table = sum_product(factors, keep).aligned(keep)
        sizes = [len(v.support) for v in data.shared]
        sizes += [len(data.model.components), data.n_cells]
        if given is not None:
            sizes.insert(0, len(next(iter(given.values()), [0])))
        # An axis of one value carries an impossible twin in the program.
        table = table[tuple(slice(0, size) for size in sizes)]
        found.append(table.expand(sizes))
    return tuple(found)


@contextmanager
def mistakes() -> Iterator[None]:
    """Raise a mistake that shows while a program runs as what it is."""
    try:
        yield
    except ProgramError as error:
        mistake: BaseException = error  # Pyro's traces raise it again, each from the one before
        while isinstance(mistake, ProgramError) and mistake.__cause__ is not None:
            mistake = mistake.__cause__
        raise mistake from mistake.__cause__


@contextmanager
def seeded_torch(rng: np.random.Generator) -> Iterator[None]:
    """Seed torch's and Pyro's global generators from `rng` and use one thread; restore both.

    Under `PYRO_LOCK`. The tables of one step are too small to share out: more threads would only
    wait for each other, and one thread adds numbers in one order wherever it runs.
    """
    with PYRO_LOCK:
        before, threads = pyro.util.get_rng_state(), torch.get_num_threads()
        pyro.set_rng_seed(int(rng.integers(2**31)))
        torch.set_num_threads(1)
        try:
            yield
        finally:
            torch.set_num_threads(threads)
            pyro.util.set_rng_state(before)
