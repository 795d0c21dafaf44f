#!/usr/bin/env python3
"""Error of the rate in short windows, before and after a calibration learnt on the first part.

    tests/benchmarks/window_rates.py build/dev/bin/gyrobench TABLE

TABLE has orientations as its reference. The first 60 % of its rows are traced, the calibration is
applied to the whole table, and the rest of the rows judges: mean rate of the gyro less that of the
reference in windows of 0.2 s, root mean square over the axes. Before: scale factor and offset of
each axis alone, by least squares on the first part. After: `gyrobench apply`, with the reference
read later by the latency that the trace found, for that is the bench's error and not the gyro's.
"""

import argparse
import json
import os
import subprocess
import tempfile

import numpy
import pandas

LEARNT = 0.6
WINDOW_S = 0.2
AXES = "xyz"


def increments_deg(orientation):
    """Rotation vectors in the sensor's frame from row to row; shape (rows - 1, 3)."""
    a, b = orientation[:-1], orientation[1:]
    scalar = (a * b).sum(axis=1)
    vector = (
        a[:, [0]] * b[:, 1:] - b[:, [0]] * a[:, 1:] - numpy.cross(a[:, 1:], b[:, 1:])
    ) * numpy.where(scalar < 0, -1, 1)[:, None]
    length = numpy.linalg.norm(vector, axis=1)
    angle = 2 * numpy.arctan2(length, abs(scalar))
    return numpy.degrees(vector * (angle / numpy.where(length > 0, length, 1))[:, None])


def delayed(times, path, by_s):
    return numpy.column_stack(
        [numpy.interp(times - by, times, column) for by, column in zip(by_s, path.T)]
    )


def window_rates(times, path, lost):
    """Mean rate of each window [deg/s], and whether the reference was there all along."""
    edges = numpy.arange(times[0], times[-1], WINDOW_S)
    rows = numpy.searchsorted(times, edges)
    rates = numpy.diff(path[rows], axis=0) / numpy.diff(times[rows])[:, None]
    losses = numpy.diff(numpy.cumsum(lost)[rows])
    return rates, losses == 0


def latencies_s(calibration):
    out = []
    for axis in AXES:
        channel = next(c for c in calibration["channels"] if c["gyro"] == axis)
        out.append(
            sum(t["coefficients"][0] for t in channel["terms"] if t["id"] == "angle.latency")
        )
    return out


def learn(gyrobench, table, folder):
    """Traces the first rows; returns the calibration and the whole table corrected by it."""
    learnt, calibration, corrected = (
        os.path.join(folder, name) for name in ("learnt.csv", "calibration.json", "corrected.csv")
    )
    table.iloc[: int(LEARNT * len(table))].to_csv(learnt, index=False)
    whole = os.path.join(folder, "whole.csv")
    table.to_csv(whole, index=False)
    for command in (
        ["trace", learnt, "--calibration", calibration],
        ["apply", calibration, whole, "-o", corrected],
    ):
        subprocess.run([gyrobench, *command], check=True, stdout=subprocess.DEVNULL)
    with open(calibration, encoding="utf-8") as file:
        return json.load(file), pandas.read_csv(corrected, comment="#")


def path_of(times, rates):
    steps = 0.5 * (rates[1:] + rates[:-1]) * numpy.diff(times)[:, None]
    return numpy.vstack([numpy.zeros(3), numpy.cumsum(steps, axis=0)])


def size(errors):
    return numpy.sqrt((errors**2).mean())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("gyrobench", help="the program")
    parser.add_argument("table", help="measurement table with gyro_*_rad_s and ref_q*")
    options = parser.parse_args()
    table = pandas.read_csv(options.table, comment="#")
    times = table["t_s"].to_numpy()
    turned = increments_deg(table[["ref_qw", "ref_qx", "ref_qy", "ref_qz"]].to_numpy())
    lost = numpy.concatenate([[False], ~numpy.isfinite(turned).all(axis=1)])
    reference = numpy.vstack([numpy.zeros(3), numpy.cumsum(numpy.nan_to_num(turned), axis=0)])
    raw = path_of(times, numpy.degrees(table[[f"gyro_{a}_rad_s" for a in AXES]].to_numpy()))
    with tempfile.TemporaryDirectory() as folder:
        calibration, corrected = learn(options.gyrobench, table, folder)
    after = path_of(times, corrected[[f"gyro_{a}_deg_s" for a in AXES]].to_numpy())

    truth, there = window_rates(times, reference, lost)
    first = numpy.arange(len(there)) < LEARNT * len(there)
    learnt, judged = there & first, there & ~first
    measured = window_rates(times, raw, lost)[0]
    before = numpy.empty_like(measured)
    for k in range(3):
        model = numpy.column_stack([truth[:, k], numpy.ones(len(truth))])
        fit = numpy.linalg.lstsq(model[learnt], measured[learnt, k], rcond=None)[0]
        before[:, k] = measured[:, k] - model @ fit
    late = window_rates(times, delayed(times, reference, latencies_s(calibration)), lost)[0]
    errors = window_rates(times, after, lost)[0] - late
    print(f"{'deg/s':<8}{'before':>8}{'after':>8}")
    for k, axis in enumerate(AXES):
        print(f"{axis:<8}{size(before[judged, k]):8.3f}{size(errors[judged, k]):8.3f}")
    print(f"{'all':<8}{size(before[judged]):8.3f}{size(errors[judged]):8.3f}")


if __name__ == "__main__":
    main()
