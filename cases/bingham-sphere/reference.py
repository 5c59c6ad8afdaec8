"""Drag of a sphere in creeping flow of a Bingham fluid without walls, by the minimum of the power over all axisymmetric flows.

The flow is u_r = sum n (n + 1) f_n/r^2 P_n(cos theta), u_theta = sum f_n'/r dP_n/dtheta, n odd, which is solenoidal whatever the f_n:
cubic Hermite elements in r. Of all that follow the sphere (U = 1, radius 1, plastic viscosity 1) and vanish at the outer radius, the
one that minimises the integral of Phi(rate), Phi' = stress, is the creeping flow; Newton's method finds it. The drag is the power
over U. `python3 cases/bingham-sphere/reference.py`; a minute.
"""
import sys

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve
from scipy.special import eval_legendre

MODES = 10
ELEMENTS = 50
ANGLES = 32


def hermite(t, h):
    """Values, first and second derivatives of the four cubic Hermite functions of an element of width h at t in 0..1."""
    value = [1 - 3 * t**2 + 2 * t**3, h * (t - 2 * t**2 + t**3), 3 * t**2 - 2 * t**3, h * (t**3 - t**2)]
    first = [(6 * t**2 - 6 * t) / h, 1 - 4 * t + 3 * t**2, (6 * t - 6 * t**2) / h, 3 * t**2 - 2 * t]
    second = [(12 * t - 6) / h**2, (6 * t - 4) / h, (6 - 12 * t) / h**2, (6 * t - 2) / h]
    return [np.array(x) for x in (value, first, second)]


class Sphere:
    """The discrete flow: rates of strain as linear functions of the unknowns."""

    def __init__(self, outer, modes=MODES, elements=ELEMENTS, angles=ANGLES):
        # Elements grow with the distance from the sphere.
        nodes = 1 + (outer - 1) * np.expm1(4 * np.linspace(0, 1, elements + 1)) / np.expm1(4)
        self.degrees = 2 * np.arange(modes) + 1
        x, wx = leggauss(angles)
        x, wx = (x + 1) / 2, wx  # half of the sphere, counted twice
        sine = np.sqrt(1 - x**2)
        n = self.degrees[:, None]
        p = np.array([eval_legendre(k, x) for k in self.degrees])
        below = np.array([eval_legendre(k - 1, x) for k in self.degrees])
        slope = n * (below - x * p) / (1 - x**2)  # dP/dx
        q = -sine * slope  # dP/dtheta
        curve = -n * (n + 1) * p - q * x / sine  # d2P/dtheta2
        t, wt = leggauss(4)
        t, wt = (t + 1) / 2, wt / 2
        self.rows, self.weights, self.dofs = [], [], []
        for e in range(elements):
            h = nodes[e + 1] - nodes[e]
            r = nodes[e] + h * t
            f, f1, f2 = hermite(t, h)  # [4, radii]
            nn = (n * (n + 1))[None, :, None, :]
            shape = lambda g, a: g[:, None, :, None] * a[None, :, None, :]
            radius = r[None, None, :, None]
            ur = nn * shape(f, p) / radius**2
            rr = nn * (shape(f1, p) / radius**2 - 2 * shape(f, p) / radius**3)
            tt = shape(f1, curve) / radius**2 + ur / radius
            ff = ur / radius + shape(f1, q) * (x / sine)[None, None, None, :] / radius**2
            rt = 0.5 * (shape(f2, q) / radius - 2 * shape(f1, q) / radius**2 + nn * shape(f, q) / radius**3)
            rates = np.stack([rr, tt, ff, np.sqrt(2) * rt])  # rate^2 = 2 sum of squares
            self.rows.append(np.sqrt(2) * rates.reshape(4, 4 * modes, -1))
            self.weights.append((2 * np.pi * r**2 * wt * h)[:, None] * wx[None, :])
            # Unknowns: value and slope at each node, per mode.
            local = np.array([2 * e, 2 * e + 1, 2 * e + 2, 2 * e + 3])
            self.dofs.append((local[:, None] + 2 * (elements + 1) * np.arange(modes)[None, :]).reshape(-1))
        self.weights = [w.reshape(-1) for w in self.weights]
        self.size = 2 * (elements + 1) * modes
        per = 2 * (elements + 1)
        fixed = np.concatenate([[m * per, m * per + 1, m * per + per - 2, m * per + per - 1] for m in range(modes)])
        self.free = np.setdiff1d(np.arange(self.size), fixed)
        self.unknowns = np.zeros(self.size)
        self.unknowns[[0, 1]] = 0.5, 1.0

    def terms(self, stress, exponent, unknowns, hessian=False):
        """Functional and power, with gradient and Hessian of the functional."""
        total = power = 0.0
        gradient, entries = np.zeros(self.size), []
        for rows, weights, dofs in zip(self.rows, self.weights, self.dofs):
            strain = np.einsum("csk,s->ck", rows, unknowns[dofs])
            rate = np.sqrt((strain**2).sum(0) + 1e-24)
            decay = np.exp(-np.minimum(exponent * rate, 700))
            share = -np.expm1(-np.minimum(exponent * rate, 700))
            viscosity = 1 + stress * share / rate
            total += (weights * (0.5 * rate**2 + stress * (rate - share / exponent))).sum()
            power += (weights * viscosity * rate**2).sum()
            if hessian:
                gradient[dofs] += np.einsum("csk,ck->s", rows, strain * (weights * viscosity))
                # d(viscosity)/d(rate) / rate
                bend = stress * (exponent * decay * rate - share) / rate**3
                a = rows * np.sqrt(weights * viscosity)[None, None, :]
                matrix = np.einsum("csk,ctk->st", a, a, optimize=True)
                along = np.einsum("csk,ck->sk", rows, strain)
                matrix += (along * (weights * bend)) @ along.T
                i, j = np.meshgrid(dofs, dofs, indexing="ij")
                entries.append((i.ravel(), j.ravel(), matrix.ravel()))
        if not hessian:
            return total, power
        i, j, v = (np.concatenate(part) for part in zip(*entries))
        return total, power, gradient, coo_matrix((v, (i, j)), shape=(self.size, self.size)).tocsc()

    def drag(self, stress, exponent):
        """Drag over that of Stokes, from the flow found last; and the relative change of the last step."""
        for _ in range(100):
            total, power, gradient, matrix = self.terms(stress, exponent, self.unknowns, True)
            free = self.free
            step = np.zeros(self.size)
            step[free] = spsolve(matrix[free][:, free], -gradient[free])
            slope = gradient @ step
            size = 1.0
            while size > 1e-4 and self.terms(stress, exponent, self.unknowns + size * step)[0] > total + 1e-4 * size * slope:
                size *= 0.5
            self.unknowns += size * step
            if -slope < 1e-9 * total:
                break
        return self.terms(stress, exponent, self.unknowns)[1] / (6 * np.pi)


def main():
    exponents = [float(x) for x in sys.argv[1:]] or [10, 30, 100, 300, 1000]
    print("Bi = 2 tau_y R/(mu U), drag over Stokes by exponents", exponents, "R/U, and 2 pi R^2 tau_y/drag of the last")
    for bingham, outer in [(0, 60), (0.1, 40), (1, 14), (10, 6), (100, 4), (1000, 4)]:
        sphere, found = Sphere(outer), []
        for exponent in exponents:
            found.append(sphere.drag(0.5 * bingham, exponent))
        stokes = found[-1]
        print(bingham, outer, " ".join(f"{x:.4f}" for x in found), f"{bingham / (6 * stokes):.4f}", flush=True)


if __name__ == "__main__":
    main()
