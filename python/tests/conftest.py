"""What several files of tests use."""

from __future__ import annotations

import pytest

import cocarry

PLANTS = ["point", "kinematic", "rapier"]


@pytest.fixture(scope="session")
def recordings(tmp_path_factory):
    """Recordings of the same human on every plant."""
    made = {}
    for plant in PLANTS:
        made[plant] = tmp_path_factory.mktemp(plant) / "run.mcap"
        scenario = cocarry.Scenario("environment-4", plant=plant, alpha=0.747, gamma=0.765, eta=5)
        with cocarry.Episode(scenario).record(made[plant]) as episode:
            episode.run()
    return made
