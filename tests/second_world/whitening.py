"""Exact whitening of the residual angle at every reading of the reference.

State (angle error a [deg], bias b [deg/s]) between readings dt apart:
    a' = a + b dt + noise,  b' = b + noise,  Q = [[N^2 dt + K^2 dt^3/3, K^2 dt^2/2], [K^2 dt^2/2, K^2 dt]]
and each reading sees a with variance R. A table begins with an unknown angle; a power-on with an unknown bias too.
(The catalogue's page, "Exact generalised least squares by whitening", here with the time-varying filter.)

The gains depend on the times alone and come from one pass in scalars. The columns then obey a linear recursion that is
cut into stretches: all stretches run side by side from zero, then their starts are handed on from one to the next.
"""
import numpy as np

UNKNOWN_ANGLE_VARIANCE = 1e6  # deg^2
UNKNOWN_BIAS_VARIANCE = 1e4  # (deg/s)^2
AT_ONCE = 65536  # values that one step of the recursion has at hand: they stay in the processor's last cache


class Whitener:
    """Filter for readings with steps dt_s, variances R, and starts: 0 goes on, 1 new table, 2 new power-on.

    within: variance of the step of the angle up to each reading, beyond that of the noise N and K.
    """

    def __init__(self, dt_s, variance, within, starts, arw, brw):
        self.f_aa, self.f_ab = (starts == 0).astype(float), np.where(starts == 0, dt_s, 0.0)
        self.f_bb = (starts != 2).astype(float)
        self.gain_a, self.gain_b, self.sigma = _gains(dt_s, variance, within, starts, arw, brw)

    def __call__(self, columns, stretch=256):
        """Whitened columns, from p columns of n readings: (m, p), in the order of the stretches, zero where padded.

        Over the readings the true noise becomes white of variance 1. `in_order` brings them back to the order of time.
        """
        p, n = len(columns), columns[0].size
        count = -(-n // stretch)
        f = [self._cut(v, count, stretch) for v in (self.f_aa, self.f_ab, self.f_bb, self.gain_a, self.gain_b)]
        weights = self._cut(1.0 / self.sigma, count, stretch)
        white, padded = np.empty((p, stretch, count)), np.zeros(count * stretch)
        for k, column in enumerate(columns):
            padded[:n] = column
            white[k] = padded.reshape(count, stretch).T
        nothing, (of_a, of_b) = np.zeros((2, stretch, count)), np.eye(2)[:, :, None] * np.ones(count)
        passed_on = self._run(nothing, f, of_a, of_b, False)  # of an angle and of a bias of 1 at each stretch's start
        together = max(1, AT_ONCE // count)
        for first in range(0, p, together):
            part = white[first:first + together]
            zeros = np.zeros((len(part), count))
            starts = self._hand_on(*self._run(part, f, zeros, zeros, False), *passed_on)
            self._run(part, f, *starts, True)
            part *= weights
        return white.reshape(p, -1).T

    @staticmethod
    def in_order(white, n, stretch=256):
        """Whitened columns (n, p) in the order of time."""
        return white.T.reshape(white.shape[1], stretch, -1).swapaxes(1, 2).reshape(white.shape[1], -1)[:, :n].T

    @staticmethod
    def _cut(values, count, stretch):
        out = np.zeros(count * stretch)
        out[:values.size] = values
        return np.ascontiguousarray(out.reshape(count, stretch).T)

    @staticmethod
    def _run(c, f, a, b, keep):
        """One pass over all stretches; keep: replaces the columns by their innovations."""
        f_aa, f_ab, f_bb, gain_a, gain_b = f
        a, b, product = a.copy(), b.copy(), np.empty_like(a)
        innovation = np.empty_like(a)
        for i in range(c.shape[1]):
            np.multiply(f_ab[i], b, out=product)
            a *= f_aa[i]
            a += product
            np.subtract(c[:, i], a, out=innovation)
            a += np.multiply(gain_a[i], innovation, out=product)
            b *= f_bb[i]
            b += np.multiply(gain_b[i], innovation, out=product)
            if keep:
                c[:, i] = innovation
        return a, b

    @staticmethod
    def _hand_on(a_end, b_end, a_of, b_of):
        """Starts of the stretches: each one's end from zero, plus what its start becomes in it."""
        a0, b0 = np.zeros_like(a_end), np.zeros_like(b_end)
        for i in range(a_end.shape[1] - 1):
            a0[:, i + 1] = a_end[:, i] + a_of[0, i] * a0[:, i] + a_of[1, i] * b0[:, i]
            b0[:, i + 1] = b_end[:, i] + b_of[0, i] * a0[:, i] + b_of[1, i] * b0[:, i]
        return a0, b0


def _gains(dt_s, variance, within, starts, arw, brw):
    """Kalman gains and innovation sigmas of every reading, in plain scalars."""
    n2, k2 = arw * arw, brw * brw
    gain_a, gain_b, sigma2 = [], [], []
    aa = ab = bb = 0.0
    for dt, r, more, start in zip(dt_s.tolist(), variance.tolist(), within.tolist(), starts.tolist()):
        bias_step = k2 * dt
        if start:
            aa, ab = UNKNOWN_ANGLE_VARIANCE, 0.0
            bb = UNKNOWN_BIAS_VARIANCE if start == 2 else bb + bias_step
        else:
            aa += dt * (2.0 * ab + dt * bb + n2 + bias_step * dt / 3.0) + more
            ab += dt * (bb + 0.5 * bias_step)
            bb += bias_step
        s = aa + r
        ka, kb = aa / s, ab / s
        gain_a.append(ka)
        gain_b.append(kb)
        sigma2.append(s)
        bb -= kb * ab
        ab *= r / s
        aa *= r / s
    return np.array(gain_a), np.array(gain_b), np.sqrt(sigma2)
