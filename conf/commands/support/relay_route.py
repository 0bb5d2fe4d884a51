"""The way of a call, over a relay or directly: options, what is typed to call somebody, and opening both ends."""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from ipaddress import ip_address
from pathlib import Path
from typing import TYPE_CHECKING

from conf.commands import Terminal
from conf.commands.support.arguments import address, pairing_code, relay_address
from conf.commands.support.capture import read_code
from conf.errors import ConfError, NetworkError

if TYPE_CHECKING:
    from conf.call.view import Waiting
    from conf.transport.interface import Transport
    from conf.transport.relay_settings import Credentials
    from conf.transport.traversal import TraversalTransport

PASSWORD_VARIABLE = "CONF_RELAY_PASSWORD"
NO_NAMEPLATE = "this code has no number in front: give --listen PORT with it, or a code such as 4711-acorn-tulip-river"
OTHER_NUMBER = "the code {code} does not begin with {nameplate}: give the code that the other end shows"
IN_USE = "somebody else waits with the number {nameplate}: use another code"
OPEN_LIMIT_S = 8.0  # for a relay to answer before nobody could call
LOOK_S = 0.3  # for the relay to say who else waits with a nameplate
STEP_S = 0.02
TRIES = 8
TRIES_PER_DIGIT = 2  # of nameplates in use, before a longer one is tried


@dataclass(frozen=True)
class RelayRoute:
    """A way over a relay.

    relay : host and port, None to find the other end in the local network; password : file of a line user:password
    """

    relay: tuple[str, int] | None = None
    password: Path | None = None

    @property
    def name(self) -> str:
        """What goes between the ends, in words."""
        return f"the relay {self.relay[0]}" if self.relay else "the local network"


LOCAL_NETWORK = RelayRoute()


def add_relay(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--relay",
        type=relay_address,
        metavar="HOST[:PORT]",
        help="where `conf relay` runs (default: CONF_RELAY; without one the local network is searched)",
    )
    parser.add_argument(
        "--relay-password",
        type=Path,
        metavar="FILE",
        help=f"a file with the relay's user:password (default: {PASSWORD_VARIABLE})",
    )


def call_target(text: str) -> tuple[str, int] | str:
    """Return the host and port to call, or the code if a text is one for a relay; of such a code its number is enough.

    A whole code on the command line can be read by other users of the machine.
    """
    from conf.protocol.session.pairing_code import is_nameplate, is_relay_code

    if is_nameplate(text):
        return text
    return pairing_code(text) if is_relay_code(text) else address(text)


def code_to_call(target: tuple[str, int] | str, given: str | None, terminal: Terminal, who: str) -> str:
    """Return the code of an end that calls: the target's, `given`, that of CONF_CODE or what the user types.

    target : as of call_target; who : shows the code
    Raises ConfError if there is none, or if it is for another number.
    """
    from conf.protocol.session.pairing_code import is_nameplate, nameplate_of

    if isinstance(target, str) and not is_nameplate(target):
        return target
    code = given or read_code(terminal, who)
    if isinstance(target, str) and nameplate_of(code) != target:
        raise ConfError(OTHER_NUMBER.format(code=code, nameplate=target))
    return code


def route_of(options: argparse.Namespace) -> RelayRoute:
    """Return the way over the relay that the options name."""
    password = options.relay_password or os.environ.get(PASSWORD_VARIABLE)
    return RelayRoute(options.relay, Path(password) if password else None)


def open_to(target: tuple[str, int] | str, route: RelayRoute, code: str) -> Transport:
    """Return the transport of an end that calls: to a host, or over the relay to who waits with the code.

    Raises NetworkError.
    """
    if isinstance(target, str):
        return call_over(route, code)
    from conf.transport.udp import UdpSocket

    return UdpSocket.open_to(*target)


def open_at(listen: tuple[str, int] | None, route: RelayRoute, code: str) -> tuple[Transport, str]:
    """Return the transport of an end that waits, and its code: at an address, or without one over the relay.

    code : "" for a new one
    Raises as wait_over.
    """
    if listen is None:
        return wait_over(route, code)
    from conf.protocol.session.pairing_code import generate_code
    from conf.transport.udp import UdpSocket

    return UdpSocket.bind(*listen), code or generate_code(os.urandom)


def describe_waiting(transport: Transport, route: RelayRoute) -> str:
    """Return where an end waits to be called, in words."""
    from conf.protocol.address import format_address

    return f"waiting over {route.name}" if transport.nameplate else f"listening on {format_address(transport.address)}"


def waiting(transport: Transport, route: RelayRoute, remote: tuple[str, int] | str | None, code: str) -> Waiting:
    """Return what a window says while there is no call.

    remote : who is called, as of call_target, None for nobody; code : what the other end types, "" if it is called
    """
    from conf.call.view import Waiting
    from conf.protocol.address import DEFAULT_RELAY_PORT, RelayAddress, format_address, typed_address
    from conf.transport.local_addresses import find_route_addresses

    if transport.nameplate or isinstance(transport.address, RelayAddress):
        relay = typed_address(*route.relay, default_port=DEFAULT_RELAY_PORT) if route.relay else ""
        return Waiting(route.name, code, transport.nameplate, relay=relay)
    if isinstance(remote, tuple):
        return Waiting(format_address(remote), code)
    host, port = transport.address[:2]
    is_everywhere = ip_address(host.partition("%")[0]).is_unspecified
    hosts = find_route_addresses() if is_everywhere else (host,)
    place = f"port {port}" if is_everywhere else format_address((host, port))
    return Waiting(place, code, hosts=tuple(typed_address(host, port) for host in hosts))


def call_over(route: RelayRoute, code: str) -> TraversalTransport:
    """Return the transport of an end that calls. Raises NetworkError."""
    from conf.protocol.session.pairing_code import nameplate_of
    from conf.transport.traversal import TraversalTransport

    return TraversalTransport.call(route.relay, nameplate_of(code), credentials=_credentials(route))


def wait_over(
    route: RelayRoute,
    code: str,
    *,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> tuple[TraversalTransport, str]:
    """Return the transport of an end that waits to be called, and its code.

    code : "" for a new one, with a number that nobody else uses
    Raises NetworkError if the relay does not answer or the number of the code is in use, ConfError if it has none.
    """
    from conf.protocol.session.pairing_code import NAMEPLATE_DIGITS, generate_code, generate_nameplate, nameplate_of
    from conf.transport.traversal import TraversalTransport

    if code and not nameplate_of(code):
        raise ConfError(NO_NAMEPLATE)
    credentials = _credentials(route)
    for number in range(TRIES):
        digits = NAMEPLATE_DIGITS + number // TRIES_PER_DIGIT
        chosen = code or generate_code(os.urandom, nameplate=generate_nameplate(os.urandom, digits=digits))
        transport = TraversalTransport.wait_at(route.relay, nameplate_of(chosen), credentials=credentials)
        try:
            _wait_until_open(transport, clock, sleep)
        except BaseException:
            transport.close()
            raise
        if not transport.others_wait:
            return transport, chosen
        transport.close()
        if code:
            break
    raise NetworkError(IN_USE.format(nameplate=nameplate_of(chosen)))


def _wait_until_open(transport: TraversalTransport, clock: Callable[[], float], sleep: Callable[[float], None]) -> None:
    end = clock() + OPEN_LIMIT_S
    while not transport.relay.is_open:
        if clock() > end:
            raise NetworkError(transport.relay.note or "the relay does not answer")
        sleep(STEP_S)
    sleep(LOOK_S)


def _credentials(route: RelayRoute) -> Credentials | None:
    if route.password is None:
        return None
    from conf.transport.relay_settings import read_credentials

    return read_credentials(route.password)
