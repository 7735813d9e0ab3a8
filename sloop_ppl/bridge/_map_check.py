"""Refuse a posterior of another map."""

from __future__ import annotations

from sloop_ppl.errors import InputError
from sloop_ppl.inference import Posterior
from sloop_ppl.maps import CityMap

__all__ = ["check_map"]


def check_map(posterior: Posterior, city: CityMap) -> None:
    """Refuse a posterior that was made on another map."""
    if posterior.city.digest != city.digest:
        raise InputError(
            f"The posterior was made on another map ('{posterior.city.name}', "
            f"{posterior.city.grid.shape} cells); expected '{city.name}' as it is now; infer it "
            "again on this map"
        )
