"""What an ideal tracer says of the very data that were written: one that knows the noise, the true motion and where each
candidate of the catalogue stands, and asks for the same thresholds as the bound.

The bound says how often one effect of a size can be found; this, whether it can be found in this set. Beside a tracer's
answer it tells what the data forbid from what the tracer loses.
"""
import numpy as np

import geometry


def residual_deg(scene, channel, gyro, reads):
    """Integral of the written samples less the angle that the written readings show, at each reading of the reference.

    gyro: samples (3, n) in the unit of the table, reads: readings (3, m) of the axes in degrees or (4, m) of a
    quaternion. Of the angle only the readings' own error is taken off: what the true motion adds is a row of M, which is
    free in any case. Readings of an axis that stands still within a table are known to be one, and have no error here.
    The Earth's rotation is taken off where the table says where it was measured.
    """
    bench = scene.bench
    out = gyro[channel]
    if bench["output"] in ("lsb", "unsigned"):
        out = (out - (32768.0 if bench["output"] == "unsigned" else 0.0)) / bench["lsb_per_deg_s"]
    elif bench["output"] == "rad_s":
        out = np.degrees(out)
    if bench["site"]:
        earth = geometry.earth_in_world(bench["latitude_deg"], bench["heading_deg"])
        out = out - geometry.world_to_sensor(scene.angles_deg, earth)[channel]
    return scene.integrate(out) - _error_of_readings(scene, channel, reads)


def _error_of_readings(scene, channel, reads):
    """What the written readings say the channel has turned, less what it has [deg]."""
    angles, _ = scene.motion_at(scene.t_read_s, scene.table_read)
    if scene.bench["reference"] == "quaternion":
        return _small_turn_deg(angles, reads)[channel]
    j = scene.at_readings(scene.directions[:, channel])
    total = np.zeros(scene.t_read_s.size)
    axes = (2,) if scene.bench["reference"] == "single" else (0, 1, 2)
    turning = np.array([t.turning_axes() for t in scene.plan.tables], dtype=bool)[scene.table_read]
    for axis in axes:
        error = np.where(turning[:, axis], reads[axis] - angles[axis], 0.0)
        step = np.diff(error, prepend=error[0]) * 0.5 * (j[axis] + np.concatenate([j[axis][:1], j[axis][:-1]]))
        summed = np.cumsum(step)
        for part in scene.reading_parts():
            total[part] += summed[part] - summed[part.start]
    return total


def _small_turn_deg(angles, reads):
    """The small turn (3, n) in S from the true orientation to that which was read [deg]."""
    true = geometry.quaternion_of(angles)
    turn = geometry.multiply(np.vstack([true[:1], -true[1:]]), reads)
    return np.degrees(2.0 * turn[1:] * np.sign(turn[:1]))


def word(named, truth_id):
    """exact, among, wrong or nothing, as `scoring` says it of a tracer; named: ids that are as likely as the best."""
    if not named:
        return "nothing"
    if truth_id not in named:
        return "wrong"
    return "exact" if len(named) == 1 else "among"
