"""Geometry of the three-axis stand, as the measurement table defines it.

Frames: W world, z up; S sensor. Angles outer, middle, inner in degrees, right-handed:
    R_WS = Rz(outer) Rx(middle) Rz(inner)      rotates sensor-frame vectors into W
Arrays have the components first: shape (3, n).
"""
import numpy as np

AXES = ("outer", "middle", "inner")
CHANNELS = ("x", "y", "z")
EARTH_RATE_DEG_S = 15.041 / 3600.0


def axis_directions(angles_deg):
    """Directions of the three stand axes in the sensor frame.

    angles_deg: (3, n), outer, middle, inner. Returns (3 axes, 3 components, n):
        outer   Rz(i)^T Rx(m)^T z = (sin m sin i, sin m cos i, cos m)
        middle  Rz(i)^T x         = (cos i, -sin i, 0)
        inner   z
    """
    middle, inner = np.radians(angles_deg[1]), np.radians(angles_deg[2])
    sin_i, cos_i, sin_m = np.sin(inner), np.cos(inner), np.sin(middle)
    directions = np.zeros((3, 3, middle.size))
    directions[0] = sin_m * sin_i, sin_m * cos_i, np.cos(middle)
    directions[1, 0], directions[1, 1] = cos_i, -sin_i
    directions[2, 2] = 1.0
    return directions


def rates_in_sensor(directions, rates_deg_s):
    """Rate of S against W, in S [deg/s], from the rates of the three axes (3, n)."""
    return np.einsum("acn,an->cn", directions, rates_deg_s)


def gravity_in_sensor(directions):
    """Specific force at rest in S [g]: R_WS^T z, which is the direction of the outer axis."""
    return directions[0]


def earth_in_world(latitude_deg, heading_deg):
    """The Earth's rotation in W [deg/s]; heading is that of W's x axis, from north."""
    latitude, heading = np.radians(latitude_deg), np.radians(heading_deg)
    return EARTH_RATE_DEG_S * np.array([np.cos(latitude) * np.cos(heading),
                                        -np.cos(latitude) * np.sin(heading), np.sin(latitude)])


def world_to_sensor(angles_deg, vector):
    """R_WS^T v for one vector v in W; angles (3, n). Returns (3, n)."""
    outer, middle, inner = np.radians(angles_deg)
    x = np.cos(outer) * vector[0] + np.sin(outer) * vector[1]
    y = -np.sin(outer) * vector[0] + np.cos(outer) * vector[1]
    y, z = (np.cos(middle) * y + np.sin(middle) * vector[2],
            -np.sin(middle) * y + np.cos(middle) * vector[2])
    return np.array([np.cos(inner) * x + np.sin(inner) * y,
                     -np.sin(inner) * x + np.cos(inner) * y, z])


def multiply(p, q):
    """Hamilton product of quaternions (4, n), scalar first."""
    return np.array([p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
                     p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
                     p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
                     p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]])


def quaternion_of(angles_deg):
    """Unit quaternion of R_WS, (4, n), scalar first."""
    half = np.radians(angles_deg) / 2.0
    zero = np.zeros(half.shape[1])
    outer = np.array([np.cos(half[0]), zero, zero, np.sin(half[0])])
    middle = np.array([np.cos(half[1]), np.sin(half[1]), zero, zero])
    inner = np.array([np.cos(half[2]), zero, zero, np.sin(half[2])])
    return multiply(multiply(outer, middle), inner)
