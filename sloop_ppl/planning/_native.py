"""The protocol by which a domain lets `NativePouct` run it in machine code.

A domain opts in with an attribute ``native`` on its transition model, a `NativeModel`. Its data
and its belief are NamedTuples of arrays and numbers; four or five functions that numba can compile
are registered for them with `register_native`. States are vectors of int64, which `step` changes in
place. Random numbers come from `uniform`.

Legend: A actions; S length of a state.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np
from numba import types
from numba.extending import overload
from numpy.typing import NDArray

from sloop_ppl.planning._compile import PART_OPTIONS, callable_part, uncached
from sloop_ppl.planning._pomdp import Agent

__all__ = [
    "NativeFunctions",
    "NativeModel",
    "generic_rollout",
    "native_draw",
    "native_legal",
    "native_policy",
    "native_rollout",
    "native_step",
    "register_native",
    "uniform",
]

State = NDArray[np.int64]
Random = NDArray[np.uint64]
T = TypeVar("T")


class NativeModel(Protocol):
    """A domain, as `NativePouct` wants to see it.

    Attributes
    ----------
    actions
        The actions, A of them; their places are the numbers that the functions use.
    state_size
        Length S of a state.
    data
        NamedTuple for whose class functions were registered.
    """

    actions: tuple[Any, ...]
    state_size: int
    data: Any

    def belief(self, agent: Agent) -> Any:
        """Return the agent's belief as the NamedTuple that `NativeFunctions.draw` takes."""
        ...

    def key(self, observation: Any) -> int:
        """Return the number that `NativeFunctions.step` gives for an observation."""
        ...


class NativeFunctions(NamedTuple):
    """The functions of a domain, each a plain function that numba can compile.

    Attributes
    ----------
    draw
        ``(data, belief, state, random) -> None`` fills a state drawn from the belief.
    legal
        ``(data, state) -> int`` returns the bit mask of the actions that may be taken.
    step
        ``(data, state, action, random) -> (reward, key, over)`` changes the state; `key` tells
        observations apart, and after `over` every reward is zero.
    policy
        ``(data, state, random) -> int`` returns the next action below the leaves.
    rollout
        None, or ``(data, state, level, depth, discount, random) -> return``, a whole rollout from
        `level` to `depth` at once, where that can be had faster than by `policy` and `step` in
        turn.
    """

    draw: Callable[..., None]
    legal: Callable[..., int]
    step: Callable[..., tuple[float, int, bool]]
    policy: Callable[..., int]
    rollout: Callable[..., float] | None = None


@callable_part
def uniform(random: Random) -> float:
    """Return the next number in [0, 1) of a stream, a vector of one uint64 (splitmix64)."""
    # Steele, Lea and Flood, Fast splittable pseudorandom number generators (2014): the whole state
    # is one uint64, which a kernel can be handed in an array.
    random[0] += np.uint64(0x9E3779B97F4A7C15)
    z = random[0]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    # The upper 53 bits are what a float64 holds.
    return np.float64(z >> np.uint64(11)) * (1.0 / 9007199254740992.0)  # 2 ** -53


# The kernels call these five; numba replaces each by the function registered for the type of data.


def native_draw(data: Any, belief: Any, state: State, random: Random) -> None:
    """Fill a state drawn from a belief."""
    raise NotImplementedError


def native_legal(data: Any, state: State) -> int:
    """Return the bit mask of the actions that may be taken."""
    raise NotImplementedError


def native_step(data: Any, state: State, action: int, random: Random) -> tuple[float, int, bool]:
    """Change a state by an action and return reward, key of the observation, whether it is over."""
    raise NotImplementedError


def native_policy(data: Any, state: State, random: Random) -> int:
    """Return the next action of a rollout."""
    raise NotImplementedError


def native_rollout(
    data: Any, state: State, level: int, depth: int, discount: float, random: Random
) -> float:
    """Return the discounted return of a rollout."""
    raise NotImplementedError


def _generic_rollout(
    data: Any, state: State, level: int, depth: int, discount: float, random: Random
) -> float:
    """Return the sum of ``discount ** i * reward_i`` of a rollout by policy and step in turn."""
    total, weight = 0.0, 1.0
    while level < depth:
        reward, _, over = native_step(data, state, native_policy(data, state, random), random)
        total += weight * reward
        if over:
            break
        weight *= discount
        level += 1
    return total


# numba compiles `native_step` once for each set of options of the functions that call it, so these
# are those of `grow`.
generic_rollout = uncached(_generic_rollout)


def register_native(data_class: type, functions: NativeFunctions) -> None:
    """Register the functions of a domain for its NamedTuple of data.

    Parameters
    ----------
    data_class
        The class of `NativeModel.data`.
    functions
        The domain's functions.
    """

    def ours(data: Any) -> bool:
        named = isinstance(data, types.BaseNamedTuple)
        return named and getattr(data, "instance_class", None) is data_class

    def plain(function: Callable[..., Any]) -> Callable[..., Any]:
        return getattr(function, "py_func", function)  # of one that is compiled already

    draw, legal, step, policy = (plain(function) for function in functions[:4])
    rollout = plain(functions.rollout or _generic_rollout)

    # numba calls each of these with types; what is returned is compiled in place of the call.

    @_overload(native_draw)
    def _(data: Any, belief: Any, state: Any, random: Any) -> Any:  # noqa: ARG001
        return draw if ours(data) else None

    @_overload(native_legal)
    def _(data: Any, state: Any) -> Any:  # noqa: ARG001
        return legal if ours(data) else None

    @_overload(native_step)
    def _(data: Any, state: Any, action: Any, random: Any) -> Any:  # noqa: ARG001
        return step if ours(data) else None

    @_overload(native_policy)
    def _(data: Any, state: Any, random: Any) -> Any:  # noqa: ARG001
        return policy if ours(data) else None

    @_overload(native_rollout)
    def _(data: Any, state: Any, level: Any, depth: Any, discount: Any, random: Any) -> Any:  # noqa: ARG001
        return rollout if ours(data) else None


def _overload(stub: Callable[..., Any]) -> Callable[[T], T]:
    untyped: Any = overload
    typed: Callable[[T], T] = untyped(stub, strict=False, jit_options=PART_OPTIONS)
    return typed
