"""The machine in motion: as SVG, as a page, as data."""
