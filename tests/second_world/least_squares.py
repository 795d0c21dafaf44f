"""The world's own check: the true model fitted to one channel by generalised least squares.

Knows what no tracer knows (the directions of the axes, the noise, which effects are hidden), so that chi-square must be
1 a reading and estimates must scatter as the bound says. The channel's main axis is taken as read, others as they are.
"""
import numpy as np

import bound
import catalogue
import geometry
import simulate


def residual_angle(world, gyro_deg_s, reads_deg):
    """z - Phi at the readings [deg]; gyro (3, n) in deg/s, reads (3, n) angles of the axes."""
    scene, channel = world.scene, world.channel
    main = catalogue.axes_felt(scene, channel)[0]
    reference = sum(scene.projected(a, channel, scene.angles_deg[a]) for a in range(3) if a != main)
    j = scene.at_readings(scene.directions[main, channel])
    assert np.allclose(np.diff(j)[np.diff(scene.table_read) == 0], 0.0, atol=1e-9), "the axis must keep its direction"
    return integrated(scene, gyro_deg_s[channel]) - reference - j * reads_deg[main]


def integrated(scene, rate):
    """Integral of a sampled rate at the readings, trapezoids less their error dt^2/12 (dw/dt - dw/dt at the start).

    The slope is that of the neighbours. Without the correction a sine of 0.8 Hz sampled at 100 Hz is 2e-4 too small,
    which three sigma of a g-dependent scale are. The sum of means has no such error.
    """
    if scene.bench["sample"] == "mean":
        return scene.integrate(rate)
    change = np.zeros(rate.size)
    change[1:-1] = (rate[2:] - rate[:-2]) / 24.0 / scene.bench["gyro_rate_hz"]
    for part in scene.parts():
        change[part.start] = change[part.stop - 1] = 0.0
    return scene.integrate(rate) - scene.at_readings(change)


def fit(world, residual_deg):
    """Estimates and standard errors of the hidden effects' linear parameters, and chi-square per degree of freedom."""
    scene, channel = world.scene, world.channel
    columns = [catalogue.responses(scene, channel, h.candidate) for h in world.hidden]
    columns = np.vstack(columns + [bound.nuisance(scene, channel)])
    if world.bench["site"]:  # M sees the Earth as well; its size is known, and M all but known
        earth = geometry.earth_in_world(world.bench["latitude_deg"], world.bench["heading_deg"])
        seen = world.sensor.m[channel] @ geometry.world_to_sensor(scene.angles_deg, earth)
        residual_deg = residual_deg - scene.integrate(seen)
    whiten = bound.whitener_of(scene, channel, world.sensor.noise(world.bench))
    white = whiten([*columns, residual_deg])
    a, y = white[:, :-1], white[:, -1]
    scale = np.sqrt((a ** 2).sum(axis=0))
    q, r = np.linalg.qr(a / scale)
    inverse = np.linalg.inv(r)
    estimates = inverse @ (q.T @ y) / scale
    left = y - q @ (q.T @ y)
    errors = np.sqrt((inverse ** 2).sum(axis=1)) / scale
    wanted = sum(len(h.theta) for h in world.hidden)
    free = residual_deg.size - a.shape[1] - len(scene.plan.tables) - len(scene.plan.targets)
    return estimates[:wanted], errors[:wanted], float(left @ left / free)


def measured(world):
    """One measurement of the world: gyro as printed, back in deg/s, and the angles read."""
    bench = world.bench
    gyro = simulate.quantised(bench, world.sensor, simulate.gyro_output(world.rng, world.scene, world.sensor,
                                                                         world.hidden))
    if bench["output"] in ("lsb", "unsigned"):
        gyro = (gyro - (32768.0 if bench["output"] == "unsigned" else 0.0)) / bench["lsb_per_deg_s"]
    if bench["output"] == "rad_s":
        gyro = np.degrees(gyro)
    return gyro, simulate.reference_angles(world.rng, world.scene, world.hidden)
