from conf.relay.udp_front import LENGTH, Opening
from conf.transport.stun import decode_request
from tools.network.fuzz_relay import MAX_UDP, HostileMessages

OPENING = LENGTH.pack(40) + b"\x01" + bytes(39)


def test_messages_are_whole_damaged_truncated_and_too_long() -> None:
    messages = HostileMessages(OPENING, seed=1)
    over_udp = [messages.over_udp() for _ in range(2000)]
    opening = sum(Opening().admits(data) for data in over_udp)
    assert 400 < opening < 1900 and OPENING[LENGTH.size :] in over_udp
    assert max(map(len, over_udp)) > MAX_UDP // 2 and min(map(len, over_udp)) <= 2
    assert OPENING in [messages.over_tcp() for _ in range(100)]
    requests = [decode_request(messages.to_stun()) is None for _ in range(2000)]
    assert 200 < sum(requests) < 1900
