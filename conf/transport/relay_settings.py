"""Settings of zenoh for the ends of a call. Each was measured with calls in network namespaces.

Strategy. What is declared goes over TCP, as zenoh repeats nothing over UDP, and data goes over UDP, where a lost
datagram delays none of the others. If only TCP comes up, it carries both. `rel` says which is which, and counts only if
zenoh's `qos` is enabled: a relay's router sees TCP connections only. It costs no byte, as all have the same priority.
"""

import ipaddress
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from conf.errors import NetworkError
from conf.transport.link_policy import OPEN_TIMEOUTS_S

if TYPE_CHECKING:
    import zenoh

KEY_PREFIX = "conf/call"  # the relay carries nothing outside conf/**
# A keep-alive each LEASE_MS / 4 costs 29 B on UDP and 107 B on TCP; NATs forget a silent UDP flow after 30 s or more.
LEASE_MS = 40_000
MAX_MESSAGE = 1 << 16  # bytes that one message may have when it is put together

Settings = Mapping[str, object]


class Credentials(NamedTuple):
    """User and password of a relay."""

    user: str
    password: str


def read_credentials(path: Path, /) -> Credentials:
    """Return the first `user:password` of a file. Raises NetworkError."""
    try:
        lines = path.read_text("utf-8").splitlines()
    except (OSError, UnicodeError) as error:
        reason = getattr(error, "strerror", None) or "it is no text"
        raise NetworkError(f"{path} cannot be read ({reason}): give a file with a line user:password") from error
    user, colon, password = next((line.strip() for line in lines if line.strip()), "").partition(":")
    if not (user and colon and password):
        raise NetworkError(f"{path} names no password: write a line user:password")
    return Credentials(user, password)


def client_settings(relay: tuple[str, int], credentials: Credentials | None = None, /) -> Settings:
    """Return the settings of one end of a call that uses a relay. relay : host and port"""
    locator = f"{url_host(relay[0])}:{relay[1]}"
    endpoints = {"strategy": "allOf", "locators": [f"tcp/{locator}?rel=1", f"udp/{locator}?rel=0"]}
    settings = {**_COMMON, "mode": "client", "connect/endpoints": [endpoints], "scouting/multicast/enabled": False}
    if credentials:
        settings["transport/auth/usrpwd/user"] = credentials.user
        settings["transport/auth/usrpwd/password"] = credentials.password
    return settings


def lan_settings() -> Settings:
    """Return the settings of one end of a call that finds the other end in its own network, without a relay."""
    return {**_COMMON, "mode": "peer", "scouting/multicast/enabled": True}


def make_config(settings: Settings, /) -> "zenoh.Config":
    """Return settings as zenoh reads them."""
    import zenoh

    config = zenoh.Config()
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return config


def open_zenoh(settings: Settings, timeout_s: float = OPEN_TIMEOUTS_S[0], /) -> "zenoh.Session":
    """Return a new session. timeout_s : of each link. Raises zenoh.ZError.

    With zenoh's timeout of 10 s, three of five starts stalled at 10 % loss.
    """
    import zenoh

    return zenoh.open(make_config({**settings, "transport/unicast/open_timeout": round(1000 * timeout_s)}))


def url_host(host: str, /) -> str:
    """Return a host as in a URL: an IPv6 address in brackets."""
    try:
        version = ipaddress.ip_address(host).version
    except ValueError:
        return host
    return f"[{host}]" if version == 6 else host


_COMMON: dict[str, object] = {
    "transport/unicast/max_links": 2,
    "transport/unicast/qos/enabled": True,
    "transport/link/tx/sequence_number_resolution": "8bit",
    "transport/link/tx/lease": LEASE_MS,
    "transport/link/rx/max_message_size": MAX_MESSAGE,
    "transport/shared_memory/enabled": False,
    "timestamping/enabled": False,
}
