"""Measurement tables as text, fast: digits are laid out in one array of bytes, then the blanks are dropped."""
import numpy as np


class Column:
    """Values to be printed with a fixed number of decimals; those not finite are empty fields."""

    def __init__(self, name, values, decimals):
        self.name, self.values, self.decimals = name, values, decimals


def _field(values, decimals):
    """Characters (n, width) of a column with a comma after it, and which of them count."""
    there = np.isfinite(values)
    scaled = np.rint(np.where(there, values, 0.0) * 10.0 ** decimals).astype(np.int64)
    negative, left = scaled < 0, np.abs(scaled)
    if left.size and left.max() < 2 ** 31:
        left = left.astype(np.uint32)
    digits = max(len(str(int(left.max()))) if left.size else 1, decimals + 1)
    point = 1 if decimals else 0
    width = 1 + digits + point + 1
    text = np.empty((values.size, width), dtype=np.uint8)
    keep = np.empty((values.size, width), dtype=bool)
    text[:, 0], keep[:, 0] = ord("-"), negative & there
    text[:, -1], keep[:, -1] = ord(","), True
    at = width - 2
    for j in range(digits):
        if point and j == decimals:
            text[:, at], keep[:, at] = ord("."), there
            at -= 1
        higher = left // 10
        text[:, at] = (left - higher * 10) + ord("0")
        keep[:, at] = there if j <= decimals else there & (left + higher > 0)
        left = higher
        at -= 1
    return text, keep


def write_table(path, keys, columns, block=100000):
    """Writes one table: `# key = value` lines, the header, the rows."""
    with open(path, "wb") as out:
        for key, value in keys.items():
            out.write(f"# {key} = {value}\n".encode())
        out.write((",".join(c.name for c in columns) + "\n").encode())
        for begin in range(0, columns[0].values.size, block):
            fields = [_field(c.values[begin:begin + block], c.decimals) for c in columns]
            text = np.concatenate([t for t, _ in fields], axis=1)
            keep = np.concatenate([k for _, k in fields], axis=1)
            text[:, -1] = ord("\n")
            out.write(text[keep].tobytes())
