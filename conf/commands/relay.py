"""`conf relay`: run a relay, through which people call each other whose routers accept no calls."""

import argparse
from pathlib import Path

from conf.commands import Terminal
from conf.commands.support.arguments import add_json, add_seconds, relay_address, relay_listen_address
from conf.commands.support.interruption import until_interrupted
from conf.errors import ConfError
from conf.protocol.address import DEFAULT_RELAY_PORT, format_address

HELP = "run a relay for calls between homes, which reads none of them"
MAX_MEMBERS = 2000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--listen",
        type=relay_listen_address,
        default=("", DEFAULT_RELAY_PORT),
        metavar="[HOST:]PORT",
        help=f"default {DEFAULT_RELAY_PORT} on all addresses; TCP and UDP, and UDP on the next two ports for STUN",
    )
    parser.add_argument(
        "--password", type=Path, metavar="FILE", help="admit only who has one of the lines user:password of this file"
    )
    parser.add_argument(
        "--peer",
        type=relay_address,
        action="append",
        default=[],
        metavar="HOST[:PORT]",
        help="another relay to be joined with; may be repeated",
    )
    parser.add_argument(
        "--max-members", type=_positive, default=MAX_MEMBERS, metavar="N", help=f"at a time (default {MAX_MEMBERS})"
    )
    add_seconds(parser)
    add_json(parser)


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    from conf.relay.front import Front, FrontOptions
    from conf.relay.loop import RelayLoop
    from conf.relay.router import Router, RouterOptions
    from conf.transport.stun import STUN_PORT_STEPS

    host, port = options.listen
    if not 0 < port <= 65535 - max(STUN_PORT_STEPS):
        raise ConfError(
            f"the relay needs its port and the next two: choose one from 1 to {65535 - max(STUN_PORT_STEPS)}"
        )
    with (
        until_interrupted() as should_continue,
        Front.bind(FrontOptions((host, port), options.max_members, options.peer)) as front,
        Router(
            RouterOptions((host, port), options.peer, options.password, options.max_members, front.router_ports)
        ) as router,
    ):
        names = " and ".join(map(str, front.stun_ports))
        terminal.write(f"relay on {format_address((host, port))}, TCP and UDP; STUN on UDP ports {names}")
        figures = RelayLoop(router, front, terminal.write).run(seconds=options.seconds, should_continue=should_continue)
    terminal.print_figures("the relay", figures)


def _positive(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value
