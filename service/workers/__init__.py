"""Worker processes: the engine that the service sends tasks to, and the tasks.

Bytes of a question go in, bytes of an answer come out (`tasks`). `engine` lets no more tasks run
than there are workers, cancels what overruns its time, and replaces workers that die; `cluster` is
Dask's local cluster with that replacement. Workers are forked from a process that has imported the
core (`prefork`, `preload`); so are `readers`, which read long bodies. Dask is used in this package
only. Begin with `tasks.py`, then `engine.py`.
"""
