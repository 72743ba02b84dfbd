"""What the passing-side policies know about a world: one obstacle and the goal, or walls and a point ahead on a path.

The paper has one obstacle, a point. In a world of walls, the nearest points of their faces stand in for it, and a point
ahead on the path of the robot's option for the goal: an extension of ours, which the paper does not have.
"""

from __future__ import annotations

import math
from typing import Protocol

import cocarry
import numpy as np
from numpy.typing import ArrayLike, NDArray

from passing_inference import LEFT, RIGHT, Floats, bearing_around, has_passed
from sampling_mpc import CLEARANCE_M, clearance_cost


class Scene(Protocol):
    """What the policies ask about a world. Positions are (x, y), m, in the world."""

    def look(self, view: cocarry.RobotView, position: Floats) -> tuple[Floats, Floats]:
        """The obstacle to pass and the goal, for an object at a position."""

    def clearance(self, base: Floats, carried: Floats) -> Floats:
        """The cost of being near obstacles, for positions (n, 2) of the base and of the object's centre."""

    def option(self, view: cocarry.RobotView, side: int) -> int:
        """The option on which the robot leads if it wants to pass on a side."""

    def is_near_end(self, position: Floats, distance: float) -> bool:
        """Whether an object at a position is nearer to the target than a distance, m."""


class OnePost:
    """One obstacle, by its centre, and the goal of the object: the paper's.

    walls: if given, the base and the object keep clear of all faces of the world, which the paper's robot does not: it
        knows no walls, and its base alone keeps clear of the obstacle.
    """

    def __init__(self, obstacle: tuple[float, float], goal: tuple[float, float], walls: Walls | None = None) -> None:
        self.obstacle, self.goal, self.walls = np.array(obstacle, float), np.array(goal, float), walls

    def look(self, view: cocarry.RobotView, position: Floats) -> tuple[Floats, Floats]:
        """Obstacle and goal."""
        return self.obstacle, self.goal

    def clearance(self, base: Floats, carried: Floats) -> Floats:
        """The paper's cost of clearance, by the distance of the base from the obstacle's centre; or that of the walls."""
        return clearance_cost(base, self.obstacle) if self.walls is None else self.walls.clearance(base, carried)

    def option(self, view: cocarry.RobotView, side: int) -> int:
        """The cheapest option on that side; beyond the obstacle, the executed one."""
        if view.executed is not None and has_passed(self.obstacle, self.goal, view.position):
            return view.executed
        sides = [side_of(view.path(option), self.obstacle, self.goal) for option in range(len(view))]
        matching = [option for option, its in enumerate(sides) if its == side]
        return cheapest(view, matching or list(range(len(view))))

    def is_near_end(self, position: Floats, distance: float) -> bool:
        """By the distance from the goal."""
        return math.dist(position, self.goal) < distance


class Walls:
    """The obstacles of a world, and a point ahead on the path of the cheapest option."""

    #: How far ahead of the object the goal is on the path, m.
    LOOKAHEAD_M = 1.5

    def __init__(self, world: cocarry.World) -> None:
        self.target = np.asarray(world.target)
        obstacles = world.obstacles
        # centre x, y, half the size along and across, yaw (rad), radius
        rows = [
            (*item.center, *(np.zeros(2) if item.size is None else 0.5 * item.size), item.yaw_rad or 0.0, item.radius_m or 0.0)
            for item in obstacles
            if item.center is not None
        ]
        self.obstacles = np.array(rows, float).reshape(-1, 6)
        reach = np.hypot(self.obstacles[:, 2], self.obstacles[:, 3]) + self.obstacles[:, 5]
        self.bounds = _bounds(self.obstacles[:, :2] - reach[:, np.newaxis], self.obstacles[:, :2] + reach[:, np.newaxis])
        #: Convex parts of polygons and rooms: their sides, begin and end, (sides, 2, 2), m, and how many each part has.
        parts = [part for item in obstacles if item.center is None for part in item.parts]
        self.sides = np.concatenate([np.zeros((0, 2, 2)), *(np.stack([part, np.roll(part, -1, axis=0)], axis=1) for part in parts)])
        self.counts = np.array([len(part) for part in parts], int)
        self.part_bounds = _bounds([part.min(axis=0) for part in parts], [part.max(axis=0) for part in parts])

    def nearest(self, positions: ArrayLike, within: float = math.inf) -> tuple[Floats, Floats]:
        """The nearest points (n, 2), m, of all obstacles to positions (n, 2), and their distances (n,), m; 0 within one.

        within: obstacles beyond this distance (m) of the rectangle around all positions do not count; infinite where none does.
        """
        positions = np.asarray(positions, float)
        around = _bounds(positions.min(axis=0) - within, positions.max(axis=0) + within)
        parts = _meet(self.part_bounds, around)
        points, distances = zip(
            _to_boxes_and_cylinders(self.obstacles[_meet(self.bounds, around)], positions[:, np.newaxis]),
            _to_polygons(self.sides[np.repeat(parts, self.counts)], self.counts[parts], positions[:, np.newaxis]),
        )
        point, distance = np.concatenate(points, axis=1), np.concatenate(distances, axis=1)
        if distance.shape[1] == 0:
            return np.full((len(positions), 2), np.inf), np.full(len(positions), np.inf)
        first, rows = distance.argmin(axis=1), np.arange(len(positions))
        return point[rows, first], distance[rows, first]

    def look(self, view: cocarry.RobotView, position: Floats) -> tuple[Floats, Floats]:
        """The point ahead on the path, and the obstacle's point nearest to halfway there."""
        path = view.path(view.executed if view.executed is not None else cheapest(view, list(range(len(view)))))
        goal = self.target if path is None else point_ahead(path, self.LOOKAHEAD_M)
        [obstacle], _ = self.nearest([0.5 * (position + goal)])
        return obstacle, goal

    def clearance(self, base: Floats, carried: Floats) -> Floats:
        """The paper's cost of clearance of base and object, by their distances from the nearest face; 10 within one."""
        _, distance = self.nearest(np.concatenate([base, carried]), within=CLEARANCE_M)
        away = np.stack([np.maximum(distance, CLEARANCE_M / 1024.0), np.zeros(len(distance))], axis=-1)
        return np.asarray(clearance_cost(away, (0.0, 0.0)).reshape(2, -1).sum(axis=0))

    def option(self, view: cocarry.RobotView, side: int) -> int:
        """The executed option, or the cheapest at the start, whatever the side."""
        return view.executed if view.executed is not None else cheapest(view, list(range(len(view))))

    def is_near_end(self, position: Floats, distance: float) -> bool:
        """By the distance from the world's target."""
        return math.dist(position, self.target) < distance


def _bounds(low: ArrayLike, high: ArrayLike) -> Floats:
    """Rectangles (n, 2, 2), m: their corners with the least and the greatest x and y."""
    return np.stack([np.asarray(low, float).reshape(-1, 2), np.asarray(high, float).reshape(-1, 2)], axis=1)


def _meet(bounds: Floats, around: Floats) -> NDArray[np.bool_]:
    """Which of the rectangles (n, 2, 2) meet a rectangle (1, 2, 2)."""
    return np.asarray(((bounds[:, 0] <= around[:, 1]) & (bounds[:, 1] >= around[:, 0])).all(axis=1))


def _to_boxes_and_cylinders(obstacles: Floats, positions: Floats) -> tuple[Floats, Floats]:
    """The nearest points (n, obstacles, 2) to positions (n, 1, 2), m, and their distances (n, obstacles); 0 within."""
    centre, half, yaw, radius = obstacles[:, :2], obstacles[:, 2:4], obstacles[:, 4], obstacles[:, 5]
    offset = positions - centre
    cosine, sine = np.cos(yaw), np.sin(yaw)
    own = np.stack([cosine * offset[..., 0] + sine * offset[..., 1], cosine * offset[..., 1] - sine * offset[..., 0]], axis=-1)
    inner = np.clip(own, -half, half)
    gap = own - inner
    length = np.hypot(gap[..., 0], gap[..., 1])
    share = np.minimum(1.0, radius / np.where(length > 0.0, length, 1.0))
    point = inner + gap * share[..., np.newaxis]
    world = centre + np.stack([cosine * point[..., 0] - sine * point[..., 1], sine * point[..., 0] + cosine * point[..., 1]], axis=-1)
    return world, np.maximum(length - radius, 0.0)


def _to_polygons(sides: Floats, counts: NDArray[np.int_], positions: Floats) -> tuple[Floats, Floats]:
    """The nearest points (n, sides, 2) of convex polygons to positions (n, 1, 2), m, and their distances (n, sides); 0 within.

    counts: the number of sides of each polygon.
    """
    begin, along = sides[:, 0], sides[:, 1] - sides[:, 0]
    offset = positions - begin
    share = np.clip((offset * along).sum(axis=-1) / (along * along).sum(axis=-1), 0.0, 1.0)
    point = begin + share[..., np.newaxis] * along
    distance = np.hypot(positions[..., 0] - point[..., 0], positions[..., 1] - point[..., 1])
    if not len(counts):
        return point, distance
    # a position within a convex polygon is to the left of all its sides
    left = along[:, 0] * offset[..., 1] - along[:, 1] * offset[..., 0] >= 0.0
    inside = np.repeat(np.logical_and.reduceat(left, np.cumsum(counts) - counts, axis=1), counts, axis=1)
    return np.where(inside[..., np.newaxis], positions, point), np.where(inside, 0.0, distance)


def cheapest(view: cocarry.RobotView, options: list[int]) -> int:
    """The option of least J_o (m) among some."""
    return min(options, key=lambda option: float(view.objective_cost_m[option]))


def point_ahead(path: NDArray[np.float64], distance: float) -> Floats:
    """The point of a path (n, 2), m, at a distance (m) along it; its end if it is shorter."""
    along = np.concatenate([[0.0], np.hypot(*np.diff(path, axis=0).T).cumsum()])
    return np.array([np.interp(distance, along, path[:, axis]) for axis in range(2)])


def side_of(path: NDArray[np.float64] | None, obstacle: Floats, goal: Floats) -> int | None:
    """The side on which a path (n, 2), m, passes an obstacle; None without a path, or for one that begins beyond it."""
    if path is None or len(path) < 2 or has_passed(obstacle, goal, path[0]):
        return None
    bearing = bearing_around(obstacle, goal, path)
    # how far it turns round the obstacle: no segment turns by more than half a turn
    turned = np.sum(np.remainder(np.diff(bearing) + math.pi, 2.0 * math.pi) - math.pi)
    return LEFT if turned <= 0.0 else RIGHT
