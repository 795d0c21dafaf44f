"""Temperature of the sensor over one power-on, on a fixed grid of time.

First order towards a target that changes in steps: dT/dt = (target - T) / tau  (the catalogue's full sequence).
"""
import numpy as np

GRID_S = 0.5
TIME_CONSTANT_S = 250.0
COLD_DEGC, WARM_DEGC = 22.0, 38.0


class Thermal:
    """T [degC], dT/dt [degC/s] and the thermometer's T, at any time since power-on."""

    def __init__(self, kind, targets, end_s, start_degC, thermometer_lag_s):
        self.grid_s = np.arange(0.0, end_s + 10.0 * GRID_S, GRID_S)
        target = self._target(kind, targets)
        self.true_degC = first_order(target, start_degC, TIME_CONSTANT_S)
        self.rate_degC_s = (target - self.true_degC) / TIME_CONSTANT_S
        self.shown_degC = self.true_degC
        if thermometer_lag_s > 0.0:
            self.shown_degC = first_order(self.true_degC, start_degC, thermometer_lag_s)

    def _target(self, kind, targets):
        if kind == "constant":
            return np.full(self.grid_s.size, WARM_DEGC)
        if kind == "cycles":  # a chamber that heats and cools
            return 31.0 + 9.0 * np.sign(np.sin(2.0 * np.pi * self.grid_s / 1100.0 + 0.3))
        target = np.empty(self.grid_s.size)
        for since_s, value in targets:
            target[self.grid_s >= since_s] = value
        return target

    def at(self, t_s, what):
        return np.interp(t_s, self.grid_s, what)


def first_order(target, start, time_constant_s):
    """dy/dt = (target - y) / tau on the grid, target held over each step."""
    decay = np.exp(-GRID_S / time_constant_s)
    y, value = np.empty(target.size), start
    for i, goal in enumerate(target):
        y[i] = value
        value = goal + (value - goal) * decay
    return y


def play(values, half_width, start):
    """Play operator: p_k = max(v_k - r, min(v_k + r, p_(k-1))).

    Runs of monotone values are done at once: within one, p is the running limit of a single bound.
    """
    out = np.empty(values.size)
    turning = np.flatnonzero(np.diff(np.sign(np.diff(values))) != 0) + 1
    edges = np.concatenate([[0], turning + 1, [values.size]])
    p = start
    for a, b in zip(edges[:-1], edges[1:]):
        part = values[a:b]
        if b - a == 0:
            continue
        out[a:b] = np.maximum(part - half_width, np.minimum(part + half_width, p))
        p = out[b - 1]
    return out
