"""A first-order lag, tau dy/dt = w - y, applied exactly to a rate that is linear between inner steps."""
import numpy as np

INNER_STEP_S = 0.0025


def running_sum(f, decay):
    """y_k = decay y_(k-1) + f_k for all k at once, by doubling; terms below 1e-15 are left out."""
    y, shift, weight = f, 1, decay
    while weight > 1e-15 and shift < y.shape[-1]:
        nxt = y.copy()
        nxt[..., shift:] += weight * y[..., :-shift]
        y, shift, weight = nxt, 2 * shift, weight * weight
    return y


def lagged(rates_at, t_s, tau_s):
    """Lagged rates (c, n) at evenly spaced times t_s; rates_at(t) gives the true rates (c, m), at rest before t_s[0].

    Over one inner step h with slope s:  y' = w + s (h - tau) + (y - w + s tau) exp(-h / tau).
    """
    interval_s = (t_s[-1] - t_s[0]) / (t_s.size - 1)
    inner = int(np.ceil(interval_s / INNER_STEP_S))
    h = interval_s / inner
    w = rates_at(t_s[0] + h * np.arange(inner * (t_s.size - 1) + 1))
    slope, decay = np.diff(w) / h, np.exp(-h / tau_s)
    drive = np.empty_like(w)
    drive[:, 0] = w[:, 0]
    drive[:, 1:] = (1.0 - decay) * w[:, :-1] + slope * (h - tau_s * (1.0 - decay))
    return running_sum(drive, decay)[:, ::inner]
