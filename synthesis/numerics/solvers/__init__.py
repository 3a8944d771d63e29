"""Solver adapters, one a file, with one table of statuses each."""
