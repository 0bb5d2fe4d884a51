from conf.transport.combined import CombinedTransport
from conf.transport.interface import SelectableTransport
from conf.transport.udp import UdpSocket
from conf.transport.zenoh_transport import RelayTransport


def test_all_transports_have_the_interface() -> None:
    """The type checker compares signatures; here the names."""
    names = {"remote", "address", "handles", "receive", "send", "wait", "close", "__enter__", "__exit__"}
    udp, relay = UdpSocket.bind("127.0.0.1", 0), RelayTransport.wait_at(("127.0.0.1", 1), "4711")
    with CombinedTransport(udp, relay) as combined:
        transports: list[SelectableTransport] = [udp, relay, combined]
        for transport in transports:
            assert names <= set(dir(transport))
            assert transport.remote is None and transport.receive(1) == []
