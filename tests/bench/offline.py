"""The offline half of phiz beside its peers: the same numbers, in turns, each on one thread.

    python offline.py PROGRAM MODEL OUT.json

PROGRAM is offline.rs beside this, built. What everybody finds must agree, or this fails.
"""

import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

# Before numpy and the others read them.
for name in ("OMP", "OPENBLAS", "MKL", "IGL"):
    os.environ[f"{name}_NUM_THREADS"] = "1"

import igl
import numpy
import scipy
import sklearn
from scipy.interpolate import RBFInterpolator
from sklearn.decomposition import PCA

ROUNDS = 7


def peers(folder):
    """For each task what the peers do, what of it is compared, and how far apart it may be."""

    def read(name, *shape, kind="<f8"):
        return numpy.fromfile(folder / name, kind).reshape(*shape)

    surface, queries = read("surface", -1, 3), read("queries", -1, 3)
    triangles = read("triangles", -1, 3, kind="<u4").astype(numpy.int64)
    faces = read("faces", 200, -1)
    source, target, head = (read(name, -1, 3) for name in ("from", "to", "head"))

    def closest():
        squared = igl.point_mesh_squared_distance(queries, surface, triangles)[0]
        return numpy.sqrt(squared)

    def svd():
        centred = faces - faces.mean(axis=0)
        _, sigmas, modes = numpy.linalg.svd(centred, full_matrices=False)
        return (sigmas**2 / (len(faces) - 1))[:-1]

    def gram():
        centred = faces - faces.mean(axis=0)
        values, vectors = numpy.linalg.eigh(centred @ centred.T)
        values, vectors = values[:0:-1], vectors[:, :0:-1]
        modes = vectors.T @ centred / numpy.sqrt(values)[:, None]
        return values / (len(faces) - 1)

    def learned():
        return PCA(n_components=len(faces) - 1, svd_solver="full").fit(faces).explained_variance_

    def rbf():
        return RBFInterpolator(source, target, kernel="linear", degree=1)(head).ravel()

    # Closest points are found in single precision, of coordinates of some 100 mm; variances of modes
    # that the rounding of a model's faces makes are not compared.
    return {
        "closest": ({"libigl": closest}, slice(None), 1e-4,
                    f"closest point, {len(queries)} queries on {len(triangles)} triangles"),
        "pca": ({"numpy, SVD": svd, "numpy, Gram": gram, "scikit-learn": learned},
                slice(0, 60), 1e-6, f"PCA of {len(faces)} faces of {faces.shape[1]} numbers"),
        "rbf": ({"scipy": rbf}, slice(None), 1e-6,
                f"RBF warp of {len(head)} points by {len(source)} landmarks"),
    }


def main():
    program, model, out = sys.argv[1:]
    report = {"versions": {m.__name__: m.__version__ for m in (numpy, scipy, sklearn)}}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        ours = subprocess.Popen([program, model, name], stdin=subprocess.PIPE,
                                stdout=subprocess.PIPE, text=True)
        if ours.stdout.readline().strip() != "ready":
            return "phiz did not start"
        tasks = {}
        for task, (others, compared, apart, what) in peers(folder).items():
            times = {"phiz": []}
            for _ in range(ROUNDS):
                print(task, file=ours.stdin, flush=True)
                answer = ours.stdout.readline()
                if not answer:
                    return f"phiz ended at {task}"
                times["phiz"].append(float(answer))
                found = numpy.fromfile(folder / f"{task}.f64")
                for peer, work in others.items():
                    started = time.perf_counter()
                    result = work()
                    times.setdefault(peer, []).append(time.perf_counter() - started)
                    off = numpy.abs(result[compared] - found[compared])
                    scale = max(1.0, numpy.abs(found[compared]).max())
                    if off.max() > apart * scale:
                        return f"{task}: {peer} and phiz are {off.max()} apart"
            medians = {who: statistics.median(all) for who, all in times.items()}
            print(f"\n{what}")
            for who, all in times.items():
                spread = f"({1e3 * min(all):.1f} to {1e3 * max(all):.1f})"
                ratio = medians[who] / medians["phiz"]
                print(f"  {who:31}{1e3 * medians[who]:9.1f} ms {spread:24}{ratio:8.2f} x")
            tasks[task] = {who: {"seconds": medians[who], "spread": [min(all), max(all)]}
                           for who, all in times.items()}
        ours.stdin.close()
        ours.wait()
    pathlib.Path(out).write_text(json.dumps({**report, "tasks": tasks}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
