"""A slice of the campaign: eight short sets of the second world, traced by the program that is given.

    test_slice.py GYROBENCH

It asks for what must hold on any day: every set is answered, and of strong effects no wrong one is named alone.
How often the right one is named is the campaign's business.
"""
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


def main(program):
    options = campaign.options_of([program, *ARGUMENTS])
    records = campaign.run_all(options)
    campaign.printing.print_all(records)
    failures = [f"{r['bench_class']}:{r['kind']}:{r['level']:g}:{r['seed']} {r['word']}: truth {r['truth']}, "
                f"said {r['said']}" for r in records if r["word"] in ("refused", "wrong")]
    if len(records) != options.sets:
        failures.append(f"{options.sets - len(records)} sets were not scored")
    for failure in failures:
        print("FAILED", failure)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
