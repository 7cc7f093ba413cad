"""Fits simulated photos with phiz and with eos, and compares.

Both get the same model (eos as a PcaModel: the singular value decomposition of what the model's
independent modes do to the 68 points and the face) and the same 68 points. eos fits shape and pose
with a scaled orthographic camera; it is tried with several regularisations and numbers of iterations,
and what counts is its best mean of a set, in each measure by itself. Errors of both are measured here.
How eos does with the 51 points inside of the outline alone is told too: its jaw points stand for
fixed vertices. So are our fits to the photos' pixels besides, which eos does not read: the bars are for
points alone.

Nothing beats the posterior: how far off the best estimate is of people of the model itself, if the pose
is unknown but near enough to be linear, and who estimates knows the noise. So do two more rows tell: `posterior`, errors
drawn from it, and `nearest`, the model's own face nearest to each person, which is what people are off
who are not of the model. Both together (`attainable`, the root of the sum of squares) are about what
can be had of points alone, if the model's people vary as these do: of whom the mean face is off as the
rows `mean face` and `model's people` tell.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import time

import eos
import numpy

# Ours as a part of the peer's best: the bars of the project (rigid, similarity).
BARS = {"close": (0.58, 0.58), "portrait": (0.65, 0.78), "sliding": (0.68, 0.68)}
# Of the points of a set: their noise, px; how wide faces are, px; how far jaw points slide, px.
SETS = {"close": (1.5, 300, 0), "portrait": (0.6, 120, 0), "sliding": (1.5, 300, 12)}
# The standard deviation of the logarithm of a focal length that nobody tells (photo::FOCAL).
FOCAL = 0.35
MEASURES = ("rigid", "similarity", "size", "pose")
LAMBDAS = [0.1, 0.3, 1, 3, 10, 30, 100, 300]
ITERATIONS = [5, 20]
POINTS, JAW, SIZE = 68, 17, 512


def errors(fitted, truth):
    """Mean distances after the best rigid motion and similarity, mm; the centroid size over the
    true one; the rotation from the fit to the truth (Umeyama 1991)."""
    a, b = fitted - fitted.mean(0), truth - truth.mean(0)
    u, _, v = numpy.linalg.svd(b.T @ a)
    rotation = u @ numpy.diag([1, 1, numpy.sign(numpy.linalg.det(u @ v))]) @ v
    a = a @ rotation.T
    scale = (a * b).sum() / (a * a).sum()
    rigid, similarity = (numpy.linalg.norm(k * a - b, axis=1).mean() for k in (1, scale))
    return rigid, similarity, numpy.sqrt((a * a).sum() / (b * b).sum()), rotation


def degrees(rotation):
    return numpy.degrees(numpy.arccos(numpy.clip((numpy.trace(rotation) - 1) / 2, -1, 1)))


def measure(photos, truths, fits):
    """Of a set: means of rigid, similarity and size, median of the pose in degrees."""
    rows = []
    for photo, truth, (vertices, seen) in zip(photos, truths, fits):
        rigid, similarity, size, rotation = errors(vertices, truth)
        real = numpy.array(photo["rotation"]).reshape(3, 3)
        rows.append((rigid, similarity, size, degrees(seen @ rotation.T @ real.T)))
    rows = numpy.array(rows)
    return {
        "rigid": rows[:, 0].mean(),
        "similarity": rows[:, 1].mean(),
        "size": rows[:, 2].mean(),
        "pose": numpy.median(rows[:, 3]),
    }


def morphable_model(mean, modes):
    basis, sigmas, _ = numpy.linalg.svd(modes.T, full_matrices=False)
    as_f32 = [x.astype(numpy.float32) for x in (mean, basis, sigmas**2)]
    shape = eos.morphablemodel.PcaModel(*as_f32, [])
    # fit_shape_and_pose asks for expressions: one that moves nothing to speak of (0.0001 mm).
    rest = eos.morphablemodel.Blendshape()
    rest.name, rest.deformation = "rest", numpy.full(len(mean), 1e-4, dtype=numpy.float32)
    return eos.morphablemodel.MorphableModel(
        shape, [rest], eos.morphablemodel.PcaModel(), None)


def fit(model, photo, first, iterations, weight):
    """The face's vertices, mm, and the rotation to a camera with x right, y down, z forward."""
    marks = [eos.core.Landmark(str(i), numpy.array(point, dtype=numpy.float32))
             for i, point in enumerate(photo["points"]) if i >= first]
    mesh, pose, _, _ = eos.fitting.fit_shape_and_pose(
        model, marks, eos.core.LandmarkMapper(), SIZE, SIZE, iterations, None, float(weight))
    # eos looks along -z with y up.
    rotation = numpy.diag([1, -1, -1]) @ numpy.array(pose.get_modelview())[:3, :3]
    u, _, v = numpy.linalg.svd(rotation)
    return numpy.array(mesh.vertices)[POINTS:, :3], u @ v


def posterior(photo, setting, points, modes, random, draws=20):
    """Errors of the best estimate of somebody of the model, of points at the mean head's places: the
    Gaussian posterior of coefficients with rotation, translation and focal length eliminated. Jaw points
    are told along the outline as well, if the set does not slide them; hidden ones too, which flatters."""
    noise, width, slide = setting
    focal, rotation = photo["focal"], numpy.array(photo["rotation"]).reshape(3, 3)
    face = points[POINTS:]
    depth = focal * numpy.linalg.norm(points[0] - points[JAW - 1]) / width
    centred = (points[:POINTS] - face.mean(0)) @ rotation.T
    x, y, z = (centred + [0, 0, depth]).T

    def seen(moves):
        """How points go in the image, px, that move so in the camera's frame; two rows a point."""
        u = focal * (moves[..., 0] - moves[..., 2] * x / z) / z
        v = focal * (moves[..., 1] - moves[..., 2] * y / z) / z
        return numpy.stack([u, v], -1).reshape(*moves.shape[:-2], -1).T

    axes = numpy.eye(3)
    pose = [numpy.cross(axis, centred) for axis in axes] + [numpy.tile(axis, (POINTS, 1)) for axis in axes]
    zoom = FOCAL * focal * numpy.stack([x / z, y / z], 1).reshape(-1, 1)
    rates = numpy.hstack([seen(modes[:, :POINTS] @ rotation.T), seen(numpy.array(pose)), zoom])
    jaw = focal * numpy.stack([x / z, y / z], 1)[:JAW]
    for i, along in enumerate(numpy.gradient(jaw, axis=0)):
        along /= numpy.linalg.norm(along)
        less = numpy.eye(2) - (1 - noise / numpy.hypot(noise, slide)) * numpy.outer(along, along)
        rates[2 * i : 2 * i + 2] = less @ rates[2 * i : 2 * i + 2]
    rates /= noise
    # The pose is free; the logarithm of the focal length has a prior, as coefficients have.
    prior = numpy.diag([1.0] * len(modes) + [0.0] * len(pose) + [1.0])
    covariance = numpy.linalg.inv(rates.T @ rates + prior)[: len(modes), : len(modes)]
    root = numpy.linalg.cholesky((covariance + covariance.T) / 2)
    for _ in range(draws):
        off = numpy.tensordot(root @ random.standard_normal(len(modes)), modes[:, POINTS:], 1)
        yield errors(face + off, face)[:3]


def nearest(truth, face, modes):
    """The model's face nearest to one, rigidly."""
    fitted = face
    for _ in range(3):
        _, _, _, rotation = errors(fitted, truth)
        target = (truth - truth.mean(0)) @ rotation + fitted.mean(0)
        free = [numpy.tile(axis, len(face)) for axis in numpy.eye(3)]
        basis = numpy.vstack([modes.reshape(len(modes), -1), free])
        weights = numpy.linalg.lstsq(basis.T, (target - face).ravel(), rcond=None)[0]
        fitted = face + numpy.tensordot(weights[: len(modes)], modes, 1)
    return fitted


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ict", required=True, help="the folder of ICT-FaceKit")
    parser.add_argument("--program", required=True, help="phiz-fit")
    parser.add_argument("--template", required=True, help="the generic head")
    parser.add_argument("--model", default="www/public/model.phiz", help="the model")
    parser.add_argument("--count", type=int, default=50, help="how many people")
    parser.add_argument("--seed", type=int, default=9000, help="the first person's seed")
    args = parser.parse_args()
    folder = pathlib.Path("target/peers/photo")
    command = [args.program, "photograph", "--ict", args.ict, "--template", args.template]
    command += ["--count", str(args.count), "--seed", str(args.seed), "--save", str(folder), "--pixels"]
    run = subprocess.run([*command, args.model], stdout=subprocess.DEVNULL, check=False)
    if run.returncode != 0:
        return run.returncode

    def floats(name):
        return numpy.fromfile(folder / f"{name}.f32", "<f4").astype(float)

    mean = floats("mean")
    modes = floats("modes").reshape(-1, len(mean))
    model = morphable_model(mean, modes)
    modes = modes.reshape(len(modes), -1, 3)
    face = mean.reshape(-1, 3)[POINTS:]
    random = numpy.random.default_rng(args.seed)
    results, kept = {}, True
    for setting, bars in BARS.items():
        photos = json.loads((folder / f"{setting}.json").read_text())
        truths = floats(f"{setting}.truth").reshape(-1, *face.shape)
        fitted = floats(f"{setting}.fitted").reshape(truths.shape)
        seen = [numpy.array(p["fitted_rotation"]).reshape(3, 3) for p in photos]
        rows = {"phiz": measure(photos, truths, zip(fitted, seen)),
                "mean face": measure(photos, truths, ((face, r) for r in seen))}
        by_pixels = floats(f"{setting}.pixels").reshape(truths.shape)
        turned = [numpy.array(p["pixels_rotation"]).reshape(3, 3) for p in photos]
        rows["phiz, pixels"] = measure(photos, truths, zip(by_pixels, turned))
        rows["mean face"]["pose"] = float("nan")  # it has none of its own
        drawn = [e for p in photos for e in posterior(p, SETS[setting], mean.reshape(-1, 3), modes, random)]
        rows["posterior"] = dict(zip(MEASURES, (*numpy.mean(drawn, 0), float("nan"))))
        people = (numpy.tensordot(random.standard_normal(len(modes)), modes[:, POINTS:], 1) for _ in range(400))
        vary = [errors(face, face + person)[:3] for person in people]
        rows["model's people"] = dict(zip(MEASURES, (*numpy.mean(vary, 0), float("nan"))))
        near = [errors(nearest(t, face, modes[:, POINTS:]), t)[:3] for t in truths]
        rows["nearest"] = dict(zip(MEASURES, (*numpy.mean(near, 0), float("nan"))))
        rows["attainable"] = {key: numpy.hypot(rows["posterior"][key], rows["nearest"][key])
                              for key in ("rigid", "similarity")}
        rows["attainable"].update(size=1.0, pose=float("nan"))
        for label, first in (("eos", 0), ("eos, 51 points", JAW)):
            tried = []
            started = time.perf_counter()
            for iterations in ITERATIONS:
                for weight in LAMBDAS:
                    fits = [fit(model, p, first, iterations, weight) for p in photos]
                    tried.append(measure(photos, truths, fits))
            rows[label] = {key: min(t[key] for t in tried) for key in tried[0] if key != "size"}
            rows[label]["size"] = min(tried, key=lambda t: t["rigid"])["size"]
            took = 1e3 * (time.perf_counter() - started) / len(tried) / len(photos)
            print(f"  {setting}, {label}: {took:.0f} ms a photo", file=sys.stderr, flush=True)
        results[setting] = rows
        kept = table(setting, rows, bars, len(photos)) and kept
    output = pathlib.Path("target/peers/photo.json")
    output.write_text(json.dumps({"seed": args.seed, "settings": results}, indent=1) + "\n")
    print(f"\n{output}")
    return 0 if kept else 1


def table(setting, rows, bars, people):
    """Prints one set; returns whether every bar was kept."""
    print(f"\n{setting}, {people} people")
    print(f"{'':18}{'rigid, mm':>12}{'similar, mm':>13}{'size':>9}{'pose, deg':>11}")
    for who, row in rows.items():
        print(f"{who:18}{row['rigid']:12.3f}{row['similarity']:13.3f}{row['size']:9.4f}"
              f"{row['pose']:11.2f}")
    kept = abs(rows["phiz"]["size"] - 1) <= 0.01 and rows["phiz"]["pose"] <= 0.9
    pairs = [("phiz", "eos"), ("phiz", "eos, 51 points"), ("phiz, pixels", "eos"), ("attainable", "eos")]
    for ours, peer in pairs:
        line = f"{ours} / {peer}".ljust(22)
        for key, bar in zip(("rigid", "similarity"), bars):
            ratio = rows[ours][key] / rows[peer][key]
            mark = ""
            if peer == "eos":
                kept = kept and (ratio <= bar or ours != "phiz")  # the bars are ours alone
                mark = f" ({'<=' if ratio <= bar else 'over'} {bar})"
            line += f"  {key} {ratio:.3f}{mark}"
        print(line)
    return kept


if __name__ == "__main__":
    sys.exit(main())
