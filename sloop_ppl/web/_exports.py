"""A posterior as a file to keep."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

from sloop_ppl.inference import Posterior
from sloop_ppl.web._refusal import Refusal

__all__ = ["export_posterior"]


def export_posterior(posterior: Posterior, kind: str) -> tuple[bytes, str, str]:
    """Return a posterior as a file.

    Parameters
    ----------
    posterior
        The posterior.
    kind
        ``png``, ``geojson`` or ``netcdf``.

    Returns
    -------
    tuple of bytes, str and str
        What it holds, its media type, and a name for it.

    Raises
    ------
    Refusal
        For another kind.
    """
    if kind == "png":
        from sloop_ppl.bridge import figure_of
        from sloop_ppl.plots import save_figure

        with tempfile.TemporaryDirectory(prefix="sloop-") as folder:
            path = Path(folder) / "belief.png"
            save_figure(figure_of(posterior), path)
            return path.read_bytes(), "image/png", "belief.png"
    if kind == "geojson":
        text = json.dumps(posterior.to_geojson(), ensure_ascii=False, allow_nan=False)
        return text.encode(), "application/geo+json", "belief.geojson"
    if kind == "netcdf":
        with tempfile.TemporaryDirectory(prefix="sloop-") as folder:
            path = Path(folder) / "posterior.nc"
            posterior.save(path)
            return path.read_bytes(), "application/x-netcdf", "posterior.nc"
    raise Refusal(404, f"No file of kind '{kind[:20]}'; expected png, geojson or netcdf")
