"""Answers by id in SQLite or PostgreSQL, and how the tables came to be what they are.

Sweeps and all that is kept by id are rows of the same database.
"""
