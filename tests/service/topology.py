"""docker-compose.yml without containers: its commands, settings and checks, on loopback ports."""

from __future__ import annotations

import json
import os
import re
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import yaml

from tests.service.killing import ROOT, Process, free_port
from tests.service.postgres import PASSWORD, program

COMPOSE: dict[str, Any] = yaml.safe_load((ROOT / "docker-compose.yml").read_text(encoding="utf-8"))
SERVICES: dict[str, Any] = COMPOSE["services"]
DOCKERFILE = (ROOT / "Dockerfile").read_text(encoding="utf-8")
SECRET = re.compile(r"\$\{POSTGRES_PASSWORD:\?[^}]*\}")
UNSET = re.compile(
    r"\$\{\w+:-([^${}]*)\}"
)  # a variable, and what stands for it where it is not set


def image_command() -> list[str]:
    """What the image runs where compose says nothing else."""
    (found,) = re.findall(r"^CMD (\[.*\])$", DOCKERFILE, re.M)
    command: list[str] = json.loads(found)
    return command


def image_check() -> list[str]:
    """The image's health check."""
    (found,) = re.findall(r"^HEALTHCHECK .*\\\n +CMD (\[.*\])$", DOCKERFILE, re.M)
    check: list[str] = json.loads(found)
    return check


def without_variables(words: str) -> str:
    """What Compose makes of words where only the password is set."""
    words, found = SECRET.sub(PASSWORD, words), 1
    while found:  # from the innermost on
        words, found = UNSET.subn(r"\1", words)
    return words


class Topology:
    """Where everything listens here, and so how the words of the compose file read here."""

    def __init__(self, folder: Path, database: int) -> None:
        self._folder, self._database, self.api, self._scheduler = (
            folder, database, free_port(), free_port(),
        )  # fmt: skip
        self._health = {"scheduler": free_port(), "worker": free_port()}

    def _here(self, words: str, service: str) -> str:
        replaced = {
            "@database:5432": f"@127.0.0.1:{self._database}",
            "scheduler:8786": f"127.0.0.1:{self._scheduler}",
            "--port=8786": f"--port={self._scheduler}",
            "0.0.0.0": "127.0.0.1",
            "=/tmp": f"={self._folder}",
            "/var/lib/camwright": str(self._folder),
            "127.0.0.1:8787": f"127.0.0.1:{self._health['scheduler']}",
            "127.0.0.1:8788": f"127.0.0.1:{self._health[service]}" if "worker" in service else "",
        }
        for there, here in replaced.items():
            words = words.replace(there, here)
        return without_variables(words)

    def started(self, service: str, name: str = "") -> Process:
        """A process of this service; of workers each has a name of its own."""
        self._health.setdefault(name or service, free_port())
        declared = SERVICES[service]
        command = [
            self._here(word, name or service) for word in declared.get("command", image_command())
        ]
        words = declared.get("environment", {}).items()
        environment = {key: self._here(value, service) for key, value in words}
        if service == "api":
            environment["CAMWRIGHT_PORT"] = str(self.api)
        module = {"python": [], "dask": ["-m", "dask"]}[command[0]]
        return Process(*module, *command[1:], **environment)

    def listens(self, service: str) -> bool:
        """Whether what answers the health check of this service is there."""
        try:
            socket.create_connection(("127.0.0.1", self._health[service])).close()
        except ConnectionRefusedError:
            return False
        return True

    def healthy(self, service: str, name: str = "") -> bool:
        """Run the health check that Docker would run in this service's container."""
        declared = SERVICES[service].get("healthcheck", {}).get("test", ["CMD", *image_check()])
        kind, *command = [self._here(word, name or service) for word in declared]
        assert kind == "CMD", f"{service}: {kind}"
        programs = {"python": sys.executable, "pg_isready": ""}
        command[0] = programs[command[0]] or program(command[0])
        environment = {
            **os.environ, "CAMWRIGHT_PORT": str(self.api),
            "PGHOST": "127.0.0.1", "PGPORT": str(self._database),
        }  # fmt: skip
        run = subprocess.run(
            command, env=environment, capture_output=True, timeout=180.0, check=False
        )
        return run.returncode == 0
