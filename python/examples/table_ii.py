"""Table II of the paper: accumulated objective cost (m) over 40 x 40 humans, the expectation of ``cocarry reproduce h2``."""

import cocarry

shares = [(i + 0.5) / 40 for i in range(40)]
humans = [(0.55 + 0.4 * a, 0.5 + 0.6 * g) for a in shares for g in shares]
study = {
    "worlds": [f"environment-{i}" for i in range(1, 5)], "plants": "point", "seeds": 1,
    "run": [{"methods": "without-model"}, *({"methods": "mutual", "eta": eta} for eta in (5, 10.5, 15))],
}  # fmt: skip
people = [{"name": f"h{i}", "alpha": alpha, "gamma": gamma} for i, (alpha, gamma) in enumerate(humans)]
table = cocarry.Table.concatenate([cocarry.sweep({**study, "human": part}) for part in (people[:800], people[800:])])
for world in study["worlds"]:
    rows = [(table["world"] == world) & (table["method"] == "without-model")]
    rows += [(table["world"] == world) & (table["method"] == "mutual") & (table["eta"] == eta) for eta in (5, 10.5, 15)]
    print(world, *(f"{table['accumulated_objective_cost_m'][row].mean():.2f}" for row in rows))
