"""The passing-side example: inference, costs and sampling MPC against closed forms; its policies carry."""

from __future__ import annotations

import importlib
import math
import pathlib

import numpy as np
import pytest

FOLDER = pathlib.Path(__file__).parents[1] / "examples" / "passing_sides"
pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason="the examples are not next to the tests")

OBSTACLE, GOAL = (0.0, 0.0), (2.0, 0.0)


@pytest.fixture
def inference(monkeypatch):
    monkeypatch.syspath_prepend(str(FOLDER))
    return importlib.import_module("passing_inference")


@pytest.fixture
def control(monkeypatch):
    monkeypatch.syspath_prepend(str(FOLDER))
    return importlib.import_module("sampling_mpc")


def around(degrees, distance=1.5):
    """A position at this angle at the obstacle from the goal."""
    return (distance * math.cos(math.radians(degrees)), distance * math.sin(math.radians(degrees)))


@pytest.mark.parametrize(("degrees", "left"), [(180, 0.5), (135, 0.75), (90, 1.0), (45, 1.0), (-135, 0.25), (-90, 0.0), (-30, 0.0)])
def test_closed_form_the_prior_is_linear_in_the_angle_before_the_obstacle_and_certain_beyond(inference, degrees, left):
    prior = inference.side_prior(OBSTACLE, GOAL, around(degrees))
    assert prior == pytest.approx([left, 1 - left], abs=1e-15)


def test_closed_form_the_likelihood_straight_before_the_obstacle(inference):
    likelihood = inference.action_likelihood(OBSTACLE, GOAL, (-1.0, 0.0))
    score = [0.5 * math.cos(math.pi / 4 * i - math.pi / 3) * (1 + math.cos(math.pi / 4 * i)) for i in range(8)] + [0.0]
    expected = np.exp(score) / np.exp(score).sum()
    assert likelihood[inference.LEFT] == pytest.approx(expected, abs=1e-15)
    assert likelihood[inference.LEFT].argmax() == 1  # ahead and to the left
    mirrored = expected[[0, 7, 6, 5, 4, 3, 2, 1, 8]]
    assert likelihood[inference.RIGHT] == pytest.approx(mirrored, abs=1e-15)


def test_closed_form_beyond_the_obstacle_the_likelihood_is_that_of_walking_to_the_goal(inference):
    likelihood = inference.action_likelihood(OBSTACLE, GOAL, (1.0, 0.0))
    expected = np.exp([math.cos(math.pi / 4 * i) for i in range(8)] + [0.0])
    assert likelihood == pytest.approx(np.stack([expected, expected]) / expected.sum(), abs=1e-15)


def test_closed_form_the_posterior_is_prior_times_both_likelihoods(inference):
    position, ahead_left, standing = around(150), (0.2, 0.2), (0.0, 0.09)
    likelihood = inference.action_likelihood(OBSTACLE, GOAL, position)
    joint = inference.side_prior(OBSTACLE, GOAL, position) * likelihood[:, 1] * likelihood[:, 8]
    found = inference.side_posterior(OBSTACLE, GOAL, position, ahead_left, standing)
    assert found == pytest.approx(joint / joint.sum(), abs=1e-15)


def test_a_velocity_is_its_nearest_direction_and_a_slow_one_is_standing(inference):
    degrees = np.array([0, 22, 23, 45, 180, -22, -23, 338])
    velocities = 0.1001 * np.stack([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))], axis=-1)
    assert inference.action_of(velocities).tolist() == [0, 0, 1, 1, 4, 0, 7, 0]
    assert inference.action_of((0.0999, 0.0)) == 8


def test_closed_form_entropy_in_bit(inference):
    assert inference.entropy([[0.5, 0.5], [1.0, 0.0], [0.75, 0.25]]) == pytest.approx([1.0, 0.0, 2 - 0.75 * math.log2(3)])


def test_metamorphic_a_turned_and_moved_room_has_the_same_posterior_and_a_mirrored_one_the_other_side(inference):
    generator = np.random.default_rng(1)
    positions, velocities = generator.uniform(-2, 2, (100, 2)), 0.3 * generator.standard_normal((2, 100, 2))
    found = inference.side_posterior(OBSTACLE, GOAL, positions, *velocities)
    quarter, offset = np.array([[0.0, -1.0], [1.0, 0.0]]), np.array([3.0, -1.0])
    moved = [np.asarray(point) @ quarter.T + offset for point in (OBSTACLE, GOAL, positions)]
    assert inference.side_posterior(*moved, *(v @ quarter.T for v in velocities)) == pytest.approx(found, abs=1e-12)
    mirror = np.array([1.0, -1.0])
    mirrored = inference.side_posterior(OBSTACLE, GOAL, positions * mirror, *(v * mirror for v in velocities))
    assert mirrored == pytest.approx(found[:, ::-1], abs=1e-12)


def test_closed_form_costs(control):
    assert control.clearance_cost([(0.25, 0.0), (0.5, 0.0), (3.0, 4.0)], OBSTACLE) == pytest.approx([1.0, 0.0, 0.0])
    assert control.goal_cost([(2.0, 0.0), (2.0, 3.0)], GOAL) == pytest.approx([0.0, 9.0])
    assert control.carried_position((1.0, 2.0, math.pi / 2), (0.8, 0.1)) == pytest.approx([0.9, 2.8])


def test_the_uncertainty_cost_is_least_where_the_base_faces_the_humans_side(control):
    faces = np.radians([0.0, 45.0, -45.0])
    poses = np.stack([np.full(3, -2.5), np.full(3, 0.0), faces], axis=-1)
    # the object stays straight before the obstacle, so that only the robot's action differs
    cost = [control.uncertainty_cost(pose, (0.0, 0.0), OBSTACLE, GOAL, (0.2, 0.2)) for pose in poses]
    assert cost[1] < cost[0] < cost[2] == pytest.approx(1.0)


def test_closed_form_a_unicycle_goes_on_arcs(control):
    quarter = control.unicycle((1.0, 0.0, 0.0), (math.pi / 2, math.pi / 2), 1.0)
    assert quarter == pytest.approx([2.0, 1.0, math.pi / 2])
    assert control.unicycle((0.0, 0.0, math.pi / 2), (0.3, 0.0), 0.5) == pytest.approx([0.0, 0.15, math.pi / 2])
    half = control.unicycle((0.0, 0.0, math.pi / 2), (0.0, math.pi), 0.75)
    assert half == pytest.approx([0.0, 0.0, -0.75 * math.pi])


def test_an_mppi_update_is_the_mean_of_inputs_weighted_by_cost(control):
    mppi = control.Mppi(seed=0, samples=2, horizon=1)
    plan, noise = np.array([[0.1, 0.2]]), np.array([[[0.1, 0.3]], [[9.0, -0.4]]])
    final = lambda poses: poses[:, 0]  # noqa: E731
    found = mppi.improved(plan, noise, (0.0, 0.0, 0.0), lambda poses: np.zeros(2), final)
    inputs = np.array([[0.2, 0.5], [0.3, -0.2]])  # within the limits
    x = [0.2 / 0.5 * math.sin(0.125), 0.3 / 0.2 * math.sin(0.05)]
    cost = [x[i] + 0.1 * (inputs[i][0] - 0.1) / 0.25 + 0.2 * (inputs[i][1] - 0.2) for i in range(2)]
    weight = np.exp(-np.array(cost))
    assert found == pytest.approx((weight @ inputs / weight.sum())[np.newaxis])


def test_the_same_seed_gives_the_same_inputs(control):
    def commands(seed):
        mppi = control.Mppi(seed=seed)
        costs = lambda poses: np.zeros(len(poses)), lambda poses: control.goal_cost(poses[:, :2], GOAL)  # noqa: E731
        return [mppi.command((-2.0, 0.0, 0.0), (0.0, 0.0), *costs).tobytes() for _ in range(3)]

    assert commands(4) == commands(4) != commands(5)
