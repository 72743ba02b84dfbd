"""The obstacles of a world, as data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Obstacle:
    """An upright obstacle on the floor, as ``World.obstacles`` gives it. Coordinates are x and y in the world, m.

    name: unique in its world.
    shape: as in the world file; a room is the walls around a polygon.
    height_m: height, m.
    center: (2,), m, of a box or a cylinder; else None.
    size: (2,), m, of a box, along its own x and y axis; else None.
    yaw_rad: of a box, the angle from the world's x axis to its own, rad; else None.
    radius_m: of a cylinder, m; else None.
    rings: its outline, corners (n, 2), m, of every ring, with the obstacle on their left: counter-clockwise around it,
        clockwise around holes; empty for a cylinder.
    parts: convex polygons that cover it, corners (n, 2), m, counter-clockwise; one, unless it is concave; empty for a
        cylinder.
    """

    name: str
    shape: Literal["box", "cylinder", "polygon", "room"]
    height_m: float
    center: NDArray[np.float64] | None
    size: NDArray[np.float64] | None
    yaw_rad: float | None
    radius_m: float | None
    rings: tuple[NDArray[np.float64], ...]
    parts: tuple[NDArray[np.float64], ...]
