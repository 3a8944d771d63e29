"""The listening socket, opened first, so that a port in use is reported at once."""

from __future__ import annotations

import errno
import socket
import sys

from service.settings import Settings


def listening_socket(settings: Settings) -> socket.socket:
    """A socket that listens at the configured address; one sentence and exit 1 where it cannot."""
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    # asyncio disables Nagle's algorithm only on sockets whose protocol is given.
    listener = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((settings.host, settings.port))
        listener.listen(256)
    except OSError as error:
        listener.close()
        in_use = error.errno == errno.EADDRINUSE
        reason = "is in use by another program" if in_use else f"cannot be used ({error.strerror})"
        sys.exit(
            f"Port {settings.port} on {settings.host} {reason}: choose another one with "
            "--port or CAMWRIGHT_PORT."
        )
    listener.set_inheritable(True)
    return listener
