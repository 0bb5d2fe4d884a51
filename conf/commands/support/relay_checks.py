"""What `conf doctor --relay` finds out about the way to a relay, one sentence each."""

from pathlib import Path

from conf.errors import ConfError, NetworkError
from conf.protocol.address import format_address
from conf.transport.relay_probe import NatKind, explain_refusal, probe_links, probe_nat
from conf.transport.relay_settings import read_credentials

NATS = {
    NatKind.NONE: "there is none: others can reach this machine directly, unless its firewall forbids that",
    NatKind.ONE_PORT: (
        "it keeps one outside port, {outside}, for both ports of the relay, as most do: calls leave the relay for a "
        "direct path, unless the other end's NAT is symmetric (whether the port is kept for other hosts too cannot be "
        "told with one relay)"
    ),
    NatKind.SYMMETRIC: (
        "it is symmetric, with another outside port for each destination ({outside}): calls work, but stay on the "
        "relay unless the other end has no such NAT"
    ),
    NatKind.UNKNOWN: (
        "only one of the relay's two STUN ports has answered ({outside}): calls work, and leave the relay if a direct "
        "path answers"
    ),
}
NO_STUN = (
    "no answer from the STUN ports {first} and {second} (UDP) of the relay: this network blocks UDP, or the relay's "
    "firewall does; calls work, but stay on the relay"
)
NO_UDP = (
    "UDP does not pass to {relay}: calls go through the relay over TCP, with longer delays; allow UDP port {port} in "
    "the firewall if it is yours"
)
NO_TCP = (
    "TCP does not pass to {relay}: calls begin later when datagrams are lost; allow TCP port {port} in the firewall "
    "if it is yours"
)


def check_nat(relay: tuple[str, int], /) -> str:
    """Return which kind of NAT this machine sits behind and what that means. Raises ConfError."""
    report = probe_nat(relay)
    if report.kind is NatKind.BLOCKED:
        raise ConfError(NO_STUN.format(first=relay[1] + 1, second=relay[1] + 2))
    outside = " and ".join(dict.fromkeys(map(format_address, report.outside)))
    return NATS[report.kind].format(outside=outside)


def check_link(relay: tuple[str, int], password: Path | None, kind: str, /) -> str:
    """Return what a relay's link does. kind : "udp" or "tcp". Raises ConfError if there is none."""
    kinds = probe_links(relay, read_credentials(password) if password else None)
    name = format_address(relay)
    if not kinds:
        raise NetworkError(explain_refusal(relay))
    if kind not in kinds:
        raise NetworkError({"udp": NO_UDP, "tcp": NO_TCP}[kind].format(relay=name, port=relay[1]))
    return {"udp": f"{name} carries calls", "tcp": f"{name} sets calls up, and carries them where UDP is blocked"}[kind]
