"""Load libopus: the copy that PyAV's wheel bundles, else the system's.

PyAV's own encoder and decoder cannot conceal lost frames and hide most settings, so the library is called directly.
"""

import ctypes
import ctypes.util
import importlib.util
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from conf.errors import AudioError

_FUNCTIONS = {  # name -> result type and types of the fixed arguments; opus_encoder_ctl is variadic
    "opus_encoder_create": (ctypes.c_void_p, (ctypes.c_int32, ctypes.c_int, ctypes.c_int, ctypes.c_void_p)),
    "opus_encoder_destroy": (None, (ctypes.c_void_p,)),
    "opus_encoder_ctl": (ctypes.c_int, (ctypes.c_void_p, ctypes.c_int)),
    "opus_encode": (ctypes.c_int32, (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_int32)),
    "opus_decoder_create": (ctypes.c_void_p, (ctypes.c_int32, ctypes.c_int, ctypes.c_void_p)),
    "opus_decoder_destroy": (None, (ctypes.c_void_p,)),
    "opus_decode": (
        ctypes.c_int,
        (ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int32, ctypes.c_void_p, ctypes.c_int, ctypes.c_int),
    ),
    "opus_packet_get_nb_samples": (ctypes.c_int, (ctypes.c_char_p, ctypes.c_int32, ctypes.c_int32)),
}
MISSING = "Opus is missing, so voice needs Codec2: install PyAV from its wheel (pip install --force-reinstall av)."


@cache
def load_opus() -> ctypes.CDLL:
    """Return libopus with the types of its functions set. Raises AudioError if there is none."""
    for name in _candidates():
        try:
            library = ctypes.CDLL(name)
            for function, (result, arguments) in _FUNCTIONS.items():
                entry = getattr(library, function)
                # Apple's ARM calling convention differs for variadic arguments: ctypes knows them as those beyond.
                entry.restype, entry.argtypes = result, arguments
        except (OSError, AttributeError):
            continue
        return library
    raise AudioError(MISSING)


def _candidates() -> Iterator[str]:
    """Yield paths and names under which libopus may be found, best first."""
    spec = importlib.util.find_spec("av")
    for folder in spec.submodule_search_locations or () if spec else ():
        package = Path(folder)
        for libraries in (package.with_name("av.libs"), package / ".dylibs"):
            for path in sorted(libraries.glob("libopus[.-]*")):
                if sys.platform == "win32":
                    import os

                    os.add_dll_directory(str(libraries))
                yield str(path)
    system = ctypes.util.find_library("opus")
    if system:
        yield system
