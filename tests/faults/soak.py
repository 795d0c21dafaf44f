#!/usr/bin/env python3
"""A daemon for a long time: does it grow, does it lose samples, what does it cost.

  tests/faults/soak.py --hours 24          bench time, as fast as the machine allows
  tests/faults/soak.py --minutes 20        real time
  tests/faults/soak.py --hours 1 --json out.json

Runs of several kinds follow each other: rests of ten minutes, turns, swings, and dry runs between them. After each the
daemon's memory and descriptors are read, and its record is looked through for samples that are missing; then the record
is removed, but for the last. Growth is that of the second half of the time against its first: the least of each, since
what a run needs is given back when the next begins.

Exit status 1 where memory grew by more than --most-growth, descriptors by more than --most-descriptors, or a sample was
lost. The daemon is that of GYROBENCH_BIN.
"""
import argparse
import json
import os
import pathlib
import shutil
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "end_to_end"))
import bench as benches  # noqa: E402
import record as records  # noqa: E402

HEAD = "procedure = { summary = 'x', description = 'x', measures = {}, parameters = {} }\nfunction run(p)\n"
LONG_S, SHORT_S = 600, 60
PROCEDURES = {"long": HEAD + f"bench.rest{{ duration_s={LONG_S} }}\nend\n",
              "short": HEAD + f"bench.rest{{ duration_s={SHORT_S} }}\nend\n"}
SCALE = ["scale", "-p", "turns=8", "-p", "rest_s=1", "-p", "initial_rest_s=5"]
SWEEP = ["sweep", "-p", "frequencies_hz=0.4,0.8", "-p", "duration_s=5", "-p", "initial_rest_s=5"]
TICKS_PER_S = os.sysconf("SC_CLK_TCK")


class Vitals:
    """Of a process, as the kernel knows them."""

    def __init__(self, pid):
        status = pathlib.Path(f"/proc/{pid}/status").read_text()
        fields = dict(line.split(":", 1) for line in status.splitlines())
        self.memory_mib = int(fields["VmRSS"].split()[0]) / 1024
        self.peak_mib = int(fields["VmHWM"].split()[0]) / 1024
        self.threads = int(fields["Threads"])
        self.descriptors = len(os.listdir(f"/proc/{pid}/fd"))
        words = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
        self.processor_s = (int(words[11]) + int(words[12])) / TICKS_PER_S


def one_run(bench, arguments):
    """A row of figures: what the record holds, and how the daemon is after it."""
    bench.run("check", "scale")
    begin = time.monotonic()
    done = bench.run("run", *arguments)
    if done.returncode != 0:
        raise RuntimeError(f"{arguments[0]}: {done.stdout[-500:]}{done.stderr}")
    folder = bench.newest_record()
    blocks, _ = records.read(folder / "events.lcmlog")
    run = json.loads((folder / "run.json").read_text())
    shutil.rmtree(folder)
    vitals = Vitals(bench.daemon.pid)
    return {"run": arguments[0], "bench_s": (run["end_utime"] - run["start_utime"]) * 1e-6,
            "wall_s": time.monotonic() - begin, "samples": sum(block.n for block in blocks),
            "lost": sum(block.missed for block in blocks[1:]) + len(records.unmarked_gaps(blocks)), **vars(vitals)}


def soak(bench, ends, rests):
    rows, bench_s = [], 0.0
    in_turn = [[rests], SCALE, [rests], SWEEP, [rests]]
    while not ends(bench_s):
        rows.append(one_run(bench, in_turn[len(rows) % len(in_turn)]))
        bench_s += rows[-1]["bench_s"]
        if len(rows) % 20 == 1:
            last = rows[-1]
            print(f"{bench_s / 3600:6.2f} h, {len(rows)} runs: {last['memory_mib']:.1f} MiB, {last['descriptors']} descriptors, "
                  f"{last['processor_s']:.0f} s of processor", file=sys.stderr, flush=True)
    return rows


def growth(rows, key):
    """The least of the second half against the least of the first, whose first quarter is not looked at: of few runs the
    first one, in which the allocator takes what all others have."""
    values = [row[key] for row in rows]
    half = len(values) // 2
    return min(values[half:]) - min(values[max(half // 4, 1):half]) if half > 1 else 0


def judge(rows, options):
    found = []
    grown_mib, grown = growth(rows, "memory_mib"), growth(rows, "descriptors")
    if grown_mib > options.most_growth:
        found.append(f"memory has grown by {grown_mib:.1f} MiB, expected at most {options.most_growth:g}")
    if grown > options.most_descriptors:
        found.append(f"descriptors have grown by {grown}, expected at most {options.most_descriptors}")
    if lost := sum(row["lost"] for row in rows):
        found.append(f"{lost} samples were lost")
    return found


def print_summary(rows):
    hours = sum(row["bench_s"] for row in rows) / 3600
    wall_s = sum(row["wall_s"] for row in rows)
    print(f"{len(rows)} runs, {hours:.2f} h of bench time in {wall_s:.0f} s: {sum(row['samples'] for row in rows)} samples, "
          f"{sum(row['lost'] for row in rows)} lost")
    print(f"memory {rows[0]['memory_mib']:.1f} MiB after the first run, {rows[-1]['memory_mib']:.1f} after the last, "
          f"grown by {growth(rows, 'memory_mib'):.1f}, peak {rows[-1]['peak_mib']:.1f}")
    print(f"descriptors {rows[0]['descriptors']} after the first run, {rows[-1]['descriptors']} after the last; threads "
          f"{rows[0]['threads']} and {rows[-1]['threads']}")
    print(f"processor {rows[-1]['processor_s']:.0f} s, {rows[-1]['processor_s'] / hours:.1f} s an hour of bench time")


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--hours", type=float, default=24, help="of bench time; default: %(default)s")
    length.add_argument("--minutes", type=float, help="in real time")
    parser.add_argument("--most-growth", type=float, default=16, help="of memory, MiB; default: %(default)s")
    parser.add_argument("--most-descriptors", type=int, default=0, help="more; default: %(default)s")
    parser.add_argument("--json", type=pathlib.Path, help="all rows")
    return parser.parse_args(arguments)


def main(arguments):
    options = parse(arguments)
    begin = time.monotonic()
    if options.minutes:
        ends, pace, rests = lambda _: time.monotonic() - begin >= 60 * options.minutes, 1, "short"
    else:
        ends, pace, rests = lambda bench_s: bench_s >= 3600 * options.hours, 0, "long"
    with benches.Bench(procedures=PROCEDURES, extra=f"[virtual]\npace = {pace}\n") as bench:
        rows = soak(bench, ends, rests)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))
    print_summary(rows)
    found = judge(rows, options)
    for one in found:
        print(f"  {one}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
