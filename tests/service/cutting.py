"""A connection to a service that breaks: what lies between them cuts the answers off."""

from __future__ import annotations

import contextlib
import socket
import threading
from urllib.parse import urlsplit


class Cutting:
    """Listens before a service; each answer of the first connections ends after so many bytes."""

    def __init__(self, url: str, cuts: list[int]) -> None:
        parts = urlsplit(url)
        self._service = (str(parts.hostname), int(parts.port or 80))
        self._cuts, self._lock = list(cuts), threading.Lock()
        self.requests: list[bytes] = []
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self._listening.getsockname()[1]}"
        self._threads = [threading.Thread(target=self._listen)]

    def __enter__(self) -> Cutting:
        self._threads[0].start()
        return self

    def __exit__(self, *_: object) -> None:
        self._listening.shutdown(socket.SHUT_RDWR)
        self._listening.close()
        for thread in self._threads:
            thread.join(10.0)
            assert not thread.is_alive()

    def _listen(self) -> None:
        while True:
            try:
                caller, _ = self._listening.accept()
            except OSError:
                return
            with self._lock:
                cut = self._cuts.pop(0) if self._cuts else -1
            thread = threading.Thread(target=self._passed_on, args=(caller, cut))
            self._threads.append(thread)
            thread.start()

    def _passed_on(self, caller: socket.socket, cut: int) -> None:
        """One request and its answer, up to ``cut`` bytes of it (-1: all)."""
        with caller, socket.create_connection(self._service) as service:
            head = b""
            while b"\r\n\r\n" not in head:
                found = caller.recv(65536)
                if not found:
                    return
                head += found
            self.requests.append(head)
            service.sendall(head.replace(b"\r\n\r\n", b"\r\nConnection: close\r\n\r\n", 1))
            with contextlib.suppress(OSError):
                while cut != 0 and (found := service.recv(cut if cut > 0 else 65536)):
                    caller.sendall(found)
                    cut -= len(found) if cut > 0 else 0
