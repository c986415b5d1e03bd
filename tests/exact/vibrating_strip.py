#!/usr/bin/env python3
"""What a rigid, smooth strip that vibrates on elastic ground feels.

    vibrating_strip.py HERTZ HALF_WIDTH [SHEAR_WAVE_SPEED NU DENSITY]
    vibrating_strip.py --check SOURCE_ROOT    what scene, page and test say of it

Lamb's half-plane: with p(k) the transform of the pressure, the surface moves by
-k_s^2 a p(k)/(G R(k)), R = (2 k^2 - k_s^2)^2 - 4 k^2 a b, a^2 = k^2 - k_p^2,
b^2 = k^2 - k_s^2. The pressure below the strip is sum a_n T_2n(x)/sqrt(1 - x^2),
whose transform is pi (-1)^n J_2n(k); Galerkin makes the motion the same all over
the strip. Prints stiffness and damping coefficient of half the strip, and the
latter of plane pressure waves, rho c_p b, to which it tends at high frequency.
"""
import cmath
import math
import os
import sys

LOSS = 0.01  # of the wave number: keeps the path off the Rayleigh pole
N = 5  # functions of the pressure
K_MAX = 60.0


def bessel(x, n_max):
    """J_0 ... J_n_max, by downward recurrence."""
    start = int(max(n_max, x)) + 20 + int(math.sqrt(40 * max(n_max, x)))
    start += start % 2
    j = [0.0] * (start + 2)
    j[start] = 1e-30
    for m in range(start, 0, -1):
        j[m - 1] = 2 * m / x * j[m] - j[m + 1]
        if abs(j[m - 1]) > 1e200:
            j = [value * 1e-200 for value in j]
    scale = j[0] + 2 * sum(j[2 : start + 1 : 2])
    return [value / scale for value in j[: n_max + 1]]


def impedance(a0, nu):
    """Force over displacement and G, of the whole strip; a0 = omega b/c_s."""
    ks = a0 * (1 - 1j * LOSS)
    kp = ks * math.sqrt((1 - 2 * nu) / (2 * (1 - nu)))
    matrix = [[math.pi * (1 - nu) / (math.pi * K_MAX) + 0j] * N for _ in range(N)]  # beyond K_MAX

    def add(lower, upper, pieces):
        half = (upper - lower) / pieces / 2
        for i in range(pieces):
            for place, weight in ((-math.sqrt(0.6), 5 / 9), (0, 8 / 9), (math.sqrt(0.6), 5 / 9)):
                k = lower + (2 * i + 1 + place) * half
                a, b = cmath.sqrt(k * k - kp * kp), cmath.sqrt(k * k - ks * ks)
                rayleigh = (2 * k * k - ks * ks) ** 2 - 4 * k * k * a * b
                value = -ks * ks * a / rayleigh * weight * half * math.pi
                j = bessel(k, 2 * N)
                for m in range(N):
                    for n in range(N):
                        matrix[m][n] += value * (-1) ** (m + n) * j[2 * m] * j[2 * n]

    add(1e-6, 1.5 * a0, int(6 / LOSS))
    add(1.5 * a0, K_MAX, 400)
    rows = [row + [math.pi if m == 0 else 0] for m, row in enumerate(matrix)]
    for i in range(N):
        for m in range(i + 1, N):
            factor = rows[m][i] / rows[i][i]
            rows[m] = [x - factor * y for x, y in zip(rows[m], rows[i])]
    result = [0j] * N
    for i in reversed(range(N)):
        result[i] = (rows[i][N] - sum(rows[i][m] * result[m] for m in range(i + 1, N))) / rows[i][i]
    return math.pi * result[0]


def strip(hertz, b, c_s=200.0, nu=0.25, rho=1800.0):
    """Stiffness, N/m, damping coefficient and that of plane waves, N s/m."""
    omega = 2 * math.pi * hertz
    stiffness = impedance(omega * b / c_s, nu) * rho * c_s**2 / 2
    c_p = c_s * math.sqrt(2 * (1 - nu) / (1 - 2 * nu))
    return stiffness.real, stiffness.imag / omega, rho * c_p * b


def check(root):
    """The damping coefficients are the same in all places that have them."""
    narrow, wide = (int(strip(48, b)[1] / 1e3) for b in (1.0, 1.125))
    failed = 0
    for path, text in (
        ("tests/scenes/ground.cc", f"narrow_strip = {narrow}e3, wide_strip = {wide}e3;"),
        ("prm/ground/vibrating-footing.prm", f"C = {narrow} kN s/m"),
        ("prm/ground/vibrating-footing.prm", f"and {wide} kN s/m for 1.125 m"),
        ("doc/ground.md", f"| {narrow}, {wide} |"),
    ):
        with open(os.path.join(root, path), encoding="utf-8") as file:
            if text not in file.read():
                print(f"FAILED: {path} does not have <{text}>")
                failed = 1
    return failed


def main():
    if len(sys.argv) == 3 and sys.argv[1] == "--check":
        sys.exit(check(sys.argv[2]))
    if not 3 <= len(sys.argv) <= 6:
        sys.exit("vibrating_strip.py HERTZ HALF_WIDTH [SHEAR_WAVE_SPEED] [POISSON] [DENSITY]")
    stiffness, damping, plane = strip(*map(float, sys.argv[1:]))
    print(f"stiffness {stiffness / 1e6:.1f} MN/m, damping coefficient {damping / 1e3:.1f} kN s/m"
          f" (plane waves {plane / 1e3:.1f})")


if __name__ == "__main__":
    main()
