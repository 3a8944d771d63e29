"""Which items of a sweep go to the workers next, and how many in a chunk."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Collection, Mapping, Sequence

CHUNK_S = 0.4  # work in a chunk [s]: long compared with sending it, short compared with a second
MAX_CHUNK = 50  # items: what is lost with a worker is done again
CHAIN = 8  # items of a sweep with warm starts that begin where the one before has ended


class Chunks:
    """The items of a sweep that are still to be sent, and those that are done: a flag each, a byte.

    A chunk has as many items as fit into ``CHUNK_S`` by what the last ones took, fewer at the end
    so that no worker is idle while another has a whole chunk left. Items whose worker died are sent
    alone from then on, so that only the one that kills workers is blamed.

    With warm starts a chunk is a chain of ``chain`` neighbours, always the same ones: of a chain
    that was interrupted, those that are done are solved once more, for the others to begin at.
    """

    def __init__(
        self,
        size: int,
        done: Collection[int],
        workers: int,
        strikes: Mapping[int, int],
        chain: int = 1,
    ) -> None:
        self._size, self.workers, self._chain = size, workers, chain
        self._unsent, self._done = bytearray(b"\1") * size, bytearray(size)
        self._strikes = Counter(strikes)
        suspects = sorted(set(strikes) - set(done))
        for number in (*done, *suspects):
            self._unsent[number] = 0
        for number in done:
            self._done[number] = 1
        self._next, self.left = 0, size - len(done)
        self._returned: deque[list[int]] = deque([number] for number in suspects)
        self._seconds: float | None = None
        self._cap = 1

    def take(self) -> list[int]:
        """The next chunk; empty where nothing is left to send."""
        if self._returned:
            chunk = self._returned.popleft()
        else:
            chunk = self._next_chain() if self._chain > 1 else self._next_items(self._chunk_size())
        self.left -= len(self.unfinished(chunk))
        return chunk

    def unfinished(self, numbers: Sequence[int]) -> list[int]:
        """Those of them that are not done."""
        return [number for number in numbers if not self._done[number]]

    def _next_chain(self) -> list[int]:
        """From the chain's first item to the last that is left, without those sent alone."""
        self._next = self._unsent.find(1, self._next)
        if self._next < 0:
            self._next = self._size
            return []
        first = self._next - self._next % self._chain
        end = min(first + self._chain, self._size)
        last = self._unsent.rfind(1, first, end)
        chunk = [n for n in range(first, last + 1) if self._unsent[n] or self._done[n]]
        for number in chunk:
            self._unsent[number] = 0
        self._next = end
        return chunk

    def _chunk_size(self) -> int:
        if self._seconds is None:
            return 1
        # Half of a worker's share of what is left, so that all workers end at about the same time.
        fair = math.ceil(self.left / (2 * self.workers))
        # At most twice as many as last time: the first items may be quicker than those to come.
        self._cap = min(2 * self._cap, MAX_CHUNK)
        return max(1, min(int(CHUNK_S / max(self._seconds, 1e-6)), self._cap, fair))

    def _next_items(self, most: int) -> list[int]:
        chunk: list[int] = []
        while self._next >= 0 and len(chunk) < most:
            self._next = self._unsent.find(1, self._next)
            if self._next >= 0:
                chunk.append(self._next)
                self._next += 1
        return chunk

    def finish(self, number: int) -> bool:
        """Note an item as done; whether it was not done before."""
        new = not self._done[number]
        self._done[number] = 1
        return new

    def record_time(self, seconds: float) -> None:
        """Note the time that an item took, in a moving average."""
        known = seconds if self._seconds is None else self._seconds
        self._seconds = 0.8 * known + 0.2 * seconds

    def put_back(self, numbers: list[int]) -> None:
        """Return items that were not begun."""
        if numbers:
            self._returned.append(numbers)
            self.left += len(self.unfinished(numbers))

    def add_strikes(self, numbers: list[int]) -> dict[int, int]:
        """Note that the worker at these items died; their strikes now.

        Only an item that was alone is certain to have caused it; of several each has one strike.
        """
        for number in numbers:
            alone = len(numbers) == 1
            self._strikes[number] = max(self._strikes[number] + alone, 1)
        return {number: self._strikes[number] for number in numbers}
