"""Clients that post until they are acknowledged and remember that, and the judge of what became."""

from __future__ import annotations

import json
import random
import subprocess
import sys
import threading
import time
import uuid
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import httpx2

from tests.service.checks.stores import Store
from tests.service.killing import ROOT
from tests.service.specs import spec
from tests.service.sweeps.test_sweeps import sweep_of

ENDED = ("successful", "failed", "dismissed")
AGAIN = (413, 429, 503)  # 413: the service stood still while it read the body
SHOWN = 5  # of each kind of fault, as examples
WAITING = 0.3  # share of the designs whose answer is waited for
SINGLE_S = (0.05, 0.6)  # that the fake core takes for a design


class FakeWork:
    """What is asked where the core is the fake one: the name says how long it takes."""

    def design(self, draw: random.Random) -> dict[str, Any]:
        return spec(f"sleep {draw.uniform(*SINGLE_S):.6f}")

    def sweep(self, number: int, items: int) -> dict[str, Any]:
        return sweep_of([f"sleep {0.1 + 1e-4 * number + 1e-6 * i:.6f}" for i in range(items)])


class RealWork:
    """What is asked of the real core: cams with another limit each, some with a law to be found."""

    def design(self, draw: random.Random) -> dict[str, Any]:
        body = spec("real")
        body["limits"][0]["rise_deg"] = round(draw.uniform(26.0, 44.0), 6)
        if draw.random() < 0.2:
            del body["program"][0]["law"]
        return body

    def sweep(self, number: int, items: int) -> dict[str, Any]:
        axis = {"kind": "range", "pointer": "/limits/0/rise_deg", "start": 30.0 + 1e-3 * number,
                "stop": 40.0, "count": items}  # fmt: skip
        return {"name": f"real {number}", "base": spec("swept"), "axes": [axis]}


@dataclass
class Seen:
    """What was acknowledged, and what was seen of it while faults went on."""

    designs: dict[str, dict[str, Any]] = field(default_factory=dict)  # spec, by address
    keys: dict[str, str] = field(default_factory=dict)  # Idempotency-Key, by address
    answers: dict[str, bytes] = field(default_factory=dict)  # by address, as first read
    cut: list[dict[str, Any]] = field(default_factory=list)  # specs whose answers were cut off
    sweeps: dict[str, int] = field(default_factory=dict)  # items, by address
    done: dict[str, int] = field(default_factory=dict)  # most that a sweep had done, by address
    wrong: list[str] = field(default_factory=list)  # what must not be
    statuses: Counter[int | str] = field(default_factory=Counter)


class Asking:
    """Clients of services that share a store."""

    def __init__(self, ports: list[int], draw: random.Random, work: FakeWork | RealWork) -> None:
        self.ports, self._draw, self.work = ports, draw, work
        self.seen, self.over = Seen(), threading.Event()
        self._client = httpx2.Client(timeout=60.0)  # one for all: each reads its certificates
        self.close = self._client.close

    def ask(self, method: str, path: str, **more: Any) -> httpx2.Response:
        """Ask one of the services, until one answers otherwise than that it cannot now."""
        while True:
            try:
                url = f"http://127.0.0.1:{self._draw.choice(self.ports)}{path}"
                answer = self._client.request(method, url, **more)
            except httpx2.TransportError as error:
                self.seen.statuses[type(error).__name__] += 1
            else:
                self.seen.statuses[answer.status_code] += 1
                if answer.status_code == 503 and "retry-after" not in answer.headers:
                    self.seen.wrong.append(f"503 without Retry-After: {answer.text[:300]}")
                if answer.status_code == 500:
                    self.seen.wrong.append(f"{method} {path}: {answer.text[:300]}")
                failed = answer.status_code == 503 and "has failed" in answer.text
                if answer.status_code not in AGAIN or failed:
                    return answer
            time.sleep(0.2)

    def post_designs(self, count: int, until_s: float) -> None:
        """So many, evenly over this time, each with an Idempotency-Key; some wait for the answer.

        Who waits has no acknowledgement until he has the answer: he asks until he has one.
        """
        for _ in range(count):
            body, key = self.work.design(self._draw), uuid.uuid4().hex
            answer = self._post(body, key, waits=self._draw.random() < WAITING)
            if answer.status_code not in (200, 202):
                self.seen.wrong.append(f"POST /v1/designs: {answer.text[:300]}")
                continue
            where = answer.headers.get("location") or answer.headers["content-location"]
            self.seen.designs[where], self.seen.keys[where] = body, key
            if answer.status_code == 200:
                self.seen.answers[where] = answer.content
            else:
                time.sleep(until_s / count)

    def _post(self, body: dict[str, Any], key: str, waits: bool = False) -> httpx2.Response:
        headers = {"Idempotency-Key": key, **({} if waits else {"Prefer": "respond-async"})}
        return self.ask("POST", "/v1/designs", json=body, headers=headers)

    def post_sweeps(self, count: int, items: int) -> None:
        """So many sweeps of so many items."""
        for number in range(count):
            answer = self.ask("POST", "/v1/sweeps", json=self.work.sweep(number, items))
            if answer.status_code not in (200, 201, 202):
                self.seen.wrong.append(f"POST /v1/sweeps: {answer.text[:300]}")
                continue
            self.seen.sweeps[json.loads(answer.content)["links"]["self"]] = items

    def watch(self) -> None:
        """Read answers meanwhile: what was seen once must stay, and counts must not go back."""
        while not self.over.wait(0.5):
            if waiting := [each for each in self.seen.designs if each not in self.seen.answers]:
                self.read(random.choice(waiting))
            for where in list(self.seen.sweeps):
                answer = self.ask("GET", where)
                if answer.status_code == 404:
                    self.seen.wrong.append(f"{where} is gone")
                    continue
                count = answer.json()["counts"]["done"]
                if count < self.seen.done.get(where, 0):
                    self.seen.wrong.append(f"{where} had {self.seen.done[where]}, has {count}")
                self.seen.done[where] = count

    def read(self, where: str) -> str:
        """Ask for a design: "done", "accepted", "lost", or what is said instead."""
        answer = self.ask("GET", where)
        if answer.status_code == 200:
            if self.seen.answers.setdefault(where, answer.content) != answer.content:
                self.seen.wrong.append(f"{where} is another answer than before")
            asked, got = self.seen.designs[where], answer.json()["spec"]
            if (asked["name"], asked["speed_rpm"]) != (got["name"], got["speed_rpm"]):
                self.seen.wrong.append(f"{where} is the answer to another question")
            return "done"
        return {202: "accepted", 404: "lost"}.get(answer.status_code, answer.text)

    def listed(self, path: str, name: str, field: str) -> list[Any]:
        """A field of all entries of a list, page by page."""
        found: list[Any] = []
        cursor: dict[str, str] = {}
        while True:
            page = self.ask("GET", path, params={"limit": "100", **cursor}).json()
            found += [each[field] for each in page[name]]
            if page["next"] is None:
                return found
            cursor = {"cursor": page["next"]}


def judge(asking: Asking, store: Store, settled_s: float) -> int:
    """Wait for all answers; print what is lost, doubled, stuck, failed and wrong; how many."""
    seen, lost, failed = asking.seen, set[str](), dict[str, str]()
    until, waiting = time.monotonic() + settled_s, {*seen.designs, *seen.sweeps}
    while waiting and time.monotonic() < until:
        for where in list(waiting):
            state = asking.read(where) if where in seen.designs else _state(asking, where)
            if state == "lost":
                lost.add(where)
            elif state not in ("done", "accepted"):
                failed[where] = state
            if state != "accepted":
                waiting.discard(where)
        time.sleep(0.5)
    doubled, missing, items = 0, 0, Counter[str]()
    # Lists, as their owner sees them: each answer once, and nothing that nobody has asked for.
    for body in seen.cut:  # whoever did not get his answer asks again
        answer = asking.ask("POST", "/v1/designs", json=body)
        if answer.status_code == 200:
            seen.designs[answer.headers["content-location"]] = body
        else:
            failed[body["name"]] = answer.text
    ids = asking.listed("/v1/designs", "items", "id")
    doubled += len(ids) - len(set(ids))
    asked = {where.rpartition("/")[2] for where in seen.designs}
    lost |= asked - set(ids)
    if more := set(ids) - asked:
        seen.wrong.append(f"designs that nobody has asked for: {sorted(more)}")
    for where, count in seen.sweeps.items():
        numbers = asking.listed(f"{where}/items", "items", "number")
        doubled += len(numbers) - len(set(numbers))
        missing += len(set(range(count)) - set(numbers))
        items.update(asking.listed(f"{where}/items", "items", "status"))
    for where, key in random.Random(0).sample(sorted(seen.keys.items()), min(50, len(seen.keys))):
        again = asking._post(seen.designs[where], key)
        if again.status_code != 200 or again.content != seen.answers.get(where):
            seen.wrong.append(f"{where} asked again with its key: {again.status_code}")
    # The same by what the database holds.
    for query in ("select id, count(*) from answers group by id having count(*) > 1",
                  "select sweep, number from sweep_items group by sweep, number "
                  "having count(*) > 1"):  # fmt: skip
        doubled += len(store.rows(query))
    owned = store.rows("select count(*) from answers where leased_by is not null")[0][0]
    verified = subprocess.run(
        [sys.executable, "-m", "service.cli", "admin", "verify", "--database-url", store.url],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    if verified.returncode:
        seen.wrong.append(f"verify: {verified.stdout[:500]} {verified.stderr[-500:]}")
    print(f"designs {len(seen.designs)} ({len(seen.cut)} whose answer was cut off), sweeps "
          f"{len(seen.sweeps)} with {sum(seen.sweeps.values())} items: {dict(items)}")  # fmt: skip
    print(f"answers of the services {dict(seen.statuses)}")
    counts = {
        "lost": len(lost) + missing, "doubled": doubled, "stuck": len(waiting),
        "failed": len(failed) + items["failed"], "wrong": len(seen.wrong), "leases left": owned,
    }  # fmt: skip
    print(", ".join(f"{name} {number}" for name, number in counts.items()))
    examples: dict[str, Callable[[], list[str]]] = {
        "lost": lambda: sorted(lost), "stuck": lambda: sorted(waiting),
        "failed": lambda: [f"{where}: {text[:300]}" for where, text in failed.items()],
        "wrong": lambda: seen.wrong,
    }  # fmt: skip
    for name, found in examples.items():
        for each in found()[:SHOWN]:
            print(f"  {name}: {each}")
    return sum(counts.values())


def _state(asking: Asking, where: str) -> str:
    """As ``read``, of a sweep."""
    answer = asking.ask("GET", where)
    if answer.status_code != 200:
        return "lost" if answer.status_code == 404 else answer.text
    state = answer.json()["state"]
    if state in ENDED:
        return "done" if state == "successful" else answer.text
    return "accepted"
