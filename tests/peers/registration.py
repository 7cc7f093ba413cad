"""Registers simulated people with phiz and with trimesh's non-rigid ICPs, and compares.

Everybody gets the same scans, the same template and the same 68 landmarks, runs on one thread and
takes turns on each person, so that a busy machine is busy for all. The peers get the template's
skin alone (eyeballs and cavities would only mislead them), a similarity Procrustes start by the
landmarks, and their documented defaults; they bring both meshes to unit size by themselves.
`phiz-fit evaluate` measures all of them. Drift is measured against each one's own registration of
ICT's mean head, so that nobody has to share another's idea of where a vertex belongs.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import time

import numpy
import trimesh

PEERS = {
    "nricp_sumner": trimesh.registration.nricp_sumner,
    "nricp_amberg": trimesh.registration.nricp_amberg,
}

# Ours as a part of the peer's: the bars of the project.
BARS = {
    ("drift", "nricp_sumner"): 0.6,
    ("drift", "nricp_amberg"): 0.35,
    ("seconds", "nricp_sumner"): 1 / 40,
}


def landmarks(path):
    points = json.loads(path.read_text())
    return numpy.array([points[f"ibug_{i:02}"] for i in range(68)])


def register(peer, folder, scan, points, out):
    """Registers the template's skin to a scan; returns the seconds that it took."""
    skin = trimesh.load(folder / "skin.ply", process=False)
    target = trimesh.load(scan, process=False)
    rest, found = landmarks(folder / "skin.json"), landmarks(points)
    faces = skin.faces.copy()
    started = time.perf_counter()
    # Where the landmarks are on the template: triangles and weights.
    feet, _, triangles = trimesh.proximity.closest_point(skin, rest)
    weights = trimesh.triangles.points_to_barycentric(skin.triangles[triangles], feet)
    matrix, _, _ = trimesh.registration.procrustes(rest, found, reflection=False, scale=True)
    skin.apply_transform(matrix)
    positions = PEERS[peer](skin, target, (triangles, weights), found)
    seconds = time.perf_counter() - started
    out.parent.mkdir(parents=True, exist_ok=True)
    trimesh.Trimesh(positions, faces, process=False).export(out)
    return seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ict", required=True, help="the folder of ICT-FaceKit")
    parser.add_argument("--program", required=True, help="phiz-fit")
    parser.add_argument("--template", required=True, help="the generic head")
    parser.add_argument("--count", type=int, default=5, help="how many people")
    parser.add_argument("--seed", type=int, default=9000, help="the first person's seed")
    parser.add_argument("--settings", default="clean,noisy", help="of phiz-fit evaluate")
    args = parser.parse_args()
    settings = args.settings.split(",")
    folder = pathlib.Path("target/peers/registration")

    def evaluate(count, seed, *more):
        command = [args.program, "evaluate", "--json", "--ict", args.ict]
        command += ["--template", args.template, "--count", str(count), "--seed", str(seed)]
        run = subprocess.run([*command, *more], stdout=subprocess.PIPE, text=True, check=False)
        if run.returncode != 0:
            sys.exit(run.returncode)
        return json.loads(run.stdout)["settings"]

    def say(what, seconds):
        print(f"  {what}: {seconds:.2f} s", file=sys.stderr, flush=True)

    # Our own registrations, and the scans for the others.
    ours = evaluate(args.count, args.seed, "--only", args.settings, "--save", str(folder))
    for peer in PEERS:
        out = folder / peer / "mean.ply"
        say(f"ICT's mean, {peer}", register(peer, folder, folder / "mean.ply",
                                            folder / "mean.json", out))
    seconds = {}
    for setting in settings:
        for seed in range(args.seed, args.seed + args.count):
            name = f"person_{seed:04}"
            [again] = evaluate(1, seed, "--only", setting)
            seconds.setdefault((setting, "phiz"), []).append(again["seconds"])
            say(f"{setting}, {name}, phiz", again["seconds"])
            scan = folder / setting / f"{name}.ply"
            for peer in PEERS:
                out = folder / peer / setting / f"{name}.ply"
                took = register(peer, folder, scan, scan.with_suffix(".json"), out)
                seconds.setdefault((setting, peer), []).append(took)
                say(f"{setting}, {name}, {peer}", took)

    results = {setting: {"phiz": report} for setting, report in zip(settings, ours)}
    for peer in PEERS:
        reports = evaluate(args.count, args.seed, "--only", args.settings,
                           "--registered", str(folder / peer))
        for setting, report in zip(settings, reports):
            results[setting][peer] = report
    for (setting, who), took in seconds.items():
        results[setting][who]["seconds"] = float(numpy.mean(took))

    output = pathlib.Path("target/peers/registration.json")
    output.write_text(json.dumps({"seed": args.seed, "settings": results}, indent=1) + "\n")
    kept = True
    for setting in settings:
        kept = table(setting, results[setting]) and kept
    print(f"\n{output}")
    return 0 if kept else 1


ROWS = [
    ("drift, face: mean, mm", "drift", lambda r: r["drift"]["mean"]),
    ("  95 %", None, lambda r: r["drift"]["percentile_95"]),
    ("scatter of spots: mean, mm", "scatter", lambda r: r["scatter"]["mean"]),
    ("face to scan: mean, mm", "distance", lambda r: r["face_to_scan"]["mean"]),
    ("  RMS", None, lambda r: r["face_to_scan"]["rms"]),
    ("face to clean skin: mean, mm", None, lambda r: r["face_to_skin"]["mean"]),
    ("head to scan: mean, mm", None, lambda r: r["head_to_scan"]["mean"]),
    ("folded pairs, face, a person", None, lambda r: r["folds"] / r["people"]),
    ("seconds a scan, one thread", "seconds", lambda r: r["seconds"]),
]


def table(setting, reports):
    """Prints one setting; returns whether every bar was kept."""
    people = reports["phiz"]["people"]
    print(f"\n{setting}, {people} people")
    print(" " * 32 + "".join(f"{who:>14}" for who in reports) + f"{'ours / sumner':>22}"
          + f"{'ours / amberg':>22}")
    kept = True
    for label, key, value in ROWS:
        if key == "scatter" and people < 2:
            continue
        line = f"{label:32}" + "".join(f"{value(r):14.3f}" for r in reports.values())
        for peer in PEERS if key else []:
            ratio = value(reports["phiz"]) / max(value(reports[peer]), 1e-12)
            bar = BARS.get((key, peer))
            mark = ""
            if bar is not None:
                kept = kept and ratio <= bar
                mark = f" {'<=' if ratio <= bar else 'over'} {bar:.3g}"
            line += f"{ratio:.3f}{mark}".rjust(22)
        print(line)
    return kept


if __name__ == "__main__":
    sys.exit(main())
