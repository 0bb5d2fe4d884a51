"""The profiles: frame rate, frames in a datagram, quantiser step, and the trained tables of each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Profile:
    """How motion is grouped into payloads and quantised.

    fps : ticks of the frame clock per second; frame numbers count ticks
    frames_per_datagram : the first frame waits for the last, which adds the delay (frames_per_datagram - 1) / fps
    step : quantiser step in each direction of the learned space, as a fraction of the eye distance
    rd_lambda : Lagrange multiplier: the squared error, in steps squared, that saving one bit may cost
    target_bits : above this size of a frame, residuals of single points wait for a later frame
    tables : the profile whose trained tables it uses
    usual_counts : numbers of frames in a datagram that cost few bits
    skip_threshold : steps: a frame that differs by less in every value need not be sent
    """

    name: str
    fps: float
    frames_per_datagram: int
    step: float
    rd_lambda: float
    target_bits: int
    tables: str
    usual_counts: tuple[int, ...]
    skip_threshold: float = 1.0

    @property
    def delay(self) -> float:
        """Return the delay that grouping frames adds, seconds."""
        return (self.frames_per_datagram - 1) / self.fps


# live: as many frames differ by 1.15 steps as a call of two at 5.4 kbit/s has room for.
# narrow: 2,400 bit/s have room for five datagrams a second of three frames each.
# rich: two frames in a datagram halve the cost of headers and add 33 ms.
# voice: a frame for each 60 ms of voice. slow: three frames for each 240 ms.
LIVE = Profile(
    "live", 15, 1, 0.0094, rd_lambda=0.10, target_bits=64, tables="live", usual_counts=(1,), skip_threshold=1.15
)
RICH = Profile("rich", 30, 2, 0.0060, rd_lambda=0.05, target_bits=64, tables="rich", usual_counts=(2,))
NARROWBAND = Profile("narrow", 15, 3, 0.0136, rd_lambda=0.065, target_bits=40, tables="narrow", usual_counts=(3,))
VOICE = Profile("voice", 50 / 3, 1, 0.0094, rd_lambda=0.10, target_bits=64, tables="live", usual_counts=(1, 2))
SLOW = Profile("slow", 12.5, 3, 0.0150, rd_lambda=0.055, target_bits=40, tables="narrow", usual_counts=(3, 6))

PROFILES = {profile.name: profile for profile in (LIVE, RICH, NARROWBAND, VOICE, SLOW)}
