"""How far a sweep that is being worked on has come, and how fast it goes."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from dataclasses import dataclass, field

WINDOW = 32  # commits over which the rate is taken


@dataclass(eq=False)
class Progress:
    """Fed with every commit; whoever watches is woken by it."""

    _marks: deque[tuple[float, int]] = field(default_factory=lambda: deque(maxlen=WINDOW))
    _pulse: asyncio.Event = field(default_factory=asyncio.Event)

    def advanced(self, done: int) -> None:
        """So many items are in the store now."""
        self._marks.append((time.monotonic(), done))
        self.woken()

    def woken(self) -> None:
        """Wake whoever watches."""
        pulse, self._pulse = self._pulse, asyncio.Event()
        pulse.set()

    @property
    def pulse(self) -> asyncio.Event:
        """Set as soon as anything happens from now on."""
        return self._pulse

    @property
    def rate_per_s(self) -> float | None:
        """Items a second over the last commits; None until there are two."""
        if len(self._marks) < 2:
            return None
        (since, had), (until, has) = self._marks[0], self._marks[-1]
        return (has - had) / (until - since) if until > since else None
