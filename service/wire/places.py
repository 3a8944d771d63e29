"""Places that clients hold while they are served, so many in all and so many of one address."""

from __future__ import annotations

from collections import Counter

from service.wire.errors import ProblemType

AGAIN = {"Retry-After": "5"}  # [s]: idle connections are closed by then


class Places:
    """Places for connections, or for something else that a client holds for a while.

    Args:
        what: they are for, in the plural. full: the type of problem where there is none.
        most: in all. each: of one address.
    """

    def __init__(self, what: str, full: ProblemType, most: int, each: int) -> None:
        self._what, self._full, self._most, self._each = what, full, most, each
        self._held, self._all = Counter[str](), 0

    def take(self, address: str) -> None:
        """Take a place; ServiceError where there is none."""
        own, held = self._held[address], self._all
        if held >= self._most:
            raise self._full(
                f"{held} {self._what} are open, as many as this server has. Try again shortly.",
                AGAIN,
            )
        if own >= self._each:
            raise self._full(
                f"{own} {self._what} from {address} are open, as many as one client may have. "
                "Close those that are not needed.", AGAIN,
            )  # fmt: skip
        self._held[address] += 1
        self._all += 1

    def leave(self, address: str) -> None:
        """Give a place back."""
        self._held[address] -= 1
        self._all -= 1
        if not self._held[address]:
            del self._held[address]
