"""`sloop warmup`."""

from __future__ import annotations

from sloop_ppl.cli.output import progress

__all__ = ["warmup"]


def warmup() -> None:
    """Compile the planner ahead of its first search; what it makes is kept.

    Where no cache folder can be written, nothing is kept, and each process compiles anew.
    """
    from sloop_ppl.planning import notify_compiling, warm_up
    from sloop_ppl.planning._compile import COMPILING

    with notify_compiling(lambda: progress(COMPILING)):
        done = warm_up()
    where = f"kept in {done.folder}" if done.folder else "no cache folder can be written: not kept"
    progress(f"the planner's machine code: {done.seconds:.1f} s, {where}")
