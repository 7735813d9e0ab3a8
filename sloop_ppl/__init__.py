"""Turn what a person says about where something is into a belief over a city map, and search it."""

__version__ = "0.1.0"
