"""The profiles: frame rate, frames in a datagram, quantiser step. Each profile has its own trained tables."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Profile:
    """How motion is grouped into payloads and quantised.

    fps : ticks of the frame clock per second; frame numbers count ticks
    frames_per_datagram : the first frame waits for the last, which adds the delay (frames_per_datagram - 1) / fps
    step : quantiser step in each direction of the learned space, as a fraction of the eye distance
    rd_lambda : Lagrange multiplier: the squared error, in steps squared, that saving one bit may cost
    target_bits : above this size of a frame, residuals of single points wait for a later frame
    """

    name: str
    fps: int
    frames_per_datagram: int
    step: float
    rd_lambda: float
    target_bits: int

    @property
    def delay(self) -> float:
        """Return the delay that grouping frames adds, seconds."""
        return (self.frames_per_datagram - 1) / self.fps


# narrow: 2,400 bit/s have room for five datagrams a second of three frames each.
# rich: two frames in a datagram halve the cost of headers and add 33 ms.
LIVE = Profile("live", fps=15, frames_per_datagram=1, step=0.0074, rd_lambda=0.05, target_bits=64)
RICH = Profile("rich", fps=30, frames_per_datagram=2, step=0.0044, rd_lambda=0.05, target_bits=64)
NARROWBAND = Profile("narrow", fps=15, frames_per_datagram=3, step=0.0082, rd_lambda=0.05, target_bits=40)

PROFILES = {profile.name: profile for profile in (LIVE, RICH, NARROWBAND)}
