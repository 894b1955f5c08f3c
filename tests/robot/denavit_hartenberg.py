"""The KR 300 R2500 as its authors published it: Denavit-Hartenberg and CAD numbers, and recursive Newton-Euler on them.

Shares nothing with ffgym: other frames (z of the base points down), other equations, one pose at a time.

J. Weigand, J. Ulmen, A. Janot, M. Ruskowski, real-time nonlinear parameter identification for an industrial robot
(2021); github.com/JonasWeigand/Robot_Identification: robot_model/model_KUKA_Quantec_Ultra_KR300.m and
ident_functions/hydraulic_weight_counterbalance.m (MIT, (c) 2021 Jonas Weigand).
"""

import numpy as np

ALPHA = np.radians([90, 0, -90, 90, -90, 180])
A = np.array([0.35, 1.15, 0.041, 0, 0, 0])
D = np.array([-0.675, -0.189, 0.189, -1, 0, -0.24])
THETA_OFFSET = np.radians([0, 0, 90, 0, 0, 0])
RECORDED_OFFSET = np.radians([0, -90, 90, 0, 0, 0])
"""What is added to recorded joint angles to get those of the table."""
GRAVITY = np.array([0, 0, 9.81])

MASS = [395.40, 339.12, 105.21, 35.80, 31.46, 17.78]
COM = 1e-3 * np.array([[-353, 174, -4], [-709, -1, 23], [-18, -18, -76], [0, 236, 1], [0, -80, -9], [0, 0, -50]])
INERTIA = 1e-6 * np.array(
    [  # xx, yy, zz, xy, yz, xz
        [16733765, 29799119, 32814954, -1703664, 129384, 4404062],
        [7507819, 88886691, 88673761, 430046, 173157, -4396607],
        [10783798, 10186135, 1943179, 118474, -606384, -101950],
        [425035, 217993, 428465, -4, -11353, -27],
        [283826, 229562, 258266, -4, -19521, -120],
        [60000, 60000, 90000, 0, 0, 0],  # published as zero; the description's choice
    ]
)
PAYLOAD_MASS, PAYLOAD_COM = 150.0, np.array([0, 0, 0.1])
PAYLOAD_INERTIA = np.diag([1.6, 1.6, 2.3])  # published as a point mass; the description's choice
GEAR_RATIO = np.array([1798 / 7, 1872 / 7, 757 / 3, 221, 5032 / 21, 206793 / 1340])
ROTOR_INERTIA = np.array([0.00923, 0.0118, 0.0118, 0.00173, 0.00173, 0.00173])

_Z = np.array([0.0, 0.0, 1.0])


def bodies():
    """Mass, centre of mass and inertia of every body: [kg], [m], [kg m^2], and the link that carries it."""
    for link, (xx, yy, zz, xy, yz, xz) in enumerate(INERTIA):
        yield link, MASS[link], COM[link], np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    yield 5, PAYLOAD_MASS, PAYLOAD_COM, PAYLOAD_INERTIA


def steps(q):
    """Rotation and origin of each frame in the one before it, at recorded joint angles q (6,)."""
    for theta, alpha, a, d in zip(q + THETA_OFFSET + RECORDED_OFFSET, ALPHA, A, D, strict=True):
        c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
        yield np.array([[c, -s * ca, s * sa], [s, c * ca, -c * sa], [0, sa, ca]]), np.array([a * c, a * s, d])


def newton_euler(q, dq, ddq, gravity=GRAVITY):
    """Joint torque [N m] (6,) of links and payload, without rotors: speeds outwards, forces inwards."""
    spin, spin_rate, acceleration = np.zeros(3), np.zeros(3), -np.asarray(gravity, dtype=float)
    motions, geometry = [], list(steps(q))
    for (turn, origin), speed, rate in zip(geometry, dq, ddq, strict=True):
        spin_rate = turn.T @ (spin_rate + rate * _Z + np.cross(spin, speed * _Z))
        spin = turn.T @ (spin + speed * _Z)
        acceleration = turn.T @ acceleration + _of_point(spin, spin_rate, turn.T @ origin)
        motions.append((spin, spin_rate, acceleration))
    force, moment, torque = np.zeros(3), np.zeros(3), np.zeros(6)  # on link i from the link before it, about its frame
    for i in reversed(range(6)):
        for link, mass, com, inertia in bodies():
            if link == i:
                spin, spin_rate, acceleration = motions[i]
                push = mass * (acceleration + _of_point(spin, spin_rate, com))
                moment = moment + np.cross(com, push) + inertia @ spin_rate + np.cross(spin, inertia @ spin)
                force = force + push
        turn, origin = geometry[i]
        force, moment = turn @ force, turn @ moment
        moment = moment + np.cross(origin, force)
        torque[i] = moment[2]
    return torque


def counterbalance_torque(q2):
    """Torque of axis 2 [N m] that holds the gas spring, at its recorded angle q2 [rad]."""
    long, short = 0.8, 0.2
    area = np.pi * (0.055**2 - 0.03**2) / 4
    delta = q2 + RECORDED_OFFSET[1] + np.radians(95)
    length = np.sqrt(long**2 + short**2 - 2 * long * short * np.cos(delta))
    lever = np.sin(delta) * long * short / length
    pressure = 1.01 * 296.8 * 328 * 0.159 / (0.00096 - (length - (long - short)) * area)
    return lever * pressure * area


def _of_point(spin, spin_rate, point):
    """Acceleration that a turning frame gives to a point in it."""
    return np.cross(spin_rate, point) + np.cross(spin, np.cross(spin, point))
