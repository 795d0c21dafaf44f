"""Defects of recorded data: what a logger, a cable or a shock makes of good rows."""
import numpy as np

from tables import Column


def damaged(rng, columns):
    """Rows lost and doubled, a gap, a lost reference, single outliers, in one table."""
    n = columns[0].values.size
    for column in columns:
        column.values = column.values.copy()
        if column.name.startswith("gyro_"):
            where = rng.integers(0, n, rng.integers(0, 3))
            column.values[where] = np.clip(column.values[where] * -3.0 + 9000.0, -32000, 32000)
    _lose_reference(rng, columns, n)
    order = _rows(rng, n)
    return [Column(c.name, c.values[order], c.decimals) for c in columns]


def with_missing_cells(rng, columns, share):
    """Single cells of the gyro's axes that are empty, each axis by itself."""
    out = []
    for column in columns:
        values = column.values
        if column.name.startswith("gyro_"):
            values = np.where(rng.uniform(size=values.size) < share, np.nan, values)
        out.append(Column(column.name, values, column.decimals))
    return out


def stamped_late(rng, columns, mean_s):
    """Rows in their order, each stamped later than it was taken by an exponential time of its own, to microseconds."""
    (at,) = [i for i, c in enumerate(columns) if c.name == "t_s"]
    taken_s, apart_s = columns[at].values, 1e-6 * np.arange(columns[at].values.size)
    late_s = taken_s + rng.exponential(mean_s, taken_s.size)
    stamps = np.maximum.accumulate(late_s - apart_s) + apart_s
    return columns[:at] + [Column("t_s", stamps, 6)] + columns[at + 1:]


def _lose_reference(rng, columns, n):
    begin, length = rng.integers(0, n), rng.integers(20, 400)
    for column in columns:
        if column.name.startswith("ref_") and n > 2000:
            column.values[begin:begin + length] = np.nan


def _rows(rng, n):
    """Rows as they arrive: single ones missing, single ones twice, and now and then a gap."""
    count = np.ones(n, dtype=np.int64)
    count[rng.integers(0, n, rng.integers(0, 6))] = 0
    count[rng.integers(0, n, rng.integers(0, 6))] = 2
    if rng.uniform() < 0.3:
        begin = rng.integers(0, n)
        count[begin:begin + rng.integers(20, 200)] = 0
    return np.repeat(np.arange(n), count)
