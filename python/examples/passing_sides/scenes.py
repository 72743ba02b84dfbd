"""What the passing-side policies know about a world: one obstacle and the goal, or walls and a point ahead on a path.

The paper has one obstacle, a point. In a world of walls, the nearest points of their faces stand in for it, and a point
ahead on the path of the robot's option for the goal: an extension of ours, which the paper does not have.
"""

from __future__ import annotations

import math
from typing import Any, Protocol

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
    """Boxes and cylinders of a world, and a point ahead on the path of the cheapest option. Needs Python 3.11."""

    #: How far ahead of the object the goal is on the path, m.
    LOOKAHEAD_M = 1.5

    def __init__(self, world: cocarry.World) -> None:
        import tomllib

        self.target = np.asarray(world.target)
        obstacles: list[dict[str, Any]] = tomllib.loads(world.text)["obstacle"]
        others = {item["shape"] for item in obstacles} - {"box", "cylinder"}
        if others:
            raise ValueError(f"{world.name}: obstacles of the shape {', '.join(sorted(others))}; Walls knows boxes and cylinders")
        # centre x, y, half the size along and across, yaw (rad), radius
        rows = [
            (
                *item["center_m"],
                *(0.5 * np.array(item.get("size_m", (0.0, 0.0)))),
                math.radians(item.get("yaw_deg", 0.0)),
                item.get("radius_m", 0.0),
            )
            for item in obstacles
        ]
        self.obstacles = np.array(rows, float)

    def nearest(self, positions: ArrayLike) -> tuple[Floats, Floats]:
        """The nearest points (n, 2), m, of all obstacles to positions (n, 2), and their distances (n,), m; 0 within one."""
        positions = np.asarray(positions, float)[:, np.newaxis]
        centre, half, yaw, radius = self.obstacles[:, :2], self.obstacles[:, 2:4], self.obstacles[:, 4], self.obstacles[:, 5]
        offset = positions - centre
        cosine, sine = np.cos(yaw), np.sin(yaw)
        own = np.stack([cosine * offset[..., 0] + sine * offset[..., 1], cosine * offset[..., 1] - sine * offset[..., 0]], axis=-1)
        inner = np.clip(own, -half, half)
        gap = own - inner
        length = np.hypot(gap[..., 0], gap[..., 1])
        share = np.minimum(1.0, radius / np.where(length > 0.0, length, 1.0))
        point = inner + gap * share[..., np.newaxis]
        world = centre + np.stack([cosine * point[..., 0] - sine * point[..., 1], sine * point[..., 0] + cosine * point[..., 1]], axis=-1)
        distance = np.maximum(length - radius, 0.0)
        first = distance.argmin(axis=1)
        rows = np.arange(len(positions))
        return world[rows, first], distance[rows, first]

    def look(self, view: cocarry.RobotView, position: Floats) -> tuple[Floats, Floats]:
        """The point ahead on the path, and the obstacle's point nearest to halfway there."""
        path = view.path(view.executed if view.executed is not None else cheapest(view, list(range(len(view)))))
        goal = self.target if path is None else point_ahead(path, self.LOOKAHEAD_M)
        [obstacle], _ = self.nearest([0.5 * (position + goal)])
        return obstacle, goal

    def clearance(self, base: Floats, carried: Floats) -> Floats:
        """The paper's cost of clearance of base and object, by their distances from the nearest face; 10 within one."""
        _, distance = self.nearest(np.concatenate([base, carried]))
        away = np.stack([np.maximum(distance, CLEARANCE_M / 1024.0), np.zeros(len(distance))], axis=-1)
        return np.asarray(clearance_cost(away, (0.0, 0.0)).reshape(2, -1).sum(axis=0))

    def option(self, view: cocarry.RobotView, side: int) -> int:
        """The executed option, or the cheapest at the start, whatever the side."""
        return view.executed if view.executed is not None else cheapest(view, list(range(len(view))))

    def is_near_end(self, position: Floats, distance: float) -> bool:
        """By the distance from the world's target."""
        return math.dist(position, self.target) < distance


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
