"""Say what was found, what was expected and what to do: the errors a user can cause."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence

__all__ = [
    "BeliefCollapse",
    "DescriptionError",
    "InputError",
    "MapError",
    "NoRelationFound",
    "OutputError",
    "OutsideMap",
    "ProgramError",
    "SloopError",
    "UnknownName",
    "nearest_names",
    "on_one_line",
]


class SloopError(Exception):
    """Base of every error that a user can cause; the command line prints it as one line."""


class InputError(SloopError, ValueError):
    """An argument has a value that cannot be used."""


_LISTED = 50
"""Names that an error lists; of more it says how many there are."""


class UnknownName(InputError):
    """A name is not in the registry or map it was looked up in.

    Attributes
    ----------
    kind
        What was looked up, such as ``"map"`` or ``"model"``.
    found
        The name that was given.
    expected
        The names that would have been accepted.
    """

    def __init__(self, kind: str, found: str, expected: Iterable[str], hint: str = "") -> None:
        self.kind, self.found, self.expected = kind, found, tuple(expected)
        near = nearest_names(found, self.expected, count=1)
        listed = f"one of {', '.join(self.expected) or 'nothing'}"
        guess = f"; did you mean '{near[0]}'?" if near else ""
        if len(self.expected) > _LISTED:
            listed = f"one of {len(self.expected)} names"
            guess = guess or f", such as {', '.join(sorted(self.expected)[:3])}"
        named = kind[:1].upper() + kind[1:]
        shown = on_one_line(found)
        super().__init__(f"{named} '{shown}' is unknown; expected {listed}{guess}{hint}")


class MapError(InputError):
    """A map file, or a part of one, does not follow the format.

    Attributes
    ----------
    feature
        Id or index of the feature at fault, if one is.
    field
        Name of the field at fault, if one is.
    """

    def __init__(self, message: str, *, feature: str | None = None, field: str | None = None):
        self.feature, self.field = feature, field
        super().__init__(message)


class OutsideMap(InputError):
    """A place lies outside the map's extent."""


class DescriptionError(InputError):
    """A description, a target or a relation is not well formed."""


class NoRelationFound(DescriptionError):
    """A sentence says nothing that could be turned into a relation."""


class BeliefCollapse(InputError):
    """Evidence gives probability zero to everything that was believed possible.

    Attributes
    ----------
    prior
        The belief before the evidence.
    observation
        What was observed or said.
    culprits
        What excludes cells, in words; empty when it was not looked for.
    """

    def __init__(
        self,
        message: str,
        *,
        prior: object = None,
        observation: object = None,
        culprits: Sequence[str] = (),
    ) -> None:
        self.prior, self.observation, self.culprits = prior, observation, tuple(culprits)
        super().__init__(message)


class ProgramError(InputError):
    """A user's mistake that shows only while the generative program runs; its cause is the mistake.

    Its message is one line, whatever is written behind it: Pyro appends a table of shapes to what
    passes through its traces. Engines raise the mistake itself.
    """

    def __init__(self, message: object) -> None:
        super().__init__(str(message).partition("\n")[0])


class OutputError(SloopError, OSError):
    """An output path cannot be written."""


def on_one_line(text: str, most: int = 200) -> str:
    r"""Return a text that others wrote for a message: on one line, the end left out if long.

    Examples
    --------
    >>> on_one_line("two\nlines")
    'two lines'
    """
    line = " ".join(text.split()) if "\n" in text or "\r" in text else text
    return line if len(line) <= most else f"{line[: most - 3]}..."


def nearest_names(name: str, known: Sequence[str], count: int = 3) -> list[str]:
    """Return up to `count` of the `known` names that look most like `name`, best first."""
    folded = {k.casefold(): k for k in reversed(known)}
    return [
        folded[m] for m in difflib.get_close_matches(name.casefold(), folded, n=count, cutoff=0.5)
    ]
