"""Learns a sparse basis with phiz and with numpy, and compares.

Everybody starts from the same samples, penalties, components and weights (phiz-fit writes them) and
makes the same number of outer iterations. They take turns, on one thread and on two, so that a busy
machine is busy for all; the medians count. Only the iterations are timed, not reading or the start.

The peers are Neumann et al.'s method as it is usually written with numpy:

- "numpy": the residual is kept, and each weight's update adds its component to the residual and
  takes it off again; ADMM works on whole matrices with a Cholesky factor. This is how the authors'
  own program goes about it. The bar is against this one.
- "numpy, Gram": phiz's own algorithm. Weights from C C' and X C', and each weight's update is the
  minimum over the weights and the size of the component at once, where the authors' program divides
  the weights by the largest. It shows that both solve the same problem: the objectives must agree.
"""

import argparse
import json
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time

# Time of numpy's over ours, how far our objective may be above numpy's, and how far from that of the
# same algorithm.
FASTER = 15.0
OBJECTIVE = 1e-3

# The penalty parameter and the number of steps of ADMM in the authors' program.
RHO = 10.0
STEPS = 10

# How phiz-fit says how long it took.
SECONDS = r"([\d.]+) s for the start, ([\d.]+) s for the iterations"


def shrink(numpy, penalty, x):
    """The proximal map of a penalty on the length of each vertex's displacement."""
    length = numpy.sqrt((x**2).sum(axis=2))
    with numpy.errstate(divide="ignore", invalid="ignore"):
        left = numpy.maximum(0.0, 1.0 - penalty / length)
    return x * numpy.nan_to_num(left)[:, :, None]


def project(numpy, weights):
    """To weights whose largest is 1 or -1."""
    largest = numpy.abs(weights).max()
    return weights if largest == 0 else weights / largest


def level(numpy, best, square, penalty):
    """Where weights are cut off when the component may grow (see weights.rs)."""
    sums = numpy.cumsum(numpy.sort(numpy.abs(best))[::-1]) - penalty / (2 * square)
    return max(0.0, (sums / numpy.arange(1, len(best) + 1)).max())


def learn(peer, folder):
    """One peer's run: the objective after each iteration, and the seconds."""
    import numpy
    from scipy.linalg import cho_factor, cho_solve

    header = json.loads((folder / "problem.json").read_text())
    faces, vertices, count = header["faces"], header["vertices"], header["components"]

    def matrix(name, *shape):
        return numpy.fromfile(folder / f"{name}.f64").reshape(shape)

    x = matrix("samples", faces, 3 * vertices)
    c = matrix("components", count, 3 * vertices)
    w = matrix("weights", faces, count)
    # The objective is halved, as the authors have it; infinite penalties forbid all the same.
    penalty = matrix("lambda", count, vertices) / 2
    forbidden = numpy.isinf(penalty)
    dual = numpy.zeros((count, vertices, 3))
    objectives = []

    began = time.perf_counter()
    residual = x - w @ c
    for _ in range(header["iterations"]):
        if peer == "numpy":
            for k in range(count):
                square = c[k] @ c[k]
                if square <= 1e-8:
                    w[:, k] = 0
                    continue
                residual += numpy.outer(w[:, k], c[k])
                w[:, k] = project(numpy, residual @ c[k] / square)
                residual -= numpy.outer(w[:, k], c[k])
        else:
            outer, cross = c @ c.T, x @ c.T
            lengths = numpy.sqrt((c.reshape(count, vertices, 3) ** 2).sum(axis=2))
            penalties = 2 * (numpy.where(forbidden, 0.0, penalty) * lengths).sum(axis=1)
            for k in range(count):
                if outer[k, k] <= 0:
                    continue
                best = (cross[:, k] - w @ outer[:, k]) / outer[k, k] + w[:, k]
                size = level(numpy, best, outer[k, k], penalties[k])
                if size > 0:
                    w[:, k] = numpy.clip(best, -size, size) / size
                outer[k] *= size
                outer[:, k] *= size
                cross[:, k] *= size
                c[k] *= size
        z = c.reshape(count, vertices, 3).copy()
        gram, products = w.T @ w, w.T @ x
        factor = cho_factor(gram + RHO * numpy.eye(count))
        for _ in range(STEPS):
            right = products + RHO * (z - dual).reshape(count, -1)
            free = cho_solve(factor, right).reshape(count, vertices, 3)
            z = shrink(numpy, penalty / RHO, free + dual)
            dual = dual + free - z
        c = z.reshape(count, -1)
        residual = x - w @ c
        lengths = numpy.sqrt((z**2).sum(axis=2))
        sparsity = (numpy.where(forbidden, 0.0, penalty) * lengths).sum()
        objectives.append(float((residual**2).sum() + 2 * sparsity))
        if (lengths[forbidden] > 0).any():
            objectives[-1] = float("inf")
    return {"objective": objectives, "seconds": time.perf_counter() - began}


def run(command, threads):
    variables = ["RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"]
    environment = os.environ | {name: str(threads) for name in variables}
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"sparse.py: {' '.join(map(str, command))}\n{done.stderr}")
    return done.stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--program", type=pathlib.Path, default="target/release/phiz-fit")
    parser.add_argument("--template", type=pathlib.Path)
    parser.add_argument("--faces", type=pathlib.Path, help="a folder of registered faces")
    parser.add_argument("--count", type=int, default=200, help="of how many faces, the first")
    parser.add_argument("--components", type=int, default=65)
    parser.add_argument("--iterations", type=int, default=10)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--out", type=pathlib.Path, default="target/peers/sparse.json")
    parser.add_argument("--peer", nargs=2, metavar=("NAME", "DIR"), help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.peer:
        print(json.dumps(learn(args.peer[0], pathlib.Path(args.peer[1]))))
        return 0
    if not (args.template and args.faces):
        parser.error("--template and --faces are needed")

    with tempfile.TemporaryDirectory() as scratch:
        scratch = pathlib.Path(scratch)
        chosen = sorted(args.faces.glob("*.ply"))[: args.count]
        if len(chosen) < args.count:
            sys.exit(f"sparse.py: {args.faces} has {len(chosen)} faces, not {args.count}")
        (scratch / "faces").mkdir()
        for face in chosen:
            (scratch / "faces" / face.name).symlink_to(face.resolve())
        ours = [args.program, "basis", "--template", args.template, "--faces", scratch / "faces"]
        ours += ["--area", "head", "--one-sided", "--plain", "--tolerance", "0"]
        ours += ["--components", str(args.components), "--iterations", str(args.iterations)]
        ours += ["-o", scratch / "basis.json"]
        run([*ours, "--save-problem", scratch / "problem"], 2)
        results = {}
        for repeat in range(args.repeats):
            for threads in (1, 2):
                for name in ("phiz", "numpy", "numpy, Gram"):
                    if name == "phiz":
                        said = run(ours, threads)
                        report = json.loads((scratch / "basis.json").read_text())["report"]
                        start, rest = re.search(SECONDS, said).groups()
                        one = {"seconds": float(rest), "start": float(start)}
                        one["objective"] = report["objective"][1:]
                    else:
                        peer = [sys.executable, __file__, "--peer", name, scratch / "problem"]
                        one = json.loads(run(peer, threads))
                    results.setdefault(name, {}).setdefault(threads, []).append(one)
                    print(
                        f"{repeat + 1}/{args.repeats} {threads} threads {name:12}"
                        f" {one['seconds']:8.2f} s",
                        file=sys.stderr,
                    )
        header = json.loads((scratch / "problem" / "problem.json").read_text())
    args.out.parent.mkdir(parents=True, exist_ok=True)
    args.out.write_text(json.dumps({"problem": header, "results": results}, indent=1))
    return 0 if table(header, results) else 1


def table(header, results):
    """Prints the comparison; whether every bar is met."""
    kept = True
    iterations = header["iterations"]
    print(
        f"{header['components']} components of {header['faces']} faces x {header['vertices']}"
        f" vertices, {iterations} outer iterations"
    )
    for threads in (1, 2):
        seconds = {
            name: statistics.median(one["seconds"] for one in runs[threads])
            for name, runs in results.items()
        }
        for name, value in seconds.items():
            objective = results[name][threads][0]["objective"][-1]
            line = f"{threads} threads {name:12} {1000 * value / iterations:9.0f} ms an iteration"
            line += f"  objective {objective:.6e}"
            if name != "phiz":
                faster = value / seconds["phiz"]
                above = results["phiz"][threads][0]["objective"][-1] / objective - 1
                line += f"  phiz {faster:6.1f} times as fast, objective {100 * above:+.3f} %"
                good = abs(above) <= OBJECTIVE
                if name == "numpy":
                    good = faster >= FASTER and above <= OBJECTIVE
                kept = kept and good
                line += "" if good else "  MISSED"
            print(line)
    return kept


if __name__ == "__main__":
    sys.exit(main())
