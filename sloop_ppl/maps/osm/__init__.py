"""OpenStreetMap: read its files into maps."""
