"""Worker processes: the engine that the service sends tasks to, and the tasks.

Bytes of a question go in, bytes of an answer come out (`tasks`). `engine` lets no more tasks run
than there are workers and cancels what overruns its time. The workers are `local`, at the ends of
pipes and forked from a process that has imported the core (`prefork`, `preload`), or `remote`, of a
Dask `scheduler`; `readers`, which read long bodies, are forked likewise. Dask is used in this
package only. Begin with `tasks.py`, then `engine.py`.
"""
