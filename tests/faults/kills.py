#!/usr/bin/env python3
"""What is left when the daemon is killed at any moment of a run, or the power fails while its record is written.

Kills: SIGKILL at a random moment of a run. Then: every sample that was in the file is read; what is missing at its end is
no older than the record's syncs are apart; the next start names the run, closes its record as interrupted, has outputs
off and axes at rest, and refuses motion until `gyrobench reset`. Some are made on a stand that is a process of its own,
which goes on moving and heating when the daemon dies (in real time, so these are few).

Power cuts: of a whole log, everything up to a random byte has reached the disk; behind it the file is cut anywhere, and
pages of 4 KiB that were not written out are zeros. Then: every sample up to that byte is read, no sample is read that was
not measured, and what is damaged is named.

Resumed runs: killed like those, taken up by the next daemon (`gyrobench resume`), their result compared with that of a
run that nobody killed: by the errors that both state, and by how many of those it is off.

  tests/faults/kills.py --kills 200 --cuts 200 --resumes 50

Progress goes to stderr, the table to stdout; exit status 1 where something was not as it must be. The daemon is that of
GYROBENCH_BIN, build/dev/bin unless given.
"""
import argparse
import csv
import json
import os
import pathlib
import random
import shutil
import signal
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "end_to_end"))
import bench as benches  # noqa: E402
import record as records  # noqa: E402
from outside_stand import OutsideStand  # noqa: E402

PACE = 40  # bench seconds a second
PAGE = 4096
OUTSIDE_EVERY = 20  # kills, one on a stand of its own
# A record is synced once a second; the rest is for a machine that is busy.
SYNCED_WITHIN_S = 4.0 * int(os.environ.get("GYROBENCH_SLOWNESS", "1"))
SCALE = ("scale", "turns=6", "initial_rest_s=8")
COMMANDS = (SCALE, ("rates", "axes=z", "rates_deg_s=20, 40", "initial_rest_s=5"), ("poses", "poses=6", "rest_s=6"),
            ("sweep", "frequencies_hz=0.4, 0.8", "initial_rest_s=5"))
MOST_SIGMAS = 4.0
# The stand of a daemon starts cold with it, and a result on the typical one depends on how warm the sensor is: by three of
# its standard errors from one run to the next, none of them interrupted. Here it is as warm at the begin as later.
STEADY = """include = "{root}/config/scenarios/typical.toml"

[thermal]
self_heating_degC = 0.0
"""
NOTHING_OVER = "none of its commands was over"
LIVES_ON = "kill, stand lives on"
PATIENT = "response_timeout_s = 2"
HEATED = """procedure = { summary = 'x', description = 'x', measures = {}, parameters = {} }
function run(p)
  bench.switch{ output='heater', on=true }
  bench.turn{ axis='inner', angle_deg=300, rate_deg_s=20 }
  bench.turn{ axis='inner', angle_deg=-300, rate_deg_s=20 }
end
"""


def arguments_of(command):
    """A procedure and its parameters as arguments of gyrobench."""
    return [command[0], *(word for parameter in command[1:] for word in ("-p", parameter))]


def read_table(path):
    """Samples and angles (as written) of an exported table, and the kinds of its defects."""
    defects, rows = [], []  # the second field of a row is the gyro's, empty where an angle stands
    with open(path, newline="") as file:
        lines = []
        for line in file:
            if not line.startswith("#"):
                lines.append(line)
            elif line.startswith("# defect = "):
                defects.append(line.split()[3])
        for row in csv.DictReader(lines):
            rows.append(tuple(value for name, value in row.items() if name != "unit_tick_s"))
    return rows, defects


def exported(bench, folder):
    """What the product reads of a record."""
    with tempfile.TemporaryDirectory() as out:
        table = pathlib.Path(out) / "table.csv"
        done = bench.run("export", folder, "-o", table)
        if done.returncode != 0:
            raise records.Broken(f"export: exit {done.returncode}: {done.stderr[-300:]}")
        return read_table(table)


def samples_in(log, run):
    """Times of the samples of a run that whole events at the begin of a log hold, in order."""
    times = []
    for channel, message in records.whole_events(log.read_bytes()):
        if channel.endswith("_GYRO"):
            block = records.Block(message)
            if block.run_id == run["run_id"] and block.utime >= run["start_utime"]:
                times += [utime for utime in block.times(message) if utime >= run["start_utime"]]
    return times


def attempt(kind, number, perform, *arguments):
    """A row on a bench of its own: one that fails is a finding, and the others go on."""
    try:
        return perform(number, *arguments)
    except Exception as error:
        row = Row(kind, f"{kind}, {number}")
        row.require(False, f"{type(error).__name__}: {error}")
        return row.done()


class Row:
    """One kill or cut: what it was, and what was not as it must be."""

    def __init__(self, kind, name):
        self.kind, self.name, self.breaches, self.reached, self.sigmas = kind, name, [], "", None
        self.begin = time.monotonic()

    def require(self, holds, text):
        if not holds:
            self.breaches.append(text)

    def done(self):
        self.wall_s = time.monotonic() - self.begin
        print(f"{self.name}: {self.reached}, {self.wall_s:.1f} s" + "".join(f"\n    {b}" for b in self.breaches),
              file=sys.stderr, flush=True)
        return self


def kill(bench):
    bench.daemon.kill()
    bench.daemon.wait(benches.DEADLINE_S)


def check_record(row, bench, folder, utime_before, size_before):
    """Of a record that was left by a daemon that was killed, and closed by the next one."""
    run = json.loads((folder / "run.json").read_text())
    row.require(run["outcome"] == "interrupted", f"the outcome is {run['outcome']}")
    log = folder / "events.lcmlog"
    if not log.exists():
        return
    row.require(log.stat().st_size >= size_before, "the log is shorter than it was")
    times = samples_in(log, run)
    rows, _ = exported(bench, folder) if times else ([], [])
    read = sum(bool(sample[1]) for sample in rows)
    row.require(read == len(times), f"{read} samples are read of {len(times)} in the log")
    if times and utime_before - run["start_utime"] > PACE * SYNCED_WITHIN_S * 1e6:
        missing_s = (utime_before - times[-1]) * 1e-6 / PACE
        row.require(missing_s <= SYNCED_WITHIN_S, f"the last {missing_s:.1f} s before the kill are missing")


def comes_true(bench, condition, within_s=5.0):
    """Of what a thread writes, or a drive does, in a moment: whether it is so before the time is over. Each try waits for
    a process, so that it is no busy loop."""
    end = time.monotonic() + within_s
    while not condition():
        if time.monotonic() > end:
            return False
        bench.run("status")
    return True


def check_start(row, bench, run_id):
    """Of the start after a kill."""
    status = bench.status()
    fault = status["fault"] or {"message": ""}
    row.require(status["state"] == "fault", f"the state is {status['state']}")
    row.require(run_id in fault["message"], f"the fault does not name {run_id}: {fault['message'][:200]}")
    row.require(comes_true(bench, lambda: run_id in bench.daemon_log()), "the log does not name the run")
    row.require(not any(status.get("outputs", {}).values()), f"outputs: {status.get('outputs')}")
    row.require(comes_true(bench, lambda: not any(axis["moving"] for axis in bench.status()["axes"])),
                "an axis moves after the start")
    refused = bench.run("run", *arguments_of(SCALE))
    row.require(refused.returncode == 1 and "gyrobench reset" in refused.stderr, f"motion is not refused: {refused.stderr}")
    row.require(bench.run("reset").returncode == 0, "reset is refused")
    row.require(bench.status()["state"] == "idle", "not idle after reset")


def one_kill(bench, number, rng):
    """Starts a run, kills the daemon at a moment of it and judges what is left. The next daemon runs afterwards."""
    command = rng.choice(COMMANDS)
    row = Row("kill", f"kill {number} in {command[0]}")
    before = set(bench.records.iterdir()) if bench.records.exists() else set()
    started = bench.json("run", *arguments_of(command), "--detach")
    time.sleep(rng.uniform(0.0, (started["duration_s"] + 25) / PACE))
    status = bench.status()
    folder = pathlib.Path(started["record"])
    log = folder / "events.lcmlog"
    size_before = log.stat().st_size if log.exists() else 0
    kill(bench)
    row.reached = status["run"]["state"]
    left = json.loads((folder / "run.json").read_text())["outcome"] if (folder / "run.json").exists() else ""
    bench.start()
    if left == "running":
        check_record(row, bench, folder, status["utime"], size_before)
        check_start(row, bench, started["run_id"])
    else:  # before its record began, or after it was closed
        row.require(bench.status()["state"] == "idle", "a start with no interrupted run is not idle")
        row.reached += f", {left or 'no record yet'}"
    row.require(len(set(bench.records.iterdir()) - before) <= 1, "more than one record was made")
    return row.done()


def one_kill_outside(number, rng):
    """The same on a stand that goes on without its daemon."""
    row = Row(LIVES_ON, f"kill {number} of a daemon whose stand lives on")
    with OutsideStand(procedures={"heated": HEATED}) as bench:
        # In real time, on a machine that is busy, a stand's reply may be late.
        bench.config.write_text(bench.config.read_text().replace('[bus.a]\n', f'[bus.a]\n{PATIENT}\n')
                                .replace('[bus.b]\n', f'[bus.b]\n{PATIENT}\n'))
        bench.start()
        while not all(device["ok"] for device in bench.status()["devices"]):
            time.sleep(0.2)
        started = bench.json("run", "heated", "--detach")
        while not bench.status()["run"]["segment"].startswith("inner"):
            if bench.status()["run"]["outcome"]:
                raise RuntimeError(bench.status()["run"]["message"])
            time.sleep(0.2)
        time.sleep(rng.uniform(0.5, 6.0))
        row.reached = bench.status()["run"]["segment"]
        kill(bench)
        # While nobody else has the line.
        row.require(bench.heats(), "the stand did not live on: the heater is off")
        row.require(bench.inner_is_moving(), "the stand did not live on: the axis is at rest")
        bench.start()
        check_start(row, bench, started["run_id"])
        bench.stop()
        row.require(not bench.inner_is_moving(), "by its own register, the axis moves")
        row.require(not bench.heats(), "by its own register, the heater is on")
    return row.done()


def whole_record(bench, command):
    """Folder, log and rows of a run that nobody disturbed."""
    done = bench.run("run", *arguments_of(command))
    if done.returncode != 0:
        raise RuntimeError(f"a clean run: {done.stdout[-300:]}{done.stderr}")
    folder = bench.newest_record()
    rows, defects = exported(bench, folder)
    return folder, (folder / "events.lcmlog").read_bytes(), rows, defects


def cut(log, synced, rng):
    """The log as a power cut may leave it: whole up to `synced`, behind it cut anywhere, unwritten pages zero."""
    data = bytearray(log[:rng.randint(synced, len(log))])
    share = rng.choice((0.0, 0.3, 0.7, 1.0))
    for page in range(synced // PAGE, len(data) // PAGE + 1):
        begin, end = max(synced, page * PAGE), min(len(data), (page + 1) * PAGE)
        if begin < end and rng.random() < share:
            data[begin:end] = bytes(end - begin)
    return bytes(data)


def invented(read, rows):
    """Rows that were not measured. Of a gyro's sample and a reading at the same time, which share a row, one may be lost."""
    at = {}
    for row in rows:
        at.setdefault(row[0], []).append(row)
    return [row for row in read
            if not any(all(cell in ("", of) for cell, of in zip(row, whole)) for whole in at.get(row[0], []))]


def one_cut(bench, number, rng, whole):
    """Cuts a record and judges what is read of it."""
    folder, log, rows, defects_before = whole
    synced = rng.randint(len(log) // 50, len(log))
    left = cut(log, synced, rng)
    row = Row("power cut", f"power cut {number} of {folder.name} behind byte {synced}, {len(left)} of {len(log)} bytes left")
    damaged = bench.folder / "cut" / folder.name
    shutil.rmtree(damaged.parent, ignore_errors=True)
    damaged.mkdir(parents=True)
    run = json.loads((folder / "run.json").read_text())
    run["outcome"] = "running"
    (damaged / "run.json").write_text(json.dumps(run))
    (damaged / "events.lcmlog").write_bytes(left)
    read, defects = exported(bench, damaged)
    analysis = bench.run("analyze", damaged)
    row.require(analysis.returncode == 0 or analysis.stderr.strip(), f"analyze: exit {analysis.returncode} with no word")
    (damaged / "events.lcmlog").write_bytes(log[:synced])
    safe = len(samples_in(damaged / "events.lcmlog", run))
    samples = [sample for sample in read if sample[1]]
    row.require(samples[:safe] == [sample for sample in rows if sample[1]][:safe],
                f"of {safe} samples that had reached the disk, not all are read; {len(samples)} in all")
    wrong = invented(read, rows)
    row.require(not wrong, f"{len(wrong)} rows are read that were not measured, {wrong[:1]}")
    if not set(rows) <= set(read) and left != log[:len(left)]:
        row.require(set(defects) - set(defects_before), f"samples are missing and no defect says so: {defects}")
    row.reached = f"{len(read)} of {len(rows)} rows, {', '.join(sorted(set(defects) - set(defects_before))) or 'no defect'}"
    return row.done()


def estimate_of(folder):
    """Value and standard error of what a run measures: the scale factor of z, or its offset where it does not turn."""
    result = json.loads((folder / "result.json").read_text())
    for scale in result["scale"]:
        if scale["axis"] == "z":
            return scale["alpha"], scale["alpha_std_error"]
    (bias,) = [bias for bias in result["bias"] if bias["axis"] == "z"]
    return bias["coefficients"][0], bias["std_errors"][0]


def refused(row, resume):
    """Killed before the first sync of its record, a run has nothing to go on from."""
    row.require(NOTHING_OVER in resume.stderr, f"resume: {resume.stderr[-400:]}{resume.stdout[-400:]}")
    row.reached = NOTHING_OVER
    return row.done()


def one_resume(bench, number, rng, whole):
    """A run that is killed, by a chance of one in three once more, and taken up, to its end."""
    command = rng.choice(COMMANDS)
    if command not in whole:
        whole[command] = estimate_of(whole_record(bench, command)[0])
    row = Row("resumed run", f"resumed run {number} of {command[0]}")
    started = bench.json("run", *arguments_of(command), "--detach")
    for again in (rng.random() < 1 / 3, False):
        begin = bench.status()["run"]["segments_done"]
        wanted = begin + rng.randint(2, 5)
        while not (run := bench.status()["run"])["outcome"] and run["segments_done"] < wanted:
            time.sleep(0.02)
        time.sleep(rng.uniform(0.0, 0.3))
        kill(bench)
        left = json.loads((pathlib.Path(started["record"]) / "run.json").read_text())
        bench.start()
        if left["outcome"] != "running":
            row.reached = "killed behind its end"
            return row.done()
        bench.run("reset")
        if not again:
            break
        taken_up = bench.run("resume", started["run_id"], "--detach", "--json")
        if taken_up.returncode != 0:
            return refused(row, taken_up)
        started = json.loads(taken_up.stdout)
    done = bench.run("resume", started["run_id"], "--json")
    if done.returncode != 0:
        return refused(row, done)
    folder = pathlib.Path(json.loads(done.stdout)["record"])
    run = json.loads((folder / "run.json").read_text())
    row.require(run.get("resumed_from") == started["run_id"], f"resumed_from is {run.get('resumed_from')}")
    (value, error), (expected, expected_error) = estimate_of(folder), whole[command]
    row.sigmas = (value - expected) / (error**2 + expected_error**2)**0.5
    row.require(abs(row.sigmas) <= MOST_SIGMAS, f"{value:.6g} ± {error:.2g}, expected {expected:.6g} ± {expected_error:.2g}")
    row.reached = f"{run['outcome']}, off by {row.sigmas:.2f} standard errors"
    return row.done()


def resumes(options, rng):
    rows, whole = [], {}
    with paced_bench(STEADY) as bench:
        for number in range(options.resumes):
            rows.append(one_resume(bench, number, rng, whole))
    sigmas = [row.sigmas for row in rows if row.sigmas is not None]
    if sigmas:
        print(f"resumed runs off by {(sum(z * z for z in sigmas) / len(sigmas))**0.5:.2f} standard errors (rms of {len(sigmas)}),"
              f" {max(map(abs, sigmas)):.2f} at most")
    return rows


def paced_bench(scenario=None):
    return benches.Bench(extra=f"[virtual]\npace = {PACE}\n", scenario=scenario)


def kills(options, rng):
    rows = []
    outside = options.kills // OUTSIDE_EVERY
    with paced_bench() as bench:
        for number in range(options.kills - outside):
            rows.append(one_kill(bench, number, rng))
    return rows + [attempt(LIVES_ON, number, one_kill_outside, rng) for number in range(outside)]


def cuts(options, rng):
    with benches.Bench() as bench:
        wholes = [whole_record(bench, command) for command in COMMANDS[:max(1, min(len(COMMANDS), options.cuts // 10))]]
        return [one_cut(bench, number, rng, rng.choice(wholes)) for number in range(options.cuts)]


def print_table(rows):
    head = ["what", "times", "breaches", "wall s each"]
    lines = []
    for kind in dict.fromkeys(row.kind for row in rows):
        group = [row for row in rows if row.kind == kind]
        lines.append([kind, len(group), sum(bool(row.breaches) for row in group),
                      f"{sum(row.wall_s for row in group) / len(group):.1f}"])
    widths = [max(len(str(line[i])) for line in [head, *lines]) for i in range(len(head))]
    for line in [head, *lines]:
        print("  ".join(str(value).ljust(width) for value, width in zip(line, widths)).rstrip())
    for row in rows:
        for breach in row.breaches:
            print(f"  {row.name}: {breach}")


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=200, help="default: %(default)s")
    parser.add_argument("--cuts", type=int, default=200, help="default: %(default)s")
    parser.add_argument("--resumes", type=int, default=50, help="default: %(default)s")
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args(arguments)


def main(arguments):
    options = parse(arguments)
    rows = kills(options, random.Random(options.seed)) if options.kills else []
    if options.cuts:
        rows += cuts(options, random.Random(options.seed + 1))
    if options.resumes:
        rows += resumes(options, random.Random(options.seed + 2))
    print_table(rows)
    return 1 if any(row.breaches for row in rows) else 0


if __name__ == "__main__":
    # Told to end, it leaves no daemon behind.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    sys.exit(main(sys.argv[1:]))
