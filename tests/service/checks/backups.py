"""A backup taken while designs and sweeps are under way, restored elsewhere: byte for byte.

    python -m tests.service.checks.backups --from sqlite --to postgresql

A service with the fake core answers questions; meanwhile `camwright admin backup` is run, and what
was finished before it began is remembered. The backup is restored into an empty database, and a
second service on that must answer each of those questions with the same bytes and the same ETag,
finish what was under way in it, and `verify` must find nothing. The exit code is 1 otherwise.
"""

from __future__ import annotations

import argparse
import random
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import ExitStack
from pathlib import Path

import httpx2

from tests.service.checks.asking import Asking, FakeWork
from tests.service.checks.stores import opened
from tests.service.killing import ROOT, answering, free_port, service

SETTLED_S = 120.0  # until what is not answered counts as stuck


def admin(*words: str) -> None:
    """Run `camwright admin`."""
    subprocess.run([sys.executable, "-m", "service.cli", "admin", *words], cwd=ROOT, check=True)


def main() -> int:
    """0 where all is as it was."""
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("from", "to"):
        parser.add_argument(f"--{name}", choices=("sqlite", "postgresql"), default="sqlite")
    for name, default in (("singles", 60), ("sweeps", 2), ("items", 200), ("over", 15)):
        parser.add_argument(f"--{name}", type=int, default=default)
    chosen = vars(parser.parse_args())
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        here = stack.enter_context(opened(chosen["from"]))
        there = stack.enter_context(opened(chosen["to"]))
        ports = [free_port(), free_port()]
        clients = [
            stack.enter_context(httpx2.Client(base_url=f"http://127.0.0.1:{port}", timeout=60.0))
            for port in ports
        ]
        first = service(folder, ports[0], CAMWRIGHT_DATABASE_URL=here.url)
        stack.callback(first.stop)
        answering(clients[0])
        asking = Asking(ports[:1], random.Random(1), FakeWork())
        stack.callback(asking.close)
        posting = [
            threading.Thread(target=asking.post_sweeps, args=(chosen["sweeps"], chosen["items"])),
            threading.Thread(target=asking.post_designs, args=(chosen["singles"], chosen["over"])),
        ]
        for thread in posting:
            thread.start()
        kept: dict[str, httpx2.Response] = {}
        while len(kept) < chosen["singles"] // 3:
            for where in list(asking.seen.designs):
                answer = clients[0].get(where)
                if answer.status_code == 200:
                    kept[where] = answer
            time.sleep(0.1)
        sweeps = {where: clients[0].get(where).json()["counts"]["done"]
                  for where in list(asking.seen.sweeps)}  # fmt: skip
        known = list(asking.seen.designs)
        file = folder / "kept.db"
        admin("backup", str(file), "--database-url", here.url)
        under_way = sum(thread.is_alive() for thread in posting)
        for thread in posting:
            thread.join()
        admin("restore", str(file), "--database-url", there.url)
        admin("verify", "--database-url", there.url)
        (folder / "second").mkdir()
        second = service(folder / "second", ports[1], CAMWRIGHT_DATABASE_URL=there.url)
        stack.callback(second.stop)
        answering(clients[1])
        other = [where for where, was in kept.items()
                 if (now := clients[1].get(where)).content != was.content
                 or now.headers["etag"] != was.headers["etag"]]  # fmt: skip
        fewer = [where for where, done in sweeps.items()
                 if clients[1].get(where).json()["counts"]["done"] < done]  # fmt: skip
        until, waiting = time.monotonic() + SETTLED_S, set(known)
        while waiting and time.monotonic() < until:
            waiting = {each for each in waiting if clients[1].get(each).status_code != 200}
            time.sleep(0.5)
        running = set(sweeps)
        while running and time.monotonic() < until:
            running = {each for each in running
                       if clients[1].get(each).json()["state"] != "successful"}  # fmt: skip
            time.sleep(0.5)
        admin("verify", "--database-url", there.url)
        print(f"from {chosen['from']} to {chosen['to']}, {under_way} clients still asking: "
              f"{len(kept)} answers compared, {len(other)} differ; {len(known)} questions known, "
              f"{len(waiting)} without an answer; sweeps {sweeps}: {len(fewer)} went back, "
              f"{len(running)} unfinished")  # fmt: skip
        return min(len(other) + len(fewer) + len(waiting) + len(running), 1)


if __name__ == "__main__":
    sys.exit(main())
