"""The passing-side example: inference, costs and sampling MPC against closed forms; its policies carry."""

from __future__ import annotations

import argparse
import importlib
import io
import math
import pathlib
import pickle
import sys
import types
import zipfile

import numpy as np
import pytest

import cocarry

FOLDER = pathlib.Path(__file__).parents[1] / "examples" / "passing_sides"
pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason="the examples are not next to the tests")

OBSTACLE, GOAL = (0.0, 0.0), (2.0, 0.0)


@pytest.fixture(autouse=True)
def examples_are_importable(monkeypatch):
    monkeypatch.syspath_prepend(str(FOLDER))


@pytest.fixture
def inference():
    return importlib.import_module("passing_inference")


@pytest.fixture
def control():
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


@pytest.fixture
def scenes():
    return importlib.import_module("scenes")


def test_a_path_has_the_side_on_which_it_passes_the_obstacle(inference, scenes):
    obstacle, goal = np.array(OBSTACLE), np.array(GOAL)
    left = np.array([(-2.0, 0.0), (0.0, 0.7), (2.0, 0.0)])
    assert scenes.side_of(left, obstacle, goal) == inference.LEFT
    assert scenes.side_of(left * (1, -1), obstacle, goal) == inference.RIGHT
    assert scenes.side_of(left[2:], obstacle, goal) is None
    assert scenes.side_of(np.array([(0.5, 1.0), (2.0, 0.0)]), obstacle, goal) is None


def test_closed_form_a_point_ahead_on_a_path(scenes):
    path = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 5.0)])
    assert scenes.point_ahead(path, 1.5) == pytest.approx([1.0, 0.5])
    assert scenes.point_ahead(path, 9.0) == pytest.approx([1.0, 5.0])


def test_closed_form_the_nearest_points_of_walls(scenes):
    text = """
name = "Box and post"
robot_width_m = 0.5
start_m = [-3.0, 0.0]
target_m = [5.0, 0.0]
[[obstacle]]
name = "box"
shape = "box"
center_m = [0.0, 2.0]
size_m = [4.0, 2.0]
yaw_deg = 90.0
height_m = 1.0
[[obstacle]]
name = "post"
shape = "cylinder"
center_m = [3.0, 0.0]
radius_m = 0.5
height_m = 1.0
[[option]]
name = "all"
openings = []
"""
    walls = scenes.Walls(cocarry.World.parse(text))
    points, distances = walls.nearest([(-2.0, 1.0), (1.8, 0.0), (0.5, 2.0)])
    assert distances == pytest.approx([1.0, 0.7, 0.0])
    assert points == pytest.approx(np.array([(-1.0, 1.0), (2.5, 0.0), (0.5, 2.0)]))
    base, carried = np.array([(-1.25, 1.0), (-2.0, 1.0)]), np.array([(-9.0, 0.0), (0.0, 2.0)])
    assert walls.clearance(base, carried) == pytest.approx([1.0, 10.0])


def test_closed_form_the_nearest_points_of_polygons_with_holes_and_of_rooms(scenes):
    text = """
name = "Corner, ring and room"
robot_width_m = 0.5
start_m = [-3.0, 0.0]
target_m = [5.0, 0.0]
[[obstacle]]
name = "corner"
shape = "polygon"
vertices_m = [[-1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [0.0, 2.0], [0.0, 4.0], [-1.0, 4.0]]
height_m = 1.0
[[obstacle]]
name = "ring"
shape = "polygon"
vertices_m = [[0.0, -5.0], [4.0, -5.0], [4.0, -1.0], [0.0, -1.0]]
holes_m = [[[1.0, -4.0], [3.0, -4.0], [3.0, -2.0], [1.0, -2.0]]]
height_m = 1.0
[[obstacle]]
name = "room"
shape = "room"
vertices_m = [[-6.0, -7.0], [8.0, -7.0], [8.0, 7.0], [-6.0, 7.0]]
height_m = 1.0
[[option]]
name = "all"
openings = []
"""
    walls = scenes.Walls(cocarry.World.parse(text))
    positions = [(1.0, 3.0), (-0.5, 3.5), (2.0, -2.8), (0.5, -3.0), (7.5, 0.0), (8.1, 0.0), (3.0, 0.0)]
    points, distances = walls.nearest(positions)
    assert distances == pytest.approx([1.0, 0.0, 0.8, 0.0, 0.5, 0.0, 1.0])
    assert points[[1, 3, 4, 5]] == pytest.approx(np.array([(-0.5, 3.5), (0.5, -3.0), (8.0, 0.0), (8.1, 0.0)]))
    # two are equally near: the point is at that distance, on one of them
    assert np.hypot(*(points - positions).T) == pytest.approx(distances)


def test_closed_form_boxes_are_as_near_as_polygons_of_their_corners(scenes):
    def walls(obstacles):
        head = 'name = "Boxes"\nrobot_width_m = 0.5\nstart_m = [-9.0, 0.0]\ntarget_m = [9.0, 0.0]\n'
        return scenes.Walls(cocarry.World.parse(head + obstacles + '[[option]]\nname = "all"\nopenings = []\n'))

    box = '[[obstacle]]\nname = "box"\nshape = "box"\ncenter_m = [1.0, 2.0]\nsize_m = [4.0, 2.0]\nyaw_deg = 30.0\nheight_m = 1.0\n'
    turn = np.array([[math.cos(math.pi / 6), math.sin(math.pi / 6)], [-math.sin(math.pi / 6), math.cos(math.pi / 6)]])
    corners = (np.array([(-2.0, -1.0), (2.0, -1.0), (2.0, 1.0), (-2.0, 1.0)]) @ turn + (1.0, 2.0)).tolist()
    polygon = f'[[obstacle]]\nname = "box"\nshape = "polygon"\nvertices_m = {corners}\nheight_m = 1.0\n'
    positions = np.random.default_rng(0).uniform(-5.0, 7.0, (500, 2))
    for found, expected in zip(walls(polygon).nearest(positions), walls(box).nearest(positions)):
        assert found == pytest.approx(expected, abs=1e-12)


@pytest.fixture
def partner():
    paths = [np.array([(-2.0, 0.0), (0.0, side), (2.0, 0.0)]) for side in (0.7, -0.7)]
    return importlib.import_module("force_partner").ForcePartner(0, paths=paths, speed_m_per_s=0.3, damping=100.0, patience_ns=10.0)


def hand_view(hand=(0.0, 0.7), force=None):
    wrench = None if force is None else np.array([-force[0], -force[1], 0, 0, 0, 0])  # that on the object
    return types.SimpleNamespace(hand=np.array(hand), hand_wrench=wrench, period=1, control_period_s=0.1)


def test_closed_form_a_hand_without_a_force_walks_its_path_and_a_force_adds_its_share_of_the_damping(partner):
    free = np.array(partner.hand(hand_view((-2.0, 0.0)))) - (-2.0, 0.0)
    assert np.hypot(*free) == pytest.approx(0.03)  # 0.3 m/s for 0.1 s
    assert free[1] / free[0] == pytest.approx(0.35, abs=1e-6)
    pulled = np.array(partner.hand(hand_view((-2.0, 0.0), (0.0, -10.0)))) - (-2.0, 0.0)
    assert pulled - free == pytest.approx([0.0, -0.01])


def test_a_human_changes_the_side_once_a_force_toward_it_has_used_up_the_patience(partner):
    def decided(force, time_s):
        hand = np.eye(4)
        hand[:2, 3] = (-1.0, 0.0)
        wrench = np.array([-force[0], -force[1], 0, 0, 0, 0])
        return partner.decide(types.SimpleNamespace(hand=hand, hand_wrench=wrench, time_s=time_s)).option

    assert [decided((0.0, 20.0), 0.2 * i) for i in range(10)] == [0] * 10  # toward the own side
    against = [decided((0.0, -20.0), 2.0 + 0.2 * i) for i in range(8)]
    assert against[:3] == [0, 0, 0] and against[-1] == 1  # 10 N s at less than 20 N take more than half a second


def test_a_human_keeps_state_through_save_and_restore(partner):
    state = partner.save()
    partner.option, partner.opposed_ns = 1, 3.0
    partner.restore(state)
    assert (partner.option, partner.opposed_ns) == (0, 0.0)


@pytest.mark.parametrize("policy", ["ic-mpc", "vanilla-mpc"])
def test_the_policies_carry_deterministically_and_through_snapshots(policy):
    tournament = importlib.import_module("tournament")
    scenario = cocarry.Scenario(cocarry.World(FOLDER / "room.toml"), plant="rapier", seed=3, speed_m_per_s=0.3)

    def made():
        scene = importlib.import_module("scenes").OnePost((0.0, 0.0), (2.5, 0.0))
        return tournament.OTHERS[policy](scene, seed=3)

    whole = cocarry.Episode(scenario, policy=made())
    whole.run(12)
    first = cocarry.Episode(scenario, policy=made())
    first.run(6)
    second = cocarry.Episode.resume(first.snapshot(), policy=made())
    second.run(6)
    assert second.tick == whole.tick
    assert whole.position[0] > -2.5 + 0.2


@pytest.mark.parametrize("plant", ["rapier", "kinematic", "point"])
def test_a_policy_without_a_scene_takes_the_walls_of_its_world_and_the_planning_step(scenes, plant):
    policies = importlib.import_module("passing_policies")
    scenario = cocarry.Scenario("environment-3", plant=plant, seed=1, speed_m_per_s=0.3, planning_step_s=0.25)
    found = cocarry.Episode(scenario, policy=policies.IcMpc)
    found.run(5)
    expected = cocarry.Episode(scenario, policy=policies.IcMpc(scenes.Walls(scenario.world)))
    expected.run(5)
    assert found.tick == expected.tick
    resumed = cocarry.Episode.resume(found.snapshot(), policy=policies.IcMpc)
    resumed.run(2)
    expected.run(2)
    assert resumed.tick == expected.tick


def test_without_a_scene_the_team_starts_facing_the_way_of_the_robots_option(scenes):
    policies = importlib.import_module("passing_policies")
    scenario = cocarry.Scenario("environment-1", plant="rapier", seed=1)

    def starts(policy):
        seen = []

        def first(view):
            if view.object is not None:
                seen.append(view.object[:2, 0])
            return policy(view)

        cocarry.Episode(scenario, policy=first, human=lambda view: 0).step()
        return seen[0]

    robots = starts(lambda view: int(view.objective_cost_m.argmin()))
    humans = starts(lambda view: None)
    assert abs(robots - humans).max() > 0.1
    assert starts(lambda view: policies.IcMpc().decide(view)) == pytest.approx(robots)
    assert starts(lambda view: policies.IcMpc(scenes.Walls(scenario.world)).decide(view)) == pytest.approx(humans)


def test_references_are_a_planning_step_apart():
    policies = importlib.import_module("passing_policies")
    way = policies.planned_poses(np.zeros(3), np.array([[0.2, 0.0]]), 0.25, 0.1)
    assert way == pytest.approx(np.stack([0.02 * np.arange(1, 9), np.zeros(8), np.zeros(8)], axis=-1))
    turned = policies.facing_hand(way, np.array([0.0, 1.0]), np.array([0.2, 0.0]), 0.1)
    assert turned[:, 2] == pytest.approx(np.full(8, math.pi / 2))


def test_sweeps_take_the_policies_as_they_are():
    policies = importlib.import_module("passing_policies")
    study = {"worlds": ["environment-1", "environment-4"], "plants": "rapier", "seeds": 1, "max_steps": 5}
    rows = cocarry.sweep(study, policy=[policies.IcMpc, policies.VanillaMpc])
    found = sorted(zip(rows["world"], rows["method"], rows["steps"]))
    assert found == [(world, method, 5) for world in study["worlds"] for method in ("ic-mpc", "vanilla-mpc")]


def test_a_preferred_side_is_carried_in_the_room_and_counts_as_a_success():
    tournament = importlib.import_module("tournament")
    result = tournament.play(tournament.Cell("room", "scripted", "human-led", 0))
    assert result.outcome == "success" and 15 < result.time_s < 20 and result.hand_acceleration_m_per_s2 < 0.1


def test_closed_form_intervals_of_the_tournament():
    tournament = importlib.import_module("tournament")
    assert tournament.share_interval(10, 10) == pytest.approx((1 / (1 + 1.959964**2 / 10), 1.0))
    assert tournament.mean_interval([2.0, 2.0, 2.0]) == (2.0, 2.0, 2.0)
    assert np.isnan(tournament.mean_interval([])[0])


@pytest.fixture
def network():
    return importlib.import_module("learned_network")


@pytest.fixture
def learned():
    return importlib.import_module("learned_planner")


def small_network(network, features=8, hidden=4, latents=2, layers=2, observed=2, scale=0.5):
    """A network of random parameters."""
    generator = np.random.default_rng(7)
    shapes = network.parameter_shapes(features, hidden, latents, layers)
    return network.Vrnn({name: scale * generator.standard_normal(shape) for name, shape in shapes.items()}, observed)


def slow_sequence(parameters, layers, observed, inputs, noise):
    """One sequence of a VRNN by plain loops over numbers, from its equations."""

    def linear(name, values):
        return affine(parameters[f"{name}.weight"], parameters[f"{name}.bias"], values)

    def affine(weight, bias, values):
        assert len(weight[0]) == len(values)
        return [sum(float(w) * v for w, v in zip(row, values)) + float(b) for row, b in zip(weight, bias)]

    def relu(values):
        return [value if value > 0.0 else 0.0 for value in values]

    def logistic(value):
        return 1.0 / (1.0 + math.exp(-value))

    size = len(parameters["emb_x.0.bias"])
    states = [[0.0] * size for _ in range(layers)]
    found = []
    for step, drawn in enumerate(noise):
        top = states[-1]
        if step < observed:
            phi_x = relu(linear("emb_x.2", relu(linear("emb_x.0", list(inputs[step])))))
            features, kind = relu(linear("enc.2", relu(linear("enc.0", phi_x + top)))), "enc"
        else:
            features, kind = relu(linear("prior.2", relu(linear("prior.0", top)))), "prior"
        mean, logarithm = linear(f"{kind}_mean", features), linear(f"{kind}_std", features)
        latent = [m + math.sqrt(math.exp(v)) * e for m, v, e in zip(mean, logarithm, drawn)]
        phi_z = relu(linear("emb_z.0", latent))
        output = linear("dec.2", relu(linear("dec.0", phi_z + top)))
        if step >= observed:
            phi_x = relu(linear("emb_x.2", relu(linear("emb_x.0", output))))
        given = phi_x + phi_z
        for layer in range(layers):
            a = affine(parameters[f"gru.weight_ih_l{layer}"], parameters[f"gru.bias_ih_l{layer}"], given)
            b = affine(parameters[f"gru.weight_hh_l{layer}"], parameters[f"gru.bias_hh_l{layer}"], states[layer])
            new = []
            for unit in range(size):
                reset = logistic(a[unit] + b[unit])
                update = logistic(a[size + unit] + b[size + unit])
                candidate = math.tanh(a[2 * size + unit] + reset * b[2 * size + unit])
                new.append((1.0 - update) * candidate + update * states[layer][unit])
            states[layer] = given = new
        found.append(output)
    return found


@pytest.mark.parametrize("layers", [1, 2, 3])
def test_a_network_is_its_equations_by_plain_loops(network, layers):
    small = small_network(network, features=3, hidden=5, latents=2, layers=layers, observed=3)
    generator = np.random.default_rng(0)
    inputs, noise = generator.standard_normal((4, 3)), generator.standard_normal((6, 9, 2))
    found = small.sample(inputs, noise)
    slow = [slow_sequence(small.parameters, layers, 3, inputs, drawn) for drawn in noise]
    assert found == pytest.approx(np.array(slow), abs=1e-13)
    # what is given after the observed steps is not seen
    assert np.array_equal(found, small.sample(inputs + 9.0 * (np.arange(4) == 3)[:, np.newaxis], noise))
    # every sequence may have its own inputs
    assert small.sample(np.stack([inputs] * 6), noise) == pytest.approx(found, abs=1e-14)
    with pytest.raises(ValueError, match="2 steps of inputs; 3 are to be observed"):
        small.sample(inputs[:2], noise)


def test_closed_form_a_network_that_decodes_its_bias_alone_repeats_it(network, learned):
    small = small_network(network, scale=0.0)
    small.parameters["dec.2.bias"][:2] = (2.0, -1.0)
    history = np.array([(7.0 + i, 20.0, math.pi) for i in range(4)])
    ways = learned.predicted_ways(small, history, np.array([[300.0, 300.0]]), np.array([900.0, 300.0]), np.ones((2, 8, 2)))
    # eight steps, three of which are the history's
    expected = [(10.0 + 2.0 * i, 20.0 - i) for i in range(1, 6)]
    assert ways == pytest.approx(np.array([expected, expected]))


def test_a_parameter_of_another_shape_is_named(network):
    shapes = network.parameter_shapes(8, 4, 2, 2)
    good = {name: np.zeros(shape) for name, shape in shapes.items()}
    assert (network.Vrnn(good, 6).hidden, network.Vrnn(good, 6).latents, network.Vrnn(good, 6).layers) == (4, 2, 2)
    with pytest.raises(ValueError, match=r"dec.0.weight of a VRNN has the shape \(4, 7\), not \(4, 8\)"):
        network.Vrnn(good | {"dec.0.weight": np.zeros((4, 7))}, 6)
    with pytest.raises(ValueError, match="prior.2.bias of a VRNN has the shape None"):
        network.Vrnn({name: value for name, value in good.items() if name != "prior.2.bias"}, 6)
    with pytest.raises(ValueError, match="of a VRNN"):
        network.Vrnn({}, 6)


def written(monkeypatch, path, content):
    """Writes a file as PyTorch does: arrays are tensors that share no storage but have an offset and transposed strides."""
    utilities = types.ModuleType("torch._utils")
    utilities._rebuild_tensor_v2 = lambda *_: None
    utilities._rebuild_tensor_v2.__module__ = "torch._utils"
    utilities._rebuild_tensor_v2.__qualname__ = "_rebuild_tensor_v2"
    torch = types.ModuleType("torch")
    torch.FloatStorage = type("FloatStorage", (), {"__module__": "torch"})
    monkeypatch.setitem(sys.modules, "torch", torch)
    monkeypatch.setitem(sys.modules, "torch._utils", utilities)

    class Storage:
        def __init__(self, values):
            self.values = values

    class Pickler(pickle.Pickler):
        def persistent_id(self, item):
            if not isinstance(item, Storage):
                return None
            archive.writestr(f"archive/data/{len(archive.namelist())}", item.values.astype("<f4").tobytes())
            key = archive.namelist()[-1].rsplit("/", 1)[-1]
            return ("storage", torch.FloatStorage, key, "cpu", len(item.values))

        def reducer_override(self, item):
            if not isinstance(item, np.ndarray):
                return NotImplemented
            # column by column, after one number that is not the tensor's
            storage = Storage(np.concatenate([[99.0], item.T.ravel()]))
            strides = (1,) if item.ndim == 1 else (1, item.shape[0])
            return utilities._rebuild_tensor_v2, (storage, 1, item.shape, strides, False, {})

    with zipfile.ZipFile(path, "w") as archive:
        buffer = io.BytesIO()
        Pickler(buffer, 2).dump(content)
        archive.writestr("archive/data.pkl", buffer.getvalue())


def test_a_checkpoint_is_read_without_pytorch(monkeypatch, network, tmp_path):
    small = small_network(network)
    settings = argparse.Namespace(H=30, skip=5, include_actions=False)
    content = {"state_dict": small.parameters, "hyper_parameters": {"hparams": settings}, "epoch": 1}
    written(monkeypatch, tmp_path / "model.ckpt", content)
    found = network.Vrnn.read(tmp_path / "model.ckpt")
    assert found.observed == 6 and found.parameters.keys() == small.parameters.keys()
    for name, value in small.parameters.items():
        assert np.array_equal(found.parameters[name], value.astype(np.float32)), name


def test_a_checkpoint_that_names_anything_else_is_refused_and_nothing_runs(monkeypatch, network, tmp_path):
    with zipfile.ZipFile(tmp_path / "bad.ckpt", "w") as archive:
        archive.writestr("archive/data.pkl", b"cbuiltins\nexec\n(S'raise SystemExit'\ntR.")
    with pytest.raises(ValueError, match=r"bad.ckpt: no file of PyTorch that can be read: it names builtins.exec"):
        network.Vrnn.read(tmp_path / "bad.ckpt")
    (tmp_path / "text.ckpt").write_text("no archive")
    with pytest.raises(ValueError, match="text.ckpt: no file of PyTorch"):
        network.Vrnn.read(tmp_path / "text.ckpt")
    settings = argparse.Namespace(H=30, skip=5, include_actions=True)
    content = {"state_dict": small_network(network).parameters, "hyper_parameters": {"hparams": settings}}
    written(monkeypatch, tmp_path / "actions.ckpt", content)
    with pytest.raises(ValueError, match="its network takes actions"):
        network.Vrnn.read(tmp_path / "actions.ckpt")


def test_closed_form_features_and_score_of_the_learned_planner(learned):
    history = np.array([(100.0, 100.0, math.pi), (104.0, 103.0, math.atan2(0.8, -0.6)), (104.0, 103.0, math.pi / 2)])
    found = learned.network_features(history, np.array([[900.0, 0.0], [180.0, 108.0]]), np.array([500.0, 100.0]))
    # seen by the robot's heading, that from the object to the robot, behind
    assert found[0] == pytest.approx([4.0, 3.0, 0.4, 0.8, -50.0, 0.0, -10.0, -1.0], abs=1e-12)
    assert found[1] == pytest.approx([0.0, 0.0, 0.6, 0.2, -30.0, -39.375, -5.2, -7.975], abs=1e-12)
    way = np.array([[3000.0, 4000.0], [3000.0, 4300.0]])
    near = math.exp(-0.5)
    assert learned.score(way, np.array([[3050.0, 4000.0]]), way[0]) == pytest.approx(-0.2 + 1.0 + near - near)
    beside = np.array([[550.0, 5000.0]])
    assert learned.score(beside, np.empty((0, 2)), np.array([9e3, 9e3])) == pytest.approx(-0.1 - near)
    assert learned.score(beside, np.empty((0, 2)), np.array([9e3, 9e3]), learned.WINDOW_PX) == pytest.approx(-0.1)


def test_closed_form_the_window_is_the_floor_of_the_room(learned):
    assert learned.ROOM.to_window([(-2.71, 1.42), (2.85, -1.36)]) == pytest.approx(np.array([(0, 0), (1200, 600)]))
    points = np.random.default_rng(0).uniform(-2, 2, (5, 2))
    assert learned.ROOM.from_window(learned.ROOM.to_window(points)) == pytest.approx(points)
    positions = np.array([(0.0, 0.0), (3.0, 4.0)])
    assert learned.tracking_cost(positions, np.zeros(2), 2) == pytest.approx([0.0, 5.0 * 0.95**2])


def test_the_history_has_fifteen_states_a_second_and_begins_full(network, learned):
    planner = learned.LearnedPlanner(small_network(network), None)
    planner._remember(0.0, np.array([0.0, 0.0, 3.1]))
    assert planner.history.shape == (31, 3) and np.ptp(planner.history, axis=0).max() == 0.0
    planner._remember(0.2, np.array([0.3, 0.0, -3.1]))
    assert planner.history.shape == (31, 3)
    turn = (2.0 * math.pi - 6.2) / 3.0
    assert planner.history[-4:] == pytest.approx(np.array([(0.1 * i, 0.0, 3.1 + turn * i) for i in range(4)]))
    planner._remember(0.2, np.array([9.0, 9.0, 9.0]))  # the same moment again
    assert planner.history[-1, 0] == pytest.approx(0.3)


def test_the_learned_planner_carries_deterministically_and_through_snapshots(network, learned, scenes):
    scenario = cocarry.Scenario(cocarry.World(FOLDER / "room.toml"), plant="rapier", seed=3, speed_m_per_s=0.3)
    small = small_network(network, scale=0.0)
    # it predicts 4 pixels ahead in 1/15 s, 0.28 m/s
    small.parameters["dec.2.bias"][0] = 4.0

    def made():
        return learned.LearnedPlanner(small, scenes.OnePost((0.0, 0.0), (2.5, 0.0)), seed=3)

    whole = cocarry.Episode(scenario, policy=made())
    whole.run(12)
    first = cocarry.Episode(scenario, policy=made())
    first.run(6)
    second = cocarry.Episode.resume(first.snapshot(), policy=made())
    second.run(6)
    assert second.tick == whole.tick
    assert whole.position[0] > -2.5 + 0.2 and abs(whole.position[1]) < 0.2
