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


def late_times(rng, mean_s, most_s, n):
    """By how much stamps are late [s]: exponential, and no more than most_s."""
    return np.minimum(rng.exponential(mean_s, n), most_s)


def late_variance(mean_s, most_s):
    """Variance [s^2] of late_times."""
    if not mean_s:
        return 0.0
    left = np.exp(-most_s / mean_s)
    return 2.0 * mean_s ** 2 * (1.0 - left * (1.0 + most_s / mean_s)) - (mean_s * (1.0 - left)) ** 2


def stamped_late(rng, columns, mean_s, most_s):
    """Rows stamped when a computer gets to them, to microseconds, in the order of these stamps."""
    (at,) = [i for i, c in enumerate(columns) if c.name == "t_s"]
    stamps = columns[at].values + late_times(rng, mean_s, most_s, columns[at].values.size)
    order = np.argsort(stamps, kind="stable")
    apart_s = 1e-6 * np.arange(order.size)
    stamps = np.maximum.accumulate(stamps[order] - apart_s) + apart_s
    return [Column("t_s", stamps, 6) if i == at else Column(c.name, c.values[order], c.decimals)
            for i, c in enumerate(columns)]


def in_packets(rng, columns, packet_s, decimals):
    """Rows stamped as a serial adapter hands them over: all that it has, one after the other, every packet_s."""
    row_s = 5e-5
    (at,) = [i for i, c in enumerate(columns) if c.name == "t_s"]
    t_s = columns[at].values
    begin_s = rng.uniform(0.0, packet_s)
    number = np.floor((t_s - begin_s) / packet_s).astype(np.int64)
    first = np.concatenate([[0], np.flatnonzero(np.diff(number)) + 1])
    in_packet = np.arange(t_s.size) - np.repeat(first, np.diff(np.append(first, t_s.size)))
    read = rng.exponential(1e-4, number[-1] - number[0] + 1)[number - number[0]]
    stamps = begin_s + (number + 1) * packet_s + read + row_s * in_packet
    apart_s = 1e-6 * np.arange(t_s.size)
    stamps = np.maximum.accumulate(stamps - apart_s) + apart_s
    return [Column("t_s", stamps, decimals) if i == at else c for i, c in enumerate(columns)]


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
