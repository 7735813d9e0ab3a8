"""Names of the candidates of a fit, without the cost of importing torch."""

from __future__ import annotations

__all__ = ["CANDIDATE_NAMES"]

CANDIDATE_NAMES = (
    "student-vonmises",
    "gaussian-clipped",
    "gaussian-cosine",
    "product-only",
    "with-four-components",
    "with-nearest-street",
)
"""Every model that `sloop eval fit` may choose, in the order in which they are listed."""
