"""The database: answers by id, in SQLite or PostgreSQL, and the migrations of its tables.

Questions and answers go in and come out as rows (`store.AnswerRow`). Sweeps keep their rows in the
same database (`sweeps/store.py`). Begin with `store.py`.
"""
