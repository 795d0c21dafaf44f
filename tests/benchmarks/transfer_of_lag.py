#!/usr/bin/env python3
"""What a calibration's lags of one recording do for another: angle error in windows of 10 s.

    gyrobench trace SLOW --calibration slow.json
    tests/benchmarks/transfer_of_lag.py slow.json MEDIUM

Scale factor and offset are fitted to MEDIUM itself, before and after; the lags are those of the
calibration alone. Works apart from the tracer: increments of the angle against the gyro's integral.
"""

import argparse
import bisect
import csv
import gzip
import json
import math

WINDOW_S = 10.0


def lag_s(calibration, axis):
    channel = next(c for c in calibration["channels"] if c["gyro"] == axis)
    lags = ("angle.latency", "bandwidth.first_order")
    return sum(e["coefficients"][0] for e in channel["terms"] if e["id"] in lags)


def read(path, axis):
    opener = gzip.open if path.endswith(".gz") else open
    times, angles, turned = [], [], []
    last_rate = None
    with opener(path, "rt", encoding="utf-8") as table:
        for row in csv.DictReader(line for line in table if not line.startswith("#")):
            t = float(row["t_s"])
            angle, rate = float(row[f"ref_angle_{axis}_deg"]), float(row[f"gyro_{axis}_deg_s"])
            if times and t <= times[-1]:
                continue
            if not times:
                times, angles, turned = [t], [angle], [0.0]
            else:
                step = angle - angles[-1]
                angles.append(angles[-1] + step - 360.0 * round(step / 360.0))
                turned.append(turned[-1] + 0.5 * (rate + last_rate) * (t - times[-1]))
                times.append(t)
            last_rate = rate
    return times, angles, turned


def delayed(times, values, by_s):
    out = []
    for t in times:
        k = min(max(bisect.bisect_right(times, t - by_s) - 1, 0), len(times) - 2)
        part = (t - by_s - times[k]) / (times[k + 1] - times[k])
        out.append(values[k] + part * (values[k + 1] - values[k]))
    return out


def windows(times):
    begin = 0
    for k in range(1, len(times) + 1):
        if k == len(times) or times[k] - times[begin] > WINDOW_S or times[k] - times[k - 1] > 1.0:
            yield begin, k
            begin = k


def error_deg(times, angles, turned):
    """Of turned = m angle + b t + a constant in each window, by least squares."""
    centred = []
    for begin, end in windows(times):
        means = [sum(v[begin:end]) / (end - begin) for v in (angles, times, turned)]
        centred += [
            (angles[k] - means[0], times[k] - means[1], turned[k] - means[2])
            for k in range(begin, end)
        ]
    aa, at, tt, ay, ty = (
        sum(r[i] * r[j] for r in centred) for i, j in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2))
    )
    det = aa * tt - at * at
    m, b = (ay * tt - ty * at) / det, (ty * aa - ay * at) / det
    return math.sqrt(sum((y - m * a - b * t) ** 2 for a, t, y in centred) / len(centred))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("calibration", help="calibration.json of another recording")
    parser.add_argument("table", help="measurement table with the angle of one axis")
    parser.add_argument("--axis", default="z", choices="xyz")
    options = parser.parse_args()
    with open(options.calibration, encoding="utf-8") as file:
        lag = lag_s(json.load(file), options.axis)
    times, angles, turned = read(options.table, options.axis)
    print(f"lag of the calibration   {1e3 * lag:8.2f} ms")
    print(f"without it               {error_deg(times, angles, turned):8.3f} deg")
    print(f"with it                  {error_deg(times, delayed(times, angles, lag), turned):8.3f} deg")


if __name__ == "__main__":
    main()
