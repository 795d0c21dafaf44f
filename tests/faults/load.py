#!/usr/bin/env python3
"""A daemon under load: how long a stop takes in each state, and what becomes of the samples.

  tests/faults/load.py --calls 1000
  tests/faults/load.py --states running,asking --calls 100
  tests/faults/load.py --storm-only

With 100 clients connected and dry runs of a hostile script under way, `stop` is called so many times in each state of
the stand, and median, 99 % and worst of the time to its answer are printed, and how many requests of all came again since
the crowd had closed their connection; the time is real time, that of the bench runs 20 times as fast. Then the storm, in real time, on a stand that is a process of its own: the same clients, two
subscribers that take nothing, a disk that hangs for 5 s, and a daemon that gets no processor for 2 s. Each sample must
be in the record, or counted as missing there and told.

Exit status 1 where a stop was slower than --slowest, or a sample is missing of which nothing is said. The daemon is that
of GYROBENCH_BIN.
"""
import argparse
import json
import os
import pathlib
import re
import signal
import statistics
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "end_to_end"))
import bench as benches  # noqa: E402
import record as records  # noqa: E402
from crowd import HOSTILE, Crowd, SlowSubscriber, ask  # noqa: E402
from outside_stand import OutsideStand  # noqa: E402

HEAD = "procedure = { summary = 'x', description = 'x', measures = {}, parameters = {} }\nfunction run(p)\n"
PROCEDURES = {
    "hostile": HOSTILE,
    "turn": HEAD + "local by_deg = bench.axes().inner.angle_deg > 0 and -3000 or 3000\n"
            "bench.turn{ axis='inner', angle_deg=by_deg, rate_deg_s=3 }\nend\n",
    "asks": HEAD + "bench.ask{ id='x', text='x', timeout_s=100000 }\nend\n",
    "rests": HEAD + "for i = 1, 5000 do bench.rest{ duration_s=1 } end\nend\n",
    "rest": HEAD + "bench.rest{ duration_s=12 }\nend\n",
}
PACE = 20
# Every minute of bench time the inner encoder refuses to answer for a quarter of one.
SILENCES = 300
SILENT = 'include = "{root}/config/scenarios/typical.toml"\n' + "".join(
    f'[[fault]]\ndevice = "inner.encoder"\nkind = "exception"\nat_s = {40 + 60 * i}\nduration_s = 15\n'
    for i in range(SILENCES))
ALARM = 'include = "{root}/config/scenarios/typical.toml"\n[[fault]]\ndevice = "inner.drive"\nkind = "alarm"\nat_s = 25\namount = 3\n'

STALL_S, TAKEN_AWAY_S = 5.0, 2.0


class State:
    """How the stand is brought into a state. procedure: that is started; None: no run. pause: then that is asked for."""

    def __init__(self, procedure=None, pause=False, scenario=None, idle_pace=0):
        self.procedure, self.pause, self.scenario, self.idle_pace = procedure, pause, scenario, idle_pace


STATES = {
    "idle": State(),
    "preparing": State("rests"),
    "running": State("turn"),
    "asking": State("asks"),
    "paused": State("rests", pause=True),
    "suspended": State("turn", scenario=SILENT, idle_pace=PACE),
    "stopping": State("rests"),
    "fault": State("turn", scenario=ALARM),
}


class Stops:
    """The stops of one state, on a daemon of its own."""

    def __init__(self, name, bench):
        self.name, self.state, self.bench = name, STATES[name], bench
        self.path = str(bench.folder / "control.sock")
        self.times_s, self.came_again = [], 0

    def status(self):
        return self.ask("GET", "/v1/status")[1]["state"]

    def post(self, target, body=b""):
        begin = time.perf_counter()
        answer = self.ask("POST", target, body)
        return time.perf_counter() - begin, answer

    def ask(self, method, target, body=b""):
        """In the crowd a connection may be closed before its request was sent; whoever comes again has lost that time."""
        for _ in range(100):
            try:
                if answer := ask(self.path, method, target, body):
                    return answer
            except ConnectionError:
                pass
            self.came_again += 1
        raise RuntimeError(f"no answer to {target} in 100 tries")

    def wait_for(self, *states):
        while (now := self.status()) not in states:
            if self.bench.daemon.poll() is not None:
                raise RuntimeError("the daemon has ended: " + self.bench.daemon_log()[-500:])
        return now

    def start(self):
        _, (status, answer) = self.post("/v1/runs", json.dumps({"procedure": self.state.procedure}).encode())
        if status not in (201, 409):
            raise RuntimeError(f"no run begins: {answer}")
        return status == 201

    def stop(self):
        """Counts where the stand was in the state that is asked for."""
        spent_s, (status, answer) = self.post("/v1/stop")
        if status != 200:
            raise RuntimeError(f"a stop was refused: {answer}")
        return spent_s

    def once(self):
        """One stop in the state; None where the state was gone before."""
        if self.name == "idle" or (self.name == "fault" and self.status() == "fault"):
            return self.stop()
        if not self.start():
            time.sleep(0.05)  # a device is silent, and nobody can begin
            return None
        if self.name == "stopping":
            self.wait_for("running")
            self.stop()
            spent_s = self.stop()
            return spent_s if self.status() == "stopping" else None
        if self.state.pause:
            self.wait_for("running")
            self.post("/v1/pause")
        now = self.wait_for(self.name, "idle", "disconnected", "fault")
        return self.stop() if now == self.name else None

    def collect(self, calls):
        for _ in range(20 * calls):
            spent_s = self.once()
            if spent_s is not None:
                self.times_s.append(spent_s)
            if len(self.times_s) == calls:
                return
            if self.name != "fault":
                self.wait_for("idle", "disconnected")
        raise RuntimeError(f"{self.name}: {len(self.times_s)} of {calls} stops found the stand in this state")


def bench_of(state):
    return benches.Bench(scenario=state.scenario, procedures=PROCEDURES,
                         extra=f"[virtual]\npace = {PACE}\nidle_pace = {state.idle_pace}\n")


def stops_in(name, calls):
    with bench_of(STATES[name]) as bench, Crowd(bench):
        stops = Stops(name, bench)
        stops.collect(calls)
        return sorted(stops.times_s), stops.came_again


def percentile(times_s, share):
    return times_s[min(len(times_s) - 1, int(share * len(times_s)))]


def storm(library):
    """What became of the samples: a row of figures, and what was not as it must be."""
    # The stand, unlike hardware, gets its processor when the crowd lets it: its replies may be late.
    bench = OutsideStand(procedures=PROCEDURES)
    bench.config.write_text(re.sub(r"(?m)^\[bus\.[ab]\]$", r"\g<0>\nresponse_timeout_s = 1", bench.config.read_text()))
    stalled = bench.folder / "stalled"
    if library:
        bench.before_start = lambda: os.environ.update(LD_PRELOAD=str(library), GYROBENCH_STALLED=str(stalled))
    with bench:
        bench.start()
        with Crowd(bench), SlowSubscriber(bench), SlowSubscriber(bench):
            path = str(bench.folder / "control.sock")
            while ask(path, "POST", "/v1/runs", b'{"procedure": "rest"}')[0] != 201:
                time.sleep(0.5)
            while (state := ask(path, "GET", "/v1/status")[1]["state"]) == "preparing":
                time.sleep(0.1)
            if state != "running":
                return {}, [f"no run: {state}: {bench.daemon_log()[-1000:]}"]
            if library:
                stalled.touch()
                time.sleep(STALL_S)
                stalled.unlink()
            bench.daemon.send_signal(signal.SIGSTOP)
            time.sleep(TAKEN_AWAY_S)
            bench.daemon.send_signal(signal.SIGCONT)
            while not (run := ask(path, "GET", "/v1/status")[1]["run"])["outcome"]:
                time.sleep(0.1)
        blocks, _ = records.read(bench.newest_record() / "events.lcmlog")
        return judge(run, blocks)


def judge(run, blocks):
    there, told = sum(block.n for block in blocks), sum(block.missed for block in blocks)
    missed = sum(block.missed for block in blocks[1:])  # what the first one misses may be from before the run
    found = records.unmarked_gaps(blocks)
    if run["outcome"] != "done":
        found.append(f"the run ended {run['outcome']}: {run['message']}")
    if missed and "lost" not in run["message"]:
        found.append(f"{missed} samples are missing, and the run's message does not say so: {run['message']!r}")
    # 200 Hz for 12 s, those that were lost among them.
    if there + told < 2200:
        found.append(f"{there} samples and {told} that are missing, expected 2400")
    return {"samples": there, "missing and told": missed, "messages": len(blocks), "said": run["message"]}, found


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--calls", type=int, default=1000, help="of stop in each state; default: %(default)s")
    parser.add_argument("--states", default=",".join(STATES), help="default: %(default)s")
    parser.add_argument("--slowest", type=float, default=2.0, help="that a stop may take, s; default: %(default)s")
    parser.add_argument("--stalling-disk", type=pathlib.Path, help="library that lets the disk hang; default: it does not")
    parser.add_argument("--storm-only", action="store_true")
    parser.add_argument("--no-storm", action="store_true")
    return parser.parse_args(arguments)


def main(arguments):
    options = parse(arguments)
    failed = False
    if not options.storm_only:
        print(f"{'state':12}{'calls':>7}{'median ms':>11}{'99 % ms':>10}{'worst ms':>10}{'came again':>12}")
        for name in options.states.split(","):
            times_s, came_again = stops_in(name, options.calls)
            print(f"{name:12}{len(times_s):7}{1e3 * statistics.median(times_s):11.2f}{1e3 * percentile(times_s, 0.99):10.2f}"
                  f"{1e3 * times_s[-1]:10.2f}{came_again:12}", flush=True)
            failed = failed or times_s[-1] > options.slowest
    if not options.no_storm:
        row, found = storm(options.stalling_disk)
        print("storm: " + ", ".join(f"{key}: {value}" for key, value in row.items()))
        for one in found:
            print(f"  {one}")
        failed = failed or bool(found)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
