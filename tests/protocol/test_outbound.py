from conf.protocol.messages import StreamParameters
from conf.protocol.outbound import Outbound
from conf.protocol.wire import decode
from tests.protocol.test_inbound import PARAMETERS, frame


def test_parameters_come_first_and_once_a_second() -> None:
    outbound = Outbound(PARAMETERS)
    sent = []
    for i in range(45):
        outbound.send_frame(frame(i / 15), i / 15)
        sent += [decode(data) for data in outbound.datagrams_to_send(i / 15)]
    kinds = [isinstance(datagram.message, StreamParameters) for datagram in sent]
    assert kinds[0] and sum(kinds) == 3
    assert [datagram.sequence for datagram in sent] == list(range(48))
    assert outbound.frames_sent == 45 and outbound.datagrams_to_send(99.0) == []
