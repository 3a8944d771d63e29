"""Imported by the process that workers are forked from, and by no other.

The import changes how the process handles signals and collects garbage, and its forks inherit that.
Ctrl-C in a terminal reaches them all, but the service stops them in order. Frozen objects are not
visited by a worker's garbage collections, so that their memory remains shared.
"""

import gc
import signal

signal.signal(signal.SIGINT, signal.SIG_IGN)
gc.disable()

import service.workers.local  # noqa: E402
import service.workers.tasks  # noqa: E402, F401
import synthesis.pipeline.synthesise  # noqa: E402, F401

gc.freeze()
gc.enable()
