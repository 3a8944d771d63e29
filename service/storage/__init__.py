"""The database: tables (`tables`), what is kept by id (`store`), and migrations between releases.

SQLite by default, PostgreSQL by URL. Begin with `store.py`.
"""
