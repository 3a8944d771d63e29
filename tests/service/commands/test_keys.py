"""`camwright keys`, and the key that commands and clients bring along."""

from __future__ import annotations

import asyncio
import json
import os
import re
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from typer.testing import CliRunner

from service import cli
from service.client import AsyncClient, Client
from service.storage.keys import ApiKeys, KeyRefused
from service.storage.store import Store
from tests.service.conftest import Running, settings_for
from tests.service.specs import spec

runner = CliRunner()


def caller_of(folder: Path, text: str) -> str:
    """Whose key it is, or why it is refused."""
    settings = settings_for(folder)
    store = Store(settings)
    try:
        return asyncio.run(ApiKeys(store, settings).caller(text)).owner
    except KeyRefused as error:
        return str(error)
    finally:
        store.dispose()


def test_keys_are_made_listed_rotated_and_revoked(tmp_path: Path) -> None:
    database = ["--database-url", f"sqlite:///{tmp_path}/designs.db"]
    audited: list[dict[str, str]] = []

    def keys(*words: str, code: int = 0) -> tuple[str, str]:
        run = runner.invoke(cli.app, ["keys", *words, *database])
        assert run.exit_code == code, run.output
        lines = [line for line in run.stderr.splitlines() if line.startswith("{")]
        audited.extend(json.loads(line) for line in lines)
        return run.stdout.strip(), run.stderr

    made, said = keys("create", "Ada's laptop", "--owner", "ada", "--days", "90",
                      "--concurrent", "3")  # fmt: skip
    assert caller_of(tmp_path, made) == "ada"
    assert made not in said
    id = re.findall(r"Key (\w{8}) of ada, \"Ada's laptop\", until 2", said)[0]
    second, said = keys("rotate", id, "--overlap-days", "1")
    end = datetime.now(UTC) + timedelta(days=1.0)
    assert f"Key {id} stays valid until {end:%Y-%m-%d}" in said
    assert [caller_of(tmp_path, each) for each in (made, second)] == ["ada", "ada"]
    listed, _ = keys("list")
    assert len(listed.splitlines()) == 2
    assert f"{id}  ada  Ada's laptop  until " in listed
    assert listed.count("concurrent=3") == 2
    assert not any(each in listed for each in (made, second))
    keys("revoke", id)
    assert caller_of(tmp_path, made) == "has been revoked"
    assert caller_of(tmp_path, second) == "ada"
    assert "revoked 2" in keys("list")[0]
    for command in ("revoke", "rotate"):
        assert "camwright keys list" in keys(command, id, code=2)[1]
    assert "1 to 64" in keys("create", "x", "--owner", " ", code=2)[1]
    newer = next(line[:8] for line in listed.splitlines() if not line.startswith(id))
    told = [{name: line.get(name) for name in ("action", "made", "key")} for line in audited]
    assert told == [
        {"action": "create key", "made": id, "key": None},
        {"action": "rotate key", "made": newer, "key": id},
        {"action": "revoke key", "made": None, "key": id},
    ]  # what was refused is not among them
    assert all(line["logger"] == "camwright.audit" and line["user"] for line in audited)
    assert not any(each in json.dumps(audited) for each in (made, second))


def test_commands_and_clients_bring_their_key_along(
    service: Running, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text, other = service.new_key("of a client"), service.new_key("of another")
    monkeypatch.setenv("CAMWRIGHT_KEY", text)
    with Client(service.url) as client:
        made = client.design(spec("by a client"))["links"]["self"]
    with Client(service.url, key=other) as client:
        assert client.get("/v1/designs")["items"] == []

    async def look() -> str:
        async with AsyncClient(service.url) as client:
            return str((await client.get(made))["name"])

    assert asyncio.run(look()) == "by a client"
    assert service.client.get(made).status_code == 404  # who has no key is another
    question = tmp_path / "question.json"
    question.write_text(json.dumps(spec("by a command")), encoding="utf-8")
    command = ["design", str(question), "--out", str(tmp_path), "--url", service.url]
    for words, owner in (([], text), (["--key", other], other)):
        run = runner.invoke(cli.app, [*command, *words])
        assert run.exit_code == 0, run.output
        assert text not in run.output
        with Client(service.url, key=owner) as client:
            names = [each["name"] for each in client.get("/v1/designs")["items"]]
        assert names[0] == "by a command"
    run = runner.invoke(cli.app, [*command, "--key", "camwright_wrong"])
    assert run.exit_code == 2
    assert "is not one of this service's" in run.stderr
    assert "camwright_wrong" not in run.output
    assert os.environ["CAMWRIGHT_KEY"] != text  # as --key has set it; the fixture sets it back
