"""How far a running sweep has come, and how fast it goes."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from dataclasses import dataclass, field

WINDOW = 32  # commits over which the rate is taken


@dataclass(eq=False)
class Progress:
    """Updated with every commit; notifies those who wait for a change."""

    _commits: deque[tuple[float, int]] = field(default_factory=lambda: deque(maxlen=WINDOW))
    _change: asyncio.Event = field(default_factory=asyncio.Event)

    def update(self, done: int) -> None:
        """Note how many items are in the store now."""
        self._commits.append((time.monotonic(), done))
        self.notify()

    def notify(self) -> None:
        """Wake those who wait for a change."""
        change, self._change = self._change, asyncio.Event()
        change.set()

    @property
    def next_change(self) -> asyncio.Event:
        """Set at the next change."""
        return self._change

    @property
    def rate_per_s(self) -> float | None:
        """Items a second over the last commits; None until there are two."""
        if len(self._commits) < 2:
            return None
        (start, first), (end, last) = self._commits[0], self._commits[-1]
        return (last - first) / (end - start) if end > start else None
