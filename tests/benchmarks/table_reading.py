#!/usr/bin/env python3
"""Best times [s], wall and processor, of reading one measurement table: table_reading.py pandas|numpy TABLE.csv[.gz]

Called by bench_table_reading, which prints it next to gyrobench's own figures.
"""
import gzip
import sys
import time

REPEATS = 4


def read_pandas(path):
    import pandas
    return pandas.read_csv(path, engine="c", comment=None)


def read_numpy(path):
    import numpy
    # A converter for empty fields costs numpy most of its speed: where there are none, it gets none.
    opened = gzip.open if path.endswith(".gz") else open
    with opened(path, "rt") as table:
        table.readline()
        rows = [table.readline() for _ in range(8)]
    missing = any(",," in row or row.rstrip().endswith(",") for row in rows)
    converters = (lambda field: float(field or "nan")) if missing else None
    return numpy.loadtxt(path, delimiter=",", skiprows=1, converters=converters, encoding="utf-8")


def main():
    read = {"pandas": read_pandas, "numpy": read_numpy}[sys.argv[1]]
    read(sys.argv[2])
    wall = processor = float("inf")
    for _ in range(REPEATS):
        begin, processor_begin = time.perf_counter(), time.process_time()
        read(sys.argv[2])
        wall = min(wall, time.perf_counter() - begin)
        processor = min(processor, time.process_time() - processor_begin)
    print(f"{wall:.6f} {processor:.6f}")


if __name__ == "__main__":
    main()
