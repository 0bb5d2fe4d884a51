"""Callers in memory: what the receiver's loop and its readings are tried with. No sockets, no clock, no sleeping."""

import random
from itertools import count

import numpy as np

from conf.protocol.address import Address
from conf.protocol.messages import MotionFrame, StreamParameters
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.sender_connection import RateOptions, SenderConnection
from conf.protocol.session.client import SenderSession
from conf.protocol.session.server import SessionServer

CODE = "amber-canoe-tiger-7"
RECEIVER = ("receiver", 2)
PARAMETERS = StreamParameters(176, 144, 15.0, 50, (6.4, 4.5, 3.0, 5.0, 1.1))
FRAME_S = 1 / 15


def new_host(code: str = CODE) -> ReceiverEndpoint:
    return ReceiverEndpoint(SessionServer(code, random.Random(1).randbytes))


class FakeCaller:
    """Somebody who calls. `shows` : what the camera sees, "face" or "nobody"; None sends nothing more."""

    def __init__(self, now: float, *, code: str = CODE, address: Address = ("10.0.0.7", 1234)) -> None:
        session = SenderSession(code, RECEIVER, random.Random(address[1]).randbytes, now)
        self.caller = SenderConnection(session, PARAMETERS, now, link=RateOptions("live"))
        self.address = address
        self.shows: str | None = "face"
        self._frames = count()
        self._due = now

    def speak(self, now: float) -> list[tuple[bytes, Address]]:
        """Return what is sent now."""
        if self.shows is None:
            return []
        if self.caller.status(now).connected and now >= self._due:
            self._due = now + FRAME_S
            if self.shows == "face":
                self.caller.send_frame(self._frame(now), now)
            else:
                self.caller.send_no_face(now, now)
        return [(data, self.address) for data, _ in self.caller.datagrams_to_send(now)]

    def hang_up(self, now: float) -> list[tuple[bytes, Address]]:
        """Return the last words."""
        self.shows = None
        return [(data, self.address) for data, _ in self.caller.close(now)]

    def hear(self, datagrams: list[tuple[bytes, Address]], now: float) -> None:
        """Take those datagrams that are for this caller."""
        for data, address in datagrams:
            if address == self.address:
                self.caller.receive_datagram(data, RECEIVER, now)

    def _frame(self, now: float) -> MotionFrame:
        turn = 0.5 * np.sin(next(self._frames) / 4)
        return MotionFrame(now, np.zeros((50, 3), np.float32), np.array([0.0, turn, 0.0, 0.0, 0.0, -3.5]))


def talk(host: ReceiverEndpoint, caller: FakeCaller, begin: float, seconds: float) -> float:
    """Let caller and host talk, 20 ms a step. Returns the time after it."""
    now = begin
    for step in range(int(seconds / 0.02)):
        now = begin + step * 0.02
        for data, address in caller.speak(now):
            host.receive_datagram(data, address, now)
        caller.hear(host.datagrams_to_send(now), now)
    return now
