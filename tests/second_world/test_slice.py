"""A slice of the campaign: eight short sets of the second world, traced by the program that is given; and the sets that
once showed a mistake of the tracer.

    test_slice.py GYROBENCH

Of the slice it asks for what must hold on any day: every set is answered, and of strong effects no wrong one is named
alone. How often the right one is named is the campaign's business. The others must stay as they became: the truth is
named, alone or among rivals, and nothing else on any channel.
"""
import multiprocessing
import sys

try:
    import numpy  # noqa: F401
except ImportError:
    print("skipped: this interpreter has no numpy")
    sys.exit(77)

import campaign

CLASSES = "short_run,single_axis_table,quaternion_hand,fast_gyro"
ARGUMENTS = ["--sets", "8", "--seed", "40", "--classes", CLASSES, "--kinds", "single,silent", "--levels", "100",
             "--jobs", "2"]
# What was named, or was not, and why.
MENDED = {
    "coarse_encoder:silent:0:60045": "ripples: means of rounded readings looked finer than they are, no axis rested",
    "coarse_encoder:single:100:8402035": "no ripple: each table alone rests at too few places to know the encoder's noise",
    "coarse_encoder:unknown:100:9400217": "a play and a latency: one reading beside a rest passed for all but exact",
    "data_defects:single:5:121169": "a step of the angle: a wild gyro sample of 4 deg/s passed",
    "data_defects:single:20:200411": "no tone: a wild gyro sample was among the first 32 of a table",
    "data_defects:silent:0:60103": "steps of the angle: wild gyro samples in motion passed",
    "fast_gyro:single:5:1200305": "no eccentricity: the only turn was held out by an extrapolation",
    "fast_gyro:single:20:91327": "no tone: it passed for bias random walk",
    "fast_reference:single:20:61047": "a step of the angle at rest: as two halves at the rest's ends",
    "coarse_stamps:silent:0:7800128": "steps of the angle: a line of rounded stamps began by few of them",
    "late_rows:single:20:7800437": "steps of the angle: stamps jumped by a packet once in a minute",
    "late_rows:single:100:3000034": "no step of the bias but of the angle: rows that came late were taken to be made then",
    "means_before:silent:0:82": "a filter: samples were means over the interval before, and late by half of it",
    "means_before:silent:0:1960013": "a filter: each channel judged by itself what the samples of the sensor are",
    "means_before:single:100:1960026": "a filter: a latency of just half an interval was no sign of such means",
    "missing_cells:silent:0:2500005": "a latency: a missing cell had the value of the sample before it",
    "noisy_slow_reference:silent:0:60024": "steps of the angle: the slow end of a motion was taken into a rest",
    "noisy_slow_reference:single:20:130046": "a step of the angle: a rest's mean passed for exact beside its own edge",
    "noisy_slow_reference:single:20:130222": "two steps of the bias: readings before and after a step had one mean",
    "noisy_slow_reference:single:100:130068": "no tone but steps: a reversal of 0.1 s was taken for a rest",
    "noisy_slow_reference:single:100:130112": "an eccentricity on another channel: as in 130046",
    "oblique_poses:single:100:9700035": "no ripple: it was smaller than half a step of the encoder",
    "oblique_poses:silent:0:9700008": "scale factors: axes at rest between two counts turned the others' direction",
    "own_clock_reference:unknown:20:200048": "an asymmetry beside a product: the product's temperature had another zero",
    "packed_stamps:silent:0:2800005": "a ripple: rows of a serial adapter were taken to be made when they came",
    "own_clock_reference:silent:0:62158": "steps of the angle: readings were moved when their stamp met a sample's",
    "poor_thermometer:single:100:91056": "two steps of the angle for one: it was placed to 12 ms",
    "poses_at_rest:single:5:121036": "no hysteresis: a fold was met by an extrapolation, so that it seemed useless",
    "poses_at_rest:single:5:1200938": "no g-sensitivity: a pose was held out by an extrapolation",
    "quaternion_hand:single:20:130228": "no tone: of a hand that hardly rests none was looked for",
    "quaternion_hand:single:100:91052": "an even scale: no resonance was looked for beyond 40 deg/s",
    "rounded_stamps:silent:0:62": "ripples: the beat of a clock with the milliseconds of its stamps",
    "seldom_logged:silent:0:50": "a delay of one run: ramps began between samples, and nobody knew where",
    "seldom_logged:single:20:7800058": "no curve of the scale: it was less than rounding makes of rests",
    "seldom_logged:single:5:7200092": "a product of rate and warming for a scale factor that depends on gravity",
    "short_run:single:5:62083": "g-sensitivity: Earth's rotation stayed on channels whose axis did not turn",
    "short_run:single:20:91193": "no step of the bias: it passed for bias random walk",
    "short_run:single:100:61127": "a step of the angle: the play began at its side",
    "slow_turns:pair:20:3100027": "neither: with an eccentricity of 15 deg a node's own noise passed for the gyro's",
    "slow_turns:pair:100:3100012": "steps of the angle as well: a column that is not there made one reading as good as six",
    "three_encoders:single:100:90044": "a latency beside the play, which was crossed back within nodes",
}


def traced(job):
    """The record of one set; an error names it."""
    try:
        return campaign.run_set(job)
    except Exception as error:
        raise RuntimeError(":".join(str(part) for part in job[1:5])) from error


def mended(program):
    """What the sets of MENDED show that they must not."""
    jobs, failures = [], []
    for name in MENDED:
        bench, kind, level, seed = name.split(":")
        jobs.append((program, bench, kind, float(level), int(seed), None, (), False))
    with multiprocessing.Pool(2) as pool:
        records = pool.map(traced, jobs, chunksize=1)
    for (name, what), record in zip(MENDED.items(), records):
        false = [f"{c['channel']}: {', '.join(c['false'])}" for c in record["silent"] if c["false"]]
        false += [f"{e['id']} with the wrong sign" for e in record["errors"] if e["wrong_sign"]]
        if record["word"] not in ("silent", "exact", "among", "recognised") or false:
            failures.append(f"{name} ({what}): {record['word']}, said {record['said']}; falsely {false}")
    return failures


def main(program):
    options = campaign.options_of([program, *ARGUMENTS])
    records = campaign.run_all(options)
    campaign.printing.print_all(records)
    failures = [f"{r['bench_class']}:{r['kind']}:{r['level']:g}:{r['seed']} {r['word']}: truth {r['truth']}, "
                f"said {r['said']}" for r in records if r["word"] in ("refused", "wrong")]
    if len(records) != options.sets:
        failures.append(f"{options.sets - len(records)} sets were not scored")
    failures += mended(program)
    for failure in failures:
        print("FAILED", failure)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
