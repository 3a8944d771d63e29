"""The database: tables (`tables`), transactions (`store`), what is kept by id
(`answers`), and migrations between releases.

SQLite by default, PostgreSQL by URL. Begin with `store.py`.
"""
