"""What an effect gains where the tracer knows the noise, and where it has to estimate it from the same data.

Angle random walk N and bias random walk K of the gyro are unknown to a tracer; an effect that is slow is taken for a
random walk in part. Residuals are drawn with the true noise and the effect; the model without the effect and the model
with it each get the walk (of a grid about the true one) and the scale of all noise that suit them best, by the
restricted likelihood of the noise beside the baseline.
"""
import dataclasses

import numpy as np

from whitening import Whitener

WALKS = (0.03, 0.2, 0.4, 0.7, 1.0, 1.4, 2.0, 3.0, 5.0, 9.0, 20.0)  # of the true K
KNOWN = WALKS.index(1.0)
MOST_READINGS = 15000


@dataclasses.dataclass
class Readings:
    dt_s: np.ndarray  # since the reading before
    starts: np.ndarray  # 0 goes on, 1 new table, 2 new power-on
    variance_deg2: np.ndarray
    within_deg2: np.ndarray  # of the step of the angle up to each reading, beyond N and K
    arw_deg_sqrt_s: float
    brw_deg_s_sqrt_s: float

    def noise(self, rng, draws):
        """Residual angles [deg] of noise alone, (draws, readings). Angles and biases begin anywhere: both are free."""
        size = (draws, self.dt_s.size)
        root = np.sqrt(self.dt_s)
        step = self.brw_deg_s_sqrt_s * root * rng.standard_normal(size)
        before = np.cumsum(step, axis=1) - step
        # Exact over a step: the bias's walk within it adds K^2 dt^3 / 12 beside its mean.
        within = self.brw_deg_s_sqrt_s * self.dt_s * root / np.sqrt(12.0) * rng.standard_normal(size)
        turn = (before + 0.5 * step) * self.dt_s + within
        white = np.sqrt(self.arw_deg_sqrt_s ** 2 * self.dt_s + self.within_deg2)
        angle = np.cumsum(turn + white * rng.standard_normal(size), axis=1)
        return angle + np.sqrt(self.variance_deg2) * rng.standard_normal(size)


def some_readings(starts):
    """Indices of evenly many readings, and of those at which something starts. What is slow is in them as well."""
    every = -(-starts.size // MOST_READINGS)
    return np.flatnonzero((starts > 0) | (np.arange(starts.size) % every == 0))


def gains(rng, readings, baseline, effect, theta, draws=200):
    """2 x log-likelihood that the effect gains, of each draw: (noise known, noise estimated).

    baseline, effect: columns over the readings; theta: the effect's true parameters.
    """
    truth = theta @ np.array(effect)
    columns = [*baseline, *effect, *(readings.noise(rng, draws) + truth)]
    scale = [max(np.abs(column).max(), 1e-300) for column in [*baseline, *effect]]
    columns[:len(scale)] = [column / size for column, size in zip(columns, scale)]
    deviances = np.array([_deviances(readings, walk, columns, len(baseline), len(effect)) for walk in WALKS])
    without, with_it, known = deviances[:, 0], deviances[:, 1], deviances[KNOWN, 2]  # (walks, draws)
    return known, without.min(axis=0) - with_it.min(axis=0)


def _deviances(readings, walk, columns, free, own):
    """-2 log of the restricted likelihood without and with the effect, but for a common constant, and what the effect
    gains where this noise is known to be the true one: (3, draws)."""
    whiten = Whitener(readings.dt_s, readings.variance_deg2, readings.within_deg2, readings.starts,
                      readings.arw_deg_sqrt_s, walk * readings.brw_deg_s_sqrt_s)
    white = whiten(columns)
    noise = 2.0 * np.log(whiten.sigma).sum()
    outputs = white[:, free + own:]
    basis, kept = _basis(white[:, :free])
    information = 2.0 * np.log(kept).sum()
    freedom = readings.dt_s.size - kept.size
    outputs = outputs - basis @ (basis.T @ outputs)
    own_basis, _ = _basis(white[:, free:free + own] - basis @ (basis.T @ white[:, free:free + own]))
    left = (outputs ** 2).sum(axis=0)
    gain = ((own_basis.T @ outputs) ** 2).sum(axis=0)
    by_scale = [noise + information + freedom * np.log(square / freedom) for square in (left, left - gain)]
    return [*by_scale, gain]


def _basis(columns):
    """Orthonormal columns of the same span, dependent ones left out, and the lengths that they had."""
    vectors, values, _ = np.linalg.svd(columns, full_matrices=False)
    kept = values > 1e-7 * values.max(initial=0.0)
    return vectors[:, kept], values[kept]
