"""The router of a relay: zenoh's, inside this process.

Strategy. It forwards a message only to those who have subscribed to its key, and nothing outside `conf/**`. It stores
nothing, needs no clock and knows no secret: what it carries is sealed end to end.
Limits: sessions in all (`max_sessions`), size of a message (`low_pass_filter`; longer ones are dropped where they come
in) and what a session may do (`access_control`: publish and subscribe, no queries, no administration). Rates
are limited in front of it: zenoh's `downsampling` enforces a minimum interval, and so drops all but the first datagram
of a burst, such as face and voice of one time (10 messages at once, 500 a second allowed: 1 arrived).
What is counted are sessions and links. Nameplates are not: asking zenoh's admin space for them while members arrive can
stop the router for good, all its threads waiting for locks (3 of 4 trials with 400 members; without it 0 of 8).
"""

import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

from conf.errors import NetworkError
from conf.protocol.address import format_address
from conf.transport.relay_settings import (
    LEASE_MS,
    MAX_MESSAGE,
    Credentials,
    Settings,
    make_config,
    read_credentials,
    url_host,
)
from conf.transport.udp import MAX_DATAGRAM, UdpSocket

ROUTER_HOST = "127.0.0.1"
MAX_MEMBERS = 2000
ACCEPT_TIMEOUT_MS = 10_000  # from a first message until the session stands; two round trips, and what is lost
MAX_KEY = "conf/**"
MAX_PENDING = 200  # sessions that are being opened


@dataclass(frozen=True)
class RouterOptions:
    """What a relay is started with.

    listen : host and port, host "" for all addresses; over TCP and UDP
    ports : in place of that two ports over TCP on this machine, for what arrives over TCP and over UDP
    peers : relays to be joined with
    password : file of lines user:password, None to admit everybody; max_members : sessions at a time
    """

    listen: tuple[str, int]
    peers: Sequence[tuple[str, int]] = ()
    password: Path | None = None
    max_members: int = MAX_MEMBERS
    ports: tuple[int, int] | None = None


@dataclass(frozen=True)
class RouterState:
    """Counts at one time. udp, tcp : links of the members"""

    members: int = 0
    udp: int = 0
    tcp: int = 0
    peers: int = 0


class Router:
    """A running router; use `with`."""

    def __init__(self, options: RouterOptions, /) -> None:
        """Start. Raises NetworkError."""
        import zenoh

        self._ports = options.ports
        credentials = read_credentials(options.password) if options.password else None
        try:
            self._session = zenoh.open(make_config(router_settings(options, credentials)))
        except zenoh.ZError as error:
            text = (
                f"cannot listen on {format_address(options.listen)}: another program uses the port, or the address is "
                "not this machine's; choose another with --listen HOST:PORT"
            )
            raise NetworkError(text) from error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close all sessions."""
        from zenoh import ZError

        with suppress(ZError):
            self._session.close()

    def state(self) -> RouterState:
        """Return the present counts."""
        import zenoh

        transports = self._session.info.transports()
        peers = {str(item.zid) for item in transports if item.whatami == zenoh.WhatAmI.ROUTER}
        links = [link for link in self._session.info.links() if str(link.zid) not in peers]
        over_udp = f":{self._ports[1]}" if self._ports else "udp/"
        udp = sum(over_udp in link.src for link in links)
        return RouterState(members=len(transports) - len(peers), udp=udp, tcp=len(links) - udp, peers=len(peers))


def router_settings(options: RouterOptions, credentials: Credentials | None, /) -> Settings:
    """Return the settings of zenoh. credentials : with which to join peers"""
    settings: dict[str, object] = {
        "mode": "router",
        "listen/endpoints": _endpoints(options),
        "connect/endpoints": [_peer_endpoints(peer) for peer in options.peers],
        "connect/exit_on_failure": False,
        "connect/timeout_ms": -1,  # go on trying, without waiting for it
        "connect/retry": {"period_init_ms": 500, "period_max_ms": 4000, "period_increase_factor": 2},
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "timestamping/enabled": False,
        "transport/unicast/max_sessions": options.max_members + len(options.peers),
        "transport/unicast/accept_pending": MAX_PENDING,
        "transport/unicast/accept_timeout": ACCEPT_TIMEOUT_MS,
        "transport/unicast/max_links": 2,
        "transport/unicast/qos/enabled": True,
        "transport/link/tx/sequence_number_resolution": "8bit",
        "transport/link/tx/lease": LEASE_MS,
        "transport/link/rx/max_message_size": MAX_MESSAGE,
        "transport/shared_memory/enabled": False,
        "access_control": _ACCESS,
        "low_pass_filter": [
            {"id": "size", "messages": ["put"], "flows": ["ingress"], "key_exprs": ["**"], "size_limit": MAX_DATAGRAM}
        ],
    }
    if options.password and credentials:
        settings |= {
            "transport/auth/usrpwd/dictionary_file": str(options.password),
            "transport/auth/usrpwd/user": credentials.user,
            "transport/auth/usrpwd/password": credentials.password,
        }
    return settings


_ACCESS = {
    "enabled": True,
    "default_permission": "deny",
    "rules": [
        {
            "id": "calls",
            "permission": "allow",
            "flows": ["ingress", "egress"],
            "messages": ["put", "declare_subscriber"],
            "key_exprs": [MAX_KEY],
        }
    ],
    "subjects": [{"id": "everybody"}],
    "policies": [{"rules": ["calls"], "subjects": ["everybody"]}],
}


def _endpoints(options: RouterOptions) -> list[str]:
    if options.ports:
        return [
            f"tcp/{ROUTER_HOST}:{port}?rel={reliable}" for port, reliable in zip(options.ports, (1, 0), strict=True)
        ]
    host, port = options.listen
    return [f"{kind}/{url_host(name)}:{port}" for name in ([host] if host else _all_hosts()) for kind in ("tcp", "udp")]


def _all_hosts() -> list[str]:
    """Return what stands for all addresses of this machine. On Windows `::` accepts no calls over IPv4."""
    if not _has_ipv6():
        return ["0.0.0.0"]
    return ["::", "0.0.0.0"] if sys.platform == "win32" else ["::"]


def _has_ipv6() -> bool:
    """Return whether this machine has IPv6."""
    try:
        with UdpSocket.bind("::1", 0):
            return True
    except NetworkError:
        return False


def _peer_endpoints(peer: tuple[str, int]) -> dict[str, object]:
    locator = f"{url_host(peer[0])}:{peer[1]}"
    return {"strategy": "allOf", "locators": [f"tcp/{locator}?rel=1", f"udp/{locator}?rel=0"]}
