"""Names of models and of what they are made of, without the cost of importing torch."""

from __future__ import annotations

__all__ = ["CELL_PRIOR_NAMES", "FRAME_PREDICTOR_NAMES", "LIKELIHOOD_NAMES", "PRESET_NAMES"]

PRESET_NAMES = (
    "uniform",
    "keyword",
    "informed",
    "sloop",
    "sloop-m2",
    "sloop-m4",
    "bayes",
    "referent-gaussian",
)
"""Every model, in the order in which they are listed."""

LIKELIHOOD_NAMES = (
    "attention-vector-sum",
    "box",
    "gaussian-displacement",
    "gaussian-clipped",
    "gaussian-cosine",
    "neural",
    "student-vonmises",
)
"""Every relation likelihood."""

FRAME_PREDICTOR_NAMES = ("nearest-street", "address", "random", "ego-ctx", "ctx", "ego")
"""Every frame predictor."""

CELL_PRIOR_NAMES = ("uniform", "streets", "off-streets")
"""Every prior over cells."""
