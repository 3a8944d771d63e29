"""Which items of a sweep are sent to the workers next, and how many at once."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Collection, Mapping, Sequence

CHUNK_S = 0.4  # work in a chunk: long beside sending it, short beside a second
MOST = 50
CHAIN = 8  # items of a sweep with warm starts that begin where the one before has ended
STRIKES = 3  # workers that an item may take with it, the last two alone with it


class Chunks:
    """The items still to be done: never in memory, but for those that came back.

    A chunk takes as many items as fit into ``CHUNK_S`` by what the last ones took, fewer at the
    end so that no worker is idle while another has a whole chunk left. Items whose worker died are
    sent alone from then on, so that only the one that kills is blamed.

    With warm starts a chunk is a chain of ``chain`` neighbours, always the same ones: of a chain
    that was interrupted, those that are done are worked on once more, for the others to begin at.
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
        self._todo, self._done = bytearray(b"\1") * size, bytearray(size)
        self._strikes = Counter(strikes)
        suspects = sorted(set(strikes) - set(done))
        for number in (*done, *suspects):
            self._todo[number] = 0
        for number in done:
            self._done[number] = 1
        self._next, self.left = 0, size - len(done)
        self._back: deque[list[int]] = deque([number] for number in suspects)
        self._seconds: float | None = None
        self._largest = 1

    def take(self) -> list[int]:
        """The next chunk; empty where nothing is left to send."""
        chunk = self._back.popleft() if self._back else self._new()
        self.left -= len(self.undone(chunk))
        return chunk

    def _new(self) -> list[int]:
        return self._next_chain() if self._chain > 1 else self._from_the_rest(self._wanted())

    def undone(self, numbers: Sequence[int]) -> list[int]:
        """Those of them that are not done."""
        return [number for number in numbers if not self._done[number]]

    def _next_chain(self) -> list[int]:
        """From the chain's first item to the last that is left; those sent alone left out."""
        self._next = self._todo.find(1, max(self._next, 0))
        if self._next < 0:
            self._next = self._size
            return []
        first = self._next - self._next % self._chain
        end = min(first + self._chain, self._size)
        last = self._todo.rfind(1, first, end)
        chunk = [n for n in range(first, last + 1) if self._todo[n] or self._done[n]]
        for number in chunk:
            self._todo[number] = 0
        self._next = end
        return chunk

    def _wanted(self) -> int:
        if self._seconds is None:
            return 1
        fair = math.ceil(self.left / (2 * self.workers))
        self._largest = min(2 * self._largest, MOST)
        return max(1, min(int(CHUNK_S / max(self._seconds, 1e-6)), self._largest, fair))

    def _from_the_rest(self, most: int) -> list[int]:
        chunk: list[int] = []
        while self._next >= 0 and len(chunk) < most:
            self._next = self._todo.find(1, self._next)
            if self._next >= 0:
                chunk.append(self._next)
                self._next += 1
        return chunk

    def finish(self, number: int) -> bool:
        """Note an item as done; whether it was not before."""
        new = not self._done[number]
        self._done[number] = 1
        return new

    def took(self, seconds: float) -> None:
        """An item took that long."""
        known = seconds if self._seconds is None else self._seconds
        self._seconds = 0.8 * known + 0.2 * seconds

    def back(self, numbers: list[int]) -> None:
        """These were not begun."""
        if numbers:
            self._back.append(numbers)
            self.left += len(self.undone(numbers))

    def struck(self, numbers: list[int]) -> dict[int, int]:
        """The worker at these died; their strikes now. They have to be sent back by the caller."""
        for number in numbers:
            alone = len(numbers) == 1
            self._strikes[number] = max(self._strikes[number] + alone, 1)
        return {number: self._strikes[number] for number in numbers}
