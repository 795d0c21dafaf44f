#!/usr/bin/env python3
"""Runs `gyrobench trace` on sets of the second world and prints truth against verdict.

    campaign.py GYROBENCH --sets 200 --seed 1 --jobs 2
    campaign.py GYROBENCH --only three_encoders:single:20:17 --keep FOLDER

The second form writes one set's tables into the folder and prints its truth as JSON. With --effects some effects alone
are hidden: so is one of them studied over many benches.
"""
import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse  # noqa: E402
import json  # noqa: E402
import multiprocessing  # noqa: E402
import shutil  # noqa: E402
import subprocess  # noqa: E402
import sys  # noqa: E402
import tempfile  # noqa: E402
import time  # noqa: E402

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import classes  # noqa: E402
import printing  # noqa: E402
import scoring  # noqa: E402
import worlds  # noqa: E402

KINDS = ("single", "pair", "silent", "unknown")
TIME_LIMIT_S = 300


def trace(program, tables):
    """The tracer's JSON, or None and why not; seconds that it took. A trace of no axis at all is no answer."""
    begin = time.monotonic()
    try:
        done = subprocess.run([program, "trace", *tables, "--json"], capture_output=True, timeout=TIME_LIMIT_S,
                              text=True, check=False)
        answer = json.loads(done.stdout) if done.returncode == 0 else None
        why = done.stderr.strip()[-400:]
    except (subprocess.TimeoutExpired, json.JSONDecodeError) as error:
        answer, why = None, str(error)[:400]
    return answer, why, time.monotonic() - begin


def run_set(job):
    """Makes, traces, scores and deletes one set."""
    program, name, kind, level, seed, keep, among, judged = job
    begin = time.monotonic()
    folder = tempfile.mkdtemp(prefix="second_world_")
    try:
        world = worlds.World(name, kind, level, seed, among=among, judged=judged)
        tables = world.write(folder)
        made_s = time.monotonic() - begin
        answer, why, traced_s = trace(program, tables)
        record = scoring.score(world.truth, answer)
        if answer is None:
            record["remarks"] = [why]
        record.update(made_s=made_s, traced_s=traced_s, effects=world.truth["effects"],
                      samples=int(world.scene.t_s.size))
        if keep:
            _keep(keep, f"{name}_{kind}_{level:g}_{seed}", tables, answer, world.truth)
        return record
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _keep(keep, label, tables, answer, truth):
    target = os.path.join(keep, label)
    os.makedirs(target, exist_ok=True)
    for table in tables:
        shutil.move(table, os.path.join(target, os.path.basename(table)))
    for name, what in (("answer", answer), ("truth", truth)):
        with open(os.path.join(target, f"{name}.json"), "w", encoding="utf-8") as out:
            json.dump(what, out, indent=1)


def jobs_of(options):
    """Jobs in an order in which any number of them is spread over classes, kinds and levels."""
    levels = {"single": options.levels, "pair": [x for x in options.levels if x >= 20] or options.levels,
              "unknown": [x for x in options.levels if x >= 20] or options.levels, "silent": [0.0]}
    wishes = [(kind, level) for kind in options.kinds for level in levels[kind]]
    found = []
    for i in range(options.sets):
        name = options.classes[i % len(options.classes)]
        turn = i // len(options.classes) + i % len(options.classes)
        kind, level = wishes[turn % len(wishes)]
        found.append((options.gyrobench, name, kind, level, options.seed + i, options.keep,
                      options.effects, True))
    return found


def run_all(options):
    jobs, records, begin = jobs_of(options), [], time.monotonic()
    with multiprocessing.Pool(options.jobs) as pool:
        for record in pool.imap_unordered(run_set, jobs):
            records.append(record)
            line = (f"{len(records)}/{len(jobs)} {time.monotonic() - begin:.0f} s  "
                    f"{record['bench_class']}:{record['kind']}:{record['level']:g}:{record['seed']}  "
                    f"{record['word']}  {', '.join(record['truth']) or '-'} -> {', '.join(record['said']) or '-'}"
                    f"  ({record['made_s']:.1f} + {record['traced_s']:.1f} s)")
            print(line, file=sys.stderr, flush=True)
    records.sort(key=lambda r: r["seed"])
    return records


def one_set(options):
    """Writes one set into --keep and prints its truth."""
    name, kind, level, seed = options.only.split(":")
    world = worlds.World(name, kind, float(level), int(seed), among=options.effects)
    os.makedirs(options.keep, exist_ok=True)
    world.write(options.keep)
    print(json.dumps(world.truth, indent=1))


def words(known=None):
    def parse(text):
        found = text.split(",")
        for word in found:
            if known and word not in known:
                raise argparse.ArgumentTypeError(f"{word}: one of {', '.join(known)} is wanted")
        return found
    return parse


def options_of(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("gyrobench", help="the program")
    parser.add_argument("--sets", type=int, default=100, help="number of sets over all classes and kinds")
    parser.add_argument("--seed", type=int, default=1, help="of the first set; each further one has the next")
    parser.add_argument("--classes", type=words(classes.CLASSES), default=list(classes.CLASSES))
    parser.add_argument("--levels", type=lambda s: [float(x) for x in s.split(",")], default=[5.0, 20.0, 100.0])
    parser.add_argument("--kinds", type=words(KINDS), default=list(KINDS))
    parser.add_argument("--effects", type=words(), default=(), help="ids that the hidden effect is chosen from")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json", help="file for all records")
    parser.add_argument("--keep", help="folder in which tables, answers and truths are kept")
    parser.add_argument("--only", metavar="CLASS:KIND:LEVEL:SEED", help="make one set into --keep, trace nothing")
    options = parser.parse_args(arguments)
    if options.only and not options.keep:
        parser.error("--only wants --keep FOLDER")
    return options


def main(arguments):
    options = options_of(arguments)
    if options.only:
        return one_set(options)
    records = run_all(options)
    if options.json:
        with open(options.json, "w", encoding="utf-8") as out:
            json.dump(records, out)
    printing.print_all(records)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
