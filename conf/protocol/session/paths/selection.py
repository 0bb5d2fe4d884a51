"""Choose the path of a session: over the relay, or directly. No I/O, no clock.

Strategy. A session that was made over a relay begins there. Both ends announce their addresses under the seal, and
probe those of the other. An address that answers directly becomes the path in use; the relay is remembered. While the
direct path is in use, every datagram that arrives directly shows that it works. After SUSPECT_S without one it is
probed, and after FALLBACK_S, if PROBED_S have passed since the first probe, the end goes back to the relay: an end
that has been busy for long must ask before it judges. A direct path may fail in one direction only, which just
one end notices: so an end that receives content over the relay, after the other has sent content directly, follows it
back. It is sent an announcement at once. From then on the addresses are probed again, slowly.

While the relay is in use, it is probed too after SUSPECT_S without a datagram. A relay may be unreachable in one
direction only, as when a NAT forgets half of a mapping; then the end that hears nothing cannot tell which. Its probes
tell the other end, which may not be heard: who receives them for UNHEARD_S should reach the relay in another way.

A session that was made without a relay follows a peer that moves, as validated by PathValidation. With a relay, only
the end that was called follows from one direct path to another, or each would follow the other for ever.
Source: RFC 8445 (candidates, checks), RFC 7675 (consent), without priorities: the first path that answers is good.
"""

from collections import OrderedDict
from collections.abc import Sequence

from conf.errors import ProtocolError
from conf.protocol.address import Address, RelayAddress, SocketAddress
from conf.protocol.rate_control.rate_limit import TokenBucket
from conf.protocol.session.handshake import RandomBytes
from conf.protocol.session.paths.candidates import (
    MAX_CANDIDATES,
    MAX_REVISION,
    PATH_CANDIDATES,
    PathCandidates,
    decode_candidates,
    encode_candidates,
    has_loopback,
    usable_candidates,
)
from conf.protocol.session.paths.validation import PATH_ANSWER, PATH_PROBE, PathValidation

SUSPECT_S = 1.2  # without a datagram: something is sent each second
FALLBACK_S = 1.7
PROBED_S = 0.4
RELAY_PROBE_S = 0.25  # between probes to a silent relay
UNHEARD_S = 0.7  # of probes over the relay: four, unless some are lost; by then an end that is deaf has helped itself
PROBED_LATELY_S = 1.0  # after that the peer has heard something
FAST_S = 3.0  # for which new addresses are probed often
FAST_INTERVAL_S = 0.06  # between probes to any of them
SLOW_INTERVAL_S = 4.0  # seven addresses are each probed again within the 30 s after which some NATs forget a mapping
ANNOUNCE_INTERVAL_S = 0.25
ANNOUNCE_OFTEN = 20  # announcements without an answer, then they come at SLOW_INTERVAL_S
# What a peer can cause to be probed: so many addresses at first, then one more in NEW_ADDRESS_S.
MAX_ADDRESSES = 16
NEW_ADDRESS_S = 30.0
_CONTROL = (PATH_PROBE, PATH_ANSWER)  # bodies that say nothing about the path in use


class PathSelection:
    """Where the datagrams of one session go.

    address : of the path in use
    relay : the peer's address on the relay, None while none is known
    is_unheard : whether the peer hears nothing of what this end sends over the relay
    """

    def __init__(self, address: Address, now: float, *, random: RandomBytes, is_caller: bool) -> None:
        """random : n -> n random bytes"""
        self.address = address
        self.relay = address if isinstance(address, RelayAddress) else None
        self._is_caller = is_caller
        self._validation = PathValidation(random)
        self._pending: list[tuple[bytes, Address]] = []
        self.is_unheard = False
        self._heard_directly = self._heard = now
        self._relay_probe_at = now
        self._is_probed = False  # by the peer over the relay in use, since the last step
        self._probed: tuple[float, float] | None = None  # first and last step at which it was
        self._suspected_at: float | None = None  # the direct path in use, with the first probe
        self._is_peer_direct = False  # the newest content came directly
        self._announcement = Announcement()
        self._remote: list[SocketAddress] = []
        self._known: OrderedDict[SocketAddress, None] = OrderedDict()
        self._new_addresses = TokenBucket(1 / NEW_ADDRESS_S, MAX_ADDRESSES)
        self._fast_until = float("-inf")
        self._probe_at = now

    @property
    def is_direct(self) -> bool:
        """Whether the path in use avoids the relay."""
        return not isinstance(self.address, RelayAddress)

    def set_local(self, addresses: Sequence[Address]) -> None:
        """Announce other addresses of this end, if they have changed."""
        self._announcement.set_addresses(usable_candidates(addresses, loopback=True))

    def receive(self, body: bytes, address: Address, now: float, *, is_newest: bool) -> bool:
        """Apply an authentic body that came from an address. Returns whether the path in use has changed.

        is_newest : no later datagram has arrived before it; a late one says nothing about where the peer is now
        """
        self._heard = now
        is_relayed = isinstance(address, RelayAddress)
        self._is_probed |= is_relayed and address == self.address and body[:1] == bytes((PATH_PROBE,))
        if not is_relayed:
            self._heard_directly, self._suspected_at = now, None
        if answer := self._validation.answer_to(body, now):
            self._pending.append((answer, address))
        if body[:1] == bytes((PATH_CANDIDATES,)):
            self._receive_candidates(body[1:], now)
        before = self.address
        validated = self._validation.validated_by(body, now)
        if validated and not (self.relay and is_relayed and not isinstance(validated, RelayAddress)):
            self._on_validated(validated)
        if is_newest and body[:1] not in [bytes((kind,)) for kind in _CONTROL]:
            self._follow(address)
        if address != self.address and is_newest and self._should_probe(address, now):
            self._probe(address, now)
        return self.address != before

    def bodies_to_send(self, now: float) -> list[tuple[bytes, Address]]:
        """Return the probes, answers and announcements that are due, each for a datagram of its own."""
        if self.relay:
            if self.is_direct:
                self._watch(now)
            if not self.is_direct:
                self._search(now)
                self._watch_relay(now)
            self._note_probes(now)
            if announced := self._announcement.body(now):
                self._pending.append((announced, self.address))
        pending, self._pending = self._pending, []
        return pending

    def _on_validated(self, validated: Address) -> None:
        if isinstance(validated, RelayAddress):
            self.relay = validated
            if self.is_direct and self._is_peer_direct:
                return
        self.address = validated

    def _follow(self, address: Address) -> None:
        """Note on which path the peer sends content; go back to the relay when it has done so."""
        if not isinstance(address, RelayAddress):
            self._is_peer_direct = True
        elif self._is_peer_direct:
            self._is_peer_direct = False
            if address == self.relay:
                self._leave_direct_path()

    def _should_probe(self, address: Address, now: float) -> bool:
        """Return whether the peer may be at another address, from which its newest datagram came."""
        if isinstance(address, RelayAddress):
            return address != self.relay
        is_kept = self.relay and self.is_direct and self._is_caller and now < self._heard_directly + SUSPECT_S
        return not is_kept

    def _probe(self, address: Address, now: float) -> None:
        if probe := self._validation.probe(address, now):
            self._pending.append((probe, address))

    def _watch(self, now: float) -> None:
        """Probe the direct path when it is silent, and go back to the relay when it stays so."""
        silence_s = now - self._heard_directly
        if silence_s >= SUSPECT_S and self._suspected_at is None:
            self._suspected_at = now
        if silence_s >= FALLBACK_S and self._suspected_at is not None and now >= self._suspected_at + PROBED_S:
            self._is_peer_direct = False
            self._leave_direct_path()
            self._probe_at = now + SLOW_INTERVAL_S / 2
        elif silence_s >= SUSPECT_S:
            self._probe(self.address, now)

    def _watch_relay(self, now: float) -> None:
        """Probe the relay when it is silent."""
        if now >= max(self._heard + SUSPECT_S, self._relay_probe_at):
            self._relay_probe_at = now + RELAY_PROBE_S
            self._probe(self.address, now)

    def _note_probes(self, now: float) -> None:
        """Find out whether the peer has heard nothing for long.

        What has arrived between two steps counts once: an end that was busy has sent nothing either.
        """
        if self._probed and now >= self._probed[1] + PROBED_LATELY_S:
            self._probed = None
        if self._is_probed:
            self._is_probed = False
            self._probed = self._probed[0] if self._probed else now, now
        self.is_unheard = self._probed is not None and self._probed[1] - self._probed[0] >= UNHEARD_S

    def _leave_direct_path(self) -> None:
        """Use the relay, and keep the direct path as the first that is tried again."""
        self._suspected_at = None
        if self.relay and not isinstance(self.address, RelayAddress):
            self._remote = [self.address, *(a for a in self._remote if a != self.address)][:MAX_CANDIDATES]
            self.address = self.relay
            self._announcement.send_at_once()

    def _search(self, now: float) -> None:
        """Probe the peer's addresses one after another."""
        if now < self._probe_at or not self._remote:
            return
        self._probe_at = now + (FAST_INTERVAL_S if now < self._fast_until else SLOW_INTERVAL_S)
        address = self._remote.pop(0)
        self._remote.append(address)
        self._probe(address, now)

    def _receive_candidates(self, data: bytes, now: float) -> None:
        try:
            candidates = decode_candidates(data)
        except ProtocolError:  # counted where bodies are
            return
        if not self.relay or not self._announcement.receive(candidates, now):
            return
        allowed = usable_candidates(candidates.addresses, loopback=has_loopback(self._announcement.addresses))
        self._remote = [address for address in allowed if self._is_admitted(address, now)]
        self._fast_until, self._probe_at = now + FAST_S, now

    def _is_admitted(self, address: SocketAddress, now: float) -> bool:
        if address not in self._known and not self._new_addresses.consume(1, now):
            return False
        self._known[address] = None
        self._known.move_to_end(address)
        if len(self._known) > MAX_ADDRESSES:
            self._known.popitem(last=False)
        return True


class Announcement:
    """When to send one's own addresses: until the peer has them, and when it asks. addresses : announced"""

    def __init__(self) -> None:
        self.addresses: tuple[SocketAddress, ...] = ()
        self._revision = 1
        self._is_seen = False
        self._seen = 0
        self._due = float("-inf")
        self._sent = 0
        self._is_asked = False

    def set_addresses(self, addresses: tuple[SocketAddress, ...]) -> None:
        """Change what is announced."""
        if addresses != self.addresses:
            if self._sent:
                self._revision = self._revision % MAX_REVISION + 1
            self.addresses, self._is_seen, self._sent = addresses, False, 0

    def send_at_once(self) -> None:
        """Announce the addresses although the peer knows them: it learns which path is in use."""
        self._is_asked, self._due = True, float("-inf")

    def receive(self, candidates: PathCandidates, now: float) -> bool:
        """Note what the peer has, and wants. Returns whether its addresses are new."""
        self._is_seen |= candidates.seen == self._revision and self._sent > 0
        self._is_asked |= candidates.wanted
        is_new = candidates.revision != self._seen
        self._seen = candidates.revision
        return is_new

    def body(self, now: float) -> bytes | None:
        """Return the body that is due, None if none is."""
        is_wanted = not self._is_seen and (self._sent < ANNOUNCE_OFTEN or now >= self._due + SLOW_INTERVAL_S)
        if now < self._due or not (is_wanted or self._is_asked):
            return None
        self._due, self._is_asked = now + ANNOUNCE_INTERVAL_S, False
        self._sent += 1
        candidates = PathCandidates(self._revision, self._seen, not self._is_seen, self.addresses)
        return bytes((PATH_CANDIDATES,)) + encode_candidates(candidates)
