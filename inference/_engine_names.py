"""Names of the engines, without the cost of importing torch."""

from __future__ import annotations

__all__ = ["ENGINE_NAMES"]

ENGINE_NAMES = ("exact", "enumerate", "importance", "nuts", "svi")
"""Every engine, in the order in which they are listed."""
