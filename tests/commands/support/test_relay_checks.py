from pathlib import Path

import pytest

from conf.commands.support import relay_checks
from conf.commands.support.relay_checks import check_link, check_nat
from conf.errors import ConfError
from conf.protocol.address import format_address
from conf.transport.relay_probe import NatKind, NatReport

RELAY = ("relay.example", 7447)
OUTSIDE = ("198.51.100.7", 4000)


@pytest.mark.parametrize(
    ("kind", "outside", "text"),
    [
        (NatKind.NONE, [OUTSIDE], "there is none: others can reach this machine directly"),
        (NatKind.ONE_PORT, [OUTSIDE, OUTSIDE], "keeps one outside port, 198.51.100.7:4000, for both"),
        (NatKind.SYMMETRIC, [OUTSIDE, ("198.51.100.7", 5)], "symmetric, .*198.51.100.7:4000 and 198.51.100.7:5"),
        (NatKind.UNKNOWN, [OUTSIDE], "only one of the relay's two STUN ports"),
    ],
)
def test_each_kind_of_nat_is_explained(
    monkeypatch: pytest.MonkeyPatch, kind: NatKind, outside: list[tuple[str, int]], text: str
) -> None:
    monkeypatch.setattr(relay_checks, "probe_nat", lambda relay: NatReport(kind, outside))
    with pytest.raises(AssertionError, match=text):
        raise AssertionError(check_nat(RELAY))


def test_stun_that_does_not_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(relay_checks, "probe_nat", lambda relay: NatReport(NatKind.BLOCKED, []))
    with pytest.raises(ConfError, match=r"no answer from the STUN ports 7448 and 7449 \(UDP\) of the relay"):
        check_nat(RELAY)


@pytest.mark.parametrize(
    ("kinds", "kind", "text"),
    [
        ("", "udp", "relay.example:7447 is not there"),
        ("tcp", "udp", "UDP does not pass to relay.example:7447: .* over TCP, .*allow UDP port 7447"),
        ("udp", "tcp", "TCP does not pass to relay.example:7447: .*allow TCP port 7447"),
    ],
)
def test_links_that_are_missing(monkeypatch: pytest.MonkeyPatch, kinds: str, kind: str, text: str) -> None:
    monkeypatch.setattr(relay_checks, "probe_links", lambda relay, credentials: frozenset(kinds.split()))
    monkeypatch.setattr(relay_checks, "explain_refusal", lambda relay: f"{format_address(relay)} is not there")
    with pytest.raises(ConfError, match=text):
        check_link(RELAY, None, kind)


def test_links_that_work(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    seen = []

    def probe(relay: tuple[str, int], credentials: object) -> frozenset[str]:
        seen.append(credentials)
        return frozenset({"tcp", "udp"})

    monkeypatch.setattr(relay_checks, "probe_links", probe)
    (tmp_path / "password").write_text("alice:secret")
    assert check_link(RELAY, None, "udp") == "relay.example:7447 carries calls"
    assert "where UDP is blocked" in check_link(RELAY, tmp_path / "password", "tcp")
    assert seen == [None, ("alice", "secret")]
