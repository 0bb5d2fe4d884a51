"""What is Codec2's own here: its modes and the concealment that this program adds."""

import numpy as np
import pytest

from conf.audio.codecs.codec2 import Codec2Decoder, Codec2Encoder
from conf.audio.samples import level_dbfs
from conf.errors import AudioError
from tests.support.synthetic_voice import max_jump, vowel


def test_modes_that_do_not_exist_are_named() -> None:
    with pytest.raises(AudioError, match="Codec2 has no mode of 450 bit/s in frames of 40 ms, only 3200 bit/s in"):
        Codec2Encoder(450, 40)
    with pytest.raises(AudioError, match="Codec2 has no mode of 1200 bit/s in frames of 20 ms"):
        Codec2Decoder(1200, 20)


def test_a_long_loss_leaves_the_decoder_alone() -> None:
    """Repeating frames moves the predictor of energy: after ten the sound came back at another level."""
    encoder = Codec2Encoder(2400, 20)
    frames = [encoder.encode(frame) for frame in vowel(2, 1.2, pitch=130).reshape(-1, 320)]
    after = []
    for lost in (3, 20):
        decoder = Codec2Decoder(2400, 20)
        for frame in frames[:20]:
            decoder.decode(frame)
        for _ in range(lost):
            decoder.conceal()
        after.append(np.concatenate([decoder.decode(frame) for frame in frames[20:24]]))
    difference = np.abs(after[0].astype(int) - after[1])[64:]  # without the tail of the resampler, 4 ms
    assert difference.max() < 100  # libcodec2 draws random phases
    assert level_dbfs(after[0][-640:]) == pytest.approx(level_dbfs(after[1][-640:]), abs=0.2)


@pytest.mark.parametrize(("bit_rate", "held", "faded"), [(3200, 2, 8), (2400, 0, 3)])
def test_lost_frames_fade_to_silence_and_the_first_good_one_fades_in(bit_rate: int, held: int, faded: int) -> None:
    encoder, decoder = Codec2Encoder(bit_rate, 20), Codec2Decoder(bit_rate, 20)
    frames = [encoder.encode(frame) for frame in vowel(0, 0.6).reshape(-1, 320)]
    before = [decoder.decode(frame) for frame in frames[:20]]
    lost = [decoder.conceal() for _ in range(faded + 2)]
    levels = [level_dbfs(frame) for frame in (before[-1], *lost)]
    assert levels[1 : 1 + held] == pytest.approx(levels[:1] * held, abs=1.0)
    assert levels[held:] == sorted(levels[held:], reverse=True)
    assert level_dbfs(lost[faded][64:]) < -90  # the resampler's tail of 4 ms holds a rest of the one before
    good = decoder.decode(frames[25])
    assert level_dbfs(good[:80]) < level_dbfs(good[-80:]) - 6
    assert max_jump(good) < 1.5 * max_jump(before[-1])
