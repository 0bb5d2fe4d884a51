"""The profiles: how many frames a second, how many in a datagram, how fine. The trained tables have a set for each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Profile:
    """How motion is cut into bundles and quantised.

    fps : ticks of the frame clock a second; frame numbers count ticks
    bundle : frames in a datagram; the first waits for the last, so it adds (bundle - 1) / fps seconds of delay
    step : the quantiser's step in each direction of the learned space, as a share of the eye distance
    trade : squared error, in steps squared, that one bit less may cost
    budget_bits : what a frame may cost before corrections of single points wait for a later frame
    """

    name: str
    fps: int
    frames_per_datagram: int
    step: float
    rd_lambda: float
    target_bits: int

    @property
    def delay(self) -> float:
        """Return the delay in seconds that bundling adds."""
        return (self.frames_per_datagram - 1) / self.fps


# live: one frame a datagram, at 15 a second. narrow: 2,400 bit/s have room for five datagrams a second of three frames.
# rich: two frames a datagram cost half the headers, and a thirtieth of a second.
LIVE = Profile("live", fps=15, frames_per_datagram=1, step=0.0074, rd_lambda=0.05, target_bits=64)
RICH = Profile("rich", fps=30, frames_per_datagram=2, step=0.0044, rd_lambda=0.05, target_bits=64)
NARROWBAND = Profile("narrow", fps=15, frames_per_datagram=3, step=0.0082, rd_lambda=0.05, target_bits=40)

PROFILES = {profile.name: profile for profile in (LIVE, RICH, NARROWBAND)}
