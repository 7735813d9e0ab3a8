"""Imported before matplotlib; see :mod:`sloop_ppl._figure_backend`."""

from sloop_ppl._figure_backend import forget_missing_backend

forget_missing_backend()
