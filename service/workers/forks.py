"""Where the processes of workers come from: forked off one that has imported the core.

On Linux: elsewhere system libraries are not safe to fork once they are loaded, and each worker
imports for itself.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
from multiprocessing import forkserver

FORKED = sys.platform == "linux"
METHOD = "forkserver" if FORKED else "spawn"
# As Dask sets them for its workers, which is too late where NumPy is there already: a thread of
# BLAS in the process that is forked would be lost in the fork.
ENVIRONMENT = {
    "MALLOC_TRIM_THRESHOLD_": "65536",
    "MKL_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "PYTHONHASHSEED": "6640",
}


def prepare() -> None:
    """Start the process that workers are forked from, if it is not there; it imports by itself.

    Asked for early, it does so while this process imports what it needs to answer.
    """
    if FORKED:
        for name, value in ENVIRONMENT.items():
            os.environ.setdefault(name, value)
        multiprocessing.set_forkserver_preload(["service.workers.prepared"])
        forkserver.ensure_running()
