"""The Cramer-Rao bound of every raw sample and every reading, and what it permits a tracer to say.

Residual at each reading of the reference: z - Phi, z the integral of every gyro sample. Its noise is angle random walk
(with the gyro's quantisation), bias random walk that runs on through the gaps of one power-on, and the reading's own
variance noise^2 + lsb^2/12; and what nobody knows of a motion with corners between samples. A reading that is stamped
late by a random time errs by the turn in it; whoever finds the even times behind the stamps can do better. The baseline
that is left free: row of M, cubic b(T), an angle of each table, a bias of each power-on.

What is approximate: an axis that does not turn within a table adds no noise to a channel beyond one reading's;
the noise of angles that decompose a motion of several axes is left out; the readings of a rest are independent ones,
but where counts are coarser than the noise a rest has one error of its own, which no averaging lowers.
"""
import math

import numpy as np

import catalogue
import defects
import geometry
import places
import unknown_walk
from whitening import Whitener

FALSE_DISCOVERY = 0.009  # of all channels of a set together
TOO_FAST = 0.8  # of the gain: less is left in some of the readings
ALONE = 10.0  # 2 x log-likelihood between the best and the next, to be named alone


def reading_variance(scene, channel):
    """Variance [deg^2] of the projected reference at each reading."""
    bench = scene.bench
    noise = bench["reference_noise_deg"]
    count = 360.0 / 2 ** bench["encoder_bits"] if bench["reference"] != "quaternion" else 0.0
    undithered = math.exp(-(2.0 * math.pi * noise / count) ** 2) if count else 0.0
    turning = np.array([t.turning_axes() for t in scene.plan.tables], dtype=float)[scene.table_read]
    felt = scene.at_readings(scene.directions[:, channel])
    share = np.ones(scene.t_read_s.size)
    if bench["reference"] == "stand":
        share = np.maximum(1.0, (turning.T * felt ** 2).sum(axis=0))
    variance = noise ** 2 + count ** 2 / 12.0
    if undithered > 0.01:
        variance = variance + count ** 2 / 12.0 * undithered * (rest_lengths(scene, count) - 1.0)
    late_s2 = defects.late_variance(bench["logged_late_s"], scene.most_late_s)
    late = late_s2 * scene.at_readings(scene.w_deg_s[channel]) ** 2
    return share * variance + late + scene.corner_variance(channel)


def rest_lengths(scene, count_deg):
    """Readings in the rest around each reading, those of 2 s at most; 1 where the angle moves on.

    A rest has one error of its own. Within a long one it says nothing against the gyro's drift being seen, so the
    error is spread over 2 s.
    """
    angles = scene.at_readings(scene.angles_deg)
    step = np.abs(np.diff(angles, axis=1)).max(axis=0)
    still = np.concatenate([[False], (step < 0.1 * count_deg) & (np.diff(scene.table_read) == 0)])
    edges = np.flatnonzero(np.diff(still.astype(np.int8))) + 1
    edges = np.concatenate([[0], edges, [still.size]])
    lengths = np.repeat(np.diff(edges), np.diff(edges)).astype(float)
    longest = max(1.0, 2.0 * min(scene.bench["reference_rate_hz"], scene.bench["gyro_rate_hz"]))
    return np.where(still, np.minimum(lengths, longest), 1.0)


def timing(scene):
    """Of the readings: time since the one before [s], and what starts with each: 0 nothing, 1 a table, 2 a power-on."""
    power_on = np.array(scene.plan.power_on)[scene.table_read]
    starts = np.zeros(scene.t_read_s.size, dtype=np.int8)
    starts[scene.first_read[:-1]] = 1
    starts[0] = 2
    starts[1:][np.diff(power_on) != 0] = 2
    dt_s = np.diff(scene.t_read_s, prepend=scene.t_read_s[0])
    return np.maximum(dt_s, 0.0), starts


def whitener_of(scene, channel, noise):
    """The filter of one channel's readings. noise: arw [deg/sqrt(s)], brw [deg/s/sqrt(s)]."""
    dt_s, starts = timing(scene)
    return Whitener(dt_s, reading_variance(scene, channel), scene.integration_variance(channel), starts,
                    noise["arw_effective"], noise["brw"])


def nuisance(scene, channel):
    """Columns of the baseline, (p, readings): row of M where an axis moves, b(T) where temperature does; a latency
    where samples are stamped late, which nobody has told."""
    columns = [scene.integrate(w) for w in scene.w_deg_s if np.ptp(w) > 1e-6]
    spread = np.ptp(scene.temp_degC)
    if spread > 0.01:
        x = (scene.temp_degC - scene.temp_degC.mean()) / spread
        columns += [scene.integrate(x ** k) for k in (1, 2, 3)]
    if scene.bench["stamped_late"]:
        columns += list(catalogue.responses(scene, channel, catalogue.Candidate("angle.latency")))
    return np.array(columns)


class Bound:
    """Gram matrix of all candidates with the baseline projected out, for one channel of one set.

    All is worked out from the Gram matrix of the scaled, whitened columns: what the baseline leaves of it is the
    Schur complement. A column of which less than 1e-7 is left counts as absorbed.
    """

    def __init__(self, scene, channel, noise, candidates):
        self.candidates = candidates
        self.false_discovery = FALSE_DISCOVERY / len(scene.bench["gyro_axes"])
        groups = [catalogue.responses(scene, channel, c) for c in candidates]
        sizes = np.cumsum([0] + [len(g) for g in groups])
        self.columns = [np.arange(a, b) for a, b in zip(sizes[:-1], sizes[1:])]
        self.whiten = whitener_of(scene, channel, noise)
        free = nuisance(scene, channel)
        self.given = [*free, *(column for group in groups for column in group)]
        steps = [i for i, c in enumerate(candidates) if places.beside(scene, c)]
        beside = [catalogue.responses(scene, channel, c)[0] for i in steps for c in places.beside(scene, candidates[i])]
        gram, kept = self._left([*self.given, *beside], len(free))
        self.gram, self.kept = gram[:sizes[-1], :sizes[-1]], kept[:sizes[-1]]
        self.places = self._places(scene, channel, gram, steps)

    def _places(self, scene, channel, gram, steps):
        """Of each candidate. gram: of the columns of all, and those of the steps beside the candidates `steps`."""
        correlations = {}
        for n, i in enumerate(steps):
            j, step = self.columns[i][0], self.candidates[i]
            if self.kept[j] > 1e-7:
                others = len(self.gram) + n * len(places.SPACINGS) + np.arange(len(places.SPACINGS))
                sizes = np.sqrt(gram[j, j] * np.maximum(gram[others, others], 1e-300))
                correlations.setdefault((step.effect, step.axis), []).append(gram[j, others] / sizes)
        return [max(1.0, places.of_steps(scene, c, correlations[c.effect, c.axis])
                    if (c.effect, c.axis) in correlations else places.count(scene, c, channel))
                for c in self.candidates]

    def _left(self, columns, free):
        """Gram matrix of all but the first `free` columns, those projected out; and the share left of each column."""
        white = self.whiten(columns)
        full = white.T @ white
        size = np.sqrt(np.diag(full))
        size[size == 0.0] = 1.0
        full /= np.outer(size, size)
        values, vectors = np.linalg.eigh(full[:free, :free])
        root = (full[free:, :free] @ vectors) / np.sqrt(np.maximum(values, 1e-13))
        left = full[free:, free:] - root @ root.T
        return left * np.outer(size[free:], size[free:]), np.maximum(np.diag(left), 0.0)

    def information(self, i):
        """Information on the linear parameters of candidate i, zero where the baseline absorbs them."""
        index = self.columns[i]
        g = self.gram[np.ix_(index, index)].copy()
        absorbed = self.kept[index] < 1e-7
        g[absorbed] = 0.0
        g[:, absorbed] = 0.0
        return g

    def sigma(self, i, direction):
        """Standard deviation of the amplitude along a direction of candidate i's parameters: 1 / sqrt(u' G u)."""
        information = float(direction @ self.information(i) @ direction)
        return 1.0 / math.sqrt(information) if information > 0.0 else math.inf

    def covariance(self, i, others, slopes):
        """Covariance of the linear parameters of candidate i, with those of `others` and the columns `slopes` free."""
        first = len(self.given) - len(self.gram)
        index = np.concatenate([self.columns[j] for j in (i, *others)])
        if len(slopes):
            gram, _ = self._left(self.given[:first] + [self.given[first + k] for k in index] + list(slopes), first)
        else:
            gram = self.gram[np.ix_(index, index)]
        size = np.diag(gram)
        seen = size > 0.0
        seen[:len(index)] &= self.kept[index] > 1e-7
        unit = np.where(seen, 1.0 / np.sqrt(np.where(seen, size, 1.0)), 0.0)
        inverse = np.linalg.pinv(gram * np.outer(unit, unit), rcond=1e-9, hermitian=True) * np.outer(unit, unit)
        mine = len(self.columns[i])
        return inverse[:mine, :mine]

    def _correlation(self):
        """What scales every column to length 1, absorbed ones to 0, and their products then."""
        seen = self.kept > 1e-7  # an absorbed column is rounding, and takes no part
        unit = np.where(seen, 1.0 / np.sqrt(np.where(seen, np.diag(self.gram), 1.0)), 0.0)
        return unit, self.gram * np.outer(unit, unit)

    def copies(self, i, theta):
        """Ids of the catalogue of which one does what candidate i does, but for less than ALONE of its gain."""
        unit, correlation = self._correlation()
        scores = self.gram[:, self.columns[i]] @ theta
        whole = float(scores[self.columns[i]] @ theta)
        ids, gains = self._gains((scores * unit)[:, None], correlation, unit)
        return sorted(effect for effect, gain in zip(ids, gains[:, 0])
                      if not effect.startswith("unknown.") and whole - gain < ALONE)

    def permitted(self, rng, truth, draws=200):
        """How often an ideal tracer names the one true effect: alone, or among rivals.

        truth: (index, vector of parameters). Scores are drawn from N(G theta, G); each candidate gains
        u' G^-1 u; the best must pass a Bonferroni threshold, over all ids and all places and axes where one is
        looked for, and be ahead of every other id by ALONE.
        """
        i, theta = truth
        mean = self.gram[:, self.columns[i]] @ theta
        unit, correlation = self._correlation()
        values, vectors = np.linalg.eigh(correlation)
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        scores = (mean * unit)[:, None] + root @ rng.standard_normal((unit.size, draws))
        ids, gains = self._gains(scores, correlation, unit)
        mine = ids.index(self.candidates[i].effect)
        near = self._near(ids, gains)
        alone = near[mine] & (near.sum(axis=0) == 1)
        return float(alone.mean()), float(near[mine].mean())

    def named(self, residual_deg):
        """Ids that an ideal tracer names on this residual, (readings,): the best one and all that are as likely; none
        where none passes its threshold."""
        gram, _ = self._left([*self.given, residual_deg], len(self.given) - len(self.gram))
        unit, correlation = self._correlation()
        ids, gains = self._gains((gram[:-1, -1] * unit)[:, None], correlation, unit)
        return [effect for effect, near in zip(ids, self._near(ids, gains)[:, 0]) if near]

    def _near(self, ids, gains):
        """Which ids (ids, draws) are within ALONE of the best, where any passes its threshold."""
        found = (gains > self._thresholds(ids)).any(axis=0)
        return (gains > gains.max(axis=0) - ALONE) & found

    def kept_by_an_unknown_walk(self, rng, scene, channel, noise, truth):
        """Of how often candidate truth[0] passes its threshold, the share that is left where the tracer has to
        estimate the noise from the same data: a random walk of unknown size explains a part of what is slow. 1 for
        what is too fast to be seen in some of the readings, as it is no walk."""
        i, theta = truth
        first = len(self.given) - len(self.gram)
        seen = self.kept[self.columns[i]] > 1e-7
        dt_s, starts = timing(scene)
        some = unknown_walk.some_readings(starts)
        within = scene.integration_variance(channel)
        readings = unknown_walk.Readings(np.diff(np.cumsum(dt_s)[some], prepend=0.0), starts[some],
                                         reading_variance(scene, channel)[some],
                                         np.diff(np.cumsum(within)[some], prepend=0.0),
                                         noise["arw_effective"], noise["brw"])
        known, unknown = unknown_walk.gains(rng, readings, [column[some] for column in self.given[:first]],
                                            [self.given[first + k][some] for k in self.columns[i][seen]], theta[seen])
        if known.mean() - seen.sum() < TOO_FAST * float(theta @ self.information(i) @ theta):
            return 1.0
        ids = sorted({c.effect for c in self.candidates})
        level = self._thresholds(ids)[ids.index(self.candidates[i].effect)]
        passed = known > level
        return float(np.mean(unknown[passed] > level)) if passed.any() else 1.0

    def _thresholds(self, ids):
        """Of the gain of each id, (ids, 1)."""
        counts, axes, freedom = {}, {}, {}
        for candidate, own, columns in zip(self.candidates, self.places, self.columns):
            effect = candidate.effect
            counts[effect] = max(counts.get(effect, 1.0), own)
            axes.setdefault(effect, set()).add(candidate.axis)
            freedom[effect] = max(freedom.get(effect, 1), int((self.kept[columns] > 1e-7).sum()))
        looked_for = [i for i in ids if i != catalogue.EARTH]
        return np.array([[threshold(len(looked_for) * counts[i] * len(axes[i]), freedom[i], self.false_discovery)
                          if i in looked_for else math.inf] for i in ids])

    def _gains(self, scores, correlation, unit):
        """Likelihood gain (2 log) of each id and draw: the best of its candidates. The Earth's is that of no more than
        its rate."""
        gains = {}
        for i, candidate in enumerate(self.candidates):
            index = self.columns[i][self.kept[self.columns[i]] > 1e-7]
            gain = np.zeros(scores.shape[1])
            if index.size:
                inverse = np.linalg.pinv(correlation[np.ix_(index, index)], rcond=1e-6, hermitian=True)
                values = inverse @ scores[index]
                if candidate.effect == catalogue.EARTH:
                    size = np.linalg.norm(unit[index][:, None] * values, axis=0)
                    values = values * np.minimum(1.0, geometry.EARTH_RATE_DEG_S / np.maximum(size, 1e-300))
                gain = np.einsum("in,in->n", 2.0 * scores[index] - correlation[np.ix_(index, index)] @ values, values)
            gains[candidate.effect] = np.maximum(gains.get(candidate.effect, 0.0), gain)
        return list(gains), np.array(list(gains.values()))


def threshold(tests, freedom=1, false_discovery=FALSE_DISCOVERY):
    """Gain that chance passes in that share of channels over all tests of an effect of so many parameters."""
    tail = false_discovery / tests
    low, high = 0.0, 200.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if chi_square_tail(middle, freedom) > tail else (low, middle)
    return high


def chi_square_tail(x, freedom):
    """Chance of more than x: Q(1/2, x/2) = erfc(sqrt(x/2)), Q(1, x/2) = exp(-x/2), and upwards from there by
    Q(a + 1, y) = Q(a, y) + y^a e^-y / Gamma(a + 1)."""
    y, a = 0.5 * x, 0.5 if freedom % 2 else 1.0
    tail = math.erfc(math.sqrt(y)) if freedom % 2 else math.exp(-y)
    while a < 0.5 * freedom:
        tail += y ** a * math.exp(-y) / math.gamma(a + 1.0)
        a += 1.0
    return tail
