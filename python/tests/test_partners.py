"""Own policies and humans, at every depth, on every plant."""

from __future__ import annotations

import pathlib
import pickle
import subprocess
import sys
import tempfile

import numpy as np
import pytest

import cocarry

PLANTS = ["point", "kinematic", "rapier"]


def example(plant: str = "point", **settings) -> cocarry.Scenario:
    return cocarry.Scenario("environment-4", plant=plant, alpha=0.747, gamma=0.765, **settings)


def eq6(view: cocarry.RobotView):
    """Eq. (6): leads on the option of least (1 - phi) J_o + phi J~_o until the human takes over, then follows."""
    if view.mode == "human-led" or view.stance == "take-over":
        return None
    phi = min(view.stubbornness, 1.0)
    cost = (1 - phi) * view.objective_cost_m + phi * view.expected_subjective_cost
    if view.executed is not None and cost[view.executed] == cost.min():
        return view.executed
    return int(cost.argmin())


class Boltzmann(cocarry.Human):
    """Chooses o with probability proportional to exp(-beta J^_o): the least beta J^_o minus a Gumbel draw."""

    def __init__(self, beta, alpha, gamma):
        self.beta, self.perception = beta, (alpha, gamma)

    def decide(self, view):
        cost = self.beta * view.subjective_cost(*self.perception) - view.gumbel()
        return cocarry.HumanDecision(int(cost.argmin()), perception=self.perception)


def same(own: cocarry.Episode, theirs: cocarry.Episode) -> None:
    ended = None
    while ended is None:
        ended = theirs.step()
        assert own.step() == ended
        assert own.tick == theirs.tick
    assert own.summary == theirs.summary
    # a recording of custom partners has their decisions besides
    assert messages(own) == messages(theirs)


def messages(episode: cocarry.Episode) -> list:
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "episode.mcap"
        file.write_bytes(episode.recording())
        recording = cocarry.read(file)
        return [(topic, recording.table(topic)) for topic in sorted(recording.topics)]


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("world", ["environment-1", "environment-4"])
def test_equation_6_gives_the_same_bytes_as_mutual(plant, world):
    # a sensitive human, who takes the lead; in Environment 1 the robot changes its option before
    scenario = cocarry.Scenario(world, plant=plant, eta=5, seed=1)
    same(cocarry.Episode(scenario, policy=eq6), cocarry.Episode(scenario))


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("seed", [0, 1])
def test_a_boltzmann_human_equals_the_built_in_one(plant, seed):
    scenario = example(plant, human_model="boltzmann(0.8)", seed=seed)
    own = cocarry.Episode(scenario, human=Boltzmann(0.8, 0.747, 0.765))
    same(own, cocarry.Episode(scenario))
    np.testing.assert_array_equal(cocarry.gumbel(seed, 3), cocarry.gumbel(seed, 5)[:3])


def test_partners_see_what_the_tick_says():
    seen = []

    class Watches(cocarry.Policy):
        def decide(self, view):
            seen.append((view.step, view.time_s, list(view.position), view.stubbornness, view.name, view["length_m"]))
            return eq6(view)

    episode = cocarry.Episode(example(), policy=Watches)
    for tick in episode:
        step, time, position, stubbornness, names, lengths = seen[-1]
        assert (step, time, position) == (tick["step"], tick["time_s"], [tick["x_m"], tick["y_m"]])
        assert stubbornness == tick["stubbornness"]
        assert names == [option["name"] for option in tick["options"]]
        np.testing.assert_array_equal(lengths, [option["length_m"] for option in tick["options"]])


@pytest.mark.parametrize("plant", ["kinematic", "rapier"])
def test_own_references_and_inputs_move_the_robot(plant):
    class Stands(cocarry.Policy):
        def decide(self, view):
            assert view.grasp.shape == (4, 4)
            return cocarry.Decision("human", inputs=np.zeros(len(view.configuration) - 1))

    class Stays(cocarry.Policy):
        def __init__(self):
            self.grasps = []

        def decide(self, view):
            self.grasps.append(view.grasp)
            [x, y], [cos, sin] = self.grasps[0][:2, 3], self.grasps[0][:2, 0]
            return cocarry.Decision("human", reference=np.tile([x, y, np.arctan2(sin, cos)], (8, 1)))

    def distances(places):
        return np.linalg.norm(np.array(places) - places[0], axis=1)

    # on the kinematic plant the hand walks away; on the physical one a human who leads waits for the object
    episode = cocarry.Episode(example(plant), policy=Stands())
    assert max(distances([(tick["base_x_m"], tick["base_y_m"]) for tick in episode])) < 0.25
    assert episode.outcome == {"kinematic": "object-lost", "rapier": "stuck"}[plant]
    # the base drives to where the arm keeps the grasp, so that the human waits likewise
    stays = Stays()
    outcome = cocarry.Episode(example(plant), policy=stays).run()["outcome"]
    assert max(distances([grasp[:2, 3] for grasp in stays.grasps])) < 0.25
    assert outcome == {"kinematic": "object-lost", "rapier": "stuck"}[plant]
    if plant == "rapier":
        views = []
        cocarry.Episode(example(plant), policy=lambda view: views.append(view)).run(3)
        assert views[-1].object.shape == (4, 4) and views[-1].grip_wrench.shape == (6,) == views[-1].hand_wrench.shape


def test_humans_resist_and_take_over():
    def resists(view):
        return cocarry.HumanDecision(0, stance="resist" if view.step < 5 else "follow", stubbornness=0.0)

    episode = cocarry.Episode(example(), human=resists)
    episode.run(5)
    assert episode.summary["walked_m"] == 0
    episode.run(1)
    assert episode.summary["walked_m"] > 0

    episode = cocarry.Episode(example(), human=lambda view: cocarry.HumanDecision(1, stance="take-over"))
    episode.run(2)
    assert episode["mode"] == "human-led" and episode["executed_index"] == 1
    # an option alone brings the stubbornness of eq. (5)
    tick = [t["stubbornness"] for t in cocarry.Episode(example(), human=lambda view: 2)]
    assert tick[0] == pytest.approx(0.1) and max(tick) > 0.1


@pytest.mark.parametrize(
    ("policy", "message"),
    [
        (lambda view: 99, r"the policy returned 99; it must be None .*an index from 0 to"),
        (lambda view: -1, r"the policy returned -1"),
        (lambda view: True, r"the policy returned True"),
        (lambda view: "nowhere", r"the policy returned 'nowhere'.*one of"),
        (lambda view: 0.5, r"the policy returned 0.5"),
        (lambda view: cocarry.Decision(0, inputs=np.full(9, np.nan)), r"inputs = .*nan.*finite numbers"),
        (lambda view: cocarry.Decision(0, inputs=np.zeros(3)), r"it must be a float64 array of shape \(9,\)"),
        (lambda view: cocarry.Decision(0, inputs=[0.0] * 9), r"it must be a float64 array"),
        (lambda view: cocarry.Decision(0, reference=np.zeros((8, 2))), r"shape \(8, 3\)"),
        (lambda view: view.nothing, r"unknown `nothing`; the options have name, length_m"),
    ],
)
def test_wrong_decisions_say_what_would_be_right(policy, message):
    with pytest.raises((cocarry.DecisionError, AttributeError), match=message):
        cocarry.Episode(example("kinematic"), policy=policy).run()


@pytest.mark.parametrize(
    ("human", "message"),
    [
        (lambda view: None, r"the human returned None; it must be an option"),
        (lambda view: cocarry.HumanDecision(77), r"option = 77"),
        (lambda view: cocarry.HumanDecision(0, stance="flee"), r"stance = 'flee'; it must be one of: follow, resist, take-over"),
        (lambda view: cocarry.HumanDecision(0, stubbornness=float("nan")), r"stubbornness = nan"),
        (lambda view: cocarry.HumanDecision(0, perception=(0.0, 1.0)), r"perception = \(0.0, 1.0\)"),
        (lambda view: cocarry.HumanDecision(0, hand=(0.0, float("inf"))), r"hand = "),
        (lambda view: 1 / 0, r"division by zero"),
    ],
)
def test_wrong_humans_say_what_would_be_right(human, message):
    with pytest.raises((cocarry.DecisionError, ZeroDivisionError), match=message):
        cocarry.Episode(example(), human=human).run()


def test_what_cannot_decide_is_refused():
    with pytest.raises(cocarry.DecisionError, match="policy = 3; it must be a callable"):
        cocarry.Episode(example(), policy=3)
    with pytest.raises(cocarry.DecisionError, match="plant=\"point\" has no robot"):
        cocarry.Episode(example(), policy=lambda view: cocarry.Decision(0, inputs=np.zeros(9))).step()


class Slow(cocarry.Policy):
    """Leads, follows, and moves the robot by itself on the way; it fails in the trial without a robot."""

    def decide(self, view):
        x, y = view.grasp[:2, 3]
        if view.step < 5:
            return cocarry.Decision(0, reference=np.tile([x, y, 0.0], (8, 1)))
        return 1 if view.step < 30 else None


def restless(view):
    return cocarry.HumanDecision(view.step % 2, stance="follow" if view.step < 60 else "take-over")


@pytest.mark.parametrize("plant", PLANTS)
def test_recordings_of_own_partners_replay_from_their_decisions(plant, tmp_path):
    for i, own in enumerate(
        [{"policy": eq6}, {"human": restless}, {"policy": lambda view: 2 if view.step < 40 else None, "human": restless}]
        + ([{"policy": Slow}] if plant != "point" else [])
    ):
        with cocarry.Episode(example(plant), **own).record(tmp_path / f"{i}.mcap") as episode:
            episode.run(80)
        replay = cocarry.read(tmp_path / f"{i}.mcap").replay()
        assert replay["verdict"] == "identical", (own, replay)
        assert episode_bytes(plant, own) == (tmp_path / f"{i}.mcap").read_bytes()
    assert "decisions.json" in (tmp_path / "0.mcap").read_bytes().decode("latin-1")


def episode_bytes(plant, own):
    episode = cocarry.Episode(example(plant), **own)
    episode.run(80)
    return episode.recording()


class Counts(cocarry.Policy):
    """Leads on the first option, and follows after so many steps; its count goes through snapshots."""

    def __init__(self, limit=20):
        self.limit, self.count = limit, 0

    def decide(self, view):
        self.count += 1
        return 0 if self.count <= self.limit else None

    def save(self):
        return self.count.to_bytes(4, "little")

    def restore(self, state):
        self.count = int.from_bytes(state, "little")


def test_memory_goes_through_snapshots_pickles_and_copies():
    episode = cocarry.Episode(example(), policy=Counts())
    episode.run(10)
    assert episode.policy.count == 10
    others = [cocarry.Episode.resume(episode.snapshot(), policy=Counts()), pickle.loads(pickle.dumps(episode))]
    episode.run()
    for other in others:
        assert other.run() == episode.summary
        assert other.recording() == episode.recording() or other is others[0]


STUDY = {"worlds": ["environment-1", "environment-4"], "plants": "point", "seeds": 4, "eta": [5, 15]}


def test_sweeps_of_own_partners_have_the_rows_of_the_built_in_ones():
    theirs, own = cocarry.sweep(STUDY), cocarry.sweep(STUDY, policy=eq6)
    assert set(own["method"]) == {"eq6"}
    for column in theirs.columns:
        if column not in ("method", "policy_code", "study", "checksum"):
            assert list(map(str, own[column])) == list(map(str, theirs[column])), column
    assert cocarry.sweep(STUDY, policy=eq6, threads=1) == own == cocarry.sweep(STUDY, policy=eq6, processes=2)
    # every episode has a policy of its own
    counted, once = (cocarry.sweep(STUDY, policy=policy, threads=2) for policy in (Counts, Counts()))
    for column in counted.columns:
        if column not in ("policy_code", "study", "checksum"):
            assert list(map(str, counted[column])) == list(map(str, once[column])), column


def test_an_exception_in_a_sweep_is_raised():
    def fails(view):
        raise RuntimeError("on purpose")

    with pytest.raises(RuntimeError, match="on purpose"):
        cocarry.sweep(STUDY, policy=fails)


def test_a_policy_sees_the_paths_of_the_options_and_nothing_of_the_humans_choice():
    seen = {}

    def policy(view):
        if view.step == 3:
            seen.update(path=view.path(2), position=view.position, length=view.length_m[2])
            seen["names"] = {name for name in dir(view) if not name.startswith("_")}
        return None if view.stance == "take-over" else int(view.objective_cost_m.argmin())

    cocarry.Episode(cocarry.Scenario("environment-4", plant="point"), policy=policy).run(5)
    path = seen["path"]
    assert np.allclose(path[0], seen["position"])
    assert abs(np.linalg.norm(np.diff(path, axis=0), axis=1).sum() - seen["length"]) < 0.01
    # as `cocarry::policy::RobotView`: stance, phi and g of the human, no option, alpha or gamma
    assert seen["names"] == {
        "step", "time_s", "planning_step_s", "world", "robot", "position", "path", "executed", "mode", "stance", "stubbornness", "discomfort",
        "configuration", "grasp", "object", "hand", "grip_wrench", "hand_wrench",
    }


@pytest.mark.parametrize("plant", PLANTS)
def test_views_have_the_world_the_planning_step_and_paths(plant):
    seen, felt = [], []

    def policy(view):
        seen.append((view.world, view.planning_step_s, view.robot, view.time_s, [view.path(i) for i in range(len(view))]))
        return None if view.stance == "take-over" else int(view.objective_cost_m.argmin())

    class Walks(cocarry.Human):
        def decide(self, view):
            felt.append((view.world, view.planning_step_s, view.position, [view.path(i) for i in range(len(view))]))
            with pytest.raises(cocarry.Error, match=f"option = {len(view)}; it must be from 0 to {len(view) - 1}"):
                view.path(len(view))
            return int(view.subjective_cost(0.747, 0.765).argmin())

    scenario = example(plant, planning_step_s=0.25)
    cocarry.Episode(scenario, policy=policy, human=Walks()).run(4)
    steps = seen[-4:]  # before them the first step was tried
    for (world, step_s, robot, time_s, paths), (human_world, human_step_s, position, human_paths), k in zip(steps, felt[-4:], range(4)):
        assert step_s == human_step_s == 0.25 and time_s == pytest.approx(0.25 * k)
        assert world is steps[0][0] and human_world is felt[-1][0] and world.text == human_world.text == scenario.world.text
        assert (robot is None) == (plant == "point") and robot is steps[0][2]
        assert robot is None or robot.name == scenario.robot.name
        for path, human_path in zip(paths, human_paths, strict=True):
            np.testing.assert_array_equal(path, human_path)
            np.testing.assert_allclose(path[[0, -1]], [position, world.target], atol=1e-9)


def test_a_hand_knows_its_control_period_and_where_it_faces():
    hands, poses = [], []

    class Turns(cocarry.Human):
        def decide(self, view):
            poses.append((len(hands), view.hand))
            return 0

        def hand(self, view):
            hands.append((view.time_s, view.period, view.periods, view.control_period_s, view.heading_rad))

    cocarry.Episode(example("rapier", planning_step_s=0.2, control_period_s=0.1, sway_m=0.0), human=Turns()).run(6)
    for (time_s, *_), (next_s, *_) in zip(hands, hands[1:]):
        assert next_s - time_s == pytest.approx(0.1)
    assert {(periods, control_s) for _, _, periods, control_s, _ in hands} == {(2, 0.1)}
    for first, pose in poses[-6:]:
        assert hands[first][1] == 0  # the first period of the step: nothing has moved since the decision
        assert hands[first][4] == pytest.approx(np.arctan2(pose[1, 0], pose[0, 0]), abs=1e-3)


@pytest.mark.parametrize("drive", ["differential", "omnidirectional"])
def test_a_robot_has_the_grasp_that_is_seen_and_its_jacobian(drive, tmp_path):
    if drive == "omnidirectional":  # one of the benchmark's
        subprocess.run([sys.executable, "-m", "cocarry", "bench", tmp_path / "bench"], check=True)
    robot = cocarry.Robot("carrier" if drive == "differential" else tmp_path / "bench" / "robots" / "omni-carrier.toml")
    assert robot.drive == drive
    seen = []

    def policy(view):
        if view.configuration is not None:
            seen.append((view.configuration, view.grasp, view.robot))
        return int(view.objective_cost_m.argmin())

    cocarry.Episode(example("kinematic", robot=robot), policy=policy).run(10)
    for configuration, grasp, of_view in seen[::3]:
        np.testing.assert_allclose(robot.grasp(configuration), grasp, atol=1e-12)
        np.testing.assert_array_equal(of_view.grasp(list(configuration)), robot.grasp(configuration))
        jacobian = robot.jacobian(configuration)
        base = len(robot.input_limits) - len(robot.joints)
        assert jacobian.shape == (6, base + len(robot.joints))
        for joint in range(len(robot.joints)):  # central differences
            step = np.zeros(len(configuration))
            step[3 + joint] = 1e-6
            there, before = robot.grasp(configuration + step), robot.grasp(configuration - step)
            turning = (there - before)[:3, :3] @ grasp[:3, :3].T / 2e-6
            found = [*(there - before)[:3, 3] / 2e-6, turning[2, 1], turning[0, 2], turning[1, 0]]
            np.testing.assert_allclose(jacobian[:, base + joint], found, atol=1e-8)
        # the base turns about its own axis, and goes ahead, or to the left too
        x, y, yaw = configuration[:3]
        ahead, arm = np.array([np.cos(yaw), np.sin(yaw)]), np.asarray(grasp[:2, 3]) - (x, y)
        across = np.array([-arm[1], arm[0]])
        if robot.drive == "omnidirectional":
            expected = [[*ahead, 0, 0, 0, 0], [-ahead[1], ahead[0], 0, 0, 0, 0], [*across, 0, 0, 0, 1]]
        else:
            rates = jacobian[5, :2]  # rad/s for a rim speed of 1 m/s: one over the track, to the right and to the left
            assert rates[1] == -rates[0] > 0
            expected = [[*(0.5 * ahead + rate * across), 0, 0, 0, rate] for rate in rates]
        np.testing.assert_allclose(jacobian[:, :base].T, expected, atol=1e-12)


def test_a_robot_refuses_what_is_no_configuration_of_it():
    robot = cocarry.Robot()
    count = 3 + len(robot.joints)
    for wrong in ([0.0] * (count - 1), [np.nan] * count, "base", None, np.zeros((count, 1))):
        for ask in (robot.grasp, robot.jacobian):
            with pytest.raises(cocarry.RobotError, match=f"(?s)^configuration = .*; it must be {count} finite numbers: the base's x, y"):
                ask(wrong)


def test_a_policy_that_keeps_what_a_view_has_is_copied():
    class Keeps(cocarry.Policy):
        def decide(self, view):
            self.kept = view.world, view.world.obstacles, view.robot
            return int(view.objective_cost_m.argmin())

    policy = Keeps()
    episode = cocarry.Episode(example("kinematic"), policy=policy)
    episode.run(3)
    again = episode.__copy__()
    again.run(2)
    episode.run(2)
    assert again.tick == episode.tick


def test_a_hand_has_a_target_in_every_control_period():
    periods = []

    class Steering(cocarry.Human):
        def decide(self, view):
            return cocarry.HumanDecision(2, stance="take-over" if view.step >= 3 else "follow")

        def hand(self, view):
            periods.append((view.period, view.periods))
            return tuple(view.hand + [0.02, 0.0]) if view.time_s > 1.0 else None

    scenario = cocarry.Scenario("environment-4", plant="rapier", control_period_s=0.05)
    cocarry.Episode(scenario, human=Steering).run(7)
    assert periods == [(period, 4) for _ in range(7) for period in range(4)]
