import json
from pathlib import Path

import pytest

from conf.errors import NetworkError
from conf.transport.relay_settings import (
    Credentials,
    client_settings,
    lan_settings,
    make_config,
    read_credentials,
    url_host,
)


@pytest.mark.parametrize(
    ("host", "text"), [("relay.example", "relay.example"), ("192.0.2.1", "192.0.2.1"), ("2001:db8::1", "[2001:db8::1]")]
)
def test_hosts_in_locators(host: str, text: str) -> None:
    assert url_host(host) == text
    (endpoints,) = json.loads(make_config(client_settings((host, 7447))).get_json("connect/endpoints"))
    assert endpoints["locators"] == [f"tcp/{text}:7447?rel=1", f"udp/{text}:7447?rel=0"]
    assert endpoints["strategy"] == "allOf"


def test_zenoh_accepts_the_settings() -> None:
    config = make_config(client_settings(("h", 1), Credentials("alice", "secret")))
    assert json.loads(config.get_json("mode")) == "client"
    assert json.loads(config.get_json("transport/auth/usrpwd/password")) == "secret"
    assert json.loads(config.get_json("scouting/multicast/enabled")) is False
    config = make_config(lan_settings())
    assert json.loads(config.get_json("mode")) == "peer"
    assert json.loads(config.get_json("scouting/multicast/enabled")) is True


def test_a_password_is_the_first_line_of_its_file(tmp_path: Path) -> None:
    path = tmp_path / "password"
    path.write_text("\n  alice:se:cret \nbob:other\n")
    assert read_credentials(path) == Credentials("alice", "se:cret")


@pytest.mark.parametrize("text", ["", "alice", ":secret", "alice:"])
def test_a_file_without_a_password(tmp_path: Path, text: str) -> None:
    path = tmp_path / "password"
    path.write_text(text)
    with pytest.raises(NetworkError, match="names no password: write a line user:password"):
        read_credentials(path)


def test_a_file_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(NetworkError, match=r"cannot be read \(No such file or directory\)"):
        read_credentials(tmp_path / "missing")
    (tmp_path / "bytes").write_bytes(b"\xff\xfe")
    with pytest.raises(NetworkError, match=r"cannot be read \(it is no text\)"):
        read_credentials(tmp_path / "bytes")
