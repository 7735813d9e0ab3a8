"""The paper's own figures, as far as they are known to us, beside which ours are set."""

from __future__ import annotations

from types import MappingProxyType

__all__ = ["NAMES", "SHOWN", "TABLE_TWO", "TABLE_TWO_TRIALS"]

NAMES = MappingProxyType(
    {"keyword": "keyword", "sloop": "SLOOP", "sloop-m2": "SLOOP (m=2)", "sloop-m4": "SLOOP (m=4)"}
)
"""Model -> what the paper calls it."""

SHOWN = ("keyword", "sloop", "sloop-m4", "bayes")
"""The models of Tables I and II."""

TABLE_TWO = MappingProxyType(
    {
        "keyword": (234.0, 179.0, 27.0),
        "sloop": (321.0, 264.0, 115.0),
        "sloop-m4": (289.0, 286.0, 215.0),
    }
)
"""Model -> mean discounted reward with 1, 2 and 3 relations, range 3, annotated relations.

Source: SLOOP (Zheng et al., RO-MAN 2021), Table II; five cities, other maps and starts than ours.
"""

TABLE_TWO_TRIALS = (100, 83, 14)
"""Trials behind each column of `TABLE_TWO`."""
