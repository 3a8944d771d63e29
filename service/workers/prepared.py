"""What a worker holds before its first design; imported by the process that they are forked from.

There alone: the import changes how its process takes signals and collects garbage, which its forks
inherit. Ctrl-C in a terminal reaches them all and is the service's to obey. What is imported stays:
frozen, it is not looked through by a worker's collections, and so its memory remains shared.
"""

from __future__ import annotations

import gc
import signal

signal.signal(signal.SIGINT, signal.SIG_IGN)
gc.disable()

import service.workers.engine  # noqa: E402, F401
import synthesis.pipeline  # noqa: E402, F401

gc.freeze()
gc.enable()
