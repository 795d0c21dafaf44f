#!/usr/bin/env python3
"""Faults in every procedure: seeded scenarios on the virtual stand, each with a daemon of its own.

Of each it is asked: does it end, and as it must (kinds.py); does a fault name its device; did an axis move beyond a
limit, after a stop or for long with nobody commanding it, by the stand's own truth; is the record readable, are its
samples continuous or what is missing said; and is a result that the fault has spoiled marked as such. What a clean
run of the same seed gives is what is not spoiled.

  tests/faults/campaign.py --scenarios 200 --jobs 2 --json out.json
  tests/faults/campaign.py --kinds runaway,jammed --procedures scale --scenarios 20

Progress goes to stderr, the table by kind of fault to stdout; exit status 1 where something was not as it must be.
The daemon is that of GYROBENCH_BIN, build/dev/bin unless given.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "end_to_end"))
import bench as benches  # noqa: E402
import record as records  # noqa: E402
from kinds import ENDS, KINDS, PROCEDURES, Scenario, scenarios  # noqa: E402
from spoilt import marked, spoilt  # noqa: E402
from truth import Truth  # noqa: E402

LONGEST_COMMAND_S = 300 * int(os.environ.get("GYROBENCH_SLOWNESS", "1"))
LIMIT_DEG = 400.0
# While the driver of one line waits for a device that is silent, two seconds of real time a try, bench time stands still
# and with it the answers of the other line, which must be the more patient one.
PATIENT = "response_timeout_s = 5"


def stand_file(folder, device, retries, seed):
    limits = "".join(f"[axis.{axis}]\nmin_deg = {-LIMIT_DEG:g}\nmax_deg = {LIMIT_DEG:g}\n"
                     for axis in ("outer", "middle", "inner"))
    faulty, other = ("b", "a") if device == "gyro" else ("a", "b")
    return (f'{limits}[bus.{faulty}]\nretries = {retries}\n[bus.{other}]\n{PATIENT}\n'
            f'[virtual]\nseed = {seed}\ntruth = "{folder}/truth.csv"\n')


class FaultBench(benches.Bench):
    """A bench of one scenario; its truth is read once its daemon has ended."""

    def __init__(self, toml, seed, stand="virtual.toml", device="gyro", retries=2):
        super().__init__(base=stand, scenario=toml)
        text = self.config.read_text().replace("[virtual]\n", "", 1).replace(
            f'scenario = "{self.folder}/scenario.toml"\n', "")
        self.config.write_text(text + stand_file(self.folder, device, retries, seed).replace(
            "[virtual]\n", f'[virtual]\nscenario = "{self.folder}/scenario.toml"\n'))

    def truth(self):
        return Truth(self.folder / "truth.csv")


def arguments_of(procedure):
    """`scale:turns=10` as arguments of gyrobench."""
    name, *parameters = procedure.split(":")
    return [name, *(word for parameter in parameters for word in ("-p", parameter))]


def results_of(folder):
    """Result and trace of a record; None of what is not there."""
    read = [folder / name for name in ("result.json", "trace.json")]
    return [json.loads(path.read_text()) if path.exists() else None for path in read]


class Clean:
    """What runs without a fault give, by procedure and seed."""

    def __init__(self):
        self.results = {}

    def of(self, scenario):
        key = (scenario.procedure, scenario.seed)
        if key not in self.results:
            toml = 'include = "{root}/config/scenarios/typical.toml"\n'
            with FaultBench(toml, scenario.seed, scenario.stand) as bench:
                done = bench.run("run", *arguments_of(scenario.command))
                if done.returncode != 0:
                    raise RuntimeError(f"a clean run of {scenario.procedure}: {done.stdout[-500:]}{done.stderr}")
                self.results[key] = results_of(bench.newest_record())
        return self.results[key]


def names_device(message, device):
    """An error of an axis may tell of its drive and of its reference."""
    return re.search(rf"\b{device.split('.')[0]}\b", message) is not None


def end_of(run, course, done):
    """How a run ended, in the words of kinds.py."""
    if run is None:
        return "not_begun" if done.returncode == 1 else f"exit {done.returncode}"
    if run["outcome"] == "done":
        resumed = any(event.event == records.Run.SUSPEND for event in course)
        return "resumed" if resumed else "done"
    words = {"fault": "stopped", "error": "refused", "failed_limits": "refused"}
    return words.get(run["outcome"], run["outcome"])


def has_acted(scenario, truth):
    begin_s = truth.fault_s()
    if begin_s is None or scenario.kind.acts == "at once":
        return begin_s is not None
    axis = scenario.device.split(".")[0]
    way_deg = truth.commanded_deg if scenario.kind.acts == "in motion" else truth.astray_deg
    return way_deg(axis, begin_s) >= scenario.kind.enough_deg


def of_run(run, truth):
    """Begin and end of a run in the truth's time."""
    return [(run[key] - truth.power_on_utime) * 1e-6 for key in ("start_utime", "end_utime")]


def acted_in(scenario, run, truth):
    """Began a second before the run's end or earlier, and did not end before its begin."""
    begin_s, end_s = of_run(run, truth)
    lasts_s = scenario.fault.get("duration_s", 0.0)
    return has_acted(scenario, truth) and truth.fault_s() + lasts_s > begin_s and truth.fault_s() < end_s - 1.0


def was_so_all_along(scenario, run, truth):
    """A sensor that jumped before the run began is another sensor with another offset, and measured as such."""
    jumped = scenario.kind.kind == "jump" and scenario.device == "gyro"
    return jumped and truth.fault_s() is not None and truth.fault_s() < of_run(run, truth)[0]


def breaches_of_record(folder, bench):
    found = []
    try:
        blocks, course = records.read(folder / "events.lcmlog")
        found += records.unmarked_gaps(blocks)
    except records.Broken as broken:
        return [f"the record is broken: {broken}"], [], []
    analysis = bench.run("analyze", folder)
    if analysis.returncode not in (0, 1) or (analysis.returncode == 1 and not analysis.stderr.strip()):
        found.append(f"analyze: exit {analysis.returncode}: {analysis.stderr[-200:]}")
    return found, blocks, course


def breaches_of_end(scenario, end, message, truth):
    acted = has_acted(scenario, truth)
    allowed = scenario.kind.ends if acted else scenario.kind.ends | {"done"}
    found = []
    if end not in allowed:
        found.append(f"ended {end}, expected {' or '.join(sorted(allowed))}: {message[:300]}")
    if end in ENDS and not names_device(message, scenario.device):
        found.append(f"a fault that does not name {scenario.device}: {message[:300]}")
    if scenario.device != "relays" and truth.heater_on():
        found.append("the heater is on at the end")
    runaway = scenario.kind.kind == "runaway"
    return found + truth.breaches(LIMIT_DEG, (scenario.device.split(".")[0], scenario.fault["amount"])
                                  if runaway else None)


def perform(scenario, clean, keep):
    """A row of the campaign."""
    row = {"run": scenario.name, "kind": scenario.kind.name, "procedure": scenario.procedure, "fault": scenario.fault,
           "end": "", "message": "", "marked": "", "breaches": []}
    begin = time.monotonic()
    bench = FaultBench(scenario.toml(), scenario.seed, scenario.stand, scenario.device, scenario.retries)
    try:
        with bench:
            done = bench.run("run", *arguments_of(scenario.command))
            folder = bench.newest_record() if bench.records.exists() and any(bench.records.iterdir()) else None
            run = json.loads((folder / "run.json").read_text()) if folder else None
            course = []
            if folder:
                found, _, course = breaches_of_record(folder, bench)
                row["breaches"] += found
            row["end"] = end_of(run, course, done)
            row["message"] = run["message"] if run else (done.stderr or done.stdout)[-400:]
            bench.status()
            bench.stop()
            truth = bench.truth()
            row["acted"] = has_acted(scenario, truth)
            row["breaches"] += breaches_of_end(scenario, row["end"], row["message"], truth)
            if row["end"] in ("done", "resumed"):
                hurt, whole = results_of(folder), clean.of(scenario)
                what = "" if was_so_all_along(scenario, run, truth) else spoilt(hurt, whole)
                row["marked"] = marked(hurt, whole)
                if not row["marked"] and (what or (scenario.kind.marks and acted_in(scenario, run, truth))):
                    row["breaches"].append(f"not marked: {what or 'what happened in the run'}")
            if keep and row["breaches"]:
                shutil.copytree(bench.folder, keep / scenario.name.replace("/", "_").replace(" ", "-"),
                                dirs_exist_ok=True, ignore=shutil.ignore_patterns("*.sock"))
    except subprocess.TimeoutExpired as late:
        row["breaches"].append(f"hangs: {late}")
    except Exception as error:  # one scenario that fails is a finding, and the others go on
        row["breaches"].append(f"{type(error).__name__}: {error}")
    row["wall_s"] = time.monotonic() - begin
    return row


def print_table(rows):
    head = ["fault", "runs", "acted", "done", "resumed", "stopped", "refused", "not begun", "marked", "breaches", "wall s"]
    lines = []
    for kind in KINDS:
        group = [row for row in rows if row["kind"] == kind.name]
        if not group:
            continue
        ends = [sum(row["end"] == end for row in group) for end in ("done", "resumed", "stopped", "refused", "not_begun")]
        lines.append([kind.name, len(group), sum(bool(row.get("acted")) for row in group), *ends,
                      sum(bool(row["marked"]) for row in group), sum(bool(row["breaches"]) for row in group),
                      f"{sum(row['wall_s'] for row in group) / len(group):.1f}"])
    lines.append(["all", *(sum(line[i] for line in lines) for i in range(1, len(head) - 1)),
                  f"{sum(row['wall_s'] for row in rows) / max(1, len(rows)):.1f}"])
    widths = [max(len(str(line[i])) for line in [head, *lines]) for i in range(len(head))]
    for line in [head, *lines]:
        print("  ".join(str(value).ljust(width) for value, width in zip(line, widths)).rstrip())


def print_breaches(rows):
    for row in rows:
        for breach in row["breaches"]:
            print(f"  {row['run']}: {breach}\n    {row['fault']}")


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenarios", type=int, default=500, help="how many; default: %(default)s")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--kinds", help="names, separated by commas; default: all")
    parser.add_argument("--procedures", help=f"default: {','.join(PROCEDURES)}")
    parser.add_argument("--run", help="one scenario again by its name, as the breaches show it")
    parser.add_argument("--jobs", type=int, default=1, help="daemons at a time; default: %(default)s")
    parser.add_argument("--json", type=pathlib.Path, help="all rows")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for records and truth of scenarios with a breach")
    return parser.parse_args(arguments)


def scenarios_of(options):
    if options.run:
        kind, _, procedure, seed = options.run.split("/")
        return [Scenario(next(k for k in KINDS if k.name == kind), procedure, int(seed.removeprefix("seed")))]
    kinds = options.kinds.split(",") if options.kinds else None
    unknown = set(kinds or []) - {kind.name for kind in KINDS}
    if unknown:
        sys.exit(f"no such kind: {', '.join(sorted(unknown))}; there are: {', '.join(kind.name for kind in KINDS)}")
    return scenarios(options.first_seed, options.scenarios, kinds,
                     options.procedures.split(",") if options.procedures else None)


def main(arguments):
    options = parse(arguments)
    benches.DEADLINE_S = LONGEST_COMMAND_S
    clean, wanted, rows = Clean(), scenarios_of(options), []
    pool = concurrent.futures.ThreadPoolExecutor(options.jobs)
    try:
        for row in pool.map(lambda scenario: perform(scenario, clean, options.keep), wanted):
            rows.append(row)
            print(f"{len(rows)}/{len(wanted)} {row['run']}: {row['end']}, {row['wall_s']:.1f} s"
                  + "".join(f"\n    {breach}" for breach in row["breaches"]), file=sys.stderr, flush=True)
            if options.json:
                options.json.write_text(json.dumps(rows, indent=1))
    finally:
        pool.shutdown(cancel_futures=True)
    print_table(rows)
    print_breaches(rows)
    return 1 if any(row["breaches"] for row in rows) else 0


if __name__ == "__main__":
    # Told to end, it finishes the scenarios under way, so that no daemon is left behind.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    sys.exit(main(sys.argv[1:]))
