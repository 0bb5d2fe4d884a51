import pytest

from conf.errors import NetworkError
from conf.protocol.address import Address
from conf.relay.stun_responder import ANSWERS_PER_S, StunResponder
from conf.transport.stun import StunClient, encode_request
from conf.transport.udp import UdpSocket
from tests.support.relay import LOOPBACK, bound_responder
from tests.support.simulated_sessions import seeded


def test_both_ports_tell_the_address_of_who_asks() -> None:
    with bound_responder() as responder, UdpSocket.bind(LOOPBACK, 0) as link:
        servers: list[Address] = [(LOOPBACK, port) for port in responder.ports]
        client = StunClient(servers, seeded(1))
        link.send(client.datagrams_to_send(0.0))
        link.send([(b"junk", servers[0])])
        for now in range(20):
            responder.wait(1.0)
            responder.step(float(now))
            if responder.answered == 2 and responder.ignored:
                break
        link.wait(1.0)
        for data, address, _ in link.receive():
            assert client.receive_datagram(data, address)
        assert client.mapped == dict.fromkeys(servers, link.address)
        assert (responder.answered, responder.ignored) == (2, 1)
        assert responder.ports[1] == responder.ports[0] + 1


def test_answers_are_limited() -> None:
    with bound_responder() as responder, UdpSocket.bind(LOOPBACK, 0) as link:
        request = (encode_request(bytes(12)), (LOOPBACK, responder.ports[0]))
        for _ in range(30):
            link.send([request] * 100)
            responder.step(0.0)
        assert responder.answered <= ANSWERS_PER_S and responder.ignored > 0


def test_ports_in_use() -> None:
    with bound_responder() as responder, pytest.raises(NetworkError, match="cannot listen"):
        StunResponder.bind(LOOPBACK, responder.ports[0])
