"""`python -m service.workers.scheduler`: Dask's scheduler, over TLS, set as the engine needs it.

Options are those of `dask scheduler`. The certificate of the cluster is made where there is none
yet: one file with key and certificate, signed by itself, which scheduler, workers and services
share (`distributed.comm.tls` of Dask's settings names it). Who does not have it runs nothing.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import dask
from distributed.cli import dask_scheduler

from service.workers.remote import CONFIGURATION

DAYS = 3650  # that the certificate holds [d]: it lives as long as the cluster's volume


def make_certificate(file: Path) -> None:
    """Write a new key and its certificate, readable for this account alone, unless it is there."""
    if file.exists():
        return
    new = file.with_suffix(".new")
    new.touch(mode=0o600)
    new.chmod(0o600)
    command = [
        "openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256",
        "-nodes", "-days", str(DAYS), "-subj", "/CN=camwright-cluster", "-keyout", "-", "-out", "-",
    ]  # fmt: skip
    made = subprocess.run(command, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    new.write_bytes(made.stdout)
    new.replace(file)


def main() -> None:
    """Make the certificate if need be, and run the scheduler."""
    file = dask.config.get("distributed.comm.tls.ca-file")
    if file is None:
        sys.exit(
            "The certificate of the cluster has no place: name a file in "
            "DASK_DISTRIBUTED__COMM__TLS__CA_FILE, see docs/deployment.md."
        )
    make_certificate(Path(file))
    run: Any = dask_scheduler.main
    with dask.config.set(CONFIGURATION):
        run(["--protocol=tls", *sys.argv[1:]])


if __name__ == "__main__":
    main()
