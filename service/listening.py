"""The socket that the service listens on: light, so that a port that is taken is told at once."""

from __future__ import annotations

import errno
import socket
import sys

from service.settings import Settings


def bound(settings: Settings) -> socket.socket:
    """A socket at the address asked for; one sentence and exit 1 where it is not to be had."""
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    # The protocol is named because asyncio switches Nagle's algorithm off only where it is.
    listening = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((settings.host, settings.port))
        listening.listen(256)
    except OSError as error:
        taken = error.errno == errno.EADDRINUSE
        reason = "is taken by another program" if taken else f"cannot be used ({error.strerror})"
        sys.exit(
            f"Port {settings.port} on {settings.host} {reason}: choose another one with "
            "--port or CAMWRIGHT_PORT."
        )
    listening.set_inheritable(True)
    return listening
