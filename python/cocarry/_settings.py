"""The settings of a scenario. Written by ``python -m cocarry._generate`` from the library's table; not by hand."""

from typing import Literal, TypedDict


class Settings(TypedDict, total=False):
    """Keywords of Scenario: every setting of an episode."""

    risk_weight_m: float
    """Weight c_r of risk against distance, in metres. Default: 10.0."""

    human_model: str
    """Model of the human: preference, boltzmann(RATIONALITY) or scripted(STEP:OPTION,...). Default: preference."""

    planning_step_s: float
    """Planning step k, in seconds: phi, g, J and sightings count in it, so an eta is for one planning step. Default: 0.2."""

    control_period_s: float
    """Control period of eqs. (7) and (8), in seconds, a whole fraction of the planning step [default: the planning step]."""

    speed_m_per_s: float
    """Walking speed of the team, in metres per second. Default: 0.5."""

    yaw_rate_rad_per_s: float
    """Largest yaw rate of the human, in radians per second. Default: 0.8."""

    max_steps: int
    """Largest number of steps [default: ten times the steps of the longest option]."""

    posture: str
    """Posture at the start, by its name in the robot file [default: the first]."""

    state_weight: float
    """Weight of the grasp error in eq. (7): Q is this number times the identity. Default: 1000.0."""

    input_weight: float
    """Weight of the inputs in eq. (7): R is this number times the identity. Default: 1.0."""

    avoid: Literal['nothing', 'base', 'robot']
    """Parts of the robot that its MPC keeps out of obstacles. Default: robot."""

    physics_rate_hz: float
    """Physics steps per second; a control period takes a whole number of them, and the remainder goes into the next. Default: 100.0."""

    solver_iterations: int
    """Solver iterations in a physics step over grips and contacts; arm and base are solved exactly. Default: 12."""

    rim_acceleration_m_per_s2: float
    """Largest acceleration of a wheel's rim, in metres per second squared. Default: 1.5."""

    gripper_stiffness_n_per_m: float
    """Linear stiffness of the gripper's hold on the object, in newtons per metre; the angular one is in proportion, the damping critical. Default: 20000.0."""

    hand_stiffness_n_per_m: float
    """Linear stiffness of the human's hold on the object, in newtons per metre; the angular one is in proportion, the damping critical. Default: 1200.0."""

    hand_speed_limit_m_per_s: float
    """Largest speed of the human's hand, in metres per second. Default: 1.0."""

    hand_acceleration_limit_m_per_s2: float
    """Largest acceleration of the human's hand, in metres per second squared. Default: 1.5."""

    step_frequency_hz: float
    """Frequency of the lateral sway, in hertz; the vertical sway is twice as fast. Default: 0.9."""

    sway_m: float
    """Amplitude of the human hand's lateral sway with the gait, in metres; half of it vertically. Default: 0.01."""

    initial_stubbornness: float
    """Stubbornness phi(0) at the start. Default: 0.1."""

    eta: float
    """Tolerance eta of the human: the larger, the more slowly stubbornness grows (paper: 5, 10.5, 15). Default: 10.5."""

    method: Literal['mutual', 'without-model', 'human-led', 'robot-led', 'follow-hand']
    """Method: who leads, and on which option. Default: mutual."""

    lead_option: int
    """Option on which the robot leads, by its number in `cocarry world` [default: the best by eq. (6)]."""

    pose: Literal['none', 'arm', 'whole-body']
    """Configurations that pose optimisation chooses among while the human leads. Default: arm."""

    pose_criterion: Literal['expected', 'uniform', 'tracked', 'manipulability']
    """Criterion of pose optimisation. Default: expected."""

    pose_weight: float
    """Weight kappa of a change of configuration in eq. (8). Default: 1.0."""

    direction_concentration: float
    """Concentration of the von Mises distribution of the walking direction on an option. Default: 20.0."""

    guide_price: float
    """Weight of the squared deviation of the base's inputs from those that follow the path; below 10000, eq. (8) decides them as well; at most 100 counts of an omnidirectional robot whose arm cannot move the grasp in every direction of the plane. Default: 10000.0."""

    guide_width_m: float
    """How far the base may be from where following the path takes it, in metres; 1000000: no bound. Default: 1000000.0."""

    prepare_while_leading: bool
    """Optimise the pose also while the robot leads, for its own path; the paper does so only while it follows. Default: False."""

    belief_update: Literal['prior', 'learn']
    """The robot's belief during the episode. Default: prior."""

    belief_lapse: float
    """Lapse rate l of the robot's belief: with probability l, a human takes any option. Above 0, a robot that learns uses the same rate for its sightings. Default: 0.0."""

    belief_rationality: float
    """Rationality beta of the robot's belief: P_o is that of humans who choose with probability proportional to exp(-beta J^), as boltzmann(beta) does [default: infinite, eq. (4)]."""
