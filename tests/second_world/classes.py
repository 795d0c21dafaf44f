"""Classes of bench: what a laboratory may have, as ranges to draw from.

A recipe is a dictionary of overrides of DEFAULT. A value is a constant, a list to choose from, a pair (low, high)
drawn uniformly, or a triple ("log", low, high) drawn log-uniformly.
"""
import numpy as np

DEFAULT = dict(
    # Gyro: rate [Hz], output and sensitivity [LSB per deg/s], zero-rate offset [deg/s], errors of scale and mounting.
    gyro_rate_hz=100.0, output="lsb", lsb_per_deg_s=[131.0, 65.5, 32.8], nominal_key=True, gyro_axes="xyz",
    zero_rate_deg_s=(1.0, 8.0), scale_error=(0.0, 0.03), misalignment=(0.005, 0.02),
    # Slopes of b(T), cubic about 30 degC: deg/s per degC, per degC^2, per degC^3.
    bias_slope=(0.005, 0.04), bias_curvature=(0.0, 6e-4), bias_cubic=(0.0, 1.5e-5),
    arw_factor=(0.8, 1.25), brw_factor=("log", 0.5, 3.0),
    # Reference: kind, bits a turn, noise [deg], rate [Hz], its own clock or the gyro's, jitter as a part of it.
    reference="stand", encoder_bits=[16, 17, 18, 19, 20], reference_noise_deg=(0.002, 0.01), reference_rate_hz=100.0,
    own_clock=False, clock_jitter=0.0,
    # Motion and tables: acceleration of straight ramps, 0 for smooth ones; gap [s] between tables of one power-on.
    # A sample is the rate of its moment, or its mean from half way to half way between the samples; its stamp is later
    # than its middle by a part of the interval.
    # Stamps are printed with so many decimals, six where the reference has its own clock.
    sample="moment", stamped_late=0.0, stamp_decimals=3, straight_ramps_deg_s2=0.0, programme="full",
    gap_s=(10.0, 60.0), power_ons="one",
    # Temperature: what it does, what measures it; thermometer noise, resolution [degC], lag [s].
    thermal="warm_up", temp_noise_degC=0.02, temp_resolution_degC=1.0 / 340.0, temp_lag_s=0.0, thermometer=True,
    accelerometer=["absent", "noisy", "uncalibrated"],
    covariates="", defects=False,
    # Of the cells of each axis of the gyro, so many are empty.
    cells_missing=0.0,
    # The computer that logs is late by a random time: in the mean so long [s], each row by itself.
    logged_late_s=0.0,
    site=[True, True, False], gear_key=True, unsigned_key=False,
    # The header names columns that no row fills: the axes that stand, and the thermometer where there is none.
    unfilled=False,
    # A serial adapter hands over what it has so often [s]; 0: each row at once.
    packets_s=0.0,
    # Its clock runs by another part than the sensor's.
    packets_off=0.0,
    # Each axis of the stand begins a table so far beside its pose, at most.
    off_zero_deg=0.0,
    # An encoder's zero is that of its axis; or it lies anywhere between two counts.
    encoder_zero_on_count=True)

CLASSES = {
    # The bench on which the tracer was found wanting.
    "three_encoders": dict(encoder_bits=17, reference_noise_deg=0.005, zero_rate_deg_s=(2.0, 4.0), gap_s=10.0,
                           lsb_per_deg_s=131.0, scale_error=(0.005, 0.015), misalignment=0.01,
                           accelerometer=["absent", "noisy"], site=True),
    "coarse_encoder": dict(encoder_bits=[12, 13], reference_noise_deg=(0.0, 0.02)),
    "noisy_slow_reference": dict(reference_noise_deg=(0.03, 0.05), reference_rate_hz=[5.0, 10.0],
                                 encoder_bits=[14, 16, 18]),
    "fast_reference": dict(programme="short", gyro_rate_hz=500.0, reference_rate_hz=500.0,
                           reference_noise_deg=(0.002, 0.03), lsb_per_deg_s=[32.8, 65.5]),
    "own_clock_reference": dict(own_clock=True, clock_jitter=(0.0, 0.2), reference_rate_hz=(15.0, 80.0),
                                reference_noise_deg=(0.002, 0.02)),
    "unsigned_counts": dict(output="unsigned", zero_rate_deg_s=(0.2, 3.0), unsigned_key=[True, False],
                            nominal_key=[True, True, False]),
    "rad_s_sensor": dict(output=["rad_s", "deg_s"], gyro_rate_hz=[50.0, 100.0, 200.0], programme="medium",
                         reference_rate_hz=50.0),
    "single_axis_table": dict(reference="single", programme="single", gyro_axes=["z", "xyz"], site=False,
                              nominal_key=[True, False], gear_key=[True, False]),
    "quaternion_hand": dict(reference="quaternion", programme="hand", gyro_rate_hz=[100.0, 200.0],
                            reference_noise_deg=(0.02, 0.1), reference_rate_hz=[50.0, 100.0], gear_key=False,
                            accelerometer="absent"),
    "many_power_ons": dict(power_ons="each", programme=["full", "medium"], zero_rate_deg_s=(2.0, 20.0)),
    "two_power_ons": dict(power_ons="two", thermal="warm_up", zero_rate_deg_s=(0.0, 20.0)),
    "no_thermometer": dict(thermometer=False, thermal="constant", programme=["full", "medium"]),
    "poor_thermometer": dict(temp_resolution_degC=[0.1, 0.25], temp_noise_degC=(0.03, 0.1), bias_slope=(0.002, 0.015),
                             thermal=["warm_up", "cycles"]),
    # A thermometer that lags shows as an offset that follows the temperature's past: whoever names that is right.
    "slow_thermometer": dict(temp_lag_s=(10.0, 40.0), thermal=["warm_up", "cycles"]),
    # Held in poses, a table each. That it rests is all the reference there is; nobody knows the headings, so the
    # Earth is left out.
    "poses_at_rest": dict(reference="none", programme="poses", thermal=["warm_up", "cycles"], reference_rate_hz=10.0,
                          reference_noise_deg=1e-5, encoder_bits=32, accelerometer=["noisy", "uncalibrated"],
                          gear_key=False, gap_s=(20.0, 90.0), site=False),
    "data_defects": dict(defects=True, programme=["full", "medium"]),
    "missing_cells": dict(cells_missing=(0.01, 0.1), gyro_rate_hz=[50.0, 100.0, 200.0], programme=["full", "medium"]),
    "covariates": dict(covariates="supply_v,humidity_pct,motor_current_a", thermal=["warm_up", "cycles"]),
    "short_run": dict(programme="short", thermal=["warm_up", "constant"], gyro_rate_hz=[50.0, 100.0]),
    "slow_gyro": dict(gyro_rate_hz=[20.0, 25.0, 50.0], reference_rate_hz=20.0),
    "fast_gyro": dict(gyro_rate_hz=1000.0, programme="short", reference_rate_hz=[100.0, 200.0], lsb_per_deg_s=16.4),
    "noisy_gyro": dict(arw_factor=(1.5, 4.0), brw_factor=("log", 1.0, 6.0)),
    "unfilled_columns": dict(unfilled=True, programme="single", thermometer=[True, False], thermal="constant",
                             site=False),
    "several_axes": dict(programme="several", reference_noise_deg=(0.001, 0.004), encoder_bits=[18, 19, 20]),
    # A logger that takes the rate of a moment now and then, on a table that starts and stops at full acceleration.
    "seldom_logged": dict(straight_ramps_deg_s2=(20.0, 80.0), gyro_rate_hz=[10.0, 12.5, 20.0, 25.0],
                          reference_rate_hz=[10.0, 20.0], programme=["full", "medium"]),
    # The clock's rate is no whole number of the milliseconds in which its stamps are printed.
    "rounded_stamps": dict(gyro_rate_hz=("log", 15.0, 130.0), reference_rate_hz=[20.0, 500.0],
                           programme=["full", "medium"]),
    # The same in hundredths of a second, of which an interval has two or three.
    "coarse_stamps": dict(gyro_rate_hz=("log", 31.0, 74.0), stamp_decimals=2, reference_rate_hz=[20.0, 100.0],
                          programme=["full", "medium"]),
    # Samples and readings come evenly, and are stamped when the computer gets to them.
    "late_stamps": dict(logged_late_s=("log", 1e-4, 2e-3), own_clock=[True, False],
                        gyro_rate_hz=[50.0, 100.0, 200.0], reference_rate_hz=[10.0, 20.0, 50.0],
                        programme=["full", "medium"]),
    # Rows come in packets, and are stamped when they come.
    "packed_stamps": dict(packets_s=[0.008, 0.016], stamp_decimals=[3, 6], gyro_rate_hz=[200.0, 210.3, 333.0, 500.0],
                          reference_rate_hz=[20.0, 50.0, 200.0], programme=["full", "medium"]),
    # Packets of about an interval and less: rows come one by one, each late by another time.
    "late_rows": dict(packets_s=[0.001, 0.004, 0.008, 0.016], packets_off=(-1e-4, 1e-4), stamp_decimals=[3, 6],
                      gyro_rate_hz=[50.0, 50.3, 62.5, 100.0, 101.7], reference_rate_hz=[10.0, 25.0, 50.0],
                      programme=["full", "medium"]),
    # A sensor whose samples are means of the rate, on such a table.
    "slow_means": dict(sample="mean", straight_ramps_deg_s2=(20.0, 80.0), gyro_rate_hz=[10.0, 12.5, 20.0, 25.0],
                       reference_rate_hz=[10.0, 20.0], programme=["full", "medium"]),
    # The same, each stamped when it is ready.
    "means_before": dict(sample="mean", stamped_late=0.5, straight_ramps_deg_s2=(20.0, 80.0),
                         gyro_rate_hz=[10.0, 12.5, 20.0, 25.0], reference_rate_hz=[10.0, 20.0],
                         programme=["full", "medium"]),
    # A single-axis table that turns slowly and not all around, its reference read with each sample.
    "slow_turns": dict(reference="single", programme="slow", gyro_axes=["z", "xyz"], site=False, thermal="warm_up",
                       gyro_rate_hz=[50.0, 100.0, 200.0], reference_rate_hz=[50.0, 100.0, 200.0],
                       reference_noise_deg=("log", 3e-4, 0.01), encoder_bits=[18, 19, 20], accelerometer="absent"),
    # One axis goes to and fro between the same places, and the others stand a little beside zero: what turns them is
    # small, and a coarse encoder rests in the same part of its step again and again.
    "beside_zero": dict(off_zero_deg=(0.02, 0.5), programme="to_and_fro", encoder_bits=[12, 13, 14, 16, 17],
                        reference_noise_deg=("log", 2e-4, 0.02), reference_rate_hz=[20.0, 50.0, 100.0],
                        gyro_rate_hz=[50.0, 100.0, 200.0], thermal=["warm_up", "constant"]),
    # One speed and one way, read with much noise: the turn, the offset and what the ramps do are nearly one.
    "one_way": dict(programme="one_way", reference_noise_deg=("log", 0.01, 0.06), reference_rate_hz=[10.0, 20.0, 50.0],
                    gyro_rate_hz=[100.0, 200.0], thermal=["warm_up", "constant"]),
    # Read at whole parts of a second while the table turns at a round speed, to and fro again and again: an encoder's
    # steps beat with the readings, each time in the same way, and a wave of many periods is nearly the same in each.
    "round_speed": dict(programme="round_speed", encoder_bits=[12, 13, 14, 17, 20],
                        reference_noise_deg=[0.0, 0.0003, 0.001, 0.004], reference_rate_hz=[10.0, 20.0, 50.0, 100.0],
                        gyro_rate_hz=[100.0, 200.0], thermal=["warm_up", "constant"],
                        straight_ramps_deg_s2=[0.0, 40.0]),
    # Axes rest at any angle while others turn: what is misread of it turns the direction that the motion comes from.
    "oblique_poses": dict(programme="oblique", encoder_zero_on_count=False, encoder_bits=[12, 13, 14, 17],
                          reference_noise_deg=("log", 1e-3, 0.05), reference_rate_hz=[10.0, 50.0, 100.0],
                          thermal=["warm_up", "constant"]),
}


def draw_value(rng, spec):
    """One value of a recipe's range."""
    if isinstance(spec, list):
        return spec[rng.integers(len(spec))]
    if isinstance(spec, tuple) and spec[0] == "log":
        return float(np.exp(rng.uniform(np.log(spec[1]), np.log(spec[2]))))
    if isinstance(spec, tuple):
        return float(rng.uniform(*spec))
    return spec


# What a lag of the thermometer looks like: b(T - lag dT/dt), with the transient of its start; the same of a scale
# factor that follows the temperature.
OF_A_LAG = ["bias.temperature_rate", "bias.warm_up", "bias.hysteresis", "composed(T*dT_dt)", "composed(w*dT_dt)"]


def tolerated(bench):
    """Ids of the effects that a bench has by itself: whoever names them is right."""
    return (OF_A_LAG if bench["temp_lag_s"] else []) + (["angle.latency"] if bench["stamped_late"] else [])


def draw_bench(name, rng, overrides=None):
    """A bench of the class, as a dictionary of the keys of DEFAULT, every one a value; overrides are for tests."""
    recipe = {**DEFAULT, **CLASSES[name], **(overrides or {})}
    return {key: draw_value(rng, recipe[key]) for key in DEFAULT}
