"""What truly happens in one set: motion, gravity, temperature, covariates, at the gyro's and the reference's times.

All tables of a set lie one after the other in the same arrays; `table` says which is which. Times are those of the
stamps: seconds since the power-on of the table.
"""
import numpy as np

import geometry
from thermal import COLD_DEGC, WARM_DEGC, Thermal

WITHIN = 32  # moments of which a mean is taken


class Scene:
    """Arrays over gyro samples (suffix-less) and over readings of the reference (suffix `_read`)."""

    def __init__(self, rng, bench, plan):
        self.bench, self.plan = bench, plan
        self.stamped_late_s = bench["stamped_late"] / bench["gyro_rate_hz"]
        self.most_late_s = 0.45 / bench["gyro_rate_hz"]  # of a computer: samples stay in their order
        self._stamps(rng)
        self.angles_deg, axis_rates = self.motion_at(self.t_s, self.table)
        self.directions = geometry.axis_directions(self.angles_deg)
        self.w_deg_s = geometry.rates_in_sensor(self.directions, axis_rates)
        if bench["sample"] == "mean":
            self.w_deg_s = self.of_samples(self.rates_in_sensor_at)
        self.g = geometry.gravity_in_sensor(self.directions)
        self._temperature(rng)
        self._covariates(rng, axis_rates)
        self._where_readings_lie()

    # Times.
    def _stamps(self, rng):
        rate_hz = self.bench["gyro_rate_hz"]
        gyro, reads = [], []
        for table in self.plan.tables:
            count = int((table.end_s - table.start_s) * rate_hz) + 1
            gyro.append(table.start_s + np.arange(count) / rate_hz)
            reads.append(self._reading_times(rng, gyro[-1]))
        self.t_s, self.t_read_s = np.concatenate(gyro), np.concatenate(reads)
        self.table = np.repeat(np.arange(len(gyro)), [t.size for t in gyro])
        self.table_read = np.repeat(np.arange(len(reads)), [t.size for t in reads])
        self.first = np.searchsorted(self.table, np.arange(len(gyro) + 1))
        self.first_read = np.searchsorted(self.table_read, np.arange(len(gyro) + 1))

    def _reading_times(self, rng, t_s):
        """With the gyro: at every k-th of its samples. On its own clock: anywhere, with jitter."""
        rate_hz = min(self.bench["reference_rate_hz"], self.bench["gyro_rate_hz"])
        if not self.bench["own_clock"]:
            reads = t_s[::max(1, int(round(self.bench["gyro_rate_hz"] / rate_hz)))] + self.stamped_late_s
            return reads[reads <= t_s[-1]]
        interval_s = 1.0 / rate_hz
        reads = np.arange(t_s[0] + rng.uniform(0.0, interval_s), t_s[-1] - interval_s, interval_s)
        reads += interval_s * self.bench["clock_jitter"] * rng.uniform(-1.0, 1.0, reads.size)
        reads = np.round(np.clip(reads, t_s[0], t_s[-1]), 6)
        together = np.abs(reads * self.bench["gyro_rate_hz"] % 1.0) < 1e-4
        return reads + 7e-6 * together  # no two rows have one stamp

    def _where_readings_lie(self):
        """Index of the gyro sample before each reading, and the fraction of the interval after it."""
        self.before = np.empty(self.t_read_s.size, dtype=np.int64)
        for i, part in enumerate(self.reading_parts()):
            t_s = self.t_s[self.first[i]:self.first[i + 1]]
            inside = np.clip(np.searchsorted(t_s, self.t_read_s[part] + 1e-9) - 1, 0, t_s.size - 2)
            self.before[part] = inside + self.first[i]
        step_s = self.t_s[self.before + 1] - self.t_s[self.before]
        self.together = self.t_read_s.size == self.t_s.size and np.array_equal(self.t_read_s, self.t_s)
        self.fraction = (self.t_read_s - self.t_s[self.before]) / step_s

    def parts(self):
        return [slice(a, b) for a, b in zip(self.first[:-1], self.first[1:])]

    def reading_parts(self):
        return [slice(a, b) for a, b in zip(self.first_read[:-1], self.first_read[1:])]

    # Physics.
    def motion_at(self, t_s, table):
        """True angles and rates of the axes (3, n) at any times (increasing within each table)."""
        edges = np.searchsorted(table, np.arange(len(self.plan.tables) + 1))
        both = [t.at(t_s[a:b]) for t, a, b in zip(self.plan.tables, edges[:-1], edges[1:])]
        return np.hstack([angle for angle, _ in both]), np.hstack([rate for _, rate in both])

    def rates_in_sensor_at(self, t_s, table):
        angles, rates = self.motion_at(t_s, table)
        return geometry.rates_in_sensor(geometry.axis_directions(angles), rates)

    def of_samples(self, rates_at):
        """What samples say of rates_at(times, tables), (3, n): that of their moments, or the means about them."""
        if self.bench["sample"] == "moment":
            return rates_at(self.t_s, self.table)
        parts_s = ((np.arange(WITHIN) + 0.5) / WITHIN - 0.5) / self.bench["gyro_rate_hz"]
        within = rates_at(np.add.outer(self.t_s, parts_s).ravel(), np.repeat(self.table, WITHIN))
        return within.reshape(3, self.t_s.size, WITHIN).mean(axis=2)

    def _temperature(self, rng):
        kind = self.bench["thermal"]
        power_on = np.array(self.plan.power_on)[self.table]
        self.temp_degC, self.temp_rate, self.shown_degC = np.empty((3, self.t_s.size))
        self.thermals, self.power_on = [], power_on
        for i, targets in enumerate(self.plan.targets):
            end_s = max(t.end_s for t, p in zip(self.plan.tables, self.plan.power_on) if p == i)
            cold = WARM_DEGC if kind == "constant" else COLD_DEGC + (rng.uniform(-2, 8) if i else 0.0)
            thermal = Thermal(kind, targets, end_s, cold, self.bench["temp_lag_s"])
            mine = power_on == i
            t_s = self.t_s[mine]
            self.temp_degC[mine] = thermal.at(t_s, thermal.true_degC)
            self.temp_rate[mine] = thermal.at(t_s, thermal.rate_degC_s)
            self.shown_degC[mine] = thermal.at(t_s, thermal.shown_degC)
            self.thermals.append(thermal)

    def over_power_ons(self, curve):
        """Values at the gyro's times of curve(thermal), an array on each power-on's grid of time."""
        out = np.empty(self.t_s.size)
        for i, thermal in enumerate(self.thermals):
            mine = self.power_on == i
            out[mine] = thermal.at(self.t_s[mine], curve(thermal))
        return out

    def _covariates(self, rng, axis_rates):
        names = [name for name in self.bench["covariates"].split(",") if name]
        self.covariates = {name: self._covariate(rng, name, axis_rates) for name in names}

    def _covariate(self, rng, name, axis_rates):
        """Supply: slow waves and steps of the load. Humidity: slow. Motor current: of the speed, and noise."""
        t = self.t_s + 4000.0 * self.power_on
        if name == "motor_current_a":
            load = 0.4 + 0.01 * np.abs(axis_rates).sum(axis=0)
            return load + 0.05 * np.sin(2 * np.pi * t / rng.uniform(20, 90)) + 0.02 * rng.standard_normal(t.size)
        periods_s = rng.uniform(*((40, 400) if name == "supply_v" else (500, 3000)), 5)
        waves = sum(np.sin(2 * np.pi * t / p + rng.uniform(0, 6.28)) for p in periods_s)
        if name == "supply_v":
            return 5.0 + 0.01 * waves + 0.02 * (np.sin(2 * np.pi * t / rng.uniform(150, 300)) > 0)
        return 45.0 + 2.0 * waves

    # From rates to the reference's readings.
    def at_readings(self, values):
        """A quantity of the gyro's times, (n) or (p, n), at the reference's times."""
        if self.together:
            return values
        start = values[..., self.before]
        return start + (values[..., self.before + 1] - start) * self.fraction

    def integrate(self, rate):
        """Angle [deg] gained since the start of the table, by trapezoids, at the readings.

        A reading between two samples sees the integral of the rate's straight line up to it. Of means the sum is
        known half way between samples, where trapezoids are off by tau^2 / 8 times the slope.
        """
        angle = self._summed(np.diff(self.t_s) * 0.5 * (rate[1:] + rate[:-1]))
        if self.stamped_late_s:
            assert np.allclose(self.fraction, 0.5, atol=1e-6), "readings are half way"
            angle -= 0.25 / self.bench["gyro_rate_hz"] * (rate[self.before + 1] - rate[self.before])
        elif self.bench["sample"] == "mean":
            assert np.isin(self.fraction, (0.0, 1.0)).all(), "readings between means are not integrated"
            changes = [np.gradient(rate[part]) for part in self.parts()]
            off = np.concatenate([change - change[0] for change in changes]) / self.bench["gyro_rate_hz"] / 8.0
            angle = angle - self.at_readings(off)
        elif not self.together:
            f, step_s = self.fraction, self.t_s[self.before + 1] - self.t_s[self.before]
            angle -= 0.5 * f * (1.0 - f) * step_s * (rate[self.before + 1] - rate[self.before])
        return angle

    def integration_variance(self, channel):
        """Variance [deg^2] that the integral between a reading and the one before has at corners of the motion.

        Where the acceleration jumps by a within an interval tau between samples, at a part f of it that nobody knows,
        trapezoids are off by a tau^2 f (1 - f) / 2: in the mean by a tau^2 / 12, which the slopes on both sides tell,
        and about that by a variance of a^2 tau^4 / 720.
        """
        out = np.zeros(self.t_read_s.size)
        if self.bench["sample"] == "mean":
            return out  # their sum is known, but for readings beside a corner: corner_variance
        for table, reads, t_s, felt in self._corners_felt(channel):
            reading = min(reads.start + np.searchsorted(self.t_read_s[reads], t_s), reads.stop - 1)
            out[reading] += felt ** 2 * table.interval_s ** 4 / 720.0
        return out

    def corner_variance(self, channel):
        """Variance [deg^2] of the integral of means up to each reading beside a corner of the motion.

        Of a jump a of the acceleration at a part f (-1/2 to 1/2) of the interval about a sample, the sum less
        tau^2 / 8 times the slope is off by a tau^2 (f |f| / 4 - 3 f / 16) at the sample and by a tau^2 (1/2 +- f)^2 / 32
        at its neighbours: in the mean square over f by 7 / 8960 and 1 / 5120 of a^2 tau^4.
        """
        out = np.zeros(self.t_read_s.size)
        if self.bench["sample"] == "moment" or self.stamped_late_s:
            return out  # half way between samples the sum is known
        for table, reads, t_s, felt in self._corners_felt(channel):
            sample = np.rint((self.t_read_s[reads] - table.start_s) / table.interval_s)
            apart = np.abs(sample - np.rint((t_s - table.start_s) / table.interval_s))
            share = np.select([apart == 0, apart == 1], [7.0 / 8960.0, 1.0 / 5120.0], 0.0)
            out[reads] += share * felt ** 2 * table.interval_s ** 4
        return out

    def _corners_felt(self, channel):
        """Corners of the motion: table, its readings, the time [s], the jump that the channel feels [deg/s^2]."""
        for table, part, reads in zip(self.plan.tables, self.parts(), self.reading_parts()):
            for t_s, axis, jump in table.corners():
                sample = min(part.start + np.searchsorted(self.t_s[part], t_s), part.stop - 1)
                yield table, reads, t_s, self.directions[axis, channel, sample] * jump

    def projected(self, axis, channel, error_deg):
        """What an error of one axis's angle adds to the channel's reference angle: integral of J d(error)."""
        j = self.directions[axis, channel]
        return self._summed(0.5 * (j[1:] + j[:-1]) * np.diff(error_deg))

    def _summed(self, step):
        """Sum of the steps between gyro samples since the start of the table, at the readings."""
        total = np.empty(step.size + 1)
        total[0] = 0.0
        np.cumsum(step, out=total[1:])
        for part in self.parts():
            total[part] -= total[part.start]
        return self.at_readings(total)
