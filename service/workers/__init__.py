"""Worker processes: the engine that the service sends tasks to, and the tasks.

Bytes of a question go in, bytes of an answer come out. Dask is used in this room only. Begin with
`tasks.py`, then `engine.py`.
"""
