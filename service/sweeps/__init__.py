"""Sweeps: what a worker does for them, what is kept of them, and who drives them."""
