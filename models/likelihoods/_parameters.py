"""Declare the numbers of a likelihood that may be tuned: unit, range and prior, in one place."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, is_dataclass, replace
from typing import Any, TypeVar

import torch
from torch import Tensor

from sloop_ppl.errors import InputError, UnknownName

__all__ = [
    "Parameter",
    "clamped",
    "parameters_of",
    "share_parameter",
    "width_parameter",
    "with_values",
]

T = TypeVar("T")


@dataclass(frozen=True)
class Parameter:
    """One number of a likelihood that may be tuned.

    A likelihood is a frozen dataclass with ``parameters: ClassVar[tuple[Parameter, ...]]``; each
    names a field whose value is a float or, while it is learnt, a tensor without dimensions.

    Parameters
    ----------
    name
        The field it is the value of.
    unit
        ``"m"``, ``"1"`` and so on.
    low, high
        Range, low < high; the value lies strictly between them.
    prior_median
        Median of the prior, within the range.
    prior_scale
        How far the prior spreads, > 0: the standard deviation of the log of the value when `low` is
        0 and `high` infinite, else of its log odds within the range.
    meaning
        What it does, in words.
    by_default
        False for a number that is learnt only when it is asked for by name.

    Raises
    ------
    InputError
        When the range is empty, the median outside it, or the scale not positive.
    """

    name: str
    unit: str
    low: float
    high: float
    prior_median: float
    prior_scale: float
    meaning: str
    by_default: bool = True

    def __post_init__(self) -> None:
        if not self.low < self.prior_median < self.high:
            raise InputError(
                f"Parameter '{self.name}' has median {self.prior_median:g}; expected it between "
                f"{self.low:g} and {self.high:g}"
            )
        if not 0 < self.prior_scale < math.inf:
            raise InputError(
                f"Parameter '{self.name}' has prior_scale {self.prior_scale:g}; expected > 0"
            )

    def checked(self, value: Any) -> float:
        """Return a value as a float.

        Raises
        ------
        InputError
            When it is no number strictly between `low` and `high`.
        """
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(
                f"Parameter '{self.name}' is {value!r}; expected a number of unit {self.unit}"
            )
        if not self.low < value < self.high:
            raise InputError(
                f"Parameter '{self.name}' is {value:g} {self.unit}; expected more than "
                f"{self.low:g} and less than {self.high:g}"
            )
        return float(value)


def width_parameter(name: str, median_m: float, meaning: str) -> Parameter:
    """Return a width in metres: any positive number, likely within a factor of e^.35 = 1.4.

    With a factor of 2 cities that a fit had not seen scored worse (`docs/models.md`).
    """
    return Parameter(name, "m", 0.0, math.inf, median_m, 0.35, meaning)


def share_parameter(name: str, median: float, meaning: str) -> Parameter:
    """Return a share or probability between 0 and 1."""
    return Parameter(name, "1", 0.0, 1.0, median, 1.0, meaning)


def parameters_of(likelihood: object) -> tuple[Parameter, ...]:
    """Return what a likelihood declares; none when it declares nothing."""
    declared: Iterable[Parameter] = getattr(likelihood, "parameters", ())
    return tuple(declared)


def with_values(likelihood: T, values: Mapping[str, float | Tensor]) -> T:
    """Return a likelihood with some of its parameters changed.

    Parameters
    ----------
    likelihood
        A frozen dataclass that declares `parameters`; one that wraps another has a method
        ``with_values`` of its own.
    values
        Parameter name -> value; a tensor is taken as it is, a number is checked.

    Raises
    ------
    UnknownName
        For a parameter it does not declare.
    InputError
        For a number out of its range.
    """
    if not values:
        return likelihood
    declared = {parameter.name: parameter for parameter in parameters_of(likelihood)}
    kind = getattr(likelihood, "name", type(likelihood).__name__)
    for name in values:
        if name not in declared:
            raise UnknownName(f"parameter of {kind}", name, declared)
    own = getattr(likelihood, "with_values", None)
    if own is not None:
        wrapped: T = own(values)
        return wrapped
    if not is_dataclass(likelihood) or isinstance(likelihood, type):
        raise InputError(
            f"{kind} declares parameters but is no dataclass; make it a frozen dataclass whose "
            "fields they are"
        )
    changed = {
        name: value if isinstance(value, Tensor) else declared[name].checked(value)
        for name, value in values.items()
    }
    new: T = replace(likelihood, **changed)
    return new


def clamped(value: float, low: float | Tensor, high: float | Tensor) -> Any:
    """Return a number kept between two others, any of which may be a tensor."""
    if isinstance(low, Tensor) or isinstance(high, Tensor):
        floor = torch.as_tensor(low, dtype=torch.float64)
        ceiling = torch.as_tensor(high, dtype=torch.float64)
        return torch.minimum(ceiling, torch.clamp_min(floor, value))
    return min(high, max(low, value))
