"""The Cramer-Rao bound of a simulated hand, by quadrature of the generator's own motion and its own noise.

Observables: in each rest the mean of the accelerometer and the integral of the gyro, in each turn where gravity
ends up. Unknown besides the parameters are gravity and the gyro's offset in each rest; in a hand also how the
sensor turned in a rest, which the tremble keeps small. Which way is north is unknown too, so that the level part of
the Earth's rotation is a nuisance of known size. The walk of the offset is Gaussian with the generator's own
standard deviation. No sample of the gyro or the accelerometer is left out, of the rests as they truly are.
"""
import numpy as np

from hand import DEG


def bound(hand, truth, m, g, t, with_gravity):
    """Standard deviations of M (9), T in its own frame (6: scales, shears), o (3), and G (9) where asked for."""
    rests, dt = truth.rests, truth.dt
    n = len(rests)
    q = np.linalg.svd(truth.t / np.linalg.norm(truth.t, axis=1)[:, None])
    q = q[0] @ q[2]
    # Motion in the accelerometer's frame.
    rate = truth.rate @ q.T
    r_wn = truth.r @ q.T
    up = r_wn[:, 2, :]
    m_inverse = np.linalg.inv(m)
    # Rotation of each turn and the integrals of it that the parameters act through.
    turns, lengths = [], []
    for (a, b), (c, _) in zip(rests[:-1], rests[1:]):
        part = slice(b, c + 1)
        local = np.einsum("ji,njk->nik", r_wn[b], r_wn[part])
        w = np.ones(len(local)) * dt
        w[0] = w[-1] = 0.5 * dt
        by_w = np.einsum("n,nac,nj->acj", w, local, rate[part])
        by_f = np.einsum("n,nac,nj->acj", w, local, up[part])
        by_b = np.einsum("n,nac->ac", w, local)
        turns.append((local[-1], by_w, by_f, by_b))
        lengths.append((c - b) * dt)
    rest_s = np.array([(b - a) * dt for a, b in rests])
    g_at = [up[a:b + 1].mean(axis=0) / np.linalg.norm(up[a:b + 1].mean(axis=0)) for a, b in rests]
    # Unknowns: M9 d3 sigma3 o3 | G9 | per rest: gravity as two tangent components, offset 3
    parameters = 18 + (9 if with_gravity else 0)
    base = parameters + 2
    size = base + 5 * n
    info = np.zeros((size, size))
    level = 15.041 / 3600.0 * DEG * np.cos(hand.latitude_deg * DEG)
    info[parameters:base, parameters:base] = np.eye(2) * 2.0 / level**2

    def tangent(v):
        e = np.eye(3)[np.argmin(np.abs(v))]
        x = np.cross(v, e)
        x /= np.linalg.norm(x)
        return np.column_stack([x, np.cross(v, x)])

    tangents = [tangent(v) for v in g_at]
    d = np.linalg.norm(t, axis=1)
    s = t / d[:, None]
    pairs = [(1, 2), (2, 0), (0, 1)]
    sa2 = hand.accel_noise_g_sqrt_s**2
    nn = (hand.walk_deg_sqrt_s * DEG)**2
    kk = (hand.bias_walk * DEG)**2

    def add(rows, variance):
        nonlocal info
        info += rows.T @ rows / variance

    for k in range(n):
        at = base + 5 * k
        rows = np.zeros((3, size))
        rows[:, at:at + 2] = t @ tangents[k]
        for i in range(3):
            rows[i, 9 + i] = s[i] @ g_at[k]
        for p, (i, j) in enumerate(pairs):
            step = 1e-6
            moved = s.copy()
            for (u, v) in ((i, j), (j, i)):
                moved[u, v] += step
            for u in (i, j):
                off = np.delete(moved[u], u)
                moved[u, u] = np.sqrt(1 - off @ off)
            rows[:, 12 + p] = d * ((moved - s) / step @ g_at[k])
        rows[:, 15:18] = np.eye(3)
        add(rows, sa2 / rest_s[k])
        rows = np.zeros((3, size))
        rows[:, at + 2:at + 5] = np.eye(3) * rest_s[k]
        rows[:, parameters:base] = rest_s[k] * m @ r_wn[(rests[k][0] + rests[k][1]) // 2].T[:, :2]
        if with_gravity:
            for i in range(3):
                rows[i, 18 + 3 * i:21 + 3 * i] = rest_s[k] * g_at[k]
        stirred = 2.0 * (hand.tremble_deg * DEG)**2 if hand.trembles else 0.0
        add(rows, nn * rest_s[k] + kk * rest_s[k]**3 / 12 + stirred)
        if k + 1 == n:
            break
        r, by_w, by_f, by_b = turns[k]
        nxt = at + 5
        to_next = tangents[k + 1].T @ r.T
        lever = to_next @ np.array([[0, -g_at[k][2], g_at[k][1]], [g_at[k][2], 0, -g_at[k][0]], [-g_at[k][1], g_at[k][0], 0]])
        rows = np.zeros((2, size))
        for i in range(3):
            for j in range(3):
                rows[:, 3 * i + j] = lever @ (-by_w[:, :, j] @ m_inverse[:, i])
                if with_gravity:
                    rows[:, 18 + 3 * i + j] = lever @ (-by_f[:, :, j] @ m_inverse[:, i])
        rows[:, parameters:base] = -lever @ r_wn[rests[k][1]].T[:, :2] * lengths[k]
        rows[:, at:at + 2] = to_next @ tangents[k]
        rows[:, nxt:nxt + 2] = -np.eye(2)
        half = lever @ (-by_b @ m_inverse) / 2
        rows[:, at + 2:at + 5] = half
        rows[:, nxt + 2:nxt + 5] = half
        # In a hand the gyro carries gravity through half of each rest as well, whose mean is a third as noisy.
        extra = (rest_s[k] + rest_s[k + 1]) / 3 if hand.trembles else 0.0
        add(rows, nn * (lengths[k] + extra) + kk * lengths[k]**3 / 12)
        walk = np.zeros((3, size))
        walk[:, at + 2:at + 5] = -np.eye(3)
        walk[:, nxt + 2:nxt + 5] = np.eye(3)
        add(walk, kk * (lengths[k] + (rest_s[k] + rest_s[k + 1]) / 2))
    covariance = np.linalg.inv(info)
    deviation = np.sqrt(np.diag(covariance))[:parameters]
    deviation[18:] /= DEG
    return deviation
