#!/usr/bin/env python3
"""Runs as people make them: every shipped procedure with its defaults, through the daemon, on the virtual stand.

Each run has a daemon of its own, just started (so the sensor is at the temperature of its power-on), on a socket and
an LCM port of its own. A bench's record depends on stand file, seed and commands alone, so a finding can be gone back
to: the name of a run says all three.

  tests/people/campaign.py --seeds 20 --procedures scale,bias+scale --scenarios typical,quiet --json out.json

A procedure may carry parameters (`scale:turns=10:rate_deg_s=20`); `bias+scale` makes both with one daemon and traces
them together as well. The daemon is that of GYROBENCH_BIN, build/dev/bin unless given. Progress goes to stderr, tables
to stdout.
"""
import argparse
import concurrent.futures
import json
import pathlib
import shutil
import signal
import sys
import time
import traceback

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "end_to_end"))
import bench as benches  # noqa: E402
from judge import judge, loop_of  # noqa: E402
from worlds import all_worlds  # noqa: E402

PROCEDURES = ["bias", "scale", "poses", "rates", "sweep", "thermal", "full", "close_loop", "bias+scale", "scale+scale"]
LONGEST_COMMAND_S = 1800


class Job:
    """One daemon's work: the procedures of `program` one after the other in one world."""

    def __init__(self, world, program, filter_setting, seed):
        self.world, self.program, self.filter, self.seed = world, program, filter_setting, seed
        self.name = f"{world.name}/{program}/filter{filter_setting}/seed{seed}"


def arguments_of(procedure):
    """`scale:turns=10` as arguments of gyrobench."""
    name, *parameters = procedure.split(":")
    return [name, *(word for parameter in parameters for word in ("-p", parameter))]


def traced(job, what, trace, run=None, wall_s=0.0):
    """A row of the campaign: one trace, judged. `what`: the procedure, or the pair that was traced together."""
    row = {"run": job.name, "scenario": job.world.name, "traced": what, "filter": job.filter, "seed": job.seed,
           "wall_s": wall_s, "hidden": job.world.hidden, "error": ""}
    row.update(judge(trace, job.world.truth, job.world.hidden))
    if run is not None:
        row["outcome"], row["bench_s"] = run["outcome"], (run["end_utime"] - run["start_utime"]) * 1e-6
        if run["procedure"] == "close_loop":
            row["loop"] = loop_of(run)
    return row


def run_one(bench, job, what, procedure):
    """Runs the procedure, returns its row and its record."""
    begin = time.monotonic()
    done = bench.run("run", *arguments_of(procedure))
    wall_s = time.monotonic() - begin
    record = bench.newest_record() if bench.records.exists() else None
    if record is None or not (record / "trace.json").exists():
        raise RuntimeError(f"gyrobench run {procedure}: exit {done.returncode}: {(done.stderr + done.stdout)[-500:]}")
    run = json.loads((record / "run.json").read_text())
    return traced(job, what, json.loads((record / "trace.json").read_text()), run, wall_s), record


def perform(job, keep):
    """All rows of a job; one with an error where it could not be done."""
    extra = f"[gyro]\nfilter = {job.filter}\n[virtual]\nseed = {job.seed}\n"
    rows, records = [], []
    try:
        with benches.Bench(scenario=job.world.scenario, extra=extra) as bench:
            for procedure in job.program.split("+"):
                before = "+".join(job.program.split("+")[:len(records)])
                what = f"{procedure} after {before}" if before else procedure
                row, record = run_one(bench, job, what, procedure)
                rows.append(row)
                records.append(record)
            if len(records) > 1:
                rows.append(traced(job, f"trace {job.program.replace('+', ' ')}", bench.json("trace", *records)))
            if keep and any(row["false"] for row in rows):
                for record in records:
                    shutil.copytree(record, keep / job.name.replace("/", "_") / record.name, dirs_exist_ok=True)
    except Exception as error:  # one job that fails is a finding, and the others go on
        print(traceback.format_exc(), file=sys.stderr)
        rows.append({"run": job.name, "scenario": job.world.name, "traced": job.program, "filter": job.filter,
                     "seed": job.seed, "error": str(error)})
    return rows


def jobs_of(options):
    worlds = all_worlds()
    names = [name for wanted in options.scenarios.split(",")
             for name in ([w for w in worlds if w.startswith("quiet+")] if wanted == "effects" else [wanted])]
    unknown = [name for name in names if name not in worlds]
    if unknown:
        sys.exit(f"no such scenario: {', '.join(unknown)}; there are: effects, {', '.join(worlds)}")
    kinds = [(worlds[name], program, int(setting))
             for name in names for program in options.procedures.split(",") for setting in options.filters.split(",")]
    # With the seeds of one kind all others would have its noise: one chance finding would count as many.
    return [Job(*kind, options.first_seed + number * options.seeds + k)
            for number, kind in enumerate(kinds) for k in range(options.seeds)]


def groups_of(rows):
    groups = {}
    for row in rows:
        groups.setdefault((row["scenario"], row["traced"], row["filter"]), []).append(row)
    return groups


def mean(values):
    values = list(values)
    return sum(values) / len(values) if values else float("nan")


def shown_mean(values):
    values = list(values)
    return f"{mean(values):.1f}" if values else "-"


def print_table(rows):
    head = ["scenario", "traced", "filter", "runs", "with false", "false", "wrong", "true", "hidden", "verdicts",
            "bench min", "wall s", "failed"]
    lines = []
    for (scenario, what, setting), group in groups_of(rows).items():
        good = [row for row in group if not row["error"]]
        verdicts = {}
        for row in good:
            for verdict, count in row["verdicts"].items():
                verdicts[verdict] = verdicts.get(verdict, 0) + count
        hidden = [row for row in good if row["hidden"]]
        lines.append([scenario, what, setting, len(group), sum(bool(row["false"]) for row in good),
                      sum(len(row["false"]) for row in good), sum(len(row["wrong"]) for row in good),
                      sum(len(row["true"]) for row in good),
                      f"{sum(row['hidden_named'] for row in hidden)}/{len(hidden)}" if hidden else "-",
                      " ".join(f"{name} {count}" for name, count in sorted(verdicts.items())),
                      shown_mean(row["bench_s"] / 60 for row in good if "bench_s" in row),
                      shown_mean(row["wall_s"] for row in good if row["wall_s"]), len(group) - len(good)])
    print_columns(head, lines)
    good = [row for row in rows if not row["error"]]
    print(f"\nall: {len(good)} traces, {sum(bool(row['false']) for row in good)} with a false name, "
          f"{len(rows) - len(good)} could not be made")


def print_columns(head, lines):
    widths = [max(len(str(line[i])) for line in [head, *lines]) for i in range(len(head))]
    for line in [head, *lines]:
        print("  ".join(str(value).ljust(width) for value, width in zip(line, widths)).rstrip())


def print_false(rows):
    print("\nfalse names, run by run:")
    for row in rows:
        for finding in row.get("false", []):
            print(f"  {row['run']}: {row['traced']}: {finding['gyro']}: {finding['says']}")


def print_loops(rows):
    loops = [row for row in rows if "loop" in row]
    if not loops:
        return
    print("\nclose_loop:")
    settled = [row["loop"] for row in loops if row["loop"]["settled"]]
    print(f"  settled {len(settled)} of {len(loops)}, within 20 min {sum(loop['minutes'] <= 20 for loop in settled)}, mean "
          f"{shown_mean(loop['minutes'] for loop in settled)} min")
    for row in loops:
        loop = row["loop"]
        print(f"  {row['run']}: {loop['minutes']:.1f} min, {loop['manoeuvres']} manoeuvres: {loop['ended']}")


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20,
                        help="runs of each scenario and procedure; every run of a campaign has a seed of its own")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--procedures", default=",".join(PROCEDURES), help="a,b or a+b; default: %(default)s")
    parser.add_argument("--scenarios", default="typical,cold-start,ideal,full-sequence,undeclared,quiet,effects",
                        help="names, or effects for each effect in turn; default: %(default)s")
    parser.add_argument("--filters", default="3", help="settings of the gyro's filter; default: %(default)s")
    parser.add_argument("--jobs", type=int, default=1, help="daemons at a time; default: %(default)s")
    parser.add_argument("--json", type=pathlib.Path, help="all rows, with the effects as the traces have them")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the records of runs with a false name")
    parser.add_argument("--most-false", type=float, help="exit 1 when a larger share of the traces has a false name")
    return parser.parse_args(arguments)


def main(arguments):
    options = parse(arguments)
    benches.DEADLINE_S = LONGEST_COMMAND_S
    jobs, rows = jobs_of(options), []
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for number, (job, found) in enumerate(zip(jobs, pool.map(lambda job: perform(job, options.keep), jobs)), 1):
            rows += found
            ids = [finding["id"] for row in found for finding in row.get("false", [])]
            errors = [row["error"] for row in found if row["error"]]
            print(f"{number}/{len(jobs)} {job.name}: {'; '.join(errors) or 'false: ' + (', '.join(ids) or 'none')}",
                  file=sys.stderr, flush=True)
            if options.json:
                options.json.write_text(json.dumps(rows, indent=1))
    print_table(rows)
    print_false(rows)
    print_loops(rows)
    good = [row for row in rows if not row["error"]]
    if len(good) < len(rows):
        return 1
    share = mean(bool(row["false"]) for row in good)
    return 1 if options.most_false is not None and not share <= options.most_false else 0


if __name__ == "__main__":
    # Told to end, it finishes the job under way, so that no daemon is left behind.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    sys.exit(main(sys.argv[1:]))
