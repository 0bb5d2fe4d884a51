"""What somebody sees, and can do, who records everything at a relay."""

import os
import time

import pytest
import zenoh

from conf.protocol.address import Address, RelayAddress
from conf.protocol.call_endpoint import CallEndpoint
from conf.protocol.messages import StreamParameters
from conf.relay.router import Router, RouterOptions
from conf.transport.exchange import DatagramExchange
from conf.transport.relay_settings import client_settings, make_config
from conf.transport.zenoh_transport import RelayTransport
from tests.support.relay import LOOPBACK, free_port, wait_until
from tests.support.simulated_sessions import CODE, WRONG

NAMES = ("Adaliciousname", "Bobaliciousname")
PLATE = "4711"


class End:
    """One end of a call over a relay."""

    def __init__(self, transport: RelayTransport, name: str) -> None:
        self.endpoint = make_endpoint(CODE, name, transport.remote)
        self._exchange = DatagramExchange(transport, self.endpoint)

    def step(self) -> None:
        now = time.monotonic()
        self._exchange.receive(now)
        self._exchange.send(now)
        while self.endpoint.next_event():
            pass


def make_endpoint(code: str, name: str, remote: Address | None = None) -> CallEndpoint:
    parameters = StreamParameters(320, 240, 15.0, 50, (6.4, 4.2, 2.0, 5.1, 1.1))
    return CallEndpoint(
        code=code, parameters=parameters, now=time.monotonic(), random=os.urandom, remote=remote, name=name
    )


@pytest.mark.slow
def test_a_capture_at_the_relay_tells_nothing_and_opens_nothing() -> None:
    port, captured = free_port(), list[tuple[str, bytes]]()
    with (
        Router(RouterOptions((LOOPBACK, port))),
        zenoh.open(make_config(client_settings((LOOPBACK, port)))) as spy,
        RelayTransport.wait_at((LOOPBACK, port), PLATE) as waiting,
        RelayTransport.call((LOOPBACK, port), PLATE, os.urandom) as calling,
    ):
        spy.declare_subscriber("conf/**", lambda item: captured.append((str(item.key_expr), item.payload.to_bytes())))
        ends = [End(waiting, NAMES[0]), End(calling, NAMES[1])]

        def step() -> None:
            for end in ends:
                end.step()

        def know_each_other() -> bool:
            step()
            return [end.endpoint.remote_state.name for end in ends] == [NAMES[1], NAMES[0]]

        wait_until(know_each_other)
        assert len(captured) >= 6
        content = b"".join(data for _, data in captured)
        assert not any(name.encode() in content for name in NAMES) and CODE.encode() not in content

        guesser = make_endpoint(WRONG, "guesser")
        for _, data in captured:  # who has everything but the words
            guesser.receive_datagram(data, RelayAddress(PLATE, "guesser"), time.monotonic())
        assert not guesser.streams and guesser.callers == set()

        peers = [end.endpoint.callers for end in ends]
        rejected = sum(end.endpoint.rejected for end in ends)
        recorded = list(captured)
        for key, data in recorded:
            spy.put(key, data)
            spy.put(key.replace(calling.address.member, "invented"), data[:-1] + bytes([data[-1] ^ 1]))

        def have_rejected() -> bool:
            step()
            return sum(end.endpoint.rejected for end in ends) > rejected

        wait_until(have_rejected)
        wait_until(know_each_other)
        assert [end.endpoint.callers for end in ends] == peers
        for end in ends:
            assert len(end.endpoint.streams) == 1
