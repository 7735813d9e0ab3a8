"""Print what a plain install brings: each dependency, its size on disk, and why it is needed.

Run it with the Python of an environment into which sloop-ppl was installed without extras:
python tests/tools/install_sizes.py. The table in docs/installing.md is what it printed.
"""

from __future__ import annotations

import re
from importlib.metadata import Distribution, PackageNotFoundError, distribution

__all__ = ["REASONS", "closure", "main"]

REASONS = {
    "torch": "tables, gradients and tensors of the model; the CPU build",
    "pyro-ppl": "the generative program and its inference",
    "numba": "the default planner `fast`, in machine code",
    "scipy": "special functions, quadrature, optimisation",
    "xarray": "labelled tables of a posterior",
    "numpy": "arrays",
    "matplotlib": "every plot",
    "pyproj": "the local frame of a map",
    "pomdp-py": "the search POMDP and its planners",
    "pillow": "pictures for frame networks, and GIFs",
    "jsonschema-rs": "map files are checked against a schema",
    "rapidfuzz": "misspelt names",
    "h5py": "saved posteriors",
    "h5netcdf": "saved posteriors as NetCDF",
    "shapely": "outlines and regions",
    "osmium": "`sloop map import` of any city, offline",
    "anyascii": "Latin aliases of names in other scripts",
    "joblib": "sweeps on several processes",
    "rich": "tables in the terminal",
    "typer": "the command line",
    "safetensors": "weights of frame networks",
    "msgspec": "files are checked field by field",
    "markdown-it-py": "reports as pages",
    "cloudpickle": "models of your own in a sweep's workers",
}
"""Dependency -> what of the core uses it."""


def name_of(requirement: str) -> str:
    """Return the normalised name of a requirement."""
    found = re.match(r"[A-Za-z0-9._-]+", requirement)
    return re.sub(r"[-_.]+", "-", found[0] if found else "").lower()


def asked(found: Distribution) -> list[str]:
    """Return the names that a distribution asks for without extras."""
    return [name_of(one) for one in found.requires or () if "extra ==" not in one]


def closure(name: str, seen: dict[str, Distribution] | None = None) -> dict[str, Distribution]:
    """Return a distribution and all that it brings, by name; what is not installed is left out."""
    seen = {} if seen is None else seen
    if name not in seen:
        try:
            seen[name] = distribution(name)
        except PackageNotFoundError:
            return seen
        for other in asked(seen[name]):
            closure(other, seen)
    return seen


def megabytes(found: Distribution) -> float:
    """Return the size of a distribution's files."""
    paths = [found.locate_file(file) for file in found.files or ()]
    return sum(p.stat().st_size for p in paths if p.exists()) / 1e6  # type: ignore[attr-defined]


def main() -> None:
    """Print the table, the largest first; what several dependencies bring stands at the end."""
    ours = distribution("sloop-ppl")
    direct = asked(ours)
    everything = closure("sloop-ppl")
    sizes = {name: megabytes(found) for name, found in everything.items()}
    rows, shared = [], set(everything) - set(direct) - {"sloop-ppl"}
    for name in direct:
        others = {n for one in direct if one != name for n in closure(one)}
        alone = sorted(set(closure(name)) - others - {name})
        shared -= set(alone)
        rows.append((sizes[name] + sum(sizes[n] for n in alone), name, alone))
    print("| package | MB | its own dependencies | for |")
    print("| --- | ---: | --- | --- |")
    for size, name, alone in sorted(rows, reverse=True):
        print(f"| {name} | {size:.0f} | {', '.join(alone)} | {REASONS[name]} |")
    both = ", ".join(sorted(shared))
    print(f"| shared dependencies | {sum(sizes[n] for n in shared):.0f} | {both} | |")
    print(f"| sloop-ppl | {sizes['sloop-ppl']:.0f} | | maps, networks, the workbench |")
    print(f"| **all {len(everything)}** | **{sum(sizes.values()):.0f}** | | |")


if __name__ == "__main__":
    main()
