"""Datagrams through a relay, a zenoh router, or through the local network without one.

Strategy. The end that waits subscribes to `conf/call/NAMEPLATE/to/*`; each caller has a random name, the last part of
the key, and subscribes to `conf/call/NAMEPLATE/from/NAME`. The nameplate is public: what is secret is sealed inside.
A key costs bytes in each message unless both sides of a link have declared it. So the waiting end declares the keys of
those it sends to more than a few times; who has just begun costs a longer key and no state.
"""

import base64
import re
import select
import threading
import time
from collections import OrderedDict, deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Self

from conf.errors import NetworkError
from conf.protocol.address import Address, RelayAddress
from conf.protocol.rate_control.rate_limit import TokenBucket
from conf.transport.interface import ReceivedDatagram
from conf.transport.link_policy import SilenceDetector
from conf.transport.relay_link import JOIN_S, RelayLink
from conf.transport.relay_probe import explain_refusal
from conf.transport.relay_settings import KEY_PREFIX, Credentials, client_settings, lan_settings, open_zenoh, url_host
from conf.transport.udp import MAX_DATAGRAM
from conf.transport.wake_up import WakeUp

if TYPE_CHECKING:
    import zenoh

MAX_QUEUED = 1024  # datagrams that wait to be received
MAX_MEMBERS = 32  # callers whose keys the waiting end has declared
# New declarations in a second, less than MAX_MEMBERS: a caller that is sent to each second is never displaced.
DECLARATIONS_PER_S = 16.0
UNDECLARED = 3  # datagrams to a caller before its key is declared
NAME_BYTES = 5
MAX_EARLY = 2  # datagrams that wait for the first session: a call begins as soon as there is one
DECLARED_S = 0.03  # for the relay to know where answers go: what is declared takes another way than datagrams
WATCHER = "nobody"  # name of no caller, to which every end that waits has subscribed
_NAMEPLATE = re.compile(r"[0-9a-z-]{1,32}")
_NAME = re.compile(r"[a-z2-7]{1,16}")


class RelayTransport:
    """One end of calls with one nameplate.

    unsent, dropped : datagrams that could not be sent, and that were received but too many, too long or ill-named
    """

    def __init__(
        self,
        nameplate: str,
        *,
        name: str = "",
        relay: tuple[str, int] | None,
        credentials: Credentials | None = None,
        open_session: "Callable[[float], zenoh.Session] | None" = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Use `wait_at` or `call` instead.

        name : of the caller, "" for the end that waits; relay : host and port, None to search the local network
        Raises ValueError if the nameplate is none.
        """
        if not _NAMEPLATE.fullmatch(nameplate):
            raise ValueError(f"nameplate: {nameplate!r} is not 1 to 32 digits, letters and dashes")
        settings = client_settings(relay, credentials) if relay else lan_settings()
        self.unsent = self.dropped = 0
        self._nameplate = nameplate
        self._name = name
        self._is_local = relay is None
        self._clock = clock
        self._received: deque[tuple[bytes, Address, float]] = deque()
        self._wake_up = WakeUp()
        self._route: _Route | None = None
        self._early: deque[tuple[bytes, Address]] = deque(maxlen=MAX_EARLY)
        self._silence = SilenceDetector()
        self._watcher: zenoh.Publisher | None = None
        self._readers: list[threading.Thread] = []
        self._link = RelayLink(
            open_session or (lambda timeout_s: open_zenoh(settings, timeout_s)),
            self._on_open,
            _fault_text(relay),
            explain=(lambda: explain_refusal(relay)) if relay else None,
            is_supervised=bool(relay),
            silence=self._silence,
        )
        self._link.start()

    @classmethod
    def wait_at(cls, relay: tuple[str, int] | None, nameplate: str, *, credentials: Credentials | None = None) -> Self:
        """Return the end that waits to be called."""
        return cls(nameplate, relay=relay, credentials=credentials)

    @classmethod
    def call(
        cls,
        relay: tuple[str, int] | None,
        nameplate: str,
        random: Callable[[int], bytes],
        *,
        credentials: Credentials | None = None,
    ) -> Self:
        """Return an end that calls. random : n -> n random bytes"""
        name = base64.b32encode(random(NAME_BYTES)).decode().lower()
        return cls(nameplate, name=name, relay=relay, credentials=credentials)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def remote(self) -> Address | None:
        """The address that stands for the end that waits, None at that end."""
        return RelayAddress(self._nameplate, "") if self._name else None

    @property
    def address(self) -> RelayAddress:
        """The address at which others see this end."""
        return RelayAddress(self._nameplate, self._name)

    @property
    def handles(self) -> list[WakeUp]:
        """What becomes readable when a datagram has arrived."""
        return [self._wake_up]

    @property
    def note(self) -> str:
        """What to tell the user while the relay does not answer, "" otherwise."""
        return self._link.fault

    @property
    def is_open(self) -> bool:
        """Whether there is a session with the relay."""
        return self._route is not None and not self._link.fault

    @property
    def carrier(self) -> str:
        """What carries datagrams to the relay: "udp", "tcp" or "" while there is no session."""
        return max(self._link.kinds, default="")

    @property
    def candidates(self) -> tuple[Address, ...]:
        """No addresses: there is nothing but the relay."""
        return ()

    @property
    def nameplate(self) -> str:
        """The number under which the ends find each other."""
        return self._nameplate

    def path_name(self, address: Address, /) -> str:
        """Return how datagrams reach an address: "relay", "relay over TCP", or without a relay "local network"."""
        if self._is_local:
            return "local network"
        return "relay over TCP" if self.carrier == "tcp" else "relay"

    @property
    def others_wait(self) -> bool:
        """Whether another end waits with this nameplate; for a caller, whether anybody does."""
        from zenoh import ZError

        try:
            return self._watcher is not None and _matches(self._watcher)
        except ZError:  # the session is being replaced
            return False

    def receive(self, limit: int, /) -> list[ReceivedDatagram]:
        """Return the datagrams that have arrived, at most `limit`."""
        self._wake_up.clear()
        now = self._clock()
        datagrams: list[ReceivedDatagram] = []
        while self._received and len(datagrams) < limit:
            data, address, arrived = self._received.popleft()
            datagrams.append(ReceivedDatagram(data, address, max(0.0, now - arrived)))
        if self._received:
            self._wake_up.set()
        return datagrams

    def send(self, datagrams: list[tuple[bytes, Address]], /) -> None:
        """Send datagrams. Before the first session the newest few wait for it; later they are lost without one.

        Raises NetworkError if the relay does not answer.
        """
        route = self._route
        if route is None and not self._link.fault:
            self._early += datagrams
            return
        for data, address in datagrams:
            is_ours = isinstance(address, RelayAddress) and address.nameplate == self._nameplate
            if route is None or not is_ours or not route.send(data, str(address[1]), self._clock()):
                self.unsent += 1
            else:
                self._silence.on_sent(self._clock())
        if datagrams and self._link.fault:
            raise NetworkError(self._link.fault)

    def wait(self, seconds: float, /) -> None:
        """Sleep until a datagram arrives, at most `seconds`."""
        select.select([self._wake_up], [], [], max(seconds, 0.0))

    def renew(self) -> None:
        """Open another session with the relay, from other ports, if the last one is not a few seconds old."""
        self._silence.on_unheard(self._clock())

    def close(self) -> None:
        """Leave the relay."""
        self._route = None
        self._link.close()
        for reader in self._readers:  # one that is in zenoh when the interpreter ends would abort the process
            reader.join(JOIN_S)
        self._wake_up.close()

    def _on_open(self, session: "zenoh.Session") -> None:
        """Declare what this end receives and sends."""
        key = f"{KEY_PREFIX}/{self._nameplate}"
        self._watcher = _declare_watcher(session, f"{key}/to/{self._name or WATCHER}")
        if self._name:
            self._read(session.declare_subscriber(f"{key}/from/{self._name}"))
            route = _CallerRoute(_declare_publisher(session, f"{key}/to/{self._name}"))
            time.sleep(DECLARED_S)
            while self._early:
                route.send(self._early.popleft()[0], "", self._clock())
            self._route = route
        else:
            self._read(session.declare_subscriber(f"{key}/to/*"))
            self._route = _WaiterRoute(session, f"{key}", self._link.call)

    def _read(self, subscriber: "zenoh.Subscriber[zenoh.Handler[zenoh.Sample]]") -> None:
        """Receive in a thread until the session is closed. zenoh's own threads for callbacks cannot be joined."""
        reader = threading.Thread(target=self._receive_all, args=(subscriber,), name="relay-receive", daemon=True)
        self._readers = [*(thread for thread in self._readers if thread.is_alive()), reader]
        reader.start()

    def _receive_all(self, subscriber: "zenoh.Subscriber[zenoh.Handler[zenoh.Sample]]") -> None:
        for sample in subscriber.handler:
            self._on_sample(sample)

    def _on_sample(self, sample: "zenoh.Sample") -> None:
        """Queue a datagram."""
        name = "" if self._name else str(sample.key_expr).rpartition("/")[2]
        is_valid = len(sample.payload) <= MAX_DATAGRAM and (bool(self._name) or bool(_NAME.fullmatch(name)))
        if not is_valid or len(self._received) >= MAX_QUEUED:
            self.dropped += 1
            return
        self._silence.on_received(self._clock())
        self._received.append((sample.payload.to_bytes(), RelayAddress(self._nameplate, name), self._clock()))
        self._wake_up.set()


class _CallerRoute:
    """The way to the end that waits."""

    def __init__(self, publisher: "zenoh.Publisher") -> None:
        self._publisher = publisher

    def send(self, data: bytes, name: str, now: float) -> bool:
        """Send a datagram. Returns whether zenoh has accepted it."""
        return _put(self._publisher, data)


class _WaiterRoute:
    """The ways to all callers."""

    def __init__(
        self, session: "zenoh.Session", key: str, call: "Callable[[Callable[[zenoh.Session], None]], bool]"
    ) -> None:
        """call : lets another thread make declarations, as these may block"""
        self._session = session
        self._key = key
        self._call = call
        self._publishers: OrderedDict[str, zenoh.Publisher] = OrderedDict()
        self._subscribers: dict[str, zenoh.Subscriber[Any]] = {}
        self._counts: OrderedDict[str, int] = OrderedDict()
        self._declarations = TokenBucket(DECLARATIONS_PER_S, DECLARATIONS_PER_S)
        self._lock = threading.Lock()

    def send(self, data: bytes, name: str, now: float) -> bool:
        """Send a datagram to a caller. Returns whether zenoh has accepted it."""
        import zenoh

        with self._lock:
            publisher = self._publishers.get(name)
            if publisher:
                self._publishers.move_to_end(name)
        if publisher:
            return _put(publisher, data)
        self._count(name, now)
        try:
            self._session.put(f"{self._key}/from/{name}", data, congestion_control=zenoh.CongestionControl.DROP)
        except zenoh.ZError:
            return False
        return True

    def _count(self, name: str, now: float) -> None:
        """Declare the key of a caller that is sent to again and again."""
        count = self._counts.pop(name, 0) + 1
        if count == UNDECLARED:
            if not self._declarations.consume(1, now) or not self._call(lambda session: self._declare(session, name)):
                count -= 1
        self._counts[name] = count
        if len(self._counts) > MAX_MEMBERS:
            self._counts.popitem(last=False)

    def _declare(self, session: "zenoh.Session", name: str) -> None:
        from zenoh import handlers

        if session is not self._session:
            return
        # Nobody needs its messages, which the other subscriber gets: with it the router knows the key by a number.
        subscriber = session.declare_subscriber(f"{self._key}/to/{name}", handlers.RingChannel(1))
        publisher = _declare_publisher(session, f"{self._key}/from/{name}")
        with self._lock:
            self._publishers[name], self._subscribers[name] = publisher, subscriber
            if len(self._publishers) <= MAX_MEMBERS:
                return
            oldest, displaced = self._publishers.popitem(last=False)
            unused = self._subscribers.pop(oldest)
        displaced.undeclare()
        unused.undeclare()


_Route = _CallerRoute | _WaiterRoute


def _declare_publisher(session: "zenoh.Session", key: str) -> "zenoh.Publisher":
    import zenoh

    return session.declare_publisher(
        key, reliability=zenoh.Reliability.BEST_EFFORT, congestion_control=zenoh.CongestionControl.DROP, express=False
    )


def _declare_watcher(session: "zenoh.Session", key: str) -> "zenoh.Publisher":
    """Return a publisher that knows whether another session has subscribed to a key."""
    import zenoh

    return session.declare_publisher(key, allowed_destination=zenoh.Locality.REMOTE)


def _matches(publisher: "zenoh.Publisher") -> bool:
    """Return whether another session has subscribed. zenoh's annotation says bool; it returns an object."""
    status: Any = publisher.matching_status
    return bool(status.matching)


def _put(publisher: "zenoh.Publisher", data: bytes) -> bool:
    import zenoh

    try:
        publisher.put(data)
    except zenoh.ZError:  # the session is being replaced
        return False
    return True


def _fault_text(relay: tuple[str, int] | None) -> str:
    if relay is None:
        return "the local network cannot be searched: name a relay with --relay HOST"
    name = f"{url_host(relay[0])}:{relay[1]}"
    return f"the relay {name} does not answer or refuses the password: check its name, password and this network"
