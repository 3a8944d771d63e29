"""The numerical core of Camwright: an ordinary library, importable without a server."""
