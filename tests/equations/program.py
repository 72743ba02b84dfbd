"""Eq. (7) as a quadratic program."""

import numpy as np
from scipy import linalg, optimize

H = 8
SUMS = np.tril(np.ones((H, H)))


class Program:
    """Eq. (7) at one configuration: the least ||M u - v||^2 with A u <= b, where u = (u(0), ..., u(H-1))."""

    def __init__(self, robot, b, weights):
        self.robot, self.q, r = robot, np.sqrt(weights[0]), np.sqrt(weights[1])
        self.m = np.vstack([self.q * np.kron(SUMS, b), r * np.eye(H * b.shape[1])])
        self.root = linalg.cholesky(self.m.T @ self.m)

    def unlimited(self, s):
        """The solution without limits, and its cost."""
        v = np.append(self.q * s.ravel(), np.zeros(self.m.shape[1]))
        u = linalg.cho_solve((self.root, False), self.m.T @ v)
        return u, np.sum((self.m @ u - v) ** 2)

    def solve(self, s, joints, taken, period):
        """u(0..H-1), the cost, and whether limits are active: those of rates (of u(0) less what the change of
        configuration takes) and of positions over the horizon. Standing still is always allowed."""
        robot, n = self.robot, len(self.robot.rates)
        u, cost = self.unlimited(s)
        most, used = np.tile(robot.rates, H), np.append(taken, np.zeros((H - 1) * n))
        up, down = (np.tile(room / period, H) for room in (robot.upper - joints, joints - robot.lower))
        bound = np.maximum(np.concatenate([most - used, most + used, up, down]), 0)
        sums = np.kron(SUMS, np.eye(n)[robot.base :])
        rows = np.vstack([np.eye(H * n), -np.eye(H * n), sums, -sums])[np.isfinite(bound)]
        excess = rows @ u - bound[np.isfinite(bound)]
        if (excess <= 1e-9).all():
            return u.reshape(H, n), cost, False
        moved = self.least_distance(rows, excess)
        return (u - moved).reshape(H, n), cost + np.sum((self.root @ moved) ** 2), True

    def least_distance(self, rows, excess):
        """How far u is from the optimum without limits: the least ||root d|| with A d >= excess (Lawson and
        Hanson, Solving Least Squares Problems, chapter 23.4)."""
        g = linalg.solve_triangular(self.root, rows.T, trans="T").T
        matrix, unit = np.vstack([g.T, excess]), np.append(np.zeros(g.shape[1]), 1)
        rest = matrix @ optimize.nnls(matrix, unit)[0] - unit
        return linalg.solve_triangular(self.root, -rest[:-1] / rest[-1])
