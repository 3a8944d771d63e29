"""What a scanner of web applications looks for, on every route of the contract; and every port.

    python -m tests.service.checks.web [part of a path] ...

It starts a service that asks for keys, asks every operation of the contract without a key, with a
wrong one, and with a good one, and prints how often each check was made and what was found. Then it
speaks garbage, TLS, HTTP/2 and a pickle that would write a file to every port on which a process of
the service listens. The exit code is 1 where anything was found.
"""

from __future__ import annotations

import json
import os
import pickle
import re
import socket
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx2

from benchmarks import processes
from service.openapi import TARGET
from tests.service.killing import ROOT, answering, free_port, service
from tests.service.specs import spec
from tests.service.workers.test_local import ports

MARK = "zq7<b>'\"&{{7*7}}"  # what must not come back as it is where a browser would read it
SCRIPT = "zq7<script>alert(1)</script>"
ELSEWHERE = "https://evil.example"
INSIDE = re.compile(
    r'Traceback|File "|/site-packages|/work/|/usr/lib|\.py\b|sqlalchemy|uvicorn|starlette|psycopg',
    re.I,
)
Answer = httpx2.Response
UP = ("..%2f..%2f..%2f..%2fetc%2fpasswd", "..%5c..%5cetc%5cpasswd", "%2e%2e/%2e%2e/etc/passwd",
      "....//....//etc/passwd", "..%252f..%252fetc%252fpasswd", "%00/etc/passwd")  # fmt: skip
FOLDERS = ("/studio/", "/assets/", "/guide/", "/problems/", "/v1/designs/", "/v1/examples/", "/")
VERBS = ("TRACE", "TRACK", "PUT", "PATCH", "OPTIONS", "CONNECT", "PROPFIND", "DEBUG", "get")


def headers_are_there(answer: Answer) -> str | None:
    """Those that keep browsers from guessing, framing and telling."""
    wanted = {
        "x-content-type-options": "nosniff", "content-security-policy": "",
        "cross-origin-resource-policy": "same-origin", "referrer-policy": "no-referrer",
        "x-request-id": "",
    }  # fmt: skip
    if answer.status_code == 400 and "x-request-id" not in answer.headers:
        del wanted["x-request-id"]  # the parser's own answer: there was no request
    missing = [n for n, v in wanted.items() if v not in answer.headers.get(n, "\0missing")]
    missing += [n for n in wanted if n not in answer.headers]
    return f"without {sorted(set(missing))}" if missing else None


def cannot_be_framed(answer: Answer) -> str | None:
    """By pages elsewhere."""
    policy = answer.headers.get("content-security-policy", "")
    return None if "frame-ancestors 'self'" in policy or "sandbox" in policy else policy


def tells_no_versions(answer: Answer) -> str | None:
    """Neither which server, nor from which file an error came."""
    told = [n for n in ("server", "x-powered-by", "via", "x-aspnet-version") if n in answer.headers]
    found = INSIDE.search(answer.text) if answer.status_code >= 400 else None
    return f"tells {told} {found and found.group()}" if told or found else None


def no_other_origin(answer: Answer) -> str | None:
    """Is let in."""
    told = {n: v for n, v in answer.headers.items() if n.startswith("access-control-")}
    return str(told) if told else None


def not_kept_by_others(answer: Answer) -> str | None:
    """What needs a key is kept by no shared cache."""
    kept = answer.headers.get("cache-control", "")
    with_key = "authorization" in answer.request.headers and answer.status_code < 400
    with_key &= answer.request.url.path.startswith("/v1/")
    return (
        f"Cache-Control {kept!r}" if with_key and not re.search("private|no-store", kept) else None
    )


def no_fault_of_ours(answer: Answer) -> str | None:
    """Whatever is asked."""
    return answer.text[:200] if answer.status_code >= 500 else None


def says_what_it_is(answer: Answer) -> str | None:
    """A type for every body, and a charset for text that browsers read."""
    kind = answer.headers.get("content-type", "")
    if answer.content and not kind:
        return "no Content-Type"
    return kind if kind.startswith("text/html") and "charset" not in kind else None


def reflects_nothing(answer: Answer) -> str | None:
    """What was sent comes back as JSON or in files that browsers do not run, and not in headers."""
    kind = answer.headers.get("content-type", "")
    if any("zq7" in value and "<" in value for value in answer.headers.values()):
        return f"in headers: {dict(answer.headers)}"
    read = not kind.startswith(
        ("application/json", "application/problem+json", "application/pdf", "model/")
    )
    return kind if read and ("zq7<b>" in answer.text or SCRIPT in answer.text) else None


def cookies_are_closed(answer: Answer) -> str | None:
    """To scripts and to other sites."""
    for cookie in answer.headers.get_list("set-cookie"):
        if not re.search("httponly", cookie, re.I) or not re.search(
            "samesite=strict", cookie, re.I
        ):
            return cookie
    return None


def leads_nowhere_else(answer: Answer) -> str | None:
    """No redirection, and no address of another host."""
    for name in ("location", "content-location", "refresh", "link"):
        if "evil" in answer.headers.get(name, ""):
            return answer.headers[name]
    return answer.headers.get("location") if 300 <= answer.status_code < 304 else None


ALWAYS: tuple[Callable[[Answer], str | None], ...] = (
    headers_are_there, cannot_be_framed, tells_no_versions, no_other_origin, not_kept_by_others,
    no_fault_of_ours, says_what_it_is, reflects_nothing, cookies_are_closed, leads_nowhere_else,
)  # fmt: skip


class Scan:
    """Questions to one service, and what every answer is looked at for."""

    def __init__(self, port: int, key: str) -> None:
        self.made, self.found = Counter[str](), list[str]()
        self.client = httpx2.Client(base_url=f"http://127.0.0.1:{port}", timeout=60.0)
        self.port, self.key = port, {"Authorization": f"Bearer {key}"}

    def check(self, name: str, good: object, words: str) -> None:
        self.made[name] += 1
        if not good:
            self.found.append(f"{name}: {words}")

    def ask(self, method: str, path: str, headers: dict[str, str], **more: Any) -> Answer:
        answer = self.client.request(method, path, headers=headers, **more)
        for each in ALWAYS:
            wrong = each(answer)
            self.check(
                each.__name__, wrong is None, f"{method} {path} {answer.status_code}: {wrong}"
            )
        return answer

    def operations(self, id: str) -> None:
        """Each of the contract, without a key, with wrong ones, and with a good one."""
        for method, path in _operations():
            real = re.sub(r"\{[^}]*\}", id, path)
            free = path in ("/livez", "/readyz") or path.startswith("/problems/")
            for headers in ({}, {"Authorization": "Bearer wrong"}, {"Cookie": "camwright-key=no"}):
                answer = self.ask(method, real, headers)
                self.check("needs a key", free or answer.status_code == 401,
                           f"{method} {path} {answer.status_code}")  # fmt: skip
            wrong = {"/metrics": 403}.get(path)
            from_elsewhere = {**self.key, "Origin": ELSEWHERE}
            if method != "DELETE":
                answer = self.ask(method, real, from_elsewhere)
                if wrong:
                    self.check("operators only", answer.status_code == wrong, path)
            answer = self.ask("OPTIONS", real, {**from_elsewhere,
                              "Access-Control-Request-Method": method})  # fmt: skip
            self.check("preflight refused", answer.status_code >= 400, real)
            for verb in VERBS[:-1]:
                if (verb.lower(), path) not in [(m.lower(), p) for m, p in _operations()]:
                    answer = self.ask(verb, real, self.key)
                    self.check("verbs refused", answer.status_code in (400, 403, 404, 405, 501),
                               f"{verb} {real} {answer.status_code}")  # fmt: skip
            if method == "POST":
                for kind in ("text/plain", "application/x-www-form-urlencoded",
                             "multipart/form-data", ""):  # fmt: skip
                    sent = json.dumps(spec("zq7")).encode()
                    headers = {**self.key, "Content-Type": kind}
                    answer = self.ask(method, real, headers, content=sent)
                    self.check("bodies of forms refused", answer.status_code in (404, 415, 422),
                               f"{kind} {real} {answer.status_code}")  # fmt: skip

    def injections(self, id: str) -> None:
        """What was sent, in every place of the question."""
        for method, path in _operations():
            if method == "DELETE":
                continue
            real = re.sub(r"\{[^}]*\}", id, path)
            names = ("q", "cursor", "limit", "status", "next", "url", "curve", "format")
            for text in (MARK, SCRIPT, "x\r\nSet-Cookie: evil=1", f"//{ELSEWHERE}"):
                answer = self.ask(method, real, self.key, params=dict.fromkeys(names, text))
                self.check("no header injected", "evil" not in answer.headers.get("set-cookie", ""),
                           real)  # fmt: skip
            if "{" in path:
                for text in (
                    "zq7%3Cscript%3Ealert(1)%3C%2Fscript%3E",
                    "a%0d%0aSet-Cookie:%20evil=1",
                ):
                    self.ask(method, re.sub(r"\{[^}]*\}", text, path), self.key)
            named = ("X-Request-ID", "X-Forwarded-Host", "Referer", "User-Agent", "Origin",
                     "If-None-Match", "Accept", "Prefer", "Idempotency-Key")  # fmt: skip
            self.ask(method, real, {**self.key, **dict.fromkeys(named, SCRIPT)})
            self.ask(method, real, {**self.key, "X-Forwarded-Host": "evil.example",
                                    "X-Forwarded-Proto": "javascript"})  # fmt: skip
            answer = self.client.request(method, real, headers={**self.key, "Host": "evil.example"})
            wanted = 200 if real in ("/livez", "/readyz") else 421  # probes call by addresses
            self.check("other names refused", answer.status_code == wanted, real)

    def ways_up(self) -> None:
        """Out of the folders that are served; by bare lines, as clients tidy paths up."""
        for folder in FOLDERS:
            for way in (*UP, "../" * 8 + "etc/passwd", "//evil.example/", "/etc/passwd"):
                answer = self.raw(f"GET {folder}{way} HTTP/1.1\r\nHost: localhost\r\n"
                                  f"Authorization: {self.key['Authorization']}\r\n"
                                  "Connection: close\r\n\r\n")  # fmt: skip
                good = b"root:" not in answer and not re.match(rb"HTTP/1.1 [35]", answer)
                self.check("no way up", good, f"{folder}{way}: {answer[:80]!r}")

    def raw(self, text: str) -> bytes:
        """What comes back for these bytes."""
        return said(self.port, text.encode())


def said(port: int, message: bytes) -> bytes:
    """All that a port answers to a message within some seconds; nothing where it resets."""
    found = b""
    try:
        with socket.create_connection(("127.0.0.1", port), 5.0) as line:
            line.settimeout(3.0)
            line.sendall(message)
            while part := line.recv(65536):
                found += part
    except OSError:
        pass
    return found


def _operations() -> Iterator[tuple[str, str]]:
    served = json.loads(TARGET.read_text(encoding="utf-8"))
    for path, methods in served["paths"].items():
        if len(sys.argv) > 1 and not any(word in path for word in sys.argv[1:]):
            continue
        for method in methods:
            yield method.upper(), path


class Runs:
    """Writes a file where it is unpickled."""

    def __init__(self, file: Path) -> None:
        self._file = file

    def __reduce__(self) -> Any:
        return os.system, (f"touch {self._file}",)


def messages(file: Path) -> dict[str, bytes]:
    """What a stranger may send to a port; some would write a file."""
    pickled = pickle.dumps(Runs(file))
    call = pickle.dumps((os.system, (f"touch {file}",)))
    return {
        "garbage": os.urandom(4096), "nothing": b"", "NUL": bytes(4096), "pickle": pickled,
        "a call of multiprocessing": len(call).to_bytes(4, "big") + call,
        "a message of Dask": b"".join(n.to_bytes(8, "little") for n in (1, len(pickled))) + pickled,
        "TLS": b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + os.urandom(508),
        "HTTP/2": b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + bytes(9),
        "SSH": b"SSH-2.0-x\r\n", "PostgreSQL": b"\0\0\0\x08\x04\xd2\x16\x2f",
        "a pickle as a body": b"POST /v1/designs HTTP/1.1\r\nHost: localhost\r\nContent-Type: "
        b"application/octet-stream\r\nContent-Length: %d\r\n\r\n" % len(pickled) + pickled,
    }  # fmt: skip


def strangers(scan: Scan, family: list[int], folder: Path) -> None:
    """Every port on which a process of these listens is the service's own, and runs nothing."""
    listening = ports(family)
    scan.check("listens on one port alone", listening == {scan.port}, f"{sorted(listening)}")
    file = folder / "ran"
    for port in listening:
        for name, message in messages(file).items():
            answer = said(port, message)
            good = not answer or re.match(rb"HTTP/1.1 4", answer)
            scan.check(
                "strangers run nothing", good and not file.exists(), f"{name}: {answer[:60]!r}"
            )
    scan.check("lives on", scan.client.get("/livez").status_code == 200, "")


def main() -> int:
    """The number of faults decides the exit code."""
    with tempfile.TemporaryDirectory() as name:
        folder, port = Path(name), free_port()
        url = {"CAMWRIGHT_DATABASE_URL": f"sqlite:///{folder}/designs.db"}
        made = subprocess.run(
            [sys.executable, "-m", "service.cli", "keys", "create", "scan", "--owner", "ada"],
            cwd=ROOT, env={**os.environ, **url}, capture_output=True, text=True, check=True,
        ).stdout  # fmt: skip
        (key,) = re.findall(r"camwright_[\w-]+", made)
        running = service(
            folder, port, real=True, CAMWRIGHT_ACCESS="keys", CAMWRIGHT_LOG_LEVEL="error", **url
        )
        try:
            scan = Scan(port, key)
            answering(scan.client)
            id = scan.ask("POST", "/v1/designs", scan.key, json=spec("zq7<b>")).json()["id"]
            scan.operations(id)
            scan.injections(id)
            scan.ways_up()
            scan.ask("POST", "/session", {}, json={"key": key})
            for path in ("/", "/docs", "/redoc", "/guide", "/openapi.json", "/spatial", "/none"):
                scan.ask("GET", path, {})
            strangers(scan, processes.family(running.running.pid), folder)
        finally:
            running.stop()
    for name, count in scan.made.items():
        print(f"{name.replace('_', ' '):28} {count:6}", flush=True)
    for each, times in Counter(scan.found).most_common():
        print(f"  {times} x {each[:400]}")
    print(f"{sum(scan.made.values())} checks, {len(scan.found)} faults")
    return min(len(scan.found), 1)


if __name__ == "__main__":
    sys.exit(main())
