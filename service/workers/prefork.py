"""The process that workers are forked from: it has imported the core already.

On Linux only. Elsewhere system libraries are not safe to fork once they are loaded, and each worker
imports the core for itself.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
from multiprocessing import forkserver

FORKED = sys.platform == "linux"
METHOD = "forkserver" if FORKED else "spawn"
# Set before NumPy is loaded: a fork would lose a second thread of BLAS.
ENVIRONMENT = {
    "MALLOC_TRIM_THRESHOLD_": "65536",
    "MKL_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "PYTHONHASHSEED": "6640",
}


def start_fork_server() -> None:
    """Start the process that workers are forked from, unless it runs already.

    Called early: it imports the core while this process imports what it needs itself.
    """
    if FORKED:
        for name, value in ENVIRONMENT.items():
            os.environ.setdefault(name, value)
        multiprocessing.set_forkserver_preload(["service.workers.preload"])
        forkserver.ensure_running()
